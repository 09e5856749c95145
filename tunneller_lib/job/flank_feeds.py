"""How long a mill takes on its tour at least, within speeds and accelerations of the axes."""

import numpy as np

from ..milling.tour import CUT, TRAVERSE
from ..ream.timing import Places, fastest

FINE = 128  # parts of a step at whose ends the limits are looked at
# Of each acceleration. Between these ends, where an axis turns round, it is passed by less than the
# rest while the axis' limit is a thousandth of the others' or more; at a ten-thousandth all of it
# was passed by 0.8 %.
USED = 0.99


def seconds_of(tour, length, feed, speeds, accelerations):
    """Return the least times (k,) in s from the place before, 0 at the first.

    Parameters
    ----------
    tour : Tour
        The way.
    length : float
        Of the mill's cutting part, in m.
    feed : float
        Greatest speed, in m/s, of the mill's axis over the workpiece, all along its cutting part,
        but on traverses.
    speeds : (5,) float
        Greatest ones of the machine's axes: three in m/s, two in rad/s.
    accelerations : (5,) float
        Likewise, in m/s^2 and rad/s^2.

    Notes
    -----
    Each chain, and each way to it or from it, goes from rest to rest; on it the axes follow cubic
    splines through the places. Along such a way the square x of its rate has bounds from the
    speeds, and each acceleration q' x'/2 + q'' x is linear in x and its slope: time-optimal path
    parametrisation, which two passes solve.
    """
    seconds = np.zeros(len(tour))
    begins = np.flatnonzero(np.append(True, tour.kind[1:] != tour.kind[:-1]))
    for first, stop in zip(begins, [*begins[1:], len(tour)], strict=True):
        # What isn't a cut begins where the part before it ended.
        rows = slice(first if tour.kind[first] == CUT else max(first - 1, 0), stop)
        most = np.inf if tour.kind[first] == TRAVERSE else feed
        ends = [tour.tip[rows] + k * tour.axis[rows] for k in (0.0, length)]
        part = _from_rest_to_rest(tour.values[rows], ends, most, speeds, accelerations)
        seconds[rows.start + 1 : stop] = part
    return seconds


def _from_rest_to_rest(values, ends, feed, speeds, accelerations):
    """Return the least times (n - 1,) of steps through values (n, 5), `ends` (n, 3) with them."""
    from scipy.interpolate import CubicSpline

    n = len(values)
    if not np.any(np.diff(values, axis=0)):
        return np.zeros(n - 1)
    at = np.linspace(0, n - 1, (n - 1) * FINE + 1)
    axes = CubicSpline(np.arange(n), values)
    slope = axes(at, 1)
    with np.errstate(divide="ignore"):
        rate = np.min(np.asarray(speeds) / np.abs(slope), axis=1)
        # Between the ends of a stiff axis no point is faster than the faster end.
        for end in ends:
            way = np.linalg.norm(CubicSpline(np.arange(n), end)(at, 1), axis=1)
            rate = np.minimum(rate, feed / way)
    bend = axes(at, 2)
    # Where nothing moves, as on a straight way back, speeds allow as much as anywhere else.
    moving = np.isfinite(rate)
    rate[~moving] = rate[moving].max()
    # An acceleration slope a + bend x is within its limits at both ends of a part (TOPP-RA calls it
    # interpolation). On the part a is constant, so that x has grown by 2 step a at the other end.
    after = np.minimum(np.arange(len(at)) + 1, len(at) - 1)
    step = np.diff(at, append=at[-1])[:, None]
    slopes = np.hstack([slope, slope[after] + 2 * step * bend[after]])
    bends = np.hstack([bend, bend[after]])
    limits = np.tile(USED * np.asarray(accelerations), 2)
    places = Places(rate**2, np.inf, limits, slopes, bends, np.ones_like(slopes))
    rate = np.sqrt(fastest(np.diff(at), places))
    return (2 * np.diff(at) / (rate[1:] + rate[:-1])).reshape(n - 1, FINE).sum(axis=1)
