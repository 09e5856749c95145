"""The exported texts, run: C by the machine's compiler, Structured Text on its syntax tree."""

import ctypes
import io
import shutil
import subprocess

import numpy as np
import pytest

from tests.controllers import SANITIZERS
from tests.long import many
from tests.structured_text import FunctionBlock
from tunneller_lib.motion import polyline, time_bresenham
from tunneller_lib.motion.export import c99, setvalue_table, structured_text

MOVES = 10_000
EDGES = [
    (0, 2**31 - 1, 1), (0, -(2**31), 1), (-(2**31), -1, 2), (2**31 - 1, 0, 3), (5, 30, 10),
    (30, 5, 10), (0, 0, 7), (-3, -3, 1), (0, 1, 2), (0, -1, 2), (0, -1, 1), (1, 2, 64),
    (-1, -(2**31), 3), (-(2**31) + 5, -(2**31), 3),
]  # fmt: skip
ties = pytest.mark.parametrize("tie", ["up", "down"])
# Those that this machine has; exported C is only run where there is one.
COMPILERS = [found for found in map(shutil.which, ("gcc", "clang")) if found]


def moves(seed, longest):
    """Return random moves, a third of them over the whole 32-bit range."""
    rng = np.random.default_rng(seed)
    size = 2.0 ** rng.choice([6, 16, 31], (MOVES, 1))
    ends = np.clip(np.rint(rng.uniform(-size, size, (MOVES, 2))), -(2**31), 2**31 - 1).astype(int)
    # A move's difference has to fit, too: the farther ends come half way back.
    ends[:, 1] = np.where(np.abs(ends[:, 1] - ends[:, 0]) < 2**31, ends[:, 1], ends[:, 1] // 2)
    ends[:, 1] = np.where(np.abs(ends[:, 1] - ends[:, 0]) < 2**31, ends[:, 1], ends[:, 0] // 2)
    return [*EDGES, *np.column_stack([ends, rng.integers(1, longest, MOVES)]).tolist()]


def line(block, start, stop, ticks):
    block(bLoad=True, nStart=start, nStop=stop, nTicks=ticks)
    values = [block.state["nSet"]]
    while block.state["nLeft"] > 0:
        block(bLoad=False)
        values.append(block.state["nSet"])
    return values


@ties
def test_structured_text_is_the_line_bit_for_bit(tie):
    block = FunctionBlock(structured_text(tie=tie))
    for start, stop, ticks in moves(1, 12):
        expected = time_bresenham(start, stop, ticks, tie=tie)
        assert line(block, start, stop, ticks) == expected.tolist(), (start, stop, ticks)


def test_structured_text_of_long_moves():
    block = FunctionBlock(structured_text())
    for start, stop, ticks in [(-(2**31), -1, 9973), (2**30, -(2**30), 4096)]:
        assert line(block, start, stop, ticks) == time_bresenham(start, stop, ticks).tolist()


@ties
def test_structured_text_is_indented_as_it_is_nested(tie):
    depth = 0
    for text in structured_text(tie=tie).splitlines()[1:-1]:
        word = text.strip()
        depth -= word.startswith(("END_", "ELSE"))
        assert len(text) - len(word) == 4 * depth, text
        depth += word.startswith(("VAR", "ELSE", "IF"))
    assert depth == 0


def test_structured_text_of_no_ticks_stays():
    block = FunctionBlock(structured_text())
    assert line(block, 3, 9, 2) == [3, 6, 9]
    for ticks in (0, -5):
        assert line(block, 1, 2, ticks) == [9]


def test_structured_text_interpreter_is_strict():
    text = structured_text()
    with pytest.raises(OverflowError):
        FunctionBlock(text)(bLoad=True, nStart=-(2**31), nStop=2**31 - 1, nTicks=3)
    with pytest.raises(NameError):
        FunctionBlock(text.replace("nQuot,", ""))
    with pytest.raises(KeyError):
        FunctionBlock(text)(nOther=1)
    block = FunctionBlock(text)
    for a, b, quotient, remainder in [(7, 2, 3, 1), (-7, 2, -3, -1), (-6, 3, -2, 0), (0, 5, 0, 0)]:
        block(bLoad=True, nStart=0, nStop=a, nTicks=b)
        floored = (quotient - 1, remainder + b) if remainder < 0 else (quotient, remainder)
        assert (block.state["nQuot"], block.state["nRem"]) == floored


@ties
@pytest.mark.parametrize("compiler", COMPILERS)
def test_c99_is_the_line_bit_for_bit(tmp_path, compiler, tie):
    (tmp_path / "line.c").write_text(c99(tie=tie))
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic",
               "-O2", "-ftrapv", "-shared", "-fPIC", "line.c", "-o", "line.so"]  # fmt: skip
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    fill = ctypes.CDLL(str(tmp_path / "line.so")).time_line_fill
    for start, stop, ticks in moves(2, 200):
        values = np.empty(ticks + 1, dtype=np.int32)
        fill(values.ctypes.data_as(ctypes.c_void_p), start, stop, ticks)
        np.testing.assert_array_equal(values, time_bresenham(start, stop, ticks, tie=tie))


@ties
@pytest.mark.parametrize("parts", [2, 3, 256, 4096])
def test_lines_between_counts_are_the_polyline_bit_for_bit(tmp_path, parts, tie):
    rng = np.random.default_rng(parts)
    low, high = -(2**28), 2**28
    n = many(40, 1000)
    runs = np.column_stack([rng.integers(low, high, (n, 2)), rng.integers(1, 40, n)])
    block = FunctionBlock(structured_text(tie=tie, parts=parts))
    for start, stop, ticks in runs.tolist():
        exact = polyline([[start], [stop]], [ticks], tie=tie, parts=parts)[:, 0]
        assert line(block, start, stop, ticks) == exact.tolist(), (start, stop, ticks)


STRICT = "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic", "-O1", "-g"
DRIVER = """
#include <stdio.h>
int main(void)
{
    int32_t start, stop, ticks;
    while (scanf("%d %d %d", &start, &stop, &ticks) == 3) {
        time_line line = {0};
        long long sum = 0;
        time_line_load(&line, start, stop, ticks);
        for (int32_t i = 1; line.nLeft > 0; i++) {
            time_line_tick(&line);
            sum += (long long)i * line.nSet;
        }
        printf("%lld %d\\n", sum, line.nSet);
    }
    return 0;
}
"""


@pytest.mark.skipif(not COMPILERS, reason="no C compiler on this machine")
def test_c99_of_a_hundred_thousand_moves_under_sanitizers(tmp_path):
    rng = np.random.default_rng(6)
    ends = rng.integers(-(2**28), 2**28, (100_000, 2))
    runs = np.column_stack([ends, rng.integers(1, 12, len(ends))])
    (tmp_path / "run.c").write_text(c99(parts=4096) + DRIVER)
    command = [COMPILERS[0], *STRICT, *SANITIZERS, "run.c", "-o", "run"]
    if subprocess.run(command, cwd=tmp_path, capture_output=True).returncode:
        pytest.skip("the compiler of this machine has no sanitizers")
    text = "\n".join(" ".join(map(str, row)) for row in runs.tolist())
    done = subprocess.run(
        [tmp_path / "run"], input=text, capture_output=True, text=True, check=True
    )
    found = np.array([row.split() for row in done.stdout.splitlines()], dtype=np.int64)
    for ticks in range(1, 12):  # those of as many ticks at once: sums that tell every set-value
        rows = runs[:, 2] == ticks
        n = np.arange(1, ticks + 1)
        line = n * (runs[rows, 1] - runs[rows, 0])[:, None] + ticks * runs[rows, :1]
        values = (line + ticks * 2048) // (ticks * 4096)
        np.testing.assert_array_equal(found[rows, 0], values @ n)
        np.testing.assert_array_equal(found[rows, 1], values[:, -1])


def test_setvalue_table_comes_back():
    values = polyline([[0, 0], [-70000, 2**31 - 1], [5, 5]], [300, 200])
    text = setvalue_table(values, ["theta", "phi"])
    assert text.splitlines()[0].split() == ["tick", "theta", "phi"]
    read = np.loadtxt(io.StringIO(text), skiprows=1, dtype=np.int64)
    np.testing.assert_array_equal(read, np.column_stack([np.arange(501), values]))


@pytest.mark.parametrize("call", [structured_text, c99])
def test_export_refuses_wrong_options(call):
    with pytest.raises(ValueError, match=r'tie: must be "up" or "down"; got \'even\'\.'):
        call(tie="even")
    for name in ("", "2nd", "a b", None, "_a", "h\u00f6he", "a\n", "a\x00b", "a*/", "x\u0661"):
        with pytest.raises(ValueError, match=r"^name: must be a letter"):
            call(name=name)


@pytest.mark.parametrize("name", ["int", "while", "inline", "int32_t", "uint_least8_t", "INT8_MAX",
                                  "line", "setvalues", "nStart"])  # fmt: skip
def test_c99_refuses_names_that_are_taken(name):
    with pytest.raises(ValueError, match=rf"^name: must be free in C99; got {name}, which is take"):
        c99(name=name)


@pytest.mark.parametrize("name", ["IF", "if", "End_If", "BOOL", "ton", "Abs", "INT_TO_REAL", "nset",
                                  "bLoad", "R", "TASK"])  # fmt: skip
def test_structured_text_refuses_names_that_are_taken(name):
    with pytest.raises(ValueError, match=rf"^name: must be free in IEC 61131-3; got {name}, which"):
        structured_text(name=name)


def test_names_are_no_longer_than_a_compiler_tells_apart():
    assert "a" * 26 + "_load(" in c99(name="a" * 26)
    assert "a" * 24 + "\n" in structured_text(name="a" * 24)
    for call, length in ((c99, 27), (structured_text, 25)):
        with pytest.raises(ValueError, match=rf"^name: must have at most {length - 1} characters"):
            call(name="a" * length)
    for name in ("a__b", "a_"):
        with pytest.raises(ValueError, match=r"^name: must have no two _ in a row"):
            structured_text(name=name)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", ["main", "IF", "a" * 26, "_x"[1:], "x_"])
def test_c99_of_any_free_name_compiles(tmp_path, compiler, name):
    (tmp_path / "line.c").write_text(c99(name=name))
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-c", "line.c"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)


def test_export_takes_a_name():
    assert "FUNCTION_BLOCK FB_Lift" in structured_text(name="FB_Lift")
    assert "lift_fill" in c99(name="lift") and "time_line" not in c99(name="lift")


def test_setvalue_table_refuses_wrong_values():
    with pytest.raises(ValueError, match=r"setvalues: must hold whole numbers"):
        setvalue_table([[0.5, 1]], ["theta", "phi"])
    with pytest.raises(ValueError, match=r"setvalues: must hold whole numbers"):
        setvalue_table([[2**31, 1]], ["theta", "phi"])
    for values in ([[1, 2, 3]], [1, 2]):
        with pytest.raises(ValueError, match=r"setvalues: must have a column for each of 2 names"):
            setvalue_table(values, ["theta", "phi"])
