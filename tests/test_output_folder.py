"""The folder of a run is replaced whole: whoever edits, kills or doubles a run loses nothing."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import pytest

from tests.audit.long import many
from tests.output_run import NAMES, write
from tunneller_lib.__main__ import main
from tunneller_lib.atomic_write import list_files, output, writing

ROOT = Path(__file__).resolve().parents[1]


def run(folder, stamp):
    with output(folder) as new:
        write(new, stamp)


def start(folder, stamp, pause=0.0, last=-1, **options):
    command = [sys.executable, "-m", "tests.output_run", *map(str, (folder, stamp, pause, last))]
    return subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(ROOT)},
                            stderr=subprocess.DEVNULL, **options)  # fmt: skip


def whole(folder):
    """Return whose files a folder holds, all of them and no others, as its manifest lists them."""
    first, *lines = (folder / "manifest.txt").read_text().splitlines()
    stamp = first.removeprefix("# ").partition(";")[0]
    names = {*NAMES, f"only_{stamp}.csv"}
    assert {path.name for path in folder.iterdir()} == {*names, "manifest.txt"}
    assert {line.split("  ")[1] for line in lines} == names
    assert {(folder / name).read_text() for name in names} == {stamp}
    return stamp


def content(folder):
    return {path.name: path.is_file() and path.read_bytes() for path in folder.iterdir()}


@contextmanager
def mounted(*arguments):
    if sys.platform != "linux" or subprocess.run(["mount", *arguments]).returncode:
        pytest.skip("nothing may be mounted here")
    try:
        yield
    finally:
        subprocess.run(["umount", arguments[-1]], check=True)


# What a user does meanwhile


def append(path, text):
    path.write_bytes(path.read_bytes() + text)


CHANGES = {
    "notes.txt": lambda out: (out / "notes.txt").write_text("mine"),
    "3.csv": lambda out: append(out / "3.csv", b"mine"),
    "figures": lambda out: (out / "figures").mkdir(),
    "manifest.txt": lambda out: append(out / "manifest.txt", b"# mine\n"),
    "manifest.txt ": lambda out: append(out / "manifest.txt", b"\xff"),
    "manifest.txt  ": lambda out: (out / "manifest.txt").write_text(
        (out / "manifest.txt").read_text().replace("# first", "# first, mine")),
    ".hidden": lambda out: (out / ".hidden").symlink_to("nowhere"),
}  # fmt: skip


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("late", [False, True])
def test_output_refuses_what_a_user_changed_and_keeps_the_new_results(tmp_path, change, late):
    out = tmp_path / "cut"
    run(out, "first")
    if not late:
        CHANGES[change](out)
        before = content(out)
    with pytest.raises(FileExistsError) as refused, output(out) as new:
        assert late, "refused before anything is written"
        write(new, "second")
        CHANGES[change](out)
        before = content(out)
    assert refused.value.filename == str(out)
    assert f"holds {change.strip()}, which isn't as a run has left it" in refused.value.strerror
    assert content(out) == before
    there = {"cut", "cut.new"} if late else {"cut"}
    assert {path.name for path in tmp_path.iterdir()} == there
    if late:
        assert refused.value.strerror.endswith(f"the new results are in {tmp_path / 'cut.new'}")
        assert whole(tmp_path / "cut.new") == "second"


def test_output_refuses_what_came_where_nothing_was_and_overwrites_no_other_folder(tmp_path):
    (tmp_path / "cut.new").write_text("mine")
    with pytest.raises(FileExistsError, match="has left it"), output(tmp_path / "cut") as new:
        write(new, "second")
        (tmp_path / "cut").mkdir()
        (tmp_path / "cut" / "0.csv").write_text("mine")
    assert content(tmp_path / "cut") == {"0.csv": b"mine"}
    assert (tmp_path / "cut.new").read_text() == "mine" and whole(tmp_path / "cut.new1") == "second"


def test_output_sees_what_changes_while_it_moves_the_folder(tmp_path, monkeypatch):
    run(tmp_path / "cut", "first")
    rename = os.rename

    def edited(source, target):
        if Path(source) == tmp_path / "cut":
            CHANGES["3.csv"](tmp_path / "cut")
        rename(source, target)

    with pytest.raises(FileExistsError, match=r"3\.csv"), output(tmp_path / "cut") as new:
        write(new, "second")
        monkeypatch.setattr("os.rename", edited)
    assert (tmp_path / "cut" / "3.csv").read_text() == "firstmine"
    assert len(content(tmp_path / "cut")) == 17


def test_manifest_is_checked_by_sha256sum(tmp_path):
    run(tmp_path, "first")
    done = subprocess.run(["sha256sum", "--strict", "-c", "manifest.txt"], cwd=tmp_path,
                          text=True, capture_output=True)  # fmt: skip
    assert done.returncode == 0 and done.stdout.count(": OK\n") == 16


# Folders that stay where they are


@contextmanager
def stay(kind, out, monkeypatch):
    """Make a folder stay where it is: it is mounted, worked in, or said to be either."""
    rename = os.rename

    def across(source, target):
        if Path(source) == out:
            raise OSError(18, "Invalid cross-device link", str(source))
        rename(source, target)

    if kind == "disk":
        with mounted("-t", "tmpfs", "tmpfs", str(out)):
            yield
    elif kind == "bind":
        (out.parent / "elsewhere").mkdir()
        with mounted("--bind", str(out.parent / "elsewhere"), str(out)):
            yield
    else:
        if kind == "worked in":
            (out / "deep").mkdir()
            monkeypatch.chdir(out)
            (out / "deep").rmdir()
        elif kind == "said to be mounted":
            monkeypatch.setattr("os.path.ismount", lambda path: Path(path) == out)
        elif kind == "parent":
            monkeypatch.setattr("os.access", lambda path, _: Path(path) != out.parent)
        else:
            monkeypatch.setattr("os.rename", across)
        yield


STAYING = ["disk", "bind", "worked in", "said to be mounted", "parent", "told at the end"]


@pytest.mark.parametrize("kind", STAYING)
def test_output_fills_a_folder_that_cannot_be_moved(tmp_path, monkeypatch, kind):
    out = tmp_path / "cut"
    out.mkdir()
    with stay(kind, out, monkeypatch):
        there = out.stat().st_ino
        for stamp in ("first", "second"):
            run(out, stamp)
            assert whole(out) == stamp and out.stat().st_ino == there
        with pytest.raises(FileExistsError, match=r"3\.csv.*new results are in") as refused:
            with output(out) as new:
                write(new, "third")
                CHANGES["3.csv"](out)
        kept = Path(refused.value.strerror.rpartition(" are in ")[2])
        assert whole(kept) == "third"
        shutil.rmtree(kept)
        (out / "3.csv").write_text("second")
        assert whole(out) == "second"
    assert {path.name for path in tmp_path.iterdir()} <= {"cut", "elsewhere"}


# A full disk


def test_output_names_the_file_that_found_no_room(tmp_path):
    (tmp_path / "disk").mkdir()
    with mounted("-t", "tmpfs", "-o", "size=128k", "tmpfs", str(tmp_path / "disk")):
        out = tmp_path / "disk" / "cut"
        run(out, "first")
        with pytest.raises(OSError) as full, output(out) as new:
            new.mkdir()
            with writing(new / "wall.stl"), (new / "wall.stl").open("wb") as file:
                file.write(bytes(10**6))
        assert (full.value.strerror, full.value.filename) == (
            "No space left on device", str(out / "wall.stl"))  # fmt: skip
        assert whole(out) == "first" and content(out.parent) == {"cut": False}


def test_list_files_names_the_manifest_that_found_no_room(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    with pytest.raises(OSError) as told:
        list_files(tmp_path, "first")
    assert told.value.filename == str(tmp_path / "manifest.txt")


# Runs that end early, or two of them


@pytest.mark.parametrize("fails", [0, 1, 2])
@pytest.mark.parametrize("error", [KeyboardInterrupt, PermissionError])
def test_output_that_fails_midway_leaves_one_run_whole(tmp_path, monkeypatch, fails, error):
    run(tmp_path / "cut", "first")
    rename, number = os.rename, count()

    def one(*paths):
        if next(number) == fails:
            raise error
        rename(*paths)

    monkeypatch.setattr("os.rename", one)
    with pytest.raises(error), output(tmp_path / "cut") as new:
        write(new, "second")
    # The third rename brings the new folder, after the earlier one was given up.
    assert whole(tmp_path / "cut") == ("second" if fails == 2 else "first")
    kept = {"cut.new"} if fails < 2 and error is PermissionError else set()
    assert {path.name for path in tmp_path.iterdir()} == {"cut", *kept}
    assert all(whole(tmp_path / name) == "second" for name in kept)


def test_output_without_a_new_folder_leaves_the_earlier_one(tmp_path):
    run(tmp_path / "cut", "first")
    with pytest.raises(FileNotFoundError), output(tmp_path / "cut"):
        pass
    assert whole(tmp_path / "cut") == "first" and content(tmp_path) == {"cut": False}


def test_output_of_two_processes_at_once_is_that_of_one(tmp_path):
    stamps = ["first", "second", "third"]
    processes = [start(tmp_path / "cut", stamp, 0.01) for stamp in stamps]
    ended = [process.wait() for process in processes]
    assert 0 in ended and set(ended) <= {0, 1}
    assert ended[stamps.index(whole(tmp_path / "cut"))] == 0
    assert content(tmp_path) == {"cut": False}


def test_output_is_refused_while_another_run_writes_there(tmp_path):
    with output(tmp_path / "cut") as new:
        with pytest.raises(BlockingIOError, match="another run"), output(tmp_path / "cut"):
            pytest.fail("two at once")
        write(new, "first")
    assert whole(tmp_path / "cut") == "first" and content(tmp_path) == {"cut": False}


def test_output_without_locks_takes_no_folder_that_may_be_another_s(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fcntl", None)
    run(tmp_path / "cut", "first")
    with output(tmp_path / "cut") as new:
        with pytest.raises(BlockingIOError, match=r"move .*\.cut\.unfinished elsewhere"):
            run(tmp_path / "cut", "third")
        write(new, "second")
    assert whole(tmp_path / "cut") == "second" and content(tmp_path) == {"cut": False}


def settled(folder):
    """Return whose files lie at a place after a run that did nothing but begin."""
    with pytest.raises(KeyError), output(folder):
        raise KeyError
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]
    return whole(folder)


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
@pytest.mark.parametrize("inside", [False, True])
def test_output_killed_at_any_rename_is_settled_by_the_next_run(tmp_path, inside):
    out = tmp_path / "cut"
    run(out, "first")
    # Old files, `old` itself, new ones: as many renames as an exchange has.
    last = 17 + 1 + 17 if inside else 3
    kills = sorted({0, 1, 16, 17, 18, 19, 33, 34, *range(many(0, 35))}) if inside else range(3)
    for kill in [*kills, last]:
        process = start(out, "second", last=kill, cwd=out if inside else tmp_path)
        ended = process.wait()
        assert ended == (0 if kill == last else -signal.SIGKILL)
        if kill < last and not inside and out.exists():
            assert whole(out) == "first"
        stamp = settled(out)
        assert stamp == ("second" if kill > (17 if inside else 1) else "first")
        run(out, "first")


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_output_interrupted_at_random_leaves_one_run_whole(tmp_path):
    rng, out = random.Random(1), tmp_path / "cut"
    run(out, "first")
    for k in range(many(9, 60)):
        before, now = whole(out), f"run{k}"
        process = start(out, now, 0.01)
        time.sleep(rng.uniform(0.05, 0.4))
        process.send_signal([signal.SIGINT, signal.SIGTERM, signal.SIGKILL][k % 3])
        process.wait()
        if k % 3 < 2 or out.exists():  # SIGKILL may come when the earlier one is moved aside
            assert whole(out) in (before, now)
        assert settled(out) in (before, now)
    run(out, "last")
    assert content(tmp_path) == {"cut": False} and whole(out) == "last"


@pytest.mark.skipif(os.name != "posix", reason="SIGTERM")
def test_cut_is_ended_by_sigterm_as_by_an_interrupt(tmp_path):
    job = ROOT / "tunneller_lib" / "job" / "reference.toml"
    process = subprocess.Popen([sys.executable, "-m", "tunneller_lib", "cut", job, "--out",
                                tmp_path / "cut"], cwd=ROOT, text=True, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)  # fmt: skip
    while "simulating" not in process.stderr.readline():
        assert process.poll() is None
    process.terminate()
    _, told = process.communicate()
    assert process.returncode == 130 and told.endswith("interrupted\n")
    assert list(tmp_path.iterdir()) == []


def test_cut_refuses_a_folder_before_it_plans_and_names_the_file(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    job = ROOT / "tunneller_lib" / "job" / "reference.toml"
    assert main(["cut", str(job), "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert told == (f"wrong: {tmp_path}: holds notes.txt, which isn't as a run has left it; "
                    "move it elsewhere, or give another --out.\n")  # fmt: skip
