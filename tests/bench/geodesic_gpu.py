"""Whether the formulas of `geodesic_inverse` compile for a graphics processor, without having one.

python -m tests.bench.geodesic_gpu > tests/bench/gpu.md

Wants `pip install "numba-cuda[cu12]"` beside the library, and no GPU: one thread is to answer one
pair, as one round of `inverse_problem.find` does.
"""

import collections
import functools
import re
import subprocess
import tempfile
from datetime import date
from importlib.metadata import distribution, version
from pathlib import Path
from types import SimpleNamespace

import numba.cuda.cudadrv.nvvm as nvvm
import numba.cuda.dispatcher as dispatcher
from numba import cuda, float64, int64, types

from tunneller_lib.kernels import compiled
from tunneller_lib.kernels.elementwise import NUMBERS, divided
from tunneller_lib.paths import geodesic_root, inverse_problem
from tunneller_lib.paths.geodesic_root import NODES

KIND = 9, 0  # of the processor: that of an H100
REGISTERS, LANES = 65_536, 2_048  # of its multiprocessors: registers, and threads at a time
LINK = 25e9  # bytes/s between it and the computer, as over PCI Express 4 by sixteen lanes
NODES_PADDED = -(-NODES // 8) * 8
HEAD = """# Geodesics on a graphics processor, on paper

`python -m tests.bench.geodesic_gpu` on {}, numba {}, numba-cuda {}.
No such processor was at hand: this is what the compiler says, and no time was measured.

The functions that answer one pair (`paths/inverse_problem.py`) compile unchanged into a kernel of
one thread a pair, for compute capability {}. Its products, sums, quotients and roots are rounded
one by one, as ours are, so that the bits should be the same. Arrays on such a processor wouldn't do
as well: each pair takes rounds of its own, and all would wait for the slowest.

| | |
| --- | --- |"""
# A product and a sum stay two roundings, as on the processors that we have; and the compiler must
# not look for a device to learn its kind.
nvvm.compile_ir = functools.partial(nvvm.compile_ir, fma=False)
dispatcher.get_current_device = lambda: SimpleNamespace(compute_capability=KIND)


def for_device():
    """Return `inverse_problem.answer` as a function for the device."""

    def made(copy):
        return cuda.jit(copy, device=True)

    return made(compiled._copied(inverse_problem.answer, {**NUMBERS, "ratio": divided}, made, {}))


answer = for_device()


def kernel(torus, ends, few, many, counts, answers):
    """Do what `inverse_problem.find` does, a pair a thread."""
    i = cuda.grid(1)
    if i < ends.shape[0]:
        rows = cuda.local.array((3, NODES_PADDED), float64)
        turn, phi1, phi2 = ends[i, 0], ends[i, 1], ends[i, 2]
        found = answer(torus, turn, phi1, phi2, (few, counts[0]), (many, counts[1]), rows)
        for k in range(6):
            answers[k, i] = found[k]


def main():
    table, row = float64[:, ::1], types.NamedTuple((float64, float64), geodesic_root.Radii)
    counts = types.UniTuple(int64, 2)
    signature = types.void(row, table, table, table, counts, table)
    text, _ = cuda.compile(kernel, signature, cc=KIND, device=False, abi="numba")
    steps = collections.Counter(re.findall(r"\b(add|sub|mul|div|fma|sqrt)\.(?:rn\.)?f64", text))
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "kernel.ptx"
        source.write_text(text)
        ptxas = distribution("nvidia-cuda-nvcc-cu12").locate_file("nvidia/cuda_nvcc/bin/ptxas")
        order = [ptxas, "-arch=sm_{}{}".format(*KIND), "-v", source, "-o", f"{folder}/kernel"]
        said = subprocess.run(order, capture_output=True, text=True, check=True).stderr
    registers = int(re.search(r"Used (\d+) registers", said)[1])
    spilled = int(re.search(r"(\d+) bytes spill stores", said)[1])
    threads = REGISTERS // registers // 32 * 32
    moved = 3 * 8 + 6 * 8  # bytes: ends in, numbers and codes out
    least = f"{moved / LINK * 1e9:.1f} ns"
    rows = {
        "steps in doubles in the program": ", ".join(
            f"{n} {name}" for name, n in steps.most_common()
        ),
        "of these a product and a sum in one rounding": steps["fma"],
        "registers a thread": registers,
        "bytes of them that are kept in memory": spilled,
        f"threads at a time, of {LANES:,} on a multiprocessor": threads,
        "bytes a pair, in and out": moved,
        f"least time a pair, of these bytes over {LINK / 1e9:.0f} GB/s": least,
    }
    print(HEAD.format(date.today(), version("numba"), version("numba-cuda"), "{}.{}".format(*KIND)))
    print("\n".join(f"| {name} | {value} |" for name, value in rows.items()))


if __name__ == "__main__":
    main()
