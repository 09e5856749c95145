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
from importlib.resources import files
from pathlib import Path

from . import __version__
from .terminal import fit

# Whatever isn't in Python itself is imported by the command that needs it: so --help needs nothing,
# and a missing package, or an interrupt meanwhile, is told in a sentence.

ABOUT = """plan and simulate cuts of a tunnelling robot

A job is a TOML file in metres, seconds and radians, or degrees in names that end in _deg. A first
one: tunneller example > job.toml; tunneller cut job.toml. Progress goes to stderr.

The exit code is 0 if all is well, though there may be warnings; 1 if a value of the job is refused,
with the reason; 2 if something can't be read: a file or a package that isn't there, what is no
TOML, a command, a table or a name that isn't known or is missing; 130 after an interrupt.
"""
SELDOM = 1_000_000  # objects that are made before Python looks for garbage
# How many laps of the axes the budget and what halves its faults take: of each joint alone, and of
# both under loads besides.
BUDGET_RUNS, LOADED_RUNS = 7, 17
LONGEST_PATH = 5000  # characters: more than systems take
PACKAGES = {"PIL": "pillow"}  # whose name isn't that of their import


def main(arguments=None):
    """Run the command that `arguments`, a list of str, names; return the process' exit code."""
    whole = parser()
    options = whole.parse_args(arguments)
    if options.run is None:
        whole.print_help()
        return 0
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


def missing(error):
    """Return a sentence that names a package that isn't installed or can't be loaded."""
    name = (error.name or "").partition(".")[0]
    package = f"the package {PACKAGES.get(name, name)}" if name else "a package"
    if not isinstance(error, ModuleNotFoundError):
        said = str(error).strip().partition("\n")[0].rstrip(".")
        return f"{package} can't be loaded; {said or 'no reason is given'}."
    extra = "" if name in ("numpy", "scipy") else "[picture]"
    return f'{package} is missing; pip install ".{extra}" in this study\'s folder brings it.'


def ended(options, code, how, why):
    """Say `how` a command with these options ended early, and `why`; return its exit code."""
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
    """Print an answer: lines as they are, and all else as JSON.

    A reader that stops early, as `| head`, doesn't stop the command.
    """
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
    """Return a value with None for each number that JSON doesn't have: inf and nan."""
    if isinstance(value, dict):
        return {name: for_json(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [for_json(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def unread(stream):
    """Redirect a stream to nowhere, so that Python can flush it at its end without an error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Parser(argparse.ArgumentParser):
    """A parser whose error messages are safe for a terminal, whatever was typed."""

    def error(self, message):
        """End the process with the exit code 2 and the message."""
        super().error(fit(message))


def parser():
    """Return the parser of the arguments."""
    whole = Parser(
        prog="tunneller", description=ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    whole.add_argument("--version", action="version", version=f"tunneller {__version__}")
    whole.set_defaults(run=None)
    commands = whole.add_subparsers(metavar="COMMAND")

    def command(name, run, text):
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(run=run)
        return added

    command("example", run_example, "print the reference job, whose comments explain each entry")
    cut = command("cut", run_cut, "plan and simulate a cut; write its error budget and files")
    cut.add_argument("job", type=Path, help="the TOML file, or - for standard input")
    cut.add_argument("--out", type=Path, metavar="FOLDER", help="under build/ by default")
    cut.add_argument("--dry-run", action="store_true", help="plan and check; simulate nothing")
    cut.add_argument(
        "--json",
        action="store_true",
        help="answer in JSON, in SI units; null for a number that isn't finite",
    )
    return whole


def run_example(_):
    """Print the reference job."""
    tell(files(__package__).joinpath("job", "reference.toml").read_text(encoding="utf-8").rstrip())


def planned(options):
    """Return the job that a command's options name, planned and checked."""
    from .job import read_job, say

    job = read_job(options.job)
    if integral := job.controller.get("integral"):
        raise ValueError(
            "[controller] integral: must be 0, for the budget has no closed form with it; "
            f"got {integral:g}."
        )
    say("planning ...")
    plan = job.planned
    say(f"planned: {len(plan.knots)} knots, {len(plan.s) - 1} moves, {plan.lap_time:.1f} s a lap")
    rays = f"{job.wall['along']} x {job.wall['around']} rays"
    axes, wall = job.expected_seconds
    # The budget runs a lap's axes some times more.
    runs = LOADED_RUNS if job.arm else BUDGET_RUNS
    lasts = f"about {max(round(axes * (1 + runs / plan.laps) + wall), 1)} s"
    say(f"the simulation, {plan.laps} x {plan.ticks.sum()} ticks on {rays}, takes {lasts}")
    return job


def simulated(job):
    """Return the simulated cut of a job."""
    import numpy as np

    from .job import say

    start = time.monotonic()
    say("simulating ...")
    cut = job.simulated(say)
    say(
        f"simulated in {time.monotonic() - start:.0f} s; the cutter is off by at most "
        f"{1e3 * np.abs(cut.deviation).max():.2f} mm"
    )
    return cut


def own_name(path):
    """Return the name of a job's folder: its file's, but never dots alone, nor that of stdin.

    Dots would name another folder: a job may be called ``...toml``.
    """
    stem = path.name.rpartition(".")[0] or path.name  # pathlib's own differs since Python 3.14
    return stem if stem.strip(".-") else "job"


@contextmanager
def seldom_swept():
    """Have Python look for garbage seldom: imports make many objects, and no cycles of them."""
    usual = gc.get_threshold()
    gc.set_threshold(SELDOM, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


@seldom_swept()
def run_cut(options):
    """Plan, simulate, and write the budget and the files; or only plan, and check the plan."""
    from .job import say
    from .job.atomic_write import list_files, output
    from .job.results import plan_numbers, plan_text, summarise, summary_text, write_all

    if options.dry_run:
        numbers = plan_numbers(planned(options))
        if not options.json:
            tell(plan_text(numbers))
        return {**numbers, "files": []} if options.json else None
    folder = options.out or Path("build") / own_name(options.job)
    with output(folder) as new:
        job = planned(options)
        cut = simulated(job)
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
    """Write pictures of the wall of a job's cut and of its laps; return their paths.

    There are none if a package is missing; `say` gets the reason.
    """
    try:
        from .job import wall_plot
    except ImportError as error:
        say(f"{path.name} is left out: {missing(error)}")
        return []
    laps = path.with_name("laps.png")
    say(f"writing {path.name} and {laps.name}")
    return wall_plot.write_pictures(job, cut, path, laps)


if __name__ == "__main__":
    sys.exit(main())
