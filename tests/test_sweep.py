"""The atlas and its sweep: the same bits on local cores, on a cluster, and after an interrupt."""

import csv
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import tunneller_lib
from tests.blocks import EVERY_PAIR, fails_late, small, survey
from tunneller_lib.__main__ import main
from tunneller_lib.paths import CHORD_PATHS, atlas, geodesic_inverse
from tunneller_lib.reporting import sweep
from tunneller_lib.reporting.sweep import compute_blocks
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

FEW = [(0, 8), (12, 3)]


@contextmanager
def at_once(_):
    """Stand for a cluster, here and block by block."""
    yield lambda survey, blocks: ((block, survey(block)) for block in blocks)


def loaded(files):
    return [np.load(file) for file in files]


def test_atlas_covers_every_pair_of_the_joint_limits_up_to_symmetry():
    turn, phi1, phi2 = np.concatenate([atlas.pairs(k) for k in range(atlas.STRIPES)], axis=1)
    machine = REFERENCE_MACHINE
    assert len(atlas.blocks()) * turn.size / atlas.STRIPES >= 1e6
    assert turn.max() == pytest.approx(machine.theta_max - machine.theta_min)
    assert phi1.max() == machine.phi_max and phi2.min() == machine.phi_min
    assert np.all(phi1 >= np.abs(phi2)) and turn.min() > 0
    assert atlas.RATIOS[0] == pytest.approx(4) and atlas.RATIOS[-1] == pytest.approx(100)


@pytest.fixture(scope="module")
def surveyed(tmp_path_factory):
    """Two blocks of the atlas, of few pairs, by two local processes."""
    return compute_blocks(survey, FEW, tmp_path_factory.mktemp("here"), jobs=2)


def test_survey_tells_what_the_functions_tell(surveyed):
    table = np.load(surveyed[1])
    assert table.shape[1] == len(atlas.COLUMNS) and np.all(table[:, 5:7] == 1)
    assert len(table) == len(EVERY_PAIR(FEW[1][1])[0][::100]) > 80
    rows = table[::9]
    torus = Torus(1 / rows[0, 0], 1)
    p = np.stack([0.7 + 0 * rows[:, 1], -rows[:, 2]], axis=-1)  # turned and mirrored
    q = np.stack([0.7 - rows[:, 1], -rows[:, 3]], axis=-1)
    np.testing.assert_allclose(geodesic_inverse(torus, p, q).length, rows[:, 4], rtol=1e-13)
    excess, aside = np.split(table[:, 7:], 2, axis=1)
    assert np.all(excess > -1e-11) and np.all(aside >= 0)


def test_sweep_goes_on_where_it_was_interrupted(tmp_path, capsys):
    blocks = [(0, k) for k in range(5)]
    first = compute_blocks(small, blocks[:2], tmp_path, jobs=1)
    first[0].with_name("0-3.part").write_bytes(b"half a block")
    stamps = [file.stat().st_mtime_ns for file in first]
    files = compute_blocks(small, blocks, tmp_path, jobs=2)
    assert [file.stat().st_mtime_ns for file in files[:2]] == stamps
    for block, table in zip(blocks, loaded(files), strict=True):
        np.testing.assert_array_equal(table, small(block))
    told = capsys.readouterr().err
    assert "2 of 5 blocks are there" in told and "5 of 5 blocks, 0 s to go" in told
    assert [path.name for path in tmp_path.rglob("*.part")] == ["0-3.part"]  # another's


def test_sweep_tells_the_time_to_go_from_its_own_pace(tmp_path, capsys, monkeypatch):
    blocks = [(0, k) for k in range(6)]
    compute_blocks(small, blocks[:2], tmp_path, jobs=1)
    clock = iter(range(100, 200, 10))  # ten seconds a block
    monkeypatch.setattr("tunneller_lib.reporting.sweep.time.monotonic", lambda: next(clock))
    capsys.readouterr()
    monkeypatch.setattr("tunneller_lib.reporting.sweep._cluster", at_once)
    compute_blocks(small, blocks, tmp_path, scheduler="here")
    told = capsys.readouterr().err
    assert re.findall(r"blocks, (\d+) s to go", told) == ["30", "20", "10", "0"]


def test_summary_needs_whole_rows():
    for wrong in (np.zeros((4, 3)), np.zeros((0, len(atlas.COLUMNS))), np.zeros(4)):
        with pytest.raises(
            ValueError, match=r"^tables: each must hold rows of \d+ columns; got sh"
        ):
            atlas.summary([wrong])


def test_sweep_keeps_the_blocks_that_were_finished(tmp_path):
    with pytest.raises(ArithmeticError):
        compute_blocks(fails_late, [(0, k) for k in range(4)], tmp_path, jobs=1)
    assert sorted(file.name for file in tmp_path.rglob("*.*")) == ["0-0.npy", "0-1.npy", "0-2.npy"]


@pytest.mark.parametrize("jobs", [0, -1, 1.5, "2"])
def test_sweep_refuses_another_number_of_processes(tmp_path, jobs):
    with pytest.raises(ValueError, match=r"^jobs: must be one whole number from 1 to 10000; got"):
        compute_blocks(small, [(0, 0)], tmp_path, jobs=jobs)


@pytest.fixture(scope="module")
def cluster():
    """Two workers and their scheduler, which is in this process."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        yield cluster


of_a_cluster = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")


@of_a_cluster
def test_sweep_on_a_cluster_of_two_workers_gives_the_same_bits(tmp_path, surveyed, cluster):
    modules = {name: module for name, module in sys.modules.items() if "tunneller" in name}
    address = cluster.scheduler_address
    there = compute_blocks(survey, FEW, tmp_path / "there", scheduler=address)
    for one, other in zip(loaded(there), loaded(surveyed), strict=True):
        np.testing.assert_array_equal(one, other)
    # What a scheduler in this process was sent would stand in the place of the library.
    assert all(sys.modules[name] is module for name, module in modules.items())
    assert all(Path(module.__file__).exists() for module in modules.values())
    assert not any("dask" in path for path in sys.path if path.endswith(".zip"))


@of_a_cluster
def test_worker_without_this_very_library_is_refused_before_a_block(
    tmp_path, cluster, monkeypatch, capsys
):
    answer = dict.fromkeys(cluster.scheduler.workers, "another's digest")
    monkeypatch.setattr("distributed.Client.run", lambda *_: answer)
    folder, table = tmp_path / "blocks", tmp_path / "atlas.csv"
    code = main(["atlas", "--folder", str(folder), "--table", str(table),
                 "--scheduler", cluster.scheduler_address])  # fmt: skip
    told = capsys.readouterr().err.splitlines()
    assert code == 1 and len(told) == 2 and not table.exists() and not list(folder.rglob("*.npy"))
    assert re.fullmatch(
        r"refused: scheduler: must have workers with tunneller_lib [\d.]+, its files and numpy the "
        r"same as here; got 2 of 2 without, such as tcp://[\d.:]+\.", told[1]
    )  # fmt: skip


@of_a_cluster
def test_cluster_without_a_worker_is_refused(tmp_path):
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=0, dashboard_address=":0") as cluster,
        pytest.raises(ValueError, match=r"^scheduler: must have workers .*; got none\.$"),
    ):
        compute_blocks(small, [(0, 0)], tmp_path, scheduler=cluster.scheduler_address)


def test_question_to_a_worker_needs_no_module_of_ours(tmp_path):
    import cloudpickle

    (tmp_path / "asked").write_bytes(cloudpickle.dumps(sweep._digest))
    code = "import pickle; print(pickle.load(open('asked', 'rb'))())"

    def answered(*packages):
        for package in packages:
            (tmp_path / package.__name__).symlink_to(Path(package.__file__).parent)
        command = [sys.executable, "-S", "-c", code]
        done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert answered(cloudpickle) == "None"  # no numpy
    assert answered(np) == "None"  # no library
    assert answered(tunneller_lib) == sweep._digest()


def test_command_writes_the_summary(tmp_path, monkeypatch):
    monkeypatch.setattr(atlas, "blocks", lambda: FEW[1:])
    monkeypatch.setattr(atlas, "survey", survey)
    table = tmp_path / "atlas.csv"
    main(["atlas", "--folder", str(tmp_path / "blocks"), "--table", str(table), "--jobs", "1"])
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(CHORD_PATHS) and rows[0]["path"] == "tangent spheres"
    kept = np.load(next(tmp_path.rglob("12-3.npy")))
    assert float(rows[0]["worst excess"]) == pytest.approx(kept[:, 7].max(), rel=1e-8)
    assert not list(tmp_path.glob("*.part"))


def test_command_without_a_name_tells_what_there_is(capsys):
    with pytest.raises(SystemExit):
        main([])
    assert "COMMAND" in capsys.readouterr().err
