"""What the planner's pages run: the command line itself, a picture of the plan, and geodesics."""

import io
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np

from exhibits.machine_plot import draw_limits
from kit import COLOURS, figure
from tunneller_lib import __main__ as command
from tunneller_lib.job.wall_plot import write_drawing
from tunneller_lib.paths import CHORD_PATHS, geodesic_direct, geodesic_inverse, path_length
from tunneller_lib.surfaces import Torus

HERE = Path("/planned")
DRAWN = 61  # places of a path in a drawing
draw_wall = command.draw_wall


def draw_plan(plan):
    """Return a drawing of a plan: the circuit between the joints' limits, the feed along it."""
    drawing, (joints, along) = figure(1, 2, height=7)
    draw_limits(joints, plan.circuit.machine)
    theta, phi = np.degrees(plan.setpoints).T
    joints.plot(theta, phi, color=COLOURS["offset"])
    knots = np.degrees(plan.circuit.position(plan.knots))
    joints.plot(*knots.T, ".", color=COLOURS["chord"], label=f"{len(plan.knots)} knots")
    joints.legend()
    along.plot(plan.s, 1e3 * plan.feed, color=COLOURS["cutter"])
    along.set(xlabel="place along the offset section / m", ylabel="feed / (mm/s)", ylim=(0, None))
    return drawing


def draw(job, cut, path):
    """Write plan and wall of a cut as pictures; return the files written."""
    plan = path.with_name("plan.png")
    command.say(f"writing {plan.name}")
    write_drawing(plan, draw_plan(cut.plan), job.stamp)
    return [plan, *draw_wall(job, cut, path)]


def cut(text, name):
    """Run the command ``cut`` on a job's text.

    Returns
    -------
    code : int
        The command's exit code.
    printed : str
        What it printed, but for progress and the files' names.
    files : dict of str to bytes
        What it wrote.
    """
    HERE.mkdir(exist_ok=True)
    folder = HERE / "files"
    for old in folder.glob("*"):
        old.unlink()
    job = HERE / name
    job.write_text(text, encoding="utf-8")
    printed = io.StringIO()
    command.draw_wall = draw
    try:
        with redirect_stdout(printed):
            code = command.main(["cut", str(job), "--out", str(folder)])
    finally:
        command.draw_wall = draw_wall
        job.unlink()
    files = {path.name: path.read_bytes() for path in sorted(folder.glob("*"))}
    said = printed.getvalue().partition(f"{folder}/")[0]
    return code, said.strip("\n"), files


def geodesic_of(asked):
    """Return a geodesic's numbers as texts with all digits that they have, and paths to draw.

    Parameters
    ----------
    asked : dict of str to float
        ``r`` and ``R`` of the torus in m; ``theta`` and ``phi`` of the start in degrees; and
        either ``theta2`` and ``phi2`` of the end, or ``azimuth`` in degrees and ``length`` in m.

    Returns
    -------
    numbers : dict of str to str
        By names with their units.
    paths : dict of str to list
        Joint positions in degrees along the geodesic and what stands in for it, by name.
    """
    torus = Torus(r=asked["r"], R=asked["R"])
    start = np.radians([asked["theta"], asked["phi"]])
    if "length" in asked:
        azimuth = np.radians(asked["azimuth"])
        way = geodesic_direct(torus, start, azimuth, asked["length"], DRAWN)
        theta, phi = np.degrees(way.position[-1])
        numbers = {"theta at the end / deg": theta, "phi at the end / deg": phi}
        numbers["azimuth at the end / deg"] = np.degrees(way.azimuth[-1])
        words = {}
    else:
        found = geodesic_inverse(torus, start, np.radians([asked["theta2"], asked["phi2"]]))
        way = found.points(DRAWN)
        numbers = {
            "length / m": found.length,
            "azimuth at the start / deg": np.degrees(found.azimuth1),
            "azimuth at the end / deg": np.degrees(found.azimuth2),
            "Clairaut's constant / m": found.clairaut,
        }
        words = {"kind": str(found.kind), "certificate": str(found.certificate)}
    paths, ends = {"geodesic": way.position}, way.position[[0, -1]]
    for name in ("projected chord", "corrected chord"):
        try:
            numbers[f"{name}, length / m"] = path_length(torus, CHORD_PATHS[name], *ends)
            paths[name] = CHORD_PATHS[name](torus, *ends, np.linspace(0, 1, DRAWN))
        except ValueError:  # none joins these ends
            continue
    texts = {name: repr(float(value)) for name, value in numbers.items()} | words
    return texts, {name: np.degrees(path).tolist() for name, path in paths.items()}
