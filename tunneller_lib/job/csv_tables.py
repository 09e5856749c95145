"""Tables of a plan for others, and for ourselves again: knots, setpoints, set-values as CSV.

In metres, radians and whole counts; the head of each says which.
"""

import numpy as np

from ..arguments import checked, shown
from ..ream.planning import Plan

JOINTS = "theta", "phi"


@checked
def knots_csv(plan: Plan):
    """Return the knots of a plan as a table: arc lengths in m and joint positions in counts."""
    counts = np.rint(plan.circuit.position(plan.knots) / plan.count).astype(np.int64)
    places = [[repr(float(s))] for s in plan.knots]
    what = "knots: s in m along the offset section, theta and phi in counts"
    return _described(plan, what, _columns(["knot", "s", *JOINTS], places, counts))


@checked
def setpoints_csv(plan: Plan):
    """Return the setpoints of a lap as a table: ticks of each move, its end, time and feed.

    Joint positions are whole parts of a count, and the head says how many ``parts`` make one. The
    first row, of no ticks, is where the lap begins; `motion.polyline` makes the set-values.
    """
    ticks = np.append(0, plan.ticks)
    times = (plan.tick * np.cumsum(ticks)).round(9)
    left = [list(row) for row in zip(ticks.tolist(), *_texts(times, plan.feed), strict=True)]
    what = "setpoints of a lap: ticks of the move to each, theta and phi in parts of a count"
    names = ["setpoint", "ticks", "time_s", "feed_m_s", *JOINTS]
    return _described(plan, what, _columns(names, left, plan.parts), parts=plan.fineness)


@checked
def setvalues_csv(plan: Plan):
    """Return the set-values of a lap as a table: tick, time, whole counts and exact slopes.

    A slope is that of the exact line from this tick to the next, which the counts round.
    """
    values = np.rint(plan.setvalues / plan.count).astype(np.int64)
    times = (plan.tick * np.arange(len(values))).round(9)
    slopes = np.concatenate([plan.slopes, np.zeros((1, 2))])
    left = [list(row) for row in zip(*_texts(times, *slopes.T), strict=True)]
    names = ["tick", "time_s", *(f"{joint}_slope_rad_s" for joint in JOINTS), *JOINTS]
    return _described(
        plan, "set-values of a lap: theta and phi in counts", _columns(names, left, values)
    )


@checked
def read_csv(text: str):
    """Return what a table of this module says, a `text`: its head's numbers and its columns.

    Both are dicts by name; a column is an array of whole numbers, or else of floats.

    Raises
    ------
    ValueError
        If it isn't such a table, as where a row has another length than the heading.

    Examples
    --------
    >>> read_csv("# a few rows\\n# tick_s = 0.005\\ntick,theta\\n0,1\\n1,2\\n")[1]["theta"]
    array([1, 2])
    """
    lines = text.splitlines()
    about = [line[2:].split(" = ") for line in lines if line.startswith("# ") and " = " in line]
    try:
        names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
        columns = zip(names, *rows, strict=True)
        return (
            {name: float(value) for name, value in about},
            {name: _numbers(cells) for name, *cells in columns},
        )
    except ValueError:
        raise ValueError(f"text: must be a table as of `knots_csv`; got {shown(text)}.") from None


def _numbers(cells):
    """Return the texts of a column as whole numbers, or else as floats."""
    cells = np.array(cells, dtype=str)
    try:
        return cells.astype(np.int64)
    except (ValueError, OverflowError):
        return cells.astype(float)


def _texts(*columns):
    """Return columns of floats as texts that are read back bit for bit."""
    return [[repr(float(one)) for one in column] for column in columns]


def _columns(names, left, counts):
    """Return numbered rows under their heading, parted by commas."""
    rows = ([i, *a, *b] for i, (a, b) in enumerate(zip(left, counts.tolist(), strict=True)))
    return "".join(",".join(map(str, row)) + "\n" for row in (names, *rows))


def _described(plan, what, text, **more):
    """Return a table under the lines that say what it is, and `more` of them."""
    head = [
        what,
        f"tick_s = {plan.tick!r}",
        f"count_rad = {plan.count!r}",
        f"laps = {plan.laps}",
        f"advance_m = {plan.advance!r}",
        *(f"{name} = {value}" for name, value in more.items()),
    ]
    return "".join(f"# {line}\n" for line in head) + text
