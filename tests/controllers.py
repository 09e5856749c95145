"""The exported controller as a program of its own, driven scan by scan through pipes.

The texts are those of a job: the C99, or the Structured Text as iec2c makes C of it. Around either
stands the same main program, which reads the inputs of a scan and writes its outputs.
"""

import resource
import shutil
import struct
import subprocess
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tunneller_lib.job import read_job
from tunneller_lib.job.controller import program
from tunneller_lib.job.controller_texts import c99_header, c99_text

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
COMPILER = shutil.which("gcc") or shutil.which("clang") or shutil.which("cc")
SANITIZERS = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
# The sanitizer of addresses reserves terabytes of them.
if resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY:
    SANITIZERS.append("-fsanitize=address")

INPUTS = (
    "bEnable", "bStart", "bHold", "bReset", "bStepDone", "nOverride", "nActualTheta", "nActualPhi",
)  # fmt: skip
OUTPUTS = (
    "nSetTheta", "nSetPhi", "nState", "bBusy", "bDone", "bStepRequest", "bError", "nErrorId",
    "nScale", "nTick", "nAhead",
)  # fmt: skip
REALS = "rValveTheta", "rValvePhi", "loopTheta.rSlope", "loopPhi.rSlope"
ANSWER = struct.Struct(f"={len(OUTPUTS)}i{len(REALS)}d")
DISABLED, STANDSTILL, MOVING, HOLDING, ERROR_STOP = range(5)
FULL = 2**15
# It reads rows of inputs, the first how often the slow task comes before, and answers each.
MAIN = """
#include <stdio.h>
static int answered(void)
{{
    int32_t whole[] = {{ {whole} }};
    double real[] = {{ {real} }};
    return fwrite(whole, sizeof whole, 1, stdout) == 1 && fwrite(real, sizeof real, 1, stdout) == 1
        && fflush(stdout) == 0;
}}
int main(void)
{{
    int32_t in[{size}];
    {begin};
    if (!answered()) return 1;
    while (fread(in, sizeof in, 1, stdin) == 1) {{
        for (int32_t k = 0; k < in[0]; ++k) {{ {slow}; }}
        {given}
        {fast};
        if (!answered()) return 1;
    }}
    return 0;
}}
"""


def main_program(place, begin, slow, fast):
    """Return the main program in C; `place` says where a variable of FB_Tunneller is."""
    return MAIN.format(
        whole=", ".join(f"(int32_t){place(name)}" for name in OUTPUTS),
        real=", ".join(map(place, REALS)),
        size=1 + len(INPUTS),
        given=" ".join(f"{place(n)} = ({'bool' if n[0] == 'b' else 'int32_t'})in[{i}];"
                       for i, n in enumerate(INPUTS, start=1)),
        begin=begin, slow=slow, fast=fast,
    )  # fmt: skip


def build(compiler, folder, text, *options):
    """Compile a C text with options in a folder; return the program's path."""
    (folder / "main.c").write_text(text)
    command = [compiler, *options, "-ffp-contract=off", "main.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "main"


def c99_program(compiler, folder, controller, *options):
    """Return the path of the C99 of a controller, compiled into a program of its own."""
    (folder / "controller.h").write_text(c99_header(controller))
    text = f"{c99_text(controller)}\n{WIRED}\n"
    main = main_program(
        "tunneller.{}".format, "", "fb_setpoints(&setpoints, &ring)",
        "fb_tunneller(&tunneller, &ring)",
    )  # fmt: skip
    return build(compiler, folder, text + main, *options)


WIRED = """
static FB_Setpoints setpoints;
static FB_Tunneller tunneller = FB_TUNNELLER_BEGIN;
static volatile T_Ring ring;
"""


class Driven:
    """A running program: `c` holds what goes in and what came out of the last scan."""

    def __init__(self, path):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.c = SimpleNamespace(**dict.fromkeys(INPUTS, 0))
        self.c.nOverride = 256
        self.ahead = 0
        self._hear()

    def _hear(self):
        said = self.process.stdout.read(ANSWER.size)
        if len(said) < ANSWER.size:
            raise RuntimeError(f"the controller ended with {self.process.wait()}")
        self.c.__dict__.update(zip(OUTPUTS + REALS, ANSWER.unpack(said), strict=True))

    def slow(self):
        self.ahead += 1

    def fast(self):
        given = (getattr(self.c, name) for name in INPUTS)
        self.process.stdin.write(struct.pack(f"={1 + len(INPUTS)}i", self.ahead, *given))
        self.process.stdin.flush()
        self.ahead = 0
        self._hear()

    def close(self):
        """End the program; return its exit code."""
        self.process.stdin.close()
        self.process.stdout.close()
        return self.process.wait()


def start(n, c):
    """Let the controller run from the first scan on, and step back where it is asked to."""
    c.bEnable = 1
    c.bStart = int(c.nState == STANDSTILL and not c.bDone)
    c.bStepDone = c.bStepRequest


def closed_loop(controller, wanted, made, scans, *, before=start):
    """Run a controller on the library's axes; return set-values, positions, valves, state a scan.

    The delay of the loop is in the wires: the valves get what an earlier scan asked for. The axes
    begin at rest where the entry does.
    """
    plants, loops = wanted.axes
    encoder = loops[0].count
    tick = wanted.planned.tick
    steps = [partial(plant.functions()["ticked"], plant.numbers(tick)) for plant in plants]
    c = controller.c
    first = wanted.planned.entry.setvalues[0]
    states = [plant.rest(float(at)) for plant, at in zip(plants, first, strict=True)]
    waiting = [(0.0, 0.0)] * loops[0].delay
    rows = []
    for n in range(scans):
        if n % made.slow == 0:
            controller.slow()
        c.nActualTheta, c.nActualPhi = (int((s[0] / encoder + 0.5) // 1) for s in states)
        before(n, c)
        controller.fast()
        waiting.append((c.rValveTheta, c.rValvePhi))
        valves = waiting.pop(0)
        rows.append([c.nSetTheta, c.nSetPhi, *(s[0] for s in states), *valves, c.nState, c.bDone,
                     c.nTick >= 0, c.nScale,
                     *(vars(c)[name] * (c.nScale / FULL) for name in REALS[2:])])  # fmt: skip
        states = [step(s, u) for step, s, u in zip(steps, states, valves, strict=True)]
    return np.array(rows)


def moved(run):
    """Return set-values and slopes of a whole run of a plan, one after the other."""
    runs = [run.entry, *[run] * run.laps, run.leave]
    first = runs[0].setvalues[:1]
    return (
        np.concatenate([first, *(one.setvalues[1:] for one in runs)]),
        np.concatenate([one.slopes for one in runs]),
    )


def job_with(job=None, /, **tables):
    """Return a job, the reference job unless told, with some keys of its tables changed."""
    job = job or read_job(REFERENCE_JOB)
    return replace(job, **{name: getattr(job, name) | keys for name, keys in tables.items()})


def with_program(wanted):
    """Return the `Program` of a job's controller."""
    return program(wanted.planned, wanted)
