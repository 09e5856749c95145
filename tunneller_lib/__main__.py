"""The command line: `tunneller --help`, or `python -m tunneller_lib --help`."""

import argparse
import atexit
import gc
import json
import math
import os
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from . import __version__
from .terminal import fit

# Whatever isn't in Python itself is imported by the command that needs it: --help needs nothing,
# and what is missing, or an interrupt meanwhile, is said in a sentence.

ABOUT = """plan, simulate and show cuts of a tunnelling robot

A job is a TOML file in metres, seconds and radians (or degrees, in names that end in _deg);
notebooks/reference.toml is one. Progress goes to stderr.

Ends with 0 if all is well, though there may be warnings; with 1 if a value of the job is refused,
with the reason; with 2 if something can't be read: a file or a package that isn't there, what is
no TOML, a command, a table or a name that isn't known or is missing; with 130 if it is interrupted.
"""


def main(arguments=None):
    """Run the command that `arguments`, a list of str, names; return the process' exit code."""
    options = parser().parse_args(arguments)
    if arguments is None:
        # Python's last look for garbage, among all that packages made, would take half a second.
        atexit.register(gc.freeze)
    try:
        answer = options.run(options)
        if answer is not None:
            tell(answer if options.json else "\n".join(answer["files"]))
        return 0
    except KeyboardInterrupt:
        return ended(options, 130, "interrupted", True)
    except BrokenPipeError:  # nobody reads the progress any more
        unread(sys.stderr)
        return 2
    except ImportError as error:
        return ended(options, 2, "wrong", missing(error))
    except MemoryError:
        return ended(options, 1, "refused", "the job needs more memory than there is.")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return ended(options, 2, "wrong", f"{where}{error.strerror or error}.")
    except ValueError as error:
        from .job import WrongJob

        wrong = isinstance(error, WrongJob)
        return ended(options, 2 if wrong else 1, "wrong" if wrong else "refused", str(error))


SELDOM = 1_000_000  # objects that are made before Python looks for garbage
# Of a lap's axes, for the budget and for what halves its faults: of each joint alone, and of both
# under loads besides.
BUDGET_RUNS, LOADED_RUNS = 7, 17
JSON = "answer in JSON, in SI units; null for a number that isn't finite"
LONGEST_PATH = 5000  # characters: more than systems take
PACKAGES = {"PIL": "pillow"}  # where it isn't called as it is imported


def missing(error):
    """Return the sentence of a package that isn't installed or can't be loaded."""
    name = (error.name or "").partition(".")[0]
    package = f"the package {PACKAGES.get(name, name)}" if name else "a package"
    if not isinstance(error, ModuleNotFoundError):
        said = str(error).strip().partition("\n")[0].rstrip(".")
        return f"{package} can't be loaded; {said or 'no reason is given'}."
    extra = "" if name in ("numpy", "scipy") else "[picture]"
    return f'{package} is missing; pip install ".{extra}" in this study\'s folder brings it.'


def ended(options, code, how, why):
    """Say how a command of these options ended early, and why; return its exit code."""
    why = why if why is True else fit(why)
    try:
        print(how if why is True else f"{how}: {why}", file=sys.stderr, flush=True)
    except OSError:  # on a full disk
        unread(sys.stderr)
    if getattr(options, "json", False):
        with suppress(OSError):  # of which there was a sentence
            tell({how: why})
    return code


def tell(answer):
    """Print an answer, lines or what JSON has; who stopped reading it still gets the files."""
    if isinstance(answer, str):
        text = "\n".join(fit(line, LONGEST_PATH) for line in answer.split("\n"))
    else:
        text = json.dumps(for_json(answer), indent=1, allow_nan=False)
    try:
        print(text, flush=True)
    except BrokenPipeError:  # `| head` has read enough
        unread(sys.stdout)
    except OSError as error:
        unread(sys.stdout)
        raise OSError(error.errno, error.strerror, "standard output") from None


def for_json(value):
    """Return what JSON has, None in the place of each number that it hasn't: inf and nan."""
    if isinstance(value, dict):
        return {name: for_json(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [for_json(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def unread(stream):
    """Let a stream go nowhere, so that nothing fails when Python flushes it at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Parser(argparse.ArgumentParser):
    """A parser whose refusals are lines fit for a terminal, whatever was typed."""

    def error(self, message):
        """End with 2 and the message."""
        super().error(fit(message))


def parser():
    """Return the parser of the arguments."""
    whole = Parser(
        prog="tunneller", description=ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    whole.add_argument("--version", action="version", version=f"tunneller {__version__}")
    commands = whole.add_subparsers(required=True, metavar="COMMAND")

    def command(name, run, text):
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(run=run)
        return added

    cut = command("cut", run_cut, "plan and simulate a cut; write its error budget and files")
    cut.add_argument("job", type=Path, help="the TOML file")
    cut.add_argument("--out", type=Path, metavar="FOLDER", help="under build/ by default")
    cut.add_argument("--json", action="store_true", help=JSON)

    return whole


def between(least, most):
    """Return the type of a whole number from `least` to `most`."""

    def whole_number(text):
        if not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"must be from {least} to {most}; got {text}.")
        return int(text)

    return whole_number


def read(options):
    """Return the job that a command's options name and its cut, planned and simulated."""
    import numpy as np

    from .job import read_job, say

    job = read_job(options.job)
    if integral := job.controller.get("integral"):
        raise ValueError(
            "[controller] integral: must be 0, for the budget has no closed form with it; "
            f"got {integral:g}."
        )
    say("planning ...")
    plan = job.planned
    start = time.monotonic()
    say(f"planned: {len(plan.knots)} knots, {len(plan.s) - 1} moves, {plan.lap_time:.1f} s a lap")
    rays = f"{job.wall['along']} x {job.wall['around']} rays"
    axes, wall = job.expected_seconds
    # The budget runs a lap's axes some times more.
    runs = LOADED_RUNS if job.arm else BUDGET_RUNS
    lasts = f"about {max(round(axes * (1 + runs / plan.laps) + wall), 1)} s"
    say(f"simulating {plan.laps} x {plan.ticks.sum()} ticks on {rays}, {lasts} ...")
    cut = job.simulated(say)
    say(
        f"simulated in {time.monotonic() - start:.0f} s; the cutter is off by at most "
        f"{1e3 * np.abs(cut.deviation).max():.2f} mm"
    )
    return job, cut


def own_name(path):
    """Return what the files of a job are called by: its file's name, never dots alone.

    Those would name another folder: a job may be called ``...toml``.
    """
    stem = path.name.rpartition(".")[0] or path.name  # pathlib's own differs since Python 3.14
    return stem if stem.strip(".") else "job"


@contextmanager
def seldom_swept():
    """Let Python look for cycles of garbage seldom: imports make many objects, and no cycles."""
    usual = gc.get_threshold()
    gc.set_threshold(SELDOM, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


@seldom_swept()
def run_cut(options):
    """Plan, simulate, and write the budget and the files."""
    from .job import say
    from .job.atomic_write import list_files, output
    from .job.results import summarise, summary_text, write_all

    folder = options.out or Path("build") / own_name(options.job)
    with output(folder) as new:
        job, cut = read(options)
        numbers = summarise(job, cut, say)
        if not options.json:
            tell(summary_text(numbers) + "\n")
        files = write_all(job, cut, new, numbers, say)
        files += draw_wall(job, cut, new / "wall.png", say)
        files.append(list_files(new, job.stamp))
    for warning in numbers["warnings"]:
        say(f"warning: {warning}")
    return {**numbers, "files": [str(folder / file.name) for file in files]}


def draw_wall(job, cut, path, say):
    """Write the wall of a job's cut as a picture to a path, and its laps beside it.

    Return the files written, none where a package is missing; `say` gets the reason.
    """
    try:
        from .job import wall_plot
    except ImportError as error:
        say(f"{path.name} is left out: {missing(error)}")
        return []
    laps = path.with_name("laps.png")
    say(f"writing {path.name} and {laps.name}")
    return [
        wall_plot.write_unrolled(path, cut, limit=job.limit, stamp=job.stamp),
        wall_plot.write_laps(laps, cut, tolerance=job.plan["tolerance"], stamp=job.stamp),
    ]


if __name__ == "__main__":
    sys.exit(main())
