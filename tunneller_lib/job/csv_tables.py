"""Tables for others, and for ourselves again: knots, setpoints, set-values as CSV.

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


@checked
def read_csv(text: str):
    """Return a table as it was written: by `knots_csv`, `setpoints_csv` or `setvalues_csv`.

    Parameters
    ----------
    text : str
        Lines of ``# name = value``, a heading, rows of numbers. Blank lines don't count.

    Returns
    -------
    about : dict of str to float
        What the head says: ``tick_s``, ``count_rad``, ``laps``, ``advance_m``.
    columns : dict of str to (n,) int or float
        By their names.

    Raises
    ------
    ValueError
        If there is no heading, its names aren't separated by commas, a name stands twice in it, a
        line has another length, or something is no number.
    """
    head = [line[2:].split(" = ") for line in text.splitlines() if line.startswith("# ")]
    about = {name: _number(name, value) for name, value in (p for p in head if len(p) == 2)}
    lines = {
        number: line.split(",")
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    }
    if not lines:
        raise ValueError("text: must have a heading; got none.")
    names = lines.pop(min(lines))
    names = [name.strip() for name in names]
    if any(mark in name for name in names for mark in ";\t"):
        raise ValueError(
            "text: its columns must be separated by commas, decimals by points; got the heading "
            f"{shown(','.join(names))}."
        )
    if len(set(names)) < len(names):
        raise ValueError(f"text: must name each column once; got {shown(names)}.")
    for number, row in lines.items():
        if len(row) != len(names):
            raise ValueError(
                f"text: line {number} must have {len(names)} numbers, one under each name; "
                f"got {len(row)}."
            )
    columns = zip(names, *lines.values(), strict=True)
    return about, {name: _numbers(name, cells) for name, *cells in columns}


def _number(name, cell):
    """Return what the head says of a name as a number."""
    try:
        return float(cell)
    except ValueError:
        raise ValueError(f"text: {shown(name)} must be a number; got {shown(cell)}.") from None


def _numbers(name, cells):
    """Return the cells of a column as whole numbers, or else as numbers."""
    for kind in (np.int64, np.float64):
        try:
            return np.array(cells, dtype=str).astype(kind)
        except (ValueError, OverflowError):
            continue
    raise ValueError(f"text: column {shown(name)} must hold numbers; got {shown(cells[:3])}.")
