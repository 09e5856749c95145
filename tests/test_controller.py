"""The exported controller, compiled and run in closed loop against the library's own axes."""

import ctypes
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from tests.controllers import closed_loop, moved
from tunneller_lib.job import read_job
from tunneller_lib.job.controller import RING_ARRAYS, program
from tunneller_lib.job.controller_texts import c99_text, plcopen_xml, structured_text_of
from tunneller_lib.motion import follow
from tunneller_lib.motion.export import IEC_KEYWORDS

READS = ["tests/references/reference_job.toml"]

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"]
compiled = pytest.mark.skipif(not COMPILER, reason="no C compiler on this machine")
KINDS = {"int32_t": ctypes.c_int32, "double": ctypes.c_double}


@cache
def job(plant="T3", **options):
    whole = read_job(REFERENCE_JOB)
    return replace(
        whole, controller={**whole.controller, "plant": plant}, plan={**whole.plan, **options}
    )


def fields(text):
    """Return the fields of the controller's structure in C as ctypes has them."""
    body = re.search(r"typedef struct \{\n((?:(?!typedef).)*)\} tunneller;", text, re.S)[1]
    found = []
    for kind, names in re.findall(r"^ *(int32_t|double|time_line) ([^;]*);", body, re.M):
        for name in names.split(", "):
            array = re.fullmatch(r"(\w+)\[(\d+)\]", name)
            if kind == "time_line":
                found.append((name, ctypes.c_int32 * 6))
            elif array:
                found.append((array[1], KINDS[kind] * int(array[2])))
            else:
                found.append((name, KINDS[kind]))
    return found


class Controller:
    """A compiled controller: attributes are the fields of its structure."""

    def __init__(self, text, folder):
        (folder / "controller.c").write_text(text)
        command = [COMPILER, *STRICT, "-O2", "-ffp-contract=off", "-shared", "-fPIC",
                   "controller.c", "-o", "controller.so", "-lm"]  # fmt: skip
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        self.calls = ctypes.CDLL(str(folder / "controller.so"))
        self.c = type("Tunneller", (ctypes.Structure,), {"_fields_": fields(text)})()
        self.calls.tunneller_init(ctypes.byref(self.c))

    def slow(self):
        self.calls.tunneller_slow(ctypes.byref(self.c))

    def fast(self):
        self.calls.tunneller_fast(ctypes.byref(self.c))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    def make(wanted, **options):
        text = c99_text(program(wanted.planned, wanted, **options))
        return Controller(text, tmp_path_factory.mktemp("controller"))

    return make


@compiled
def test_closed_loop_of_the_c99_is_the_librarys(made):
    wanted = job("T0")
    lap = wanted.planned
    setvalues, slopes = moved(lap)
    controller = made(wanted)
    found = closed_loop(controller, wanted, len(slopes))
    counts = np.rint(setvalues / lap.count).astype(int)
    np.testing.assert_array_equal(found[:, :2], counts[:-1])
    track = follow(*wanted.axes, setvalues, slopes=slopes)
    np.testing.assert_allclose(found[:, 2:4], track.position[:-1], atol=1e-9)
    np.testing.assert_allclose(found[:, 4:6], track.command, atol=1e-7)
    c = controller.c
    assert c.nStarved == 0 and c.nTripped == 0
    controller.fast()
    assert c.bDone == 1 and c.nMode == 0
    # The same wall: no place of the cutter differs.
    centre = lap.circuit.overcut(found[:, 2:4]) - lap.circuit.overcut(track.position[:-1])
    assert np.abs(centre).max() < 1e-9


@compiled
@pytest.mark.parametrize(
    "plan, options",
    [
        ({}, {"setpoints": "stored"}),
        ({"path": "corrected chord"}, {}),
        ({"path": "corrected chord"}, {"setpoints": "stored"}),
        ({"laps": 2}, {}),
    ],
    ids=["stored", "corrected", "corrected, stored", "two laps"],
)
def test_set_values_are_the_librarys_with_one_setpoint_every_other_scan(made, plan, options):
    wanted = job("T0", **plan)
    lap = wanted.planned
    setvalues, slopes = moved(lap)
    controller = made(wanted, **options)

    def drive(n, c):
        c.bRun = 1
        if n % 2 == 0:
            controller.slow()

    found = closed_loop(controller, wanted, len(slopes), ahead=0, before=drive)
    np.testing.assert_array_equal(found[:, :2], np.rint(setvalues[:-1] / lap.count))
    assert controller.c.nStarved == 0


@compiled
def test_override_slows_the_axes_to_its_share_and_hold_stops_them(made):
    wanted = job("T0")
    lap = wanted.planned
    controller = made(wanted)

    def drive(n, c):
        c.bRun = 1
        c.nOverride = 256 if n < 1500 else 90
        c.bHold = 2000 <= n < 2400

    found = closed_loop(controller, wanted, 14_000, before=drive)
    assert controller.c.nTripped == 0 and np.ptp(found[2060:2400, :2]) == np.ptp(found[2060, :2])
    stays = found[2100:2400, :2]
    assert np.all(stays == stays[0])
    assert controller.c.nStarved == 0
    # At full speed the set-values are the lap's.
    full = np.rint(moved(lap)[0] / lap.count)
    np.testing.assert_array_equal(found[:1500, :2], full[:1500])
    speed = np.linalg.norm(np.diff(found[1700:1990, 2:4], axis=0), axis=-1).mean()
    whole = np.linalg.norm(np.diff(found[1200:1490, 2:4], axis=0), axis=-1).mean()
    assert speed / whole == pytest.approx(90 / 256, rel=0.05)


@compiled
def test_retract_ends_where_the_cutter_entered(made):
    wanted = job("T0")
    controller = made(wanted)

    def drive(n, c):
        c.bRun = 1
        c.bHold = n >= 3000
        c.bRetract = n >= 3200

    found = closed_loop(controller, wanted, 8000, before=drive)
    first = wanted.planned.entry.setvalues[0] / wanted.planned.count
    np.testing.assert_allclose(found[-1, :2], first, atol=1)
    assert controller.c.bDone == 1 and controller.c.nTripped == 0
    over = wanted.planned.circuit.overcut(found[3200:, 2:4])
    assert over.max() < 1e-3  # never farther out than the wall that is wanted


@compiled
def test_trips_shut_the_valves_until_they_are_reset(made):
    wanted = job("T0")
    controller = made(wanted)
    controller.c.bRun = 1
    controller.slow()
    controller.c.nActualTheta = controller.c.nSetTheta + 5000
    controller.c.nActualPhi = controller.c.nSetPhi
    controller.fast()
    assert (controller.c.nMode, controller.c.nTripped) == (3, 1)
    assert controller.c.rValveTheta == controller.c.rValvePhi == 0
    controller.c.nActualTheta = controller.c.nSetTheta
    controller.fast()
    assert controller.c.nMode == 3
    controller.c.bReset = 1
    controller.c.bRun = 0
    controller.fast()
    assert (controller.c.nMode, controller.c.nTripped) == (0, 0)


@compiled
def test_a_late_slow_task_costs_time_and_no_count(made):
    wanted = job("T0")
    lap = wanted.planned
    controller = made(wanted)
    counts = np.rint(moved(lap)[0] / lap.count).astype(int)

    def late(n, c):
        c.bRun = 1
        if n % 14 == 0:
            controller.slow()

    found = closed_loop(controller, wanted, 15_000, ahead=0, before=late)
    assert controller.c.nStarved > 100 and controller.c.bDone == 1
    changed = np.concatenate([[True], np.any(np.diff(found[:, :2], axis=0) != 0, axis=1)])
    kept = np.concatenate([[True], np.any(np.diff(counts, axis=0) != 0, axis=1)])
    np.testing.assert_array_equal(found[changed, :2], counts[kept])


@pytest.fixture(scope="module")
def texts():
    wanted = job("T3")
    return program(wanted.planned, wanted)


def test_structured_text_has_the_same_statements_as_the_c99(texts):
    """A text is a program in each language, and every variable that it names is declared."""
    found = structured_text_of(texts)
    for name, body in (("PRG_Slow", texts.slow), ("PRG_Fast", texts.fast)):
        unit = found[found.index(f"PROGRAM {name}\n") :]
        unit = unit[: unit.index("END_PROGRAM")]
        declared = set(re.findall(r"^ {4}(\w+) : [A-Z]", unit, re.M))
        lines = [line for line in body if not line.strip().startswith("(*")]
        names = set(re.findall(r"\b[nbra][A-Z]\w*", "\n".join(lines)))
        inputs = {"bLoad", "nStart", "nStop", "nTicks"}  # of the line's own block
        assert names - {"nSet"} - inputs <= declared
        for line in lines:
            assert line.replace("NABS(", "ABS(") in unit
    # Once for all: the ring with its ends, which both tasks see, and nothing besides.
    shared = found[found.index("VAR_GLOBAL") :]
    shared = re.findall(r"^ {4}(\w+) : ", shared[: shared.index("END_VAR")], re.M)
    assert set(shared) == {"nHead", "nTail", "bEnd", *RING_ARRAYS}
    assert found.count("END_CONFIGURATION") == 1 and "FastTask WITH Fast : PRG_Fast" in found


@pytest.mark.parametrize("text_of", [c99_text, structured_text_of, plcopen_xml])
def test_texts_are_of_programs(text_of):
    with pytest.raises(ValueError, match=r"^controller: must be of class Program; got "):
        text_of({"parts": 1})


def test_programs_are_of_plans_and_jobs():
    planned = job("T0").planned
    with pytest.raises(ValueError, match=r"^job: must be of class Job; got "):
        program(planned, planned)
    with pytest.raises(ValueError, match=r"^plan: must be of class Plan; got "):
        program(None, job("T0"))


def test_structured_text_is_balanced_and_its_identifiers_short_and_free(texts):
    found = re.sub(r"\(\*.*?\*\)", "", structured_text_of(texts), flags=re.S)
    words = re.findall(r"\b(?:END_)?IF\b", found)
    assert words.count("IF") == words.count("END_IF") > 40
    names = {name.upper() for name in re.findall(r"^ {4}(\w+) :", found, re.M)}
    assert not names & IEC_KEYWORDS
    assert max(map(len, names)) <= 24


def test_plcopen_xml_holds_the_same_programs_and_variables(texts):
    root = Xml.fromstring(plcopen_xml(texts))
    space = {"p": "http://www.plcopen.org/xml/tc6_0201", "h": "http://www.w3.org/1999/xhtml"}
    pous = {pou.get("name"): pou for pou in root.iterfind(".//p:pou", space)}
    assert set(pous) == {"FB_TimeLine", "PRG_Slow", "PRG_Fast"}
    found = structured_text_of(texts)
    for name in ("PRG_Slow", "PRG_Fast"):
        body = pous[name].find("p:body/p:ST/h:xhtml", space).text
        assert body in found
        variables = [v.get("name") for v in pous[name].iterfind(".//p:variable", space)]
        unit = found[found.index(f"PROGRAM {name}\n") :]
        assert variables == re.findall(r"^ {4}(\w+) : [A-Z]", unit[: unit.index("END_PROG")], re.M)
    table = pous["PRG_Slow"].find(".//p:variable[@name='aTicks']//p:arrayValue", space)
    assert [int(v.get("value")) for v in table.iter(f"{{{space['p']}}}simpleValue")] == (
        texts.tables["aTicks"]
    )
    tasks = [task.get("interval") for task in root.iterfind(".//p:task", space)]
    assert tasks == ["T#5ms", "T#10ms"]


@pytest.mark.parametrize("path", ["tangent spheres", "corrected chord"])
def test_slow_task_computes_the_plans_setpoints(path):
    """The foot of a point on a chord or beside it: the table gives the plan's setpoints back."""
    wanted = job("T0", path=path)
    lap = wanted.planned
    t = {name: np.array(values) for name, values in program(lap, wanted).tables.items()}
    knots = np.stack([t["aKnotX"], t["aKnotY"], t["aKnotZ"]], axis=-1)
    start, stop = knots[t["aKnot"]], knots[t["aKnot"] + 1]
    m = start + t["aShare"][:, None] * (stop - start)
    if path == "corrected chord":
        aside = np.stack([t["aAsideX"], t["aAsideY"], t["aAsideZ"]], axis=-1)
        m += t["aShift"][:, None] * aside[t["aKnot"]]
        assert 1e-7 < np.abs(t["aShift"]).max() < 1e-3
    assert "aShift" in t or path == "tangent spheres"
    foot = np.stack(lap.circuit.machine.torus.angles(m), axis=-1)
    kinks = np.stack([t["aKinkTheta"], t["aKinkPhi"]], axis=-1)
    found = foot + t["aWeight"][:, None] * kinks[t["aCorner"]]
    assert np.abs(found - lap.setpoints[1:]).max() < 0.02 * lap.count / lap.fineness
