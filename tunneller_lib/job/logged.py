"""A log of one axis as CSV, and the gain and lag that it tells."""

from contextlib import contextmanager
from dataclasses import asdict
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, shown
from ..motion.identify import LEAST_ROWS, MOST_ROWS, identify_axis, identify_loop
from ..motion.quantities import Share
from .csv_reading import read_csv
from .tables import content_of, text_of

TIME = "time_s"
# The columns beside the time: what was the input, what the axis did.
LOGS = [("valve", "speed_rad_s"), ("valve", "position_rad"), ("set_rad", "actual_rad")]
MOST_BYTES = 100 * MOST_ROWS  # of a file
UNEVEN = 0.01  # of a tick, by which a row's time may be off
UNITS = {"valve": "rad/s", "set_rad": "1/s"}


def _found(name, value):
    """Return `value`, which must be a dict as `identify_log` makes it."""
    if not isinstance(value, dict) or "gain_unit" not in value:
        raise ValueError(f"{name}: must be a dict from identify_log; got {shown(value)}.")
    return value


Found = Annotated[dict, Rule("dict", _found)]


def read_log(path):
    """Return the text of a log, or raise WrongJob."""
    return text_of(path, content_of(path, "a log", MOST_BYTES))


@checked
def identify_log(text: str, *, feedforward: Share(2) = 0.0):
    """Return what a log tells of an axis or of its loop, ready for JSON.

    Parameters
    ----------
    text : str
        CSV with a heading. Columns ``time_s``, and ``valve`` (-1 to 1) with ``speed_rad_s`` or
        ``position_rad``, or ``set_rad`` with ``actual_rad``; others are left alone.
    feedforward : float
        Share of the slope that the loop adds, see `motion.identify.identify_loop`.

    Returns
    -------
    found : dict
        ``columns`` that were used, ``rows``, ``tick_s``, ``gain`` and ``gain_error``, their
        ``gain_unit``: rad/s for the full valve, or 1/s of a loop; ``lag_s``, ``lag_error_s``,
        ``delay`` in whole ticks, ``rms`` that is left, in the measured column's unit.

    Raises
    ------
    ValueError
        If a column is missing, rows are too few or too many, the times aren't even, or nothing
        moves; it names columns as the log does.
    """
    _, columns = read_csv(text, most=2 * MOST_ROWS)
    pair = next((pair for pair in LOGS if {TIME, *pair} <= set(columns)), None)
    if pair is None:
        known = "; or ".join(", ".join((TIME, *pair)) for pair in LOGS)
        raise ValueError(f"text: must have the columns {known}; got {', '.join(columns)}.")
    given, measured = (columns[name].astype(float) for name in pair)
    if not LEAST_ROWS <= len(given) <= MOST_ROWS:
        raise ValueError(f"text: must have {LEAST_ROWS} to {MOST_ROWS} rows; got {len(given)}.")
    tick = _tick(columns[TIME].astype(float))
    if pair[0] == "valve":
        if feedforward:
            raise ValueError(f"feedforward: must be 0 for an axis' log; got {feedforward:g}.")
        kind = pair[1].partition("_")[0]
        with _named(valve=pair[0], measured=pair[1]):
            found = identify_axis(given, measured, tick, kind=kind)
    else:
        with _named(setvalue=pair[0], actual=pair[1]):
            found = identify_loop(given, measured, tick, feedforward=feedforward)
    about = asdict(found)
    return {
        "columns": list(pair),
        "rows": len(given),
        "tick_s": tick,
        "gain": about["gain"][0],
        "gain_error": about["gain"][1],
        "gain_unit": UNITS[pair[0]],
        "lag_s": about["lag"][0],
        "lag_error_s": about["lag"][1],
        "delay": found.delay,
        "rms": found.rms,
    }


@checked
def identified_text(numbers: Found):
    """Return what `identify_log` found as lines for people."""
    per = numbers["gain_unit"] + (" for the full valve" if numbers["columns"][0] == "valve" else "")
    unit = numbers["columns"][1].partition("_")[2].replace("_", "/")
    return "\n".join(
        [
            f"{numbers['rows']} rows, {1e3 * numbers['tick_s']:g} ms apart: "
            f"{' and '.join(numbers['columns'])}",
            f"gain   {numbers['gain']:.4g} ± {numbers['gain_error']:.1g} {per}",
            f"lag    {1e3 * numbers['lag_s']:.4g} ± {1e3 * numbers['lag_error_s']:.1g} ms",
            f"delay  {numbers['delay']} ticks",
            f"left   {numbers['rms']:.2g} {unit} rms: noise",
        ]
    )


@contextmanager
def _named(**columns):
    """Let a refusal name a column as the log does, in the place of an argument."""
    try:
        yield
    except ValueError as error:
        argument, colon, what = str(error).partition(": ")
        name = (columns | {"tick": f"steps of {TIME}"}).get(argument, argument)
        raise ValueError(f"{name}{colon}{what}") from None


def _tick(times):
    """Return the even distance of times, in s."""
    steps = np.diff(times)
    if not np.all(np.isfinite(steps)):
        raise ValueError(f"text: {TIME} must be finite times; got {shown(times[:3].tolist())}.")
    tick = float((times[-1] - times[0]) / len(steps))
    worst = float(np.abs(steps - tick).max())
    if not 0 < tick or worst > UNEVEN * tick:
        raise ValueError(
            f"text: {TIME} must rise by steps even to {100 * UNEVEN:g} %; got steps from "
            f"{steps.min():g} to {steps.max():g} s."
        )
    return tick
