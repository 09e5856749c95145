"""The exported texts, run: C by the machine's compiler, Structured Text on its syntax tree."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from tests.audit.long import many
from tests.structured_text import FunctionBlock
from tunneller_lib.motion import polyline
from tunneller_lib.motion.export import line_c99, line_text, operations, read_blocks

MOVES = 10_000
EDGES = [
    (0, 2**31 - 1, 1), (0, -(2**31), 1), (-(2**31), -1, 2), (2**31 - 1, 0, 3), (5, 30, 10),
    (30, 5, 10), (0, 0, 7), (-3, -3, 1), (0, 1, 2), (0, -1, 2), (0, -1, 1), (1, 2, 64),
    (-1, -(2**31), 3), (-(2**31) + 5, -(2**31), 3),
]  # fmt: skip
# Those that this machine has; exported C is only run where there is one.
COMPILERS = [found for found in map(shutil.which, ("gcc", "clang")) if found]
compilers = pytest.mark.parametrize("compiler", COMPILERS)
STRICT = (
    "-std=c99 -Wall -Wextra -Wconversion -Wshadow -pedantic -Werror "
    "-fsanitize=undefined -fsanitize-undefined-trap-on-error -O1 -shared -fPIC"
).split()
FILL = """
void fill(int32_t *values, int32_t start, int32_t stop, int32_t ticks)
{
    FB_Line line = {0};
    line.bLoad = true;
    line.nStart = start;
    line.nStop = stop;
    line.nTicks = ticks;
    fb_line(&line);
    line.bLoad = false;
    for (values[0] = line.nSet; ticks > 0; --ticks) {
        fb_line(&line);
        *++values = line.nSet;
    }
}
"""


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
    """Return the set-values of a move from an instance of FB_Line."""
    block(bLoad=True, nStart=start, nStop=stop, nTicks=ticks)
    values = [block.state["nSet"]]
    for _ in range(ticks):
        block(bLoad=False)
        values.append(block.state["nSet"])
    return values


def in_parts(start, stop, ticks, parts):
    return polyline([[start], [stop]], [ticks], parts=parts)[:, 0].tolist()


def built(compiler, folder, text):
    """Return a C text as a library; what C leaves open, such as a sum beyond 32 bits, ends it."""
    (folder / "text.c").write_text(text)
    command = [compiler, *STRICT, "text.c", "-o", "text.so", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "text.so"))


# ---- the line -------------------------------------------------------------------------------


@pytest.mark.parametrize("parts", [1, 2, 3, 256, 4096, 2**16])
def test_line_in_structured_text_is_the_polyline_bit_for_bit(parts):
    block = FunctionBlock(line_text(parts=parts))
    for move in EDGES + moves(parts, 40)[len(EDGES) :: many(300, 10)]:
        assert line(block, *move) == in_parts(*move, parts), move


@compilers
@pytest.mark.parametrize("parts", [1, 4096])
def test_line_in_c_of_thousands_of_moves_is_exact(tmp_path, compiler, parts):
    text = line_c99() if parts == 1 else line_c99(parts=parts)
    fill = built(compiler, tmp_path, text + FILL).fill
    size = 10, many(2000, 10_000), 2
    ends = np.random.default_rng(6).integers(-(2**30), 2**30, size, dtype=np.int32)
    for ticks, pairs in enumerate(ends, start=1):
        found = np.empty((len(pairs), ticks + 1), dtype=np.int32)
        for row, pair in zip(found, pairs.tolist(), strict=True):
            fill(ctypes.c_void_p(row.ctypes.data), *pair, ticks)
        start, stop = pairs.T.astype(np.int64)[..., None]
        exact = start * ticks + np.arange(ticks + 1) * (stop - start)
        np.testing.assert_array_equal(found, (exact + ticks * parts // 2) // (ticks * parts))
    for move in moves(2, 200)[:: many(4, 1)]:
        values = np.empty(move[2] + 1, dtype=np.int32)
        fill(values.ctypes.data_as(ctypes.c_void_p), *move)
        assert values.tolist() == in_parts(*move, parts)


# ---- the operations --------------------------------------------------------------------------

COUNTED = """FUNCTION_BLOCK F
WHILE n < nMany AND x > -1.0 DO
    (* a - b
       * c *)
    n := n + 1;
    IF x * y > 1.0 THEN
        x := ABS(-x);
    ELSIF x + y > 2.0 THEN
        x := SQRT(x) /
            -(y);
    ELSE
        a[2 * i + 1] := ATAN(x) * COS(-x);
    END_IF;
END_WHILE;
n := n MOD 3;
END_FUNCTION_BLOCK
"""


def test_operations_are_those_of_each_statement_once():
    (block,) = read_blocks(COUNTED)
    # Sums and products 4, changes of sign 3, quotients and remainders 2, functions 3.
    assert operations(block) == 12
