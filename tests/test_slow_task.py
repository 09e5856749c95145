"""The exported slow task, run: its waypoints are the library's corrected chord."""

import ctypes
import math
import re
import shutil
import subprocess

import numpy as np
import pytest
from blark.parse import parse_source_code

from tunneller_lib.motion.export import IEC_KEYWORDS
from tunneller_lib.motion.slow_task import waypoint_operations, waypoints_c99, waypoints_st
from tunneller_lib.paths import corrected_chord
from tunneller_lib.surfaces import REFERENCE_MACHINE

READS = []

MACHINE = REFERENCE_MACHINE
LOW, HIGH = (MACHINE.theta_min, MACHINE.phi_min), (MACHINE.theta_max, MACHINE.phi_max)
COUNT = 2 * np.pi / 2**16
COMPILERS = [found for found in map(shutil.which, ("gcc", "clang")) if found]
CHORD = 352  # operations of the tangent spheres' 32 waypoints, see notebooks/11_rivals.ipynb


def pairs(n):
    """Return random pairs, the opposite corners, a meridian, ends close together."""
    p, q = np.random.default_rng(8).uniform(LOW, HIGH, (2, n, 2))
    p[0], q[0] = LOW, HIGH
    p[1], q[1] = (0.2, -0.5), (0.2, 0.6)
    p[2], q[2] = (0.2, 0.5), (0.2, 0.5)
    p[3], q[3] = (0.2, 0.5), (0.2 + 3e-6, 0.5 - 3e-6)
    p[4], q[4] = (0.2, 0.5), (0.2 + 3e-5, 0.5 - 3e-5)
    p[5], q[5] = (-0.2, 0.0), (0.5, 0.0)
    return p, q


def from_structured_text(text):
    """Return a Python function (ring, tube, p, q) -> (n, 2) of what a function block says."""
    body = text[text.rindex("END_VAR") + len("END_VAR") : text.index("END_FUNCTION_BLOCK")]
    size = int(re.search(r"ARRAY\[0\.\.(\d+)\]", text)[1]) + 1
    lines = []
    for line in body.strip("\n").split("\n"):
        line = line.replace(";", "")
        loop = re.fullmatch(r"( *)FOR i := (.+) TO (.+?)( BY -1)? DO", line)
        if loop:
            pad, first, last, down = loop.groups()
            step, past = (-1, f"({last}) - 1") if down else (1, f"({last}) + 1")
            line = f"{pad}for i in range({first}, {past}, {step}):"
        line = re.sub(r"\bIF (.+) THEN", r"if \1:", line).replace("ELSE", "else:")
        if line.strip() not in ("END_FOR", "END_IF"):
            lines.append(line.replace(":=", "="))
    names = re.search(r"\n    ([\w, ]+) : ARRAY.*\nEND_VAR\nVAR\n.*\n    ([\w, ]+) : ARRAY", text)
    arrays = ", ".join(names.groups()).split(", ")

    def run(ring, tube, p, q):
        state = {name: [math.nan] * size for name in arrays}
        state |= {"SQRT": math.sqrt, "SIN": math.sin, "COS": math.cos, "ATAN2": math.atan2}
        state |= {"ring": ring, "tube": tube}
        state |= {"thetaP": p[0], "phiP": p[1], "thetaQ": q[0], "phiQ": q[1]}
        exec("\n".join(lines), state)
        return np.transpose([state["theta"], state["phi"]])

    return run


@pytest.mark.parametrize("points", [5, 9, 32])
def test_structured_text_agrees_to_a_tenth_of_a_count(points):
    program = from_structured_text(waypoints_st(points))
    p, q = pairs(100)
    expected = corrected_chord(MACHINE.torus, p, q, points)
    found = [program(MACHINE.r, MACHINE.R, *ends) for ends in zip(p, q, strict=True)]
    assert np.max(np.abs(found - expected)) < COUNT / 10
    np.testing.assert_allclose(np.array(found)[:, 0], p, atol=1e-14)
    np.testing.assert_allclose(np.array(found)[:, -1], q, atol=1e-13)


def test_difference_falls_with_the_fourth_power_of_the_waypoints():
    p, q = pairs(60)
    worst = []
    for points in (9, 17, 33):
        program = from_structured_text(waypoints_st(points))
        found = [program(MACHINE.r, MACHINE.R, *ends) for ends in zip(p, q, strict=True)]
        worst.append(np.max(np.abs(found - corrected_chord(MACHINE.torus, p, q, points))))
    assert np.all(np.abs(np.log2(np.divide(worst[:-1], worst[1:])) - 4) < 0.1)


@pytest.mark.skipif(not COMPILERS, reason="no C compiler on this machine")
@pytest.mark.parametrize("compiler", COMPILERS)
def test_c_agrees_to_a_tenth_of_a_count(tmp_path, compiler):
    points = 9
    source, library = tmp_path / "waypoints.c", tmp_path / "waypoints.so"
    source.write_text(waypoints_c99(points))
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror"]
    command = [compiler, *warnings, "-O1", "-shared", "-fPIC", "-o", library, source, "-lm"]
    subprocess.run(command, check=True)
    call = ctypes.CDLL(str(library)).waypoints
    p, q = pairs(2_000)
    row = ctypes.c_double * points
    found = np.empty((len(p), points, 2))
    for k, ends in enumerate(zip(p, q, strict=True)):
        theta, phi = row(), row()
        sizes = (MACHINE.r, MACHINE.R, *ends[0], *ends[1])
        call(*map(ctypes.c_double, sizes), theta, phi)
        found[k] = np.transpose([theta, phi])
    assert np.max(np.abs(found - corrected_chord(MACHINE.torus, p, q, points))) < COUNT / 10


def test_operations_are_at_most_six_times_the_chord_s():
    count = waypoint_operations(32)
    assert sum(count) <= 6 * CHORD
    assert sum(count) == 1761 and count.divisions == 103 and count.functions == 144


def test_operations_are_those_of_a_run():
    """Counted again while the Structured Text runs, on numbers that count."""
    done = []

    class Counted(float):
        pass

    def counting(kind, of):
        def method(*numbers):
            done.append(kind)
            return Counted(of(*(float(number) for number in numbers)))

        return method

    for name, kind in (("add", "simple"), ("sub", "simple"), ("mul", "simple"),
                       ("truediv", "divisions")):  # fmt: skip
        own = getattr(float, f"__{name}__")
        setattr(Counted, f"__{name}__", counting(kind, own))
        setattr(Counted, f"__r{name}__", counting(kind, lambda a, b, own=own: own(b, a)))
    Counted.__neg__ = counting("simple", float.__neg__)
    text = waypoints_st(9)
    program = from_structured_text(re.sub(r"(?<![\w.])(\d+\.\d+)", r"NUMBER(\1)", text))
    functions = {name: counting("functions", getattr(math, name.lower()))
                 for name in ("SQRT", "SIN", "COS", "ATAN2")}  # fmt: skip
    cells = [cell.cell_contents for cell in program.__closure__]
    lines = next(c for c in cells if isinstance(c, list) and "=" in c[0])
    arrays = next(c for c in cells if isinstance(c, list) and "theta" in c)
    given = dict.fromkeys(arrays) | functions | {"NUMBER": Counted}
    state = given | {name: [Counted(0)] * 9 for name in arrays}
    sizes = (0.08, 0.8, 0.1, 0.2, 0.7, -0.3)
    state |= dict(zip(("ring", "tube", "thetaP", "phiP", "thetaQ", "phiQ"),
                      map(Counted, sizes), strict=True))  # fmt: skip
    exec("\n".join(lines), state)
    counted = waypoint_operations(9)
    assert {kind: done.count(kind) for kind in counted._fields} == counted._asdict()


def test_structured_text_is_parsed_and_its_names_are_free():
    text = waypoints_st(9)
    (block,) = parse_source_code(text).transform().items
    declared = [str(variable.variable.name) for part in block.declarations
                for item in part.items for variable in item.variables]  # fmt: skip
    upper = [name.upper() for name in declared]
    assert len(set(upper)) == len(upper) > 30
    assert not set(upper) & IEC_KEYWORDS
    used = set(re.findall(r"[A-Za-z]\w*", text[text.rindex("END_VAR") :]))
    words = {"END_VAR", "END_FUNCTION_BLOCK", "FOR", "TO", "BY", "DO", "END_FOR", "IF", "THEN",
             "ELSE", "END_IF", "SQRT", "SIN", "COS", "ATAN2"}  # fmt: skip
    assert used - words == set(declared)


def test_c_is_indented_as_its_braces_are_nested():
    depth = 0
    for text in waypoints_c99(9).splitlines():
        word = text.strip()
        depth -= word.startswith("}")
        if word and depth:  # what stands in a function
            assert len(text) - len(word) == 4 * depth, text
        depth += word.endswith("{")
    assert depth == 0


@pytest.mark.parametrize("call", [waypoints_st, waypoints_c99])
def test_names_that_the_program_uses_are_refused(call):
    for name in ("psi", "Theta", "RING", "i"):
        with pytest.raises(ValueError, match=r"^name: must be free in the program; got"):
            call(9, name=name)
    assert "Segment" in call(9, name="Segment")
    for points in (2, 1001, 3.5):
        with pytest.raises(ValueError, match=r"^points: must be one whole number from 3 to 1000"):
            call(points)
