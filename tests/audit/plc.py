"""Run the exported configuration, compiled by MatIEC's iec2c, and have its XML read: `make plc`.

The Structured Text runs by its own tasks and intervals, scan by scan beside the C99, on the
library's axes and with random inputs. What came of it goes to tests/audit/plc.md.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import closing, suppress
from itertools import islice
from pathlib import Path

import numpy as np

from tests.audit.long import git
from tests.controllers import (
    ANSWER,
    COMPILER,
    DISABLED,
    ERROR_STOP,
    FULL,
    INPUTS,
    OUTPUTS,
    REALS,
    SANITIZERS,
    Driven,
    build,
    c99_program,
    closed_loop,
    job_with,
    main_program,
    moved,
    with_program,
)
from tunneller_lib.job.controller_texts import plcopen_xml
from tunneller_lib.job.reader import Job
from tunneller_lib.motion.stability import gain_limit

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "tests" / "audit" / "plc.md"
RANDOM = 10
SCANS = 20_000  # of each comparison with random inputs
OIL, CORRECTED = {"plant": "T3"}, {"path": "corrected chord", "laps": 2}
STRICT = "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"
HOW_TO_GET_IT = {
    "IEC2C": "No iec2c is on PATH or at IEC2C; it comes of https://github.com/beremiz/matiec by "
    "`autoreconf -i && ./configure && make` with flex and bison, and wants its lib beside it.",
    "SCHEMA": "No SCHEMA: PLCopen's tc6_xml_v201.xsd, as Beremiz has it in plcopen; it needs "
    "xmllint, of libxml2.",
    "BEREMIZ": "No BEREMIZ: a clone of https://github.com/beremiz/beremiz.",
    "XML2ST": "No XML2ST: a clone of https://github.com/Autonomy-Logic/xml2st, OpenPLC's reader.",
}
# Both readers are of one descent. A missing module that looks for controllers in a network, and
# windows, aren't needed to read a file.
READER = """
import sys
from importlib.util import find_spec
from unittest.mock import MagicMock
sys.path.insert(0, sys.argv[1])
if find_spec("fake_wx"):
    sys.modules["zeroconf"] = MagicMock()
    import fake_wx, controls
from PLCControler import PLCControler
from PLCGenerator import GenerateCurrentProgram
reader = PLCControler()
complaints = [said for said in [reader.OpenXMLFile(sys.argv[2])] if said is not None]
chunks = GenerateCurrentProgram(reader, reader.Project, complaints, complaints)
if complaints:
    sys.exit(f"{complaints}")
with open(sys.argv[3], "w") as file:
    file.write("".join(text for text, *_ in chunks))
"""
# iec2c's library asks for the time, which nothing here does.
HEAD = """#include <stdbool.h>
#include <stdint.h>
#include <iec_std_lib.h>
TIME __CURRENT_TIME;
#include "Tunneller.c"
#include "Controller.c"
static unsigned long tick;
"""
SCAN = "config_run__(tick++)"


def jobs():
    """Yield what is tried: a name and a job."""
    yield "the reference job, T3", job_with(controller=OIL)
    yield "corrected chords, two laps, T3", job_with(controller=OIL, plan=CORRECTED)
    # In single precision, as iec2c reads it, 4.1 is less.
    odd = CORRECTED | {"tick": 4.1e-3, "step": 8e-3, "laps": 1}
    yield "a tick of 4.1 ms, corrected chords, T3", job_with(controller=OIL, plan=odd)
    for number, wanted in enumerate(islice(random_jobs(11), RANDOM), start=1):
        about = f"{wanted.section['shape']}, {wanted.plan['path']}, {wanted.controller['plant']}"
        yield f"random job {number}: {about}", wanted


def random_jobs(seed):
    """Yield random jobs that aren't refused, without end: machines, sections, feeds, loops."""
    rng = np.random.default_rng(seed)
    while True:
        wanted = _random_job(rng)
        with suppress(ValueError):
            axes, loops = wanted.axes
            turns = wanted.planned.setvalues
            angles = np.linspace(turns.min(axis=0), turns.max(axis=0), 5).T
            limit = min(map(gain_limit, axes, loops, angles))
            wanted = job_with(wanted, controller={"gain": min(limit * rng.uniform(0.2, 0.7), 30.0)})
            with_program(wanted)
            yield wanted


def _random_job(rng):
    """Return a random job, which may be refused."""
    R = rng.uniform(0.6, 1.1)
    shape = rng.choice(["egg", "circle"])
    size = R * rng.uniform(0.5, 0.75)
    low, high, swing = np.radians(rng.uniform([-60, 30, 35], [-50, 35, 40]))
    tick = float(rng.choice([2e-3, 5e-3, 10e-3]))
    feed = rng.uniform(0.03, 0.25)
    return Job(
        hydraulics={},
        ground={},
        body={},
        machine={
            "r": R * rng.uniform(0.02, 0.25), "R": R, "theta_min": low, "theta_max": high,
            "phi_min": -swing, "phi_max": swing, "cutter_radius": R * rng.uniform(0.15, 0.3),
            "depth": rng.uniform(0.005, 0.03), "height": -R * rng.uniform(0.2, 0.6),
        },
        section={"shape": str(shape), {"egg": "a", "circle": "radius"}[str(shape)]: size},
        limits={"feed": feed, "acceleration": rng.uniform(0.2, 1.5)},
        plan={
            "tolerance": rng.uniform(5e-4, 3e-3), "step": max(5e-3, 1.5 * feed * tick),
            "tick": tick, "count": 2 * np.pi / 2 ** int(rng.integers(15, 20)),
            "rest": rng.uniform(0, 1), "laps": int(rng.integers(1, 3)), "advance": 0.03,
            "path": str(rng.choice(["projected chord", "corrected chord"])),
        },
        controller={
            "plant": str(rng.choice(["T0", "T1", "T2", "T3"])), "gain": 1.0,
            "feedforward": float(rng.choice([0, 0.5, 1])), "delay": int(rng.integers(0, 3)),
        },
        stance={}, pose={}, wall={"along": 60, "around": 120},
    )  # fmt: skip


def short(wanted):
    """Return whether a job has two laps that don't take long."""
    return wanted.plan["laps"] == 2 and 2 * wanted.planned.ticks.sum() < SCANS / 6


def translated(folder, text, blocks=""):
    """Return the C files of a Structured Text, by their names, as iec2c makes them in a folder."""
    folder.mkdir()
    (folder / "controller.st").write_text(text)
    (folder / "blocks.st").write_text(blocks)
    iec2c = Path(found("IEC2C")).resolve()
    command = [iec2c, "-I", iec2c.parent / "lib", "controller.st"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise ValueError(f"iec2c: {done.stderr.strip()}")
    return {path.name: path.read_text() for path in sorted(folder.glob("*.[ch]"))}


def configuration(folder, made, *options):
    """Return the path of a controller's Structured Text as iec2c and a C compiler make it."""
    units = translated(folder, made.text, made.blocks)
    # It calls in each such time, which must be the fast task's interval, then.
    (common,) = re.findall(r"common_ticktime__ = (\d+)ULL \* 1ULL;", units["Tunneller.c"])
    fast = re.search(r"TASK Fast\(INTERVAL := T#(.*)ms,", made.text)[1]
    if int(common) != round(1e6 * float(fast)):
        raise ValueError(f"the tasks' intervals are multiples of {common} ns")
    # Every variable is in capitals there, and its value is in a field.
    place = lambda name: f"CONTROLLER__FASTTASK.TUNNELLER.{name.upper()}.value"  # noqa: E731
    text = HEAD + main_program(place, "config_init__()", "", SCAN)
    library = Path(found("IEC2C")).resolve().parent / "lib" / "C"
    return build(COMPILER, folder, text, "-O2", "-w", *options, f"-I{library}")


class Both:
    """The exported configuration and the C99 side by side, scan by scan with the same inputs.

    The configuration calls its slow task after the fast one of a tick, and the C99's is called like
    that, too.
    """

    def __init__(self, folder, made, *options):
        (folder / "c99").mkdir()
        self.texts = Driven(configuration(folder / "iec", made, *options))
        self.c99 = Driven(c99_program(COMPILER, folder / "c99", made, *STRICT, "-O2", *options))
        self.c = self.texts.c
        self.period = made.slow
        self.scans = self.different = 0

    def slow(self):
        """Nothing: the configuration has its own interval."""

    def fast(self):
        for name in INPUTS:
            setattr(self.c99.c, name, getattr(self.c, name))
        self.texts.fast()
        self.c99.fast()
        if self.scans % self.period == 0:
            self.c99.slow()
        self.scans += 1
        one, other = (
            ANSWER.pack(*(getattr(each.c, name) for name in OUTPUTS + REALS))
            for each in (self.texts, self.c99)
        )
        self.different += one != other

    def close(self):
        for each in (self.texts, self.c99):
            if each.close():
                raise RuntimeError("a controller ended with an error")


def planned():
    """Yield a row of the table for each job that runs as it is planned."""
    for name, wanted in jobs():
        made = with_program(wanted)
        plan = wanted.planned
        counts = np.rint(moved(plan)[0] / plan.count)
        # To the start position at up to a trip's way, and a full ring.
        approach, ring, at_once = (int(re.search(rf"{name} : .*DINT := \[?(\d+)", made.text)[1])
                                   for name in ("aTicks", "nRing", "nAtOnce"))  # fmt: skip
        before = 2 * approach + (ring // at_once + 3) * made.slow
        with tempfile.TemporaryDirectory() as folder, closing(Both(Path(folder), made)) as both:
            track = closed_loop(both, wanted, made, before + len(counts) + 10 * plan.laps)
        if not track[-1, 7]:
            raise ValueError(f"{name}: not at its end after {both.scans} scans")
        ran, wrong = compared(track, plan, counts)
        yield (
            name, f"{1e3 * plan.tick:g} and {1e3 * plan.tick * made.slow:g}", f"{both.scans:,}",
            both.different, f"{len(counts) - 1:,}", f"{ran:,}", wrong,
        )  # fmt: skip


def compared(track, plan, counts):
    """Return how many scans a run took, and in how many set-values aren't the library's.

    Its set-values at the same instant, which the sum of the time scales tells; between two ticks
    those between their set-values, truncated. A lap ends at a tick.
    """
    ticks = [plan.entry.ticks.sum(), *[plan.ticks.sum()] * plan.laps, plan.leave.ticks.sum()]
    laps = np.cumsum(ticks)[1:-2] * FULL  # those with a step behind them
    at = wrong = 0
    # The run's, without the way to the start position.
    moving = track[(track[:, 9] > 0) & (track[:, 8] == 1)]
    for row in moving:
        tick, part = divmod(at, FULL)
        way = (counts[tick + 1] - counts[tick]) * part / FULL
        wrong += bool(np.any(row[:2] != counts[tick] + np.trunc(way)))
        after = min(at + int(row[9]), (len(counts) - 1) * FULL)
        at = int(next((end for end in laps if at < end <= after), after))
    wrong += bool(np.any(track[-1, :2] != counts[-1])) + (at != (len(counts) - 1) * FULL)
    return len(moving), wrong


def pressed(both, wanted, scans, seed):
    """Drive a controller with random inputs; return how often states and errors were seen."""
    rng = np.random.default_rng(seed)
    c, plan = both.c, wanted.planned
    first = plan.entry.setvalues[0] / plan.count
    ratio = plan.count / wanted.axes[1][0].count
    at, frozen, fault = first.copy(), first, None
    seen = Counter()
    for n in range(scans):
        if n % 20 == 0:
            u = rng.random(8)
            c.bEnable, c.bHold, c.bReset, c.bStart, c.bStepDone = map(
                int, u[:5] < (0.998, 0.01, 0.3, 0.5, 0.5)
            )
            if u[5] < 0.5:
                c.nOverride = int(rng.integers(-1000, 1001)) if u[5] < 0.05 else 256
            if u[6] < 0.004:
                fault = ("freeze", "jump", "wrap")[int(rng.integers(3))]
            elif u[7] < 0.2:
                fault = None
        if c.nState in (DISABLED, ERROR_STOP) and rng.random() < 0.05:
            at = first + rng.normal(0, 30, 2)  # jogged back
        if fault == "jump":
            frozen = at + rng.normal(0, 1e5, 2)
        elif fault == "wrap":
            frozen = at + 2**31 - 1 - first
        elif fault is None:
            frozen = at
        c.nActualTheta, c.nActualPhi = (
            (int(count) + 2**31) % 2**32 - 2**31 for count in np.rint(ratio * frozen)
        )
        steps, done = c.bStepRequest, c.bDone
        both.fast()
        if c.nState not in (DISABLED, ERROR_STOP):
            at = at + 0.7 * (np.array([c.nSetTheta, c.nSetPhi]) - at)
        seen.update([f"state {c.nState}", f"error {c.nErrorId}"])
        seen["steps"] += c.bStepRequest > steps
        seen["runs"] += c.bDone > done
    return seen


def random_inputs():
    """Yield a row of the table for each job with random inputs, both programs under sanitizers."""
    plain = job_with(controller={"plant": "T0"}, plan={"laps": 2})
    cases = (
        ("the reference job, T0, two laps", plain),
        ("corrected chords, two laps, T3", job_with(controller=OIL, plan=CORRECTED)),
        ("a random job of short laps, two", next(filter(short, random_jobs(12)))),
    )
    for seed, (name, wanted) in enumerate(cases):
        made = with_program(wanted)
        options = *SANITIZERS, "-g"
        with (
            tempfile.TemporaryDirectory() as folder,
            closing(Both(Path(folder), made, *options)) as both,
        ):
            seen = pressed(both, wanted, SCANS, seed)
        yield (
            name, f"{both.scans:,}", both.different,
            *(" ".join(f"{seen[f'{kind} {n}']:,}" for n in range(5 if kind == "state" else 4))
              for kind in ("state", "error")),
            seen["runs"], seen["steps"],
        )  # fmt: skip


def found(name):
    """Return where a tool is that an environment variable names, or None."""
    return os.environ.get(name) or (shutil.which("iec2c") if name == "IEC2C" else None)


def version(name):
    """Return the commit of a tool."""
    place = Path(found(name)).resolve()
    folder = place if place.is_dir() else place.parent
    return git("describe", "--always", folder=folder) or "unknown"


def checked_xml():
    """Yield sentences about the PLCopen XML of some jobs: schema, and what readers make of it."""
    for name in ("SCHEMA", "BEREMIZ", "XML2ST"):
        if not found(name):
            yield HOW_TO_GET_IT[name]
            continue
        count = 0
        for _, wanted in jobs():
            made = with_program(wanted)
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder, "controller.xml")
                file.write_text(plcopen_xml(made), encoding="utf-8")
                if name == "SCHEMA":
                    command = ["xmllint", "--noout", "--schema", found(name), file]
                else:
                    st = Path(folder, "read.st")
                    command = [sys.executable, "-B", "-c", READER, found(name), file, st]
                done = subprocess.run(command, capture_output=True, text=True)
                if done.returncode:
                    raise ValueError(f"{name}: {done.stderr.strip()}")
                if name != "SCHEMA":
                    ours = translated(Path(folder, "ours"), made.text, made.blocks)
                    if translated(Path(folder, "theirs"), st.read_text()) != ours:
                        raise ValueError(f"{name} reads other statements")
            count += 1
        if name == "SCHEMA":
            yield f"The XML of all {count} jobs is valid by {Path(found(name)).name} (xmllint)."
        else:
            reader = {"BEREMIZ": "Beremiz", "XML2ST": "OpenPLC's xml2st"}[name]
            yield (
                f"{reader} at {version(name)} reads the XML of all {count} without complaint, and "
                "iec2c makes of its text the same C, byte for byte, as of the exported text."
            )


def table(*head, rows):
    """Return the lines of a table, which are printed as they come."""
    lines = ["", f"| {' | '.join(head)} |", "|" + " --- |" * len(head)]
    for row in rows:
        lines.append(f"| {' | '.join(map(str, row))} |")
        print(lines[-1], flush=True)
    return lines


def main():
    if not found("IEC2C"):
        print(HOW_TO_GET_IT["IEC2C"])
        return 1
    if not COMPILER:
        print("There is no C compiler here, for the C that iec2c writes.")
        return 1
    begun = time.monotonic()
    commit = git("describe", "--always", "--dirty")
    runs = table(
        "job", "tasks, ms", "scans", "other than the C99", "ticks of the plan",
        "scans of the run", "set-values other than the library's", rows=planned(),
    )  # fmt: skip
    presses = table(
        "job", "scans", "other than the C99", "scans in states 0 to 4", "with errors 0 to 3",
        "runs to the end", "steps asked for", rows=random_inputs(),
    )  # fmt: skip
    xml = list(checked_xml())
    print(*xml, sep="\n")
    gcc = subprocess.run([COMPILER, "--version"], text=True, capture_output=True).stdout
    lines = [
        "# The exported configuration, run",
        "",
        f"`make plc` on {time.strftime('%F')} at {commit}, {time.monotonic() - begun:.0f} s: "
        f"MatIEC's iec2c at {version('IEC2C')}, {gcc.splitlines()[0]}. The configuration runs as "
        "it is exported, by `config_run__` with its own tasks and intervals; beside it the C99, "
        "which gets the same inputs. A scan differs where any bit of set-values, valves, state, "
        "time scale, slopes or any other output does.",
        "",
        "In closed loop with the library's axes, from power-on to `bDone`. The library's "
        "set-values are those at the instant that the sum of the time scales tells:",
        *runs,
        "",
        f"With random inputs, both programs under sanitizers ({', '.join(SANITIZERS)}), the C99 "
        f"without a warning by {' '.join(STRICT)}. Random are enable, hold, start, reset, step "
        "done, an override from -1000 to 1000, and encoders that freeze, jump and wrap:",
        *presses,
        "",
        " ".join(xml),
    ]  # fmt: skip
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return int(any(row.split(" | ")[i] != "0" for lines, i in ((runs, 3), (presses, 2))
                   for row in lines[3:]))  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
