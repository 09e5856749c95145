"""A rod against a line grown to a box: what Line and finite cylinder announces as its part two."""

import numpy as np

from ..arguments import Corners, checked
from .rod import Rod
from .rod_interval import GUARD


@checked
def meet_box(rod: Rod, low: Corners, high: Corners):
    """Return the lowest and highest points of a rod in boxes that are endless along z.

    Parameters
    ----------
    rod : Rod
        With flat or round ends. For a box in another pose turn the rod instead.
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
    The rod is convex, so its highest point in the box is its own highest point, or the highest of
    its section by one side's plane, or on a corner's line. Each has a closed form: on a rim, on
    a ruling, on an end's ball. All candidates are points of the rod, so that the greatest of those
    in the box is the answer, with the rounding of `Rod.meet_line` and no search.

    Examples
    --------
    >>> bottom, top = meet_box(Rod((0, 0, 0), (0, 8, 0), 2), (1, 1), (3, 9))
    >>> float(top.round(6)), float(bottom.round(6))
    (1.732051, -1.732051)
    """
    low, high = np.broadcast_arrays(low, high)
    if not np.all(low <= high):
        raise ValueError("low: must not be above high on either axis; got a corner that is.")
    guard = GUARD * (rod.radius + rod.length)
    # On the corners' lines: where these meet the rod.
    lines = [_at(x[..., 0], y[..., 1]) for x in (low, high) for y in (low, high)]
    enter, leave = rod.meet_line(np.stack(lines), (0.0, 0.0, 1.0))
    bottom, top = enter.min(axis=0), leave.max(axis=0)
    if rod.length == 0 and rod.ends == "flat":
        return bottom, top
    # The rod's own lowest and highest points are on its ends, since a line along a straight wall
    # rises to one of them.
    ends = _ball_points if rod.ends == "round" else _rim_points
    points = ends(rod, None, None)
    # Of its section by a side's plane they are on an end again, or on a ruling that crosses it.
    for axis in (0, 1):
        for side in (low[..., axis], high[..., axis]):
            points += ends(rod, axis, side) + _ruling_points(rod, axis, side)
    # NaN marks a candidate that isn't there, and is inside no box.
    for point in points:
        inside = np.all((point[..., :2] >= low - guard) & (point[..., :2] <= high + guard), axis=-1)
        bottom = np.where(inside, np.minimum(bottom, point[..., 2]), bottom)
        top = np.where(inside, np.maximum(top, point[..., 2]), top)
    return bottom[()], top[()]


def _ball_points(rod, axis, side):
    """Return the lowest and highest points of the ends' balls, or of their cuts by a plane."""
    points = []
    for end in np.array([rod.a, rod.b]):
        centre, off = end, 0.0
        if axis is not None:
            off = side - end[axis]
            centre = end + off[..., None] * np.eye(3)[axis]
        room = (rod.radius - off) * (rod.radius + off)
        met = np.abs(off) <= rod.radius + GUARD * (rod.radius + rod.length)
        rise = np.where(met, np.sqrt(np.maximum(room, 0)), np.nan)
        points += [centre + sign * rise[..., None] * np.eye(3)[2] for sign in (1, -1)]
    return points


def _rim_points(rod, axis, side):
    """Return the lowest and highest points of the rims, or where they cross a plane."""
    # A rim is centre + r (cos level + sin steep): `level` is horizontal, and `steep` leads up the
    # disc. An upright axis has level rims, of which all points are as high.
    unit = rod.axis / rod.length
    run = np.hypot(*unit[:2])
    level = np.array([-unit[1], unit[0], 0.0]) / run if run > 0 else np.eye(3)[0]
    steep = np.cross(unit, level)
    points = []
    for end in np.array([rod.a, rod.b]):
        if axis is None:
            points += [end + sign * rod.radius * steep for sign in (1, -1)]
            continue
        # Where the rim's coordinate is the side's: level cos + steep sin = off, all shares of r.
        # The rim sways by `reach` along this axis; if it doesn't, it runs along the plane, and
        # its extremes are those above.
        reach = np.hypot(level[axis], steep[axis])
        if reach * rod.radius > GUARD * (rod.radius + rod.length):
            off = (side - end[axis]) / (rod.radius * reach)
            # A side that touches the rim within the guard touches it where it comes nearest.
            beyond = GUARD * (rod.radius + rod.length) / (rod.radius * reach)
            met = np.abs(off) <= 1 + beyond
            off = np.clip(off, -1, 1)
            root = np.where(met, np.sqrt((1 - off) * (1 + off)), np.nan)
            cos, sin = level[axis] / reach, steep[axis] / reach
            for sign in (1, -1):
                first, second = cos * off - sign * sin * root, sin * off + sign * cos * root
                turned = first[..., None] * level + second[..., None] * steep
                points.append(end + rod.radius * turned)
    return points


def _ruling_points(rod, axis, side):
    """Return where the wall's rulings that are lowest and highest at a plane cross it, or NaN."""
    v = rod.axis
    if v[axis] == 0:  # such a ruling runs along the plane, from rim to rim
        return []
    normal = np.zeros(3)
    normal[axis], normal[2] = -v[2], v[axis]
    offset = rod.radius * normal / np.hypot(v[axis], v[2])
    points = []
    for sign in (1, -1):
        start = np.array(rod.a) + sign * offset
        share = (side - start[axis]) / v[axis]
        beyond = GUARD * (rod.radius + rod.length) / np.abs(v[axis])
        met = (share >= -beyond) & (share <= 1 + beyond)
        share = np.where(met, np.clip(share, 0, 1), np.nan)
        points.append(start + share[..., None] * v)
    return points


def _at(x, y):
    return np.stack([x, y, np.zeros_like(x)], axis=-1)
