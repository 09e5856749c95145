"""Tables of a plan as CSV: a heading of names with units, then rows of numbers.

What all rows share stands in a table of its own, of one row.
"""

import csv
import io

import numpy as np


def table(rows):
    """Return rows, dicts with the same keys, as CSV with the keys as heading."""
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _columns(columns):
    """Return a dict of columns of numbers as CSV; floats keep all their digits."""
    rows = zip(*(np.asarray(one).tolist() for one in columns.values()), strict=True)
    return table([dict(zip(columns, row, strict=True)) for row in rows])


def plan_csv(plan, stamp):
    """Return what all tables of a plan share: the job's `stamp`, tick, count, laps, advance.

    The unit of the setpoints is a count divided by ``parts``.
    """
    about = {"job": stamp, "tick_s": plan.tick, "count_rad": plan.count, "parts": plan.fineness}
    return table([{**about, "laps": plan.laps, "advance_m": plan.advance}])


def knots_csv(plan):
    """Return the knots of a plan: arc lengths along the offset section, positions in counts."""
    theta, phi = np.rint(plan.circuit.position(plan.knots) / plan.count).astype(np.int64).T
    knots = {"knot": range(len(theta)), "s_m": plan.knots}
    return _columns({**knots, "theta_counts": theta, "phi_counts": phi})


def setpoints_csv(plan):
    """Return the setpoints of the laps: ticks of the move to each, time, feed and position.

    The rows of lap 1 come first, then, if there are several, those of lap 2, as which all others
    are. The first row of each, with no ticks, is its begin; `motion.polyline` makes the set-values.
    """
    return _columns(_by_lap(plan, _setpoints))


def _setpoints(lap):
    ticks = np.append(0, lap.ticks)
    theta, phi = lap.parts.T
    return {
        "setpoint": np.arange(len(ticks)),
        "ticks": ticks,
        "time_s": (lap.tick * np.cumsum(ticks)).round(9),
        "feed_m_s": lap.feed,
        "theta_parts": theta,
        "phi_parts": phi,
    }


def setvalues_csv(plan):
    """Return the set-values of the laps: ticks, times, exact slopes and whole counts.

    A slope is that of the exact line from this tick to the next; the counts round that line. Laps
    are as in `setpoints_csv`.
    """
    return _columns(_by_lap(plan, _setvalues))


def _setvalues(lap):
    theta, phi = np.rint(lap.setvalues / lap.count).astype(np.int64).T
    ticks = np.arange(len(theta))
    slopes = np.concatenate([lap.slopes, np.zeros((1, 2))]).T
    found = {"tick": ticks, "time_s": (lap.tick * ticks).round(9)}
    found |= zip(("theta_slope_rad_s", "phi_slope_rad_s"), slopes, strict=True)
    return found | {"theta_counts": theta, "phi_counts": phi}


def _by_lap(plan, columns):
    """Return the columns of the first lap and of one beside it, behind the number of the lap."""
    laps = [plan] if plan.laps == 1 else [plan, plan.lap(1)]
    found = []
    for number, lap in enumerate(laps, start=1):
        own = columns(lap)
        found.append({"lap": np.full(len(own["time_s"]), number)} | own)
    return {name: np.concatenate([one[name] for one in found]) for name in found[0]}
