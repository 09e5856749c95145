"""How far down an upright box comes before it touches a rod: the note's part two."""

import numpy as np

from ..arguments import Corners, checked
from .rod import Rod
from .rod_interval import GUARD
from .solid import outermost

UP = np.array([0.0, 0.0, 1.0])


@checked
def meet_box(rod: Rod, low: Corners, high: Corners):
    """Return the lowest and the highest points of a rod within boxes that are endless along z.

    Parameters
    ----------
    rod : Rod
        In any pose, with flat or round ends.
    low, high : (..., 2) float
        Opposite corners (x, y) of the boxes' sections, in m; low <= high.

    Returns
    -------
    bottom, top : (...) float
        Heights z between which a rectangular cutter over that section touches the rod, in m;
        ``inf`` and ``-inf`` where it doesn't.

    Raises
    ------
    ValueError
        If a corner isn't finite or low > high.

    Notes
    -----
    Line and finite cylinder announces this as its part two but doesn't give it. The height of the
    rod's upper side is a concave function over the plane. Over a rectangle it is greatest at the
    rod's own highest point, if that lies over it; or in the plane of a side, where the rod's border
    runs along that side; or on the line through a corner. Each such place has a closed form and is
    a point of the rod. So the highest of them is the answer, and none can be too high. The answer
    is that of a rod whose surface is off by at most 64 eps of its size plus the box's distance.

    Examples
    --------
    >>> bottom, top = meet_box(Rod((0, 0, 0), (0, 8, 0), 2), (1, 1), (3, 9))
    >>> float(top.round(6)), float(bottom.round(6))
    (1.732051, -1.732051)

    A box may have no width; then it is a line.

    >>> bottom, top = meet_box(Rod((0, 0, 1), (0, 0, 5), 2), (1, 0), (1, 0))
    >>> float(bottom), float(top)
    (1.0, 5.0)
    """
    low, high = np.broadcast_arrays(low, high)
    if not np.all(low <= high):
        raise ValueError("low: must not be above high on either axis; got a corner that is.")
    # The lines through the corners of the section come first.
    x = np.stack([low[..., 0], high[..., 0]])[[0, 1, 1, 0]]
    y = np.stack([low[..., 1], high[..., 1]])[[0, 0, 1, 1]]
    bottom, top = rod.meet_line(np.stack([x, y, np.zeros_like(x)], axis=-1), UP)
    # Everything else is counted from the rod's start, from where places have the most digits.
    low, high = low - rod.a[:2], high - rod.a[:2]
    reach = np.maximum(np.abs(low), np.abs(high)).max(axis=-1)
    guard = GUARD * (rod.radius + rod.length + reach)
    _, ends = rod.hull
    points = [way[:, 0] for way in outermost(ends, UP[:, None])]  # the rod's own highest and lowest
    for along, across in ((0, 1), (1, 0)):
        for side in (low, high):
            points += _in_plane(rod, along, across, side[..., across], guard)
    bottom, top = bottom.min(axis=0), top.max(axis=0)
    for x, y, z in points:
        # A place that doesn't exist is NaN, which is over nothing.
        over = (low[..., 0] - guard <= x) & (x <= high[..., 0] + guard)
        over = over & (low[..., 1] - guard <= y) & (y <= high[..., 1] + guard)
        bottom = np.where(over, np.fmin(bottom, rod.a[2] + z), bottom)
        top = np.where(over, np.fmax(top, rod.a[2] + z), top)
    return bottom[()], top[()]


def _in_plane(rod, along, across, at, guard):
    """Yield points of a rod, counted from its start, that may be its outermost in upright planes.

    Parameters
    ----------
    rod : Rod
        The rod.
    along, across : {0, 1}
        The axis, x or y, that runs in the planes, and the one at right angles to them.
    at : (...) float
        The planes' places on the latter, in m, counted from the rod's start.
    guard : (...) float
        How far rounding may move a place, in m.

    Yields
    ------
    x, y, z : (...) float
        Counted from the rod's start, in m; NaN where a plane has no such point.
    """
    v, r = rod.axis, rod.radius
    length = rod.length
    if rod.ends == "round":
        # The plane cuts the ball at an end in a circle, whose top and bottom may be outermost.
        for centre in (np.zeros(3), v):
            away, half = _chord(at - centre[across], r, 1.0, guard)
            for height in (half, -half):
                beside = centre[across] + away
                yield _place(along, across, centre[along], beside, centre[2] + height)
    if length == 0:
        return
    w = v / length
    # Where the rod is highest in a plane, its normal has no part along the side. On the wall such
    # places are two rulings, +-r `aside`, in (across, z), from the rod's axis. The plane cuts each.
    # In a rod that runs along the side every ruling is such a place, and the rod's ends tell. The
    # points below are then those of its axis, which are points of the rod and so never too high.
    run = np.hypot(w[across], w[2])
    aside = (w[2], -w[across]) / run if run else np.zeros(2)
    for radial in (r * aside, -r * aside):
        first, last = radial[0] - at, radial[0] + v[across] - at
        # The ruling must come within the guard of the plane. If it lies in it all along, any of its
        # points will do: the ends and the corners' lines tell the rest.
        met = (np.minimum(first, last) <= guard) & (np.maximum(first, last) >= -guard)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(first == last, 0.0, np.clip(first / (first - last), 0, 1))
        share = np.where(met, share, np.nan)
        yield _place(
            along, across, share * v[along], radial[0] + share * v[across], radial[1] + share * v[2]
        )
    if rod.ends == "flat":
        # The plane cuts a disc along a chord, whose ends may be outermost. Where the disc lies in
        # the plane, any chord will do: the disc's own top and the corners' lines tell the rest. The
        # chord runs in the direction (x, z), along the side and up, at right angles to the rod's
        # axis; its middle lies in the disc, `away` from the centre.
        sine = np.hypot(w[along], w[2])
        x, z = (-w[2] / sine, w[along] / sine) if sine else (0.0, 1.0)
        for centre in (np.zeros(3), v):
            away, half = _chord(at - centre[across], r, sine, guard)
            for reach in (half, -half):
                yield _place(
                    along,
                    across,
                    centre[along] - away * (z * w[across]) + reach * x,
                    centre[across] + away * sine,
                    centre[2] + away * (x * w[across]) + reach * z,
                )


def _chord(away, radius, sine, guard):
    """Return how far a circle's chord, cut by a plane, is from the centre, and half its length.

    The plane is `away` from the centre, in m, and is at an angle with this sine to the circle's own
    plane. Where it passes beside the circle by more than the guard, half the length is NaN; within
    the guard the chord is moved onto the circle.
    """
    met = np.abs(away) <= sine * radius + guard
    away = np.clip(away / (sine or 1.0), -radius, radius)
    # By this product nothing cancels near a touch, as it would in radius^2 - away^2.
    return away, np.where(met, np.sqrt((radius - away) * (radius + away)), np.nan)


def _place(along, across, first, second, z):
    """Return x, y and z of points from their places along and across a plane."""
    x, y = (first, second) if along == 0 else (second, first)
    return x, y, z
