"""Write controller_cycles.csv: what a controller's parts cost on an ATmega328P and on a Cortex-M.

    python -m tests.references.controller_cycles

Needs Debian's gcc-avr, avr-libc, libsimavr-dev, libelf-dev, gcc-arm-none-eabi,
libnewlib-arm-none-eabi, qemu-system-arm and gcc. simavr counts cycles; qemu counts instructions, of
which a Cortex-M0 and a Cortex-M4 do most in one cycle. Each part is a call; what a call of an empty
function costs is taken off.
"""

import json
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from functools import partial
from itertools import combinations, product
from pathlib import Path

import numpy as np

from tests.controllers import FULL, job_with, with_program
from tests.references import tables
from tunneller_lib.job.controller_texts import c99_header, c99_text
from tunneller_lib.motion import time_bresenham
from tunneller_lib.motion.export import (
    C_HEAD,
    c99_code,
    c99_types,
    constant_rows,
    line_c99,
    read_blocks,
)
from tunneller_lib.paths import corrected_chord, cutting_circuit, geodesic_inverse, project_chord
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

HERE = Path(__file__).parent
TABLE = Path(__file__).with_suffix(".csv")
SOURCE = Path(__file__).with_suffix(".c")
GEODESIC = HERE / "geodesic.c"
WAYPOINTS_TEXT = HERE / "waypoints.st"
COLUMNS = ["processor", "part", "unit", "calls", "least", "median", "most"]
MOVES, ROWS, SMALL_RING, POINTS = 60, 8, 12, 9
PARTS = {
    2: "integer line, a move", 3: "integer line, a tick", 4: "two-axis line, a tick",
    5: "the listing, a move", 6: "the listing, a tick",
    7: "y = k x + d, a move", 8: "y = k x + d, a tick",
    9: "a setpoint, {}", 10: "a scan of the fast task",
    11: f"{POINTS} waypoints, corrected chord",
}  # fmt: skip
WAYS = (
    "projected chord", "corrected chord", "geodesic by shooting", "geodesic by Newton's method",
    "geodesic as in a textbook",
)  # fmt: skip
for k, (where, way) in enumerate(product(("of the lap", "corner to corner"), WAYS)):
    PARTS[12 + k] = f"{POINTS} waypoints {where}, {way}"
# The block as a function, beside which its state is kept.
WAYPOINTS = """
void waypoints(double ring, double tube, double thetaP, double phiP, double thetaQ, double phiQ,
               double *theta, double *phi)
{
    static FB_Waypoints c;
    c.ring = ring; c.tube = tube;
    c.thetaP = thetaP; c.phiP = phiP; c.thetaQ = thetaQ; c.phiQ = phiQ;
    fb_waypoints(&c);
    for (int k = 0; k < (int)(sizeof c.phi / sizeof *phi); ++k) {
        theta[k] = c.theta[k];
        phi[k] = c.phi[k];
    }
}
"""
COUNTS = 2**16 / (2 * np.pi)  # a rad
ARM = ["arm-none-eabi-gcc", "--specs=nosys.specs", "-nostartfiles", "-mthumb"]
SCALE = 1024 / 62.5, 1024 / 40  # ticks of the timer an instruction, at 16 and at 25 MHz
CORTEX = {
    "Cortex-M0": (["-mcpu=cortex-m0"], "microbit", SCALE[0]),
    "Cortex-M4 without FPU": (["-mcpu=cortex-m4", "-mfloat-abi=soft"], "mps2-an386", SCALE[1]),
    "Cortex-M4 with FPU": (
        ["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"], "mps2-an386", SCALE[1],
    ),
}  # fmt: skip


def subjects():
    """Yield a name, a C text, the switches and a check of what is said of what is measured."""
    # In the place of its call, as the statements of the listing are.
    head = "void fb_line(FB_Line *c);"
    text = line_c99().replace(head, f"static inline __attribute__((always_inline)) {head}")
    yield "lines", text, ["-DLINES", f"-DMOVES={MOVES}"], check_lines
    for path in ("projected chord", "corrected chord"):
        wanted = job_with(controller={"plant": "T3"}, plan={"path": path})
        few, *ends = few_rows(with_program(wanted), wanted.planned)
        code = c99_text(few).replace('#include "controller.h"\n', "")
        yield path, c99_header(few) + code, ["-DCONTROLLER"], partial(check_setpoints, *ends)
    yield "waypoints", waypoints_c99(POINTS) + WAYPOINTS, [f"-DPOINTS={POINTS}"], print
    switches = [f"-DWAYS={POINTS}", f"-DCORNERS={len(lap())}"]
    yield "ways", ways_c99(), switches, check_said_ways


def waypoints_text(points):
    """Return waypoints of a corrected chord as a function block in Structured Text.

    A call with the sizes of the torus, r as ring and R as tube, and the ends' joint positions, in m
    and rad, fills theta and phi, in rad, for so many points, both ends included.
    """
    return WAYPOINTS_TEXT.read_text(encoding="utf-8").replace("@LAST", str(points - 1))


def waypoints_c99(points):
    """Return the same block in C99."""
    blocks = read_blocks(waypoints_text(points))
    return "\n".join([C_HEAD, c99_types(blocks), c99_code(blocks)])


def lap():
    """Return the ends (n, 2, 2) of the reference lap's segments."""
    circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    knots = circuit.position(np.append(circuit.knots(1e-3), circuit.profile.perimeter))
    return np.stack([knots[:-1], knots[1:]], axis=1)


def corners():
    """Return the ends (6, 2, 2) of ways between the corners of the joint limits."""
    m = REFERENCE_MACHINE
    every = product((m.theta_min, m.theta_max), (m.phi_min, m.phi_max))
    return np.array(list(combinations(every, 2)))


def ways_c99():
    """Return ways between two positions in C99, and pairs of ends."""
    pairs = np.concatenate([lap(), corners()]).reshape(-1, 4).tolist()
    rows = ",\n".join("    {" + ", ".join(map(repr, pair)) + "}" for pair in pairs)
    pairs = f"static const double pairs[][4] = {{\n{rows},\n}};\n"
    return "\n".join([GEODESIC.read_text(), waypoints_c99(POINTS), WAYPOINTS, pairs])


def few_rows(whole, plan):
    """Return a program of eight moves about a corner, which the memory of an ATmega328P holds.

    They are the whole lap, which begins and ends at rest at once. Returns their ends, too, in
    parts of a count, and how many there are in a count.
    """
    blocks = read_blocks(whole.text + whole.blocks)
    constants = {row.name: json.loads(row.begin) for block in blocks
                 for row in block.rows("VAR CONSTANT")}  # fmt: skip
    knot, first = np.array(constants["aKnot"]), constants["nFirst"]
    middle = first + 1 + int(np.flatnonzero(np.diff(knot[first:]))[0])
    # The one before them is the way to the start position.
    rows = slice(middle - ROWS // 2 - 1, middle + ROWS // 2)
    knots = slice(int(knot[rows].min()), int(knot[rows].max()) + 1)
    moves, places, ring = len(knot), len(constants["aKnotX"]), constants["nRing"]
    for name, values in constants.items():
        if isinstance(values, list) and len(values) == moves:
            constants[name] = values[rows]
        elif isinstance(values, list) and len(values) == places:
            constants[name] = values[knots]
    constants["aKnot"] = [one - knots.start for one in constants["aKnot"]]
    ends = plan.setpoints[rows.start - first + 1 : rows.stop - first + 1]
    constants["aStart"] = ends[0].tolist()
    ends = np.rint(ends / constants["rPart"]).astype(int)
    constants["aTicks"][0] = 10
    constants["aFree"][:2] = [FULL] * 2
    constants |= {"nRing": SMALL_RING, "nAtOnce": 1, "nFirst": 1, "nExit": ROWS + 1,
                  "nRows": ROWS + 1}  # fmt: skip
    text = re.sub(r"(T_Job : STRUCT\n).*?( +END_STRUCT)", rf"\1{constant_rows(constants)}\2",
                  whole.text, flags=re.S)  # fmt: skip
    few = whole._replace(text=text.replace(f"[0..{ring - 1}]", f"[0..{SMALL_RING - 1}]"))
    return few, ends, constants["nParts"]


def ran(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{command[0]}: {done.stderr[-2000:]}")
    return done.stdout + done.stderr


def firmware(compiler, options, text, switches, folder):
    """Build the firmware of a subject in a folder."""
    (folder / "subject.c").write_text(text)
    ran([*compiler, "-O2", "-std=gnu99", "-ffp-contract=off", '-DSUBJECT="subject.c"', "-I.",
         *switches, *options, str(SOURCE), "-lm", "-o", "firmware.elf"], folder)  # fmt: skip


def on_avr(*subject):
    """Return what the simulated ATmega328P prints of a subject: text, switches and folder."""
    folder = subject[-1]
    firmware(["avr-gcc"], ["-mmcu=atmega328p"], *subject)
    host = str(HERE / "controller_cycles_avr.c")
    ran(["gcc", "-O2", host, "-o", "host", "-lsimavr", "-lelf"], folder)
    return ran(["./host", "firmware.elf"], folder)


def on_arm(kind, board, *subject):
    """Return what a simulated Cortex-M prints."""
    firmware(ARM, [*kind, f"-T{HERE / 'controller_cycles.ld'}"], *subject)
    return ran(
        ["qemu-system-arm", "-M", board, "-icount", "shift=10", "-nographic", "-monitor", "none",
         "-serial", "none", "-semihosting-config", "enable=on,target=native", "-kernel",
         "firmware.elf"], subject[-1])  # fmt: skip


def read(printed, scale):
    """Return the costs of each part and what was said, from a firmware's print.

    `scale` is of ticks of its timer an instruction.
    """
    costs, said = defaultdict(list), []
    for line in printed.splitlines():
        if line.startswith("@"):
            what = int(line[1:])
        elif line.startswith("+"):
            costs[what].append(round(int(line[1:]) / scale))
        elif line.startswith("="):
            said.append(int(line[1:]))
    return costs, said


def check_setpoints(ends, parts, processor, said):
    """Raise where the setpoints that a firmware said are a count off, or a run wasn't done."""
    *said, done = said
    off = np.abs(np.reshape(said, (-1, 2)) - ends[1:]).max() / parts
    print(f"{processor}: setpoints are off by at most {off:.4f} counts", file=sys.stderr)
    assert done == 1
    assert off < 1


def check_lines(processor, said):
    """Raise where the lines that a firmware said aren't the library's."""
    drawn = 2026

    def random_number(low, high):
        nonlocal drawn
        drawn = (drawn * 1664525 + 1013904223) % 2**32
        return low + (drawn >> 8) % (high - low)

    at = 0
    off = [0, 0]
    for _ in range(MOVES):
        ends = []
        for _ in range(2):
            start = random_number(-32768, 32768)
            ends.append((start, start + random_number(-2000, 2000)))
        ticks = random_number(2, 40)
        lines = [time_bresenham(*one, ticks) for one in ends]
        rows = np.reshape(said[at : at + 3 * (ticks + 1)], (-1, 3))
        np.testing.assert_array_equal(rows[:, 0], lines[0])
        off = np.maximum(off, np.abs(rows[:, 1:] - lines[0][:, None]).max(axis=0))
        at += rows.size + 1
        assert said[at - 1] == lines[1][-1]
    assert at == len(said)
    print(f"{processor}: the listing and y = k x + d are off by at most {off.tolist()} counts",
          file=sys.stderr)  # fmt: skip


def check_said_ways(processor, said):
    """Print how far a firmware's waypoints are from the library's, in counts.

    Raises where one is off by more than 1, or 2 between corners, or a geodesic wasn't found.
    """
    ends = np.concatenate([lap(), corners()])
    rows = np.reshape(said, (len(ends), len(WAYS), 1 + 2 * POINTS)).swapaxes(0, 1)
    found = rows[..., 1:].reshape(*rows.shape[:2], POINTS, 2) / 1e8
    given = REFERENCE_MACHINE.torus, ends[:, 0], ends[:, 1]
    geodesic = geodesic_inverse(*given).points(POINTS).position
    true = [project_chord(*given, POINTS), corrected_chord(*given, POINTS), *[geodesic] * 3]
    off = COUNTS * np.abs(found - true).max(axis=(2, 3))
    assert np.all(rows[..., 0] > 0)
    for of, most in ((slice(len(lap())), 1), (slice(len(lap()), None), 2)):
        assert off[:, of].max() <= most
        for way, each, tries in zip(WAYS, off[:, of], rows[:, of, 0], strict=True):
            print(f"{processor}, {len(each)} ways, {way}: at most {each.max():.4f} counts off; "
                  f"tries {np.bincount(tries)[1:].tolist()}", file=sys.stderr)  # fmt: skip


def measured(processor, run, unit, scale=1):
    """Yield the rows of a processor."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text, switches, check in subjects():
            costs, said = read(run(text, switches, Path(folder)), scale)
            check(processor, said)
            (empty,) = costs.pop(1)
            for what, every in costs.items():
                if what == 10 and name != "projected chord":
                    continue
                every = np.array(every) - empty
                cost = every.min(), np.median(every), every.max()
                yield [processor, PARTS[what].format(name), unit, len(every), *map(int, cost)]


def rows():
    """Yield the rows of the table."""
    yield from measured("ATmega328P", on_avr, "cycles")
    for processor, (kind, board, scale) in CORTEX.items():
        yield from measured(processor, partial(on_arm, kind, board), "instructions", scale)


if __name__ == "__main__":
    tables.write(TABLE, COLUMNS, rows())
