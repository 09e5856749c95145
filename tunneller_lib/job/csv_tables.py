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
    """Return the setpoints of a lap: ticks of the move to each, time, feed and position.

    The first row, with no ticks, is the lap's begin; `motion.polyline` makes the set-values.
    """
    ticks = np.append(0, plan.ticks)
    setpoints = {"setpoint": range(len(ticks)), "ticks": ticks}
    setpoints["time_s"] = (plan.tick * np.cumsum(ticks)).round(9)
    theta, phi = plan.parts.T
    return _columns({**setpoints, "feed_m_s": plan.feed, "theta_parts": theta, "phi_parts": phi})


def setvalues_csv(plan):
    """Return the set-values of a lap: ticks, times, exact slopes and whole counts.

    A slope is that of the exact line from this tick to the next; the counts round that line.
    """
    theta, phi = np.rint(plan.setvalues / plan.count).astype(np.int64).T
    ticks = np.arange(len(theta))
    slopes = np.concatenate([plan.slopes, np.zeros((1, 2))]).T
    found = {"tick": ticks, "time_s": (plan.tick * ticks).round(9)}
    found |= zip(("theta_slope_rad_s", "phi_slope_rad_s"), slopes, strict=True)
    return _columns({**found, "theta_counts": theta, "phi_counts": phi})
