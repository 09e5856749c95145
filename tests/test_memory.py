"""What a command refuses for its memory, measured: the peak of three sizes; and endless files."""

import os
import subprocess
import sys
import tracemalloc
from contextlib import contextmanager

import numpy as np
import pytest

from tests.examples.job import _JOB
from tunneller_lib.__main__ import main
from tunneller_lib.job import mesh, read_job, reader, results
from tunneller_lib.job.tables import MOST_BYTES

READS = []

TEXT = _JOB.read_text(encoding="utf-8")
RAYS = "along = 4\naround = 12"


@contextmanager
def traced():
    """Give a function that returns the most memory that Python had since, in bytes."""
    tracemalloc.start()
    try:
        yield lambda: tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def changed(folder, changes):
    text = TEXT
    for old, new in changes.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "job.toml"
    path.write_text(text, encoding="utf-8")
    return path


# Its memory's peak is asked for by the process itself: what is told of it from outside counts the
# memory of the tests, too, from which it was begun.
COMMAND = """
import resource, sys
from pathlib import Path
from tunneller_lib.__main__ import main
assert main(sys.argv[1:]) == 0
said = Path("/proc/self/status")
if said.exists():
    lines = dict(line.split(":", 1) for line in said.read_text().splitlines())
    print(1024 * int(lines["VmHWM"].split()[0]))
else:
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def peak(folder, changes):
    """Return the most memory that a cut by a changed job ever had, in bytes."""
    arguments = ["cut", changed(folder, changes), "--out", folder / "out"]
    plain = {name: value for name, value in os.environ.items() if "MALLOC" not in name}
    done = subprocess.run([sys.executable, "-c", COMMAND, *arguments], env=plain, text=True,
                          capture_output=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return int(done.stdout.splitlines()[-1])


SIZES = 100, 500, 700  # rays, each way


def test_a_ray_takes_at_most_what_the_guard_counts(tmp_path):
    peaks = [peak(tmp_path, {RAYS: f"along = {n}\naround = {n}"}) for n in SIZES]
    a_ray, _ = np.polyfit(np.square(SIZES), peaks, 1)
    assert 0.2 * reader.A_RAY < a_ray < reader.A_RAY


def test_a_tick_takes_at_most_what_the_guard_counts(tmp_path, monkeypatch):
    # What halves a fault is the same faults once more, of few rows each.
    none = (None, None, None)
    monkeypatch.setattr(results, "halved_by", lambda job, faults, say: [none] * len(faults))
    peaks, ticks = [], []
    for tick in (1e-3, 1e-3, 5e-4, 2.5e-4):  # the first also brings compilers
        slow = {"tick = 0.02": f"tick = {tick}", "feed = 1.0": "feed = 0.5"}
        job = read_job(changed(tmp_path, slow))
        ticks.append(job.planned.ticks.sum())
        with traced() as most:
            cut = job.simulated()
            numbers = results.summarise(job, cut)
            results.write_all(job, cut, tmp_path / f"out {tick} {len(ticks)}", numbers, str)
            peaks.append(most())
    a_tick, _ = np.polyfit(ticks[1:], peaks[1:], 1)
    assert 0.5 * reader.A_TICK < a_tick < reader.A_TICK


def test_job_that_takes_too_much_is_refused_with_what_fits(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "allowed_memory", lambda: 500.0 * 60 * 40)
    job = read_job(changed(tmp_path, {RAYS: "along = 120\naround = 80"}))
    for run in (lambda: job.expected_seconds, job.simulated):
        with pytest.raises(ValueError, match=r"^\[wall\] along, around: 120 x 80 rays, with all "
                           r"that is made of them, need 0\.0048 GB, and 0\.0012 GB are allowed; "
                           r"60 x 40 would fit\.$"):  # fmt: skip
            run()
    assert read_job(changed(tmp_path, {RAYS: "along = 60\naround = 40"})).simulated()
    monkeypatch.setattr(reader, "allowed_memory", lambda: 1e5)
    with pytest.raises(ValueError, match=r"^\[plan\] tick, laps: \d+ ticks need 0\.000\d+ GB, and "
                       r"0\.0001 GB are allowed\.$"):  # fmt: skip
        read_job(changed(tmp_path, {})).simulated()


def test_wall_is_written_in_blocks_as_it_is_at_once(monkeypatch):
    points, faces = mesh.wall_solid(read_job(_JOB).simulated().wall)
    at_once = b"".join(mesh.stl(points, faces, "a"))
    monkeypatch.setattr(mesh, "BLOCK", 7)
    blocks = list(mesh.stl(points, faces, "a"))
    assert b"".join(blocks) == at_once and len(blocks) == 2 + -(-len(faces) // 7)


def test_endless_file_is_refused_before_it_is_read(tmp_path, capsys):
    if not os.path.exists("/dev/zero"):
        pytest.skip("there is no file without an end here")
    assert main(["cut", "/dev/zero", "--out", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert told == f"wrong: /dev/zero: is larger than a job may be, {MOST_BYTES} bytes.\n"
