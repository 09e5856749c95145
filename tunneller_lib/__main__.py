"""The command line: `tunneller --help`, or `python -m tunneller_lib --help`."""

import argparse
import atexit
import csv
import gc
import json
import math
import os
import sys
import time
from contextlib import contextmanager, suppress
from importlib import import_module
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


def missing(error, extra="[scene]"):
    """Return the sentence of a package that isn't installed or can't be loaded.

    What needs more than numpy and scipy says which `extra` brings it.
    """
    name = (error.name or "").partition(".")[0]
    if not isinstance(error, ModuleNotFoundError):
        said = str(error).strip().partition("\n")[0].rstrip(".")
        why = said or "no reason is given"
        if name != "vtkmodules":
            which = f"the package {PACKAGES.get(name, name)}" if name else "a package"
            return f"{which} can't be loaded; {why}."
        from .reporting import gl

        return f"VTK can't be loaded ({why}): {gl.REMEDY}"
    extra = {"numpy": "", "scipy": "", "distributed": "[cluster]"}.get(name, extra)
    return (
        f"the package {PACKAGES.get(name, name)} is missing; "
        f'pip install ".{extra}" in this study\'s folder brings it.'
    )


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

    job = command("cut", run_cut, "plan and simulate a cut; write its error budget and files")
    scene = command("scene", run_scene, "write the machine in the tunnel as a web page, offline")
    film = command("animate", run_animate, "write an animation of the cut as a GIF (minutes)")
    film.description += (
        "; without a graphics card each picture takes one to several seconds, 60 of them minutes"
    )
    for added, out in ((job, ""), (scene, ".html"), (film, ".gif")):
        added.add_argument("job", type=Path, help="the TOML file")
        added.add_argument(
            "--out",
            type=path_with(out),
            metavar=f"FILE{out}" if out else "FOLDER",
            help="under build/ by default",
        )
        added.add_argument("--json", action="store_true", help=JSON)
    scene.add_argument("--share", type=share, default=1.0, help="of the run: 0 to 1, the end")
    film.add_argument("--frames", type=between(2, 600), default=60, help="how many, 60 by default")
    film.add_argument(
        "--width", type=between(64, 1600), default=800, help="in pixels, at most 1600"
    )

    added = command("atlas", run_atlas, "sweep tori and pairs of positions (minutes)")
    added.add_argument(
        "--folder", type=Path, default=Path("build/atlas"), help="where blocks are kept"
    )
    added.add_argument(
        "--table", type=table, default=Path("notebooks/atlas.csv"), help="the summary"
    )
    added.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster")
    added.add_argument(
        "--jobs", type=between(1, 10_000), help="local processes, one a core by default"
    )
    return whole


def path_with(suffix):
    """Return the type of a path with this suffix; any if it is empty."""

    def path(text):
        if suffix and Path(text).suffix != suffix:
            raise argparse.ArgumentTypeError(f"must end in {suffix}; got {text}.")
        return Path(text)

    return path


def share(text):
    """Return a number from 0 to 1."""
    if not 0 <= float(text) <= 1:
        raise argparse.ArgumentTypeError(f"must be from 0 to 1; got {text}.")
    return float(text)


def between(least, most):
    """Return the type of a whole number from `least` to `most`."""

    def whole_number(text):
        if not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"must be from {least} to {most}; got {text}.")
        return int(text)

    return whole_number


def table(text):
    """Return the path of a table whose folder is there."""
    if not Path(text).parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {Path(text).parent}.")
    return Path(text)


def read(options, *, budget=False):
    """Return the job that a command's options name and its cut, planned and simulated.

    Where a `budget` is wanted a job that has none is refused.
    """
    import numpy as np

    from .job import read_job, say

    job = read_job(options.job)
    if budget and (integral := job.controller.get("integral")):
        raise ValueError(
            "[controller] integral: must be 0 for cut, whose budget has no closed form with it; "
            f"scene and animate take it; got {integral:g}."
        )
    say("planning ...")
    plan = job.planned
    start = time.monotonic()
    say(f"planned: {len(plan.knots)} knots, {len(plan.s) - 1} moves, {plan.lap_time:.1f} s a lap")
    rays = f"{job.wall['along']} x {job.wall['around']} rays"
    axes, wall = job.expected_seconds
    # The budget runs a lap's axes some times more.
    runs = LOADED_RUNS if job.arm else BUDGET_RUNS
    more = runs / plan.laps if budget else 0.0
    lasts = f"about {max(round(axes * (1 + more) + wall), 1)} s"
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
        job, cut = read(options, budget=True)
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
        from .reporting import figure, pictures, wall_plot
    except ImportError as error:
        say(f"{path.name} is left out: {missing(error, '[picture]')}")
        return []
    say(f"writing {path.name}")
    drawing, ax = figure(height=9)
    wall_plot.draw_unrolled(ax, cut, limit=job.limit)
    files = [pictures.write_picture(path, drawing, job.stamp)]
    laps = path.with_name("laps.png")
    say(f"writing {laps.name}")
    drawing, ax = figure(height=6)
    wall_plot.draw_laps(ax, cut, tolerance=job.plan["tolerance"])
    return [*files, pictures.write_picture(laps, drawing, job.stamp)]


def run_scene(options):
    """Write the scene at a share of the run."""
    import_module("trame")  # else first asked for when the page is written, after the simulation
    from .job import say
    from .job.atomic_write import check_writable, output
    from .reporting import pictures, tunnel_scene

    out = options.out or Path("build") / f"{own_name(options.job)}.html"
    check_writable(out)
    with output(out) as new:
        job, cut = read(options)
        tick = round(options.share * (len(cut.centres) - 1))
        if options.share < 1:
            say(f"cutting again, up to {tick * cut.plan.tick:.1f} s ...")
        plotter = tunnel_scene.cut_scene(cut, tick, limit=job.limit)
        pictures.write_picture(new, plotter, job.stamp)
    return {"files": [str(out)]}


def run_animate(options):
    """Write the pictures of the run."""
    from .job.atomic_write import check_writable, output
    from .reporting import pictures, tunnel_scene

    out = options.out or Path("build") / f"{own_name(options.job)}.gif"
    check_writable(out)
    with output(out) as new:
        job, cut = read(options)
        count = options.frames
        every = tunnel_scene.cut_pictures(cut, count, width=options.width, limit=job.limit)
        pictures.write_picture(new, counted(every, count), job.stamp)
    return {"files": [str(out)]}


def counted(pictures, count):
    """Yield pictures and say how many are done."""
    from .job import say

    start = time.monotonic()
    for number, picture in enumerate(pictures, start=1):
        yield picture
        pace = (time.monotonic() - start) / number
        say(f"{number} of {count} pictures, {pace * (count - number):.0f} s to go")


def run_atlas(options):
    """Sweep the blocks that are missing, then write the summary."""
    import numpy as np

    from .job.atomic_write import replacement
    from .paths import atlas
    from .reporting.sweep import compute_blocks

    files = compute_blocks(
        atlas.survey, atlas.blocks(), options.folder, scheduler=options.scheduler, jobs=options.jobs
    )
    rows = atlas.summary(map(np.load, files))
    with replacement(options.table) as new, new.open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({name: plain(value) for name, value in row.items()} for row in rows)


def plain(value):
    """Return a number with nine digits, other values as they are."""
    return f"{value:.9g}" if isinstance(value, float) else value


if __name__ == "__main__":
    sys.exit(main())
