"""The atlas and its sweep: the same bits on any number of cores, and after an interrupt."""

import re

import numpy as np
import pytest

from exhibits import atlas
from exhibits.sweep import compute_blocks
from tests.blocks import EVERY_PAIR, fails_late, small, survey
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

FEW = [(0, 8), (12, 3)]


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
    assert re.fullmatch(r"small-[0-9a-f]{12}", first[0].parent.name)
    first[0].with_name("0-3.part").write_bytes(b"half a block")
    stamps = [file.stat().st_mtime_ns for file in first]
    files = compute_blocks(small, blocks, tmp_path, jobs=2)
    assert [file.stat().st_mtime_ns for file in files[:2]] == stamps
    for block, table in zip(blocks, loaded(files), strict=True):
        np.testing.assert_array_equal(table, small(block))
    told = capsys.readouterr().err
    assert "3 of 5 blocks" in told and "5 of 5 blocks" in told
    assert [path.name for path in tmp_path.rglob("*.part")] == ["0-3.part"]  # another's


def test_sweep_keeps_the_blocks_that_were_finished(tmp_path):
    with pytest.raises(ArithmeticError):
        compute_blocks(fails_late, [(0, k) for k in range(4)], tmp_path, jobs=1)
    assert sorted(file.name for file in tmp_path.rglob("*.*")) == ["0-0.npy", "0-1.npy", "0-2.npy"]
