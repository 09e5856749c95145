"""The exported texts, run: C by the machine's compiler, Structured Text on its syntax tree."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from tests.audit.long import many
from tests.structured_text import FunctionBlock
from tunneller_lib.motion import polyline
from tunneller_lib.motion.export import (
    C_HEAD,
    C_MACROS,
    c99_code,
    c99_types,
    constant_rows,
    line_c99,
    line_text,
    operations,
    read_blocks,
)

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
    for move in EDGES + moves(parts, 40)[len(EDGES) :: many(100, 10)]:
        assert line(block, *move) == in_parts(*move, parts), move


@compilers
@pytest.mark.parametrize("parts", [1, 4096])
def test_line_in_c_of_a_hundred_thousand_moves_is_exact(tmp_path, compiler, parts):
    text = line_c99() if parts == 1 else line_c99(parts=parts)
    fill = built(compiler, tmp_path, text + FILL).fill
    ends = np.random.default_rng(6).integers(-(2**30), 2**30, (10, 10_000, 2), dtype=np.int32)
    for ticks, pairs in enumerate(ends, start=1):
        found = np.empty((len(pairs), ticks + 1), dtype=np.int32)
        for row, pair in zip(found, pairs.tolist(), strict=True):
            fill(ctypes.c_void_p(row.ctypes.data), *pair, ticks)
        start, stop = pairs.T.astype(np.int64)[..., None]
        exact = start * ticks + np.arange(ticks + 1) * (stop - start)
        np.testing.assert_array_equal(found, (exact + ticks * parts // 2) // (ticks * parts))
    for move in moves(2, 200):
        values = np.empty(move[2] + 1, dtype=np.int32)
        fill(values.ctypes.data_as(ctypes.c_void_p), *move)
        assert values.tolist() == in_parts(*move, parts)


# ---- the translator -------------------------------------------------------------------------

SAMPLE = """(* What a block may have. *)
TYPE
    T_Pair : STRUCT
        nIn : DINT;
        nBy : DINT; (* a field of a name that blocks have, too *)
    END_STRUCT;
    T_Shared : STRUCT
        nCount : DINT;
        aPair : ARRAY [0..1] OF T_Pair;
    END_STRUCT;
    T_Job : STRUCT
@JOB    END_STRUCT;
END_TYPE

FUNCTION_BLOCK FB_Inner
VAR_INPUT
    nBy : DINT;
END_VAR
VAR_OUTPUT
    nSum : DINT;
END_VAR
(* Two lines of a comment, of which the first one ends in DO
   and the second one names nBy := nSum - nBy. *)
nSum := nSum
    + nBy;
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Sample
VAR_INPUT
    nIn : DINT := 7; (* without a call of more *)
    rIn : LREAL := -7.9;
    bOn : BOOL;
END_VAR
VAR_OUTPUT
    nBranch, nSum : DINT;
    aOut : ARRAY [0..3] OF DINT;
    rOut : LREAL;
END_VAR
VAR_EXTERNAL
    job : T_Job;
    both : T_Shared;
END_VAR
VAR
    i, nFORM : DINT;
    inner : FB_Inner;
    pair : T_Pair;
END_VAR
IF NOT bOn AND nIn <> 3 THEN
    nBranch := 1;
ELSIF nIn = 3 OR
        nIn > 100 THEN
    nBranch := 2;
ELSE
    nBranch := 3;
END_IF;
i := 0;
WHILE i < 5 AND nIn <> i DO
    i := i + 1;
END_WHILE;
FOR nFORM := 3 TO 2 BY -1 DO
    aOut[nFORM] := aOut[nFORM] + 10 * nSum + nFORM;
    nSum := nSum + 1;
END_FOR;
FOR nFORM := 0 TO 1 DO
    aOut[nFORM] := nFORM;
END_FOR;
inner(nBy := nIn + 1);
bOn := (inner.nSum >= 8 AND TRUE) OR FALSE;
rOut := ABS(-DINT_TO_LREAL(TRUNC(rIn) MOD job.nFour)) * job.rSmall
    + SQRT(MIN(MAX(job.aTable[i MOD 3], 0.25), 4.0))
    + -(ATAN(0.0) + ATAN2(0.0, 1.0) + SIN(0.0) + COS(0.0));
both.nCount := both.nCount + inner.nSum;
pair := both.aPair[0];
pair.nBy := both.nCount;
both.aPair[nSum - nSum + 1] := pair;
END_FUNCTION_BLOCK
"""
RUN = """
double run(int32_t *out, int32_t in, int32_t on, int32_t calls)
{
    static volatile T_Shared both;
    FB_Sample sample = FB_SAMPLE_BEGIN;
    if (in) sample.nIn = in;
    for (; calls > 0; --calls) {
        sample.bOn = on;
        fb_sample(&sample, &both);
    }
    int32_t values[] = {sample.nBranch, sample.i, sample.bOn, sample.aOut[0], sample.aOut[1],
                        sample.aOut[2], sample.aOut[3], both.aPair[1].nBy};
    for (int k = 0; k < 8; ++k) out[k] = values[k];
    return sample.rOut;
}
"""


@pytest.fixture(scope="module")
def sample():
    """Return the sample's blocks."""
    table = {"nFour": 4, "rSmall": 5e-05, "aTable": np.array([9.0, -1e300, 1.0])}
    return read_blocks(SAMPLE.replace("@JOB", constant_rows(table)))


@compilers
def test_statements_do_in_c_what_they_say(tmp_path, compiler, sample):
    texts = C_HEAD, C_MACROS, c99_types(sample), c99_code(sample), RUN
    run = built(compiler, tmp_path, "\n".join(texts)).run
    run.restype = ctypes.c_double
    out = (ctypes.c_int32 * 8)()
    small = 3 * 5e-05 - 1
    # What came out, worked out by hand: i and the table's value stop at the input or at 5.
    assert run(out, 0, 0, 1) == pytest.approx(small + 1.0)
    assert list(out) == [1, 5, 1, 0, 1, 12, 3, 8]
    assert run(out, 3, 0, 1) == pytest.approx(small + 2.0)
    assert list(out) == [2, 3, 0, 0, 1, 12, 3, 12]
    assert run(out, 101, 1, 1) == pytest.approx(small + 1.0)
    assert list(out) == [2, 5, 1, 0, 1, 12, 3, 114]
    assert run(out, 4, 1, 2) == pytest.approx(small + 0.5)
    assert list(out) == [3, 4, 1, 0, 1, 44, 26, 129]


def test_operations_are_those_of_each_statement_once(sample):
    # By hand: sums 11, products 2, changes of sign 2, a remainder and functions 5.
    assert [operations(block) for block in sample if block.body] == [1, 21]
