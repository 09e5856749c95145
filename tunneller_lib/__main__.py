"""The command line: `tunneller --help`, or `python -m tunneller_lib --help`."""

import argparse
import json
import math
import os
import signal
import sys
import time
from importlib.resources import files
from pathlib import Path

from . import __version__
from .terminal import fit

# Packages are imported by the commands that need them, so that --help needs none, and a missing
# package is reported in a sentence.

ABOUT = """plan and simulate cuts of a tunnelling robot

A job is a TOML file in metres, seconds and radians, or degrees in names that end in _deg. A first
one: tunneller example > job.toml; tunneller cut job.toml. Progress goes to stderr.

The exit code is 0 for success, even with warnings; 1 if a value of the job is refused, with the
reason; 2 if a file can't be read or written, isn't TOML, or has a table or a name that is unknown
or missing, or if a package is missing; 130 after an interrupt or SIGTERM.
"""
PACKAGES = {"PIL": "pillow"}  # installed under another name than they are imported by


def main(arguments=None):
    """Run the command that `arguments`, a list of str, names; return the process' exit code."""
    if arguments is None:  # a program of its own, which SIGTERM ends as Ctrl-C does
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    whole = parser()
    options = whole.parse_args(arguments)
    if options.run is None:
        whole.print_help()
        return 0
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
        why = str(error).partition("\n")[0].rstrip(".")
        return f"{package} can't be loaded; {why}."
    extra = "" if name in ("numpy", "scipy") else "[picture]"
    return f'{package} is missing; pip install ".{extra}" in this study\'s folder brings it.'


def ended(options, code, how, why):
    """Say `how` a command with these `options` ended early and `why`; return its exit code."""
    why = why if why is True else fit(why)
    print(how if why is True else f"{how}: {why}", file=sys.stderr, flush=True)
    if getattr(options, "json", False):
        tell({how: why})
    return code


def say(text):
    """Print a line of progress on standard error, at once."""
    print(fit(text), file=sys.stderr, flush=True)


def tell(answer):
    """Print an answer: text as it is, anything else as JSON."""
    text = answer
    if not isinstance(answer, str):
        text = json.dumps(for_json(answer), indent=1, allow_nan=False)
    try:
        print(text, flush=True)
    except OSError as error:
        unread(sys.stdout)
        if not isinstance(error, BrokenPipeError):  # `| head` has read enough, which is no error
            raise


def for_json(value):
    """Return a value with None in place of inf and nan, which JSON lacks."""
    if isinstance(value, dict):
        return {name: for_json(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [for_json(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def unread(stream):
    """Redirect a closed stream to nowhere, so that Python can flush it on exit without an error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def parser():
    """Return the parser of the arguments."""
    whole = argparse.ArgumentParser(
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
    from .job import read_job

    job = read_job(options.job)
    say("planning ...")
    plan = job.planned
    job.checked  # noqa: B018
    say(f"planned: {len(plan.knots)} knots, {len(plan.s) - 1} moves, {plan.lap_time:.1f} s a lap")
    return job


def simulated(job):
    """Return the simulated cut of a job."""
    import numpy as np

    start = time.monotonic()
    say(f"simulating {job.planned.laps} x {job.planned.ticks.sum()} ticks ...")
    cut = job.simulated(say)
    say(
        f"simulated in {time.monotonic() - start:.0f} s; the cutter is off by at most "
        f"{1e3 * np.abs(cut.deviation).max():.2f} mm"
    )
    return cut


def run_cut(options):
    """Plan a cut; unless it is a dry run also simulate it, and write the budget and the files."""
    from .atomic_write import list_files, output
    from .job.results import plan_numbers, plan_text, summarise, summary_text, write_all

    if options.dry_run:
        numbers = plan_numbers(planned(options))
        if not options.json:
            tell(plan_text(numbers))
        warn(numbers)
        return {**numbers, "files": []} if options.json else None
    # A job's name may be - or dots alone, which would name another folder.
    folder = options.out or Path("build", options.job.stem.strip(".-") or "job")
    with output(folder) as new:
        job = planned(options)
        cut = simulated(job)
        numbers = summarise(job, cut, say)
        if not options.json:
            tell(summary_text(numbers) + "\n")
        files = write_all(job, cut, new, numbers, say)
        files += draw_wall(job, cut, new / "wall.png")
        files.append(list_files(new, job.stamp))
    warn(numbers)
    return {**numbers, "files": [str(folder / file.name) for file in files]}


def warn(numbers):
    """Say the warnings among a command's numbers."""
    for warning in numbers["warnings"]:
        say(f"warning: {warning}")


def draw_wall(job, cut, path):
    """Write pictures of the wall of a job's cut and of its laps; return their paths.

    If a package is missing there are none, and the reason is said.
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
