"""What a command leaves: one job's files whole, whatever happens to it, and a user's untouched."""

import os
import re
import shutil
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from tests.examples.job import _JOB
from tunneller_lib.__main__ import main
from tunneller_lib.job.atomic_write import list_files, output
from tunneller_lib.job.tables import stamp_of

READS = []

ROOT = Path(__file__).resolve().parents[1]
LATER = _JOB.read_text(encoding="utf-8").replace("gain = 10", "gain = 9")
BAD = LATER.replace("gain = 9", "gain = 1000")
JOBS = {"earlier": _JOB.read_text(encoding="utf-8"), "later": LATER, "bad": BAD}


def told_by(folder):
    """Return whose files are in a folder that is whole: each as listed and of the same job."""
    first, *lines = (folder / "manifest.txt").read_text().splitlines()
    names = set()
    for line in lines:
        digest, name = line.split("  ")
        content = (folder / name).read_bytes()
        assert sha256(content).hexdigest() == digest, name
        stamp = first.removeprefix("# ").partition(";")[0].encode()
        assert stamp in content or (name.endswith(".csv") and name != "plan.csv"), name
        names.add(name)
    assert {path.name for path in folder.iterdir()} == {*names, "manifest.txt"}
    assert len(names) > 11
    name, digest = re.search(r"job (\w+)\.toml, sha256 (\w+);", first).groups()
    assert sha256(JOBS[name].encode()).hexdigest().startswith(digest)
    return name


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    """Return a folder with the jobs, and the results of one where nothing was in the way."""
    folder = tmp_path_factory.mktemp("jobs")
    for name, text in JOBS.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    assert main(["cut", str(folder / "earlier.toml"), "--out", str(folder / "earlier")]) == 0
    return folder


def cut(jobs, name, out):
    return main(["cut", str(jobs / f"{name}.toml"), "--out", str(out)])


def test_files_say_which_job_they_are_of(jobs):
    assert told_by(jobs / "earlier") == "earlier"
    # By another program, where there is one.
    if Path("/usr/bin/sha256sum").exists():
        check = ["sha256sum", "--check", "--strict", "manifest.txt"]
        subprocess.run(check, cwd=jobs / "earlier", check=True, stdout=subprocess.DEVNULL)


def test_same_job_gives_the_same_bytes_through_a_link_over_a_system_s_litter(jobs, tmp_path):
    (tmp_path / "disk" / "again").mkdir(parents=True)
    (tmp_path / "disk" / "again" / ".DS_Store").write_bytes(b"")
    (tmp_path / "again").symlink_to(tmp_path / "disk" / "again")
    assert cut(jobs, "earlier", tmp_path / "again") == 0
    assert (tmp_path / "again").is_symlink()
    names = {path.name for path in (jobs / "earlier").iterdir()}
    assert names == {path.name for path in (tmp_path / "disk" / "again").iterdir()}
    for name in names:
        assert (jobs / "earlier" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_stamp_keeps_to_letters_that_any_comment_may_hold():
    stamp = stamp_of('*/ -->\n*) "é".toml' + 99 * "x", b"text")
    assert re.fullmatch(r"tunneller_lib [\d.]+, job [\w.]{20}, sha256 [0-9a-f]{16}", stamp, re.A)


KILLED = """
import os, shutil, sys
from pathlib import Path
from tunneller_lib import __main__ as command
from tunneller_lib.job import results
from tests.test_output import told_by

jobs, place = map(Path, sys.argv[1:])

def files(job, *_):
    # Write what no simulation is needed for.
    folder = place / ".cut.tunneller" / "new" / "cut"
    folder.mkdir()
    made = [folder / f"{n}.txt" for n in range(12)]
    for file in made:
        file.write_text(job.stamp)
    return made

command.simulated = lambda job: None
results.summarise = lambda *_: {"warnings": []}
results.summary_text = lambda numbers: ""
results.write_all = files
command.draw_wall = lambda *_: []
arguments = ["cut", str(jobs / "later.toml"), "--out", str(place / "cut")]
sys.stderr = open(os.devnull, "w")

def ended(after):
    # Return the exit code of a cut that is killed before it touches a file once more.
    if not (child := os.fork()):
        left = [after]
        def count(event, about):
            if about and str(about[0]).startswith(str(place)):
                left[0] -= 1
                if left[0] < 0:
                    os._exit(99)
        sys.addaudithook(count)
        sys.stdout = sys.stderr
        os._exit(command.main(arguments))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

after, seen = 0, []
while True:
    for path in place.iterdir():
        shutil.rmtree(path)
    shutil.copytree(jobs / "earlier", place / "cut")
    code = ended(after)
    seen.append(told_by(place / "cut") if (place / "cut").exists() else "none")
    if code == 0:
        break
    assert code == 99, code
    if after % 5 == 0 or seen[-1] == "none":  # the next run ends well and leaves nothing behind
        assert ended(9**9) == 0 and told_by(place / "cut") == "later"
        assert [path.name for path in place.iterdir()] == ["cut"]
    after += 1
print(*seen)
"""


def test_cut_killed_anywhere_leaves_the_files_of_one_job(jobs, tmp_path):
    command = [sys.executable, "-c", KILLED, jobs, tmp_path]
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    seen = done.stdout.split()
    assert seen.count("earlier") > 30 and seen.count("later") > 3 and seen.count("none") == 1
    assert seen == sorted(seen, key=["earlier", "none", "later"].index)


def test_second_run_into_a_folder_is_refused_in_a_sentence(jobs, tmp_path, capsys):
    out = tmp_path / "cut"
    with output(out) as new:
        new.mkdir()
        list_files(new, "tunneller_lib")
        assert cut(jobs, "later", out) == 2
    told = capsys.readouterr().err
    assert told == f"wrong: {out}: another run is writing there.\n" and out.exists()


def test_job_that_is_refused_leaves_none_of_an_earlier_run_in_its_place(jobs, tmp_path, capsys):
    out = tmp_path / "cut"
    for number in ("", "1"):
        assert cut(jobs, "later", out) == 0 and cut(jobs, "bad", out) == 1
        *_, said, why = capsys.readouterr().err.splitlines()
        assert said == f"{out}: what an earlier run left there is now {out}.earlier{number}"
        assert why.startswith("refused: ") and not out.exists()
        assert told_by(Path(f"{out}.earlier{number}")) == "later"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.earlier", "cut.earlier1"]
    assert main(["cut", str(tmp_path / "none.toml"), "--out", str(tmp_path / "a" / "b")]) == 2
    assert not (tmp_path / "a").exists()


def test_run_that_is_interrupted_leaves_the_earlier_one(jobs, tmp_path, monkeypatch):
    shutil.copytree(jobs / "earlier", tmp_path / "cut")

    def stop(*_, **__):
        raise KeyboardInterrupt

    for place in ("job.results.summarise", "__main__.draw_wall", "job.atomic_write.list_files"):
        with monkeypatch.context() as patch:
            patch.setattr(f"tunneller_lib.{place}", stop)
            assert cut(jobs, "later", tmp_path / "cut") == 130
        assert told_by(tmp_path / "cut") == "earlier"
        assert [path.name for path in tmp_path.iterdir()] == ["cut"]


def renaming(monkeypatch, fails, error):
    """Let the renaming with a number fail with an error."""
    rename, count = os.rename, iter(range(99))

    def one(*paths):
        if next(count) == fails:
            raise error
        rename(*paths)

    monkeypatch.setattr("os.rename", one)


@pytest.mark.parametrize(("fails", "error", "left"), [
    (0, KeyboardInterrupt(), "cut"), (1, KeyboardInterrupt(), "cut"),
    (0, PermissionError(13, "no"), "cut.earlier"), (1, PermissionError(13, "no"), "cut.earlier"),
])  # fmt: skip
def test_exchange_that_fails_midway_keeps_the_earlier_run(
    jobs, tmp_path, monkeypatch, fails, error, left
):
    shutil.copytree(jobs / "earlier", tmp_path / "cut")
    renaming(monkeypatch, fails, error)
    with pytest.raises(type(error)), output(tmp_path / "cut") as new:
        new.mkdir()
    assert [path.name for path in tmp_path.iterdir()] == [left]
    assert told_by(tmp_path / left) == "earlier"


CHANGES = {
    "a note": lambda out: (out / "notes.txt").write_text("mine"),
    "an edit": lambda out: (out / "budget.csv").write_text("mine"),
    "a folder": lambda out: (out / "figures").mkdir(),
    "a link": lambda out: ((out / "line.c").unlink(), (out / "line.c").symlink_to("controller.c")),
    "no manifest": lambda out: (out / "manifest.txt").unlink(),
}


@pytest.mark.parametrize("change", CHANGES)
def test_folder_that_holds_a_user_s_files_is_refused_and_stays(jobs, tmp_path, capsys, change):
    out = tmp_path / "cut"
    shutil.copytree(jobs / "earlier", out)
    CHANGES[change](out)
    before = {path: path.is_dir() or path.read_bytes() for path in out.iterdir()}
    assert cut(jobs, "later", out) == 2
    told = capsys.readouterr().err.splitlines()[-1]
    assert re.search(r"cut: holds [\w.]+, which isn't as a run has left it; move that else", told)
    assert {path: path.is_dir() or path.read_bytes() for path in out.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["cut"]


def test_files_that_a_user_leaves_during_the_run_are_kept_aside(jobs, tmp_path, capsys):
    out = tmp_path / "cut"
    shutil.copytree(jobs / "earlier", out)
    with output(out) as new:
        new.mkdir()
        list_files(new, "tunneller_lib")
        (out / "notes.txt").write_text("mine")
    assert (tmp_path / "cut.earlier" / "notes.txt").read_text() == "mine"
    assert [path.name for path in out.iterdir()] == ["manifest.txt"]
    assert capsys.readouterr().err.endswith(f"is now {out}.earlier\n")


def test_folder_where_one_is_isn_t_taken_away(jobs, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cut(jobs, "later", Path(".")) == 2
    assert ".: is a folder that is mounted, or the one where you are; " in capsys.readouterr().err


def test_disk_that_takes_no_more_is_told_with_the_folder(jobs, tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tunneller_lib.job.atomic_write.list_files", full)
    assert cut(jobs, "later", tmp_path / "cut") == 2 and list(tmp_path.iterdir()) == []
    assert capsys.readouterr().err.endswith(f"wrong: {tmp_path}/cut: No space left on device.\n")
