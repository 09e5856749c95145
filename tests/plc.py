"""Run the exported Structured Text, compiled by MatIEC's iec2c: `make plc`; the result is kept.

The controllers of some jobs are compiled and run in closed loop with the library's axes, scan by
scan. What came of it goes to tests/plc.md. With SCHEMA=FILE, the PLCopen scheme tc6_xml_v201.xsd,
xmllint also checks the XML.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from itertools import islice
from pathlib import Path

from tests.controllers import (
    Driven,
    build,
    closed_loop,
    differences,
    followed,
    main_program,
    random_jobs,
    with_program,
)
from tunneller_lib.job import read_job
from tunneller_lib.job.controller_texts import plcopen_xml, structured_text_of

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "tests" / "plc.md"
REFERENCE_JOB = ROOT / "tests" / "references" / "reference_job.toml"
RANDOM = 10
HOW_TO_GET_IT = (
    "iec2c isn't on PATH; it comes of MatIEC, https://github.com/beremiz/matiec, by `autoreconf -i "
    "&& ./configure && make` with flex and bison, and wants that folder, lib and all, on PATH."
)


def jobs():
    """Yield what is tried: a name, a job and the options of its program."""
    whole = read_job(REFERENCE_JOB)
    oil = replace(whole, controller={**whole.controller, "plant": "T3"})
    yield "the reference job, T3", oil, {}
    yield "the same, the lap in constant arrays", oil, {"setpoints": "stored"}
    corrected = replace(oil, plan={**whole.plan, "path": "corrected chord", "laps": 2})
    yield "corrected chords, two laps, T3", corrected, {}
    for number, wanted in enumerate(islice(random_jobs(11), RANDOM), start=1):
        about = f"{wanted.section['shape']}, {wanted.plan['path']}, {wanted.controller['plant']}"
        yield f"random job {number}: {about}", wanted, {}


def compiled(compiler, folder, controller):
    """Return the path of a controller's Structured Text as iec2c and a C compiler make it."""
    iec2c = Path(shutil.which("iec2c")).resolve()
    library = iec2c.parent / "lib"
    (folder / "controller.st").write_text(structured_text_of(controller))
    done = subprocess.run(
        [iec2c, "-I", library, "controller.st"], cwd=folder, capture_output=True, text=True
    )
    if done.returncode:
        raise ValueError(f"iec2c: {done.stderr.strip()}")
    # Every variable is in capitals there, and an input's value is in a field.
    place = lambda name: f"CONTROLLER__FASTTASK.{name.upper()}.value"  # noqa: E731
    calls = (
        "config_init__()",
        "PRG_SLOW_body__(&CONTROLLER__SLOWTASK)",
        "PRG_FAST_body__(&CONTROLLER__FASTTASK)",
    )
    # iec2c's library asks for the time, which nothing here does.
    head = "#include <stdint.h>\n#include <iec_std_lib.h>\nTIME __CURRENT_TIME;\n"
    units = '#include "Tunneller.c"\n#include "Controller.c"\n'
    text = head + units + main_program(place, *calls)
    return build(compiler, folder, text, "-O2", "-w", f"-I{library / 'C'}")


def tried(compiler):
    """Yield a row of the table for each job: scans, wrong counts, differences, valves."""
    for name, wanted, options in jobs():
        track = followed(wanted)
        with tempfile.TemporaryDirectory() as folder:
            controller = Driven(compiled(compiler, Path(folder), with_program(wanted, **options)))
            found = closed_loop(controller, wanted, len(track.command))
            late = controller.c.nStarved
            controller.close()
        wrong, away, opened = differences(found, track, wanted.planned.count)
        print(f"{name}: {len(found)} scans, {wrong} wrong counts", flush=True)
        yield name, len(found), wrong, late, away, opened


def checked_xml(schema):
    """Return a sentence about the PLCopen XML of the reference job."""
    if not schema:
        return "The PLCopen XML wasn't checked: no SCHEMA was given."
    wanted = read_job(REFERENCE_JOB)
    text = plcopen_xml(with_program(wanted))
    command = ["xmllint", "--noout", "--schema", schema, "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True)
    return (
        f"The PLCopen XML of the reference job is {'' if done.returncode == 0 else 'in'}valid by "
        f"{Path(schema).name} (xmllint)."
    )


def main():
    compiler = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
    if not shutil.which("iec2c"):
        print(HOW_TO_GET_IT)
        return 1
    if not compiler:
        print("There is no C compiler here, for the C that iec2c writes.")
        return 1
    begun = time.monotonic()
    rows = list(tried(compiler))
    commit = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.run(commit, cwd=ROOT, text=True, capture_output=True).stdout.strip()
    xml = checked_xml(os.environ.get("SCHEMA"))
    lines = [
        "# The Structured Text, compiled",
        "",
        f"`make plc` on {time.strftime('%F')} at {commit}, MatIEC's iec2c and a C compiler, "
        f"{time.monotonic() - begun:.0f} s. Both programs, task by task, in closed loop with the "
        f"library's axes. {xml}",
        "",
        "| job | scans | wrong counts | late | positions differ by, rad | valves by |",
        "| --- | --- | --- | --- | --- | --- |",
        *(f"| {name} | {scans:,} | {wrong} | {late} | {away:.0e} | {opened:.0e} |"
          for name, scans, wrong, late, away, opened in rows),
    ]  # fmt: skip
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(xml)
    return int(any(row[2] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
