"""Chains of positions along which a conical mill goes, across its characteristic."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Length, Length0, Whole, checked
from ..envelopes import hyperosculating_cones
from ..envelopes.functions import as_jet
from ..envelopes.jet import jet_variables
from ..kernels.exact import dot, norm
from .faces import Patch
from .positions import Cloud, Positions, depths_of
from .tools import ConicalMill

MOST_TURN = np.cos(np.radians(15))  # cosine of the greatest turn of the axis in one step
BETWEEN = 4  # places from one position to the next at which gouging is looked for


@dataclass(frozen=True, eq=False)
class Chain:
    """Positions one after the other: arrays with a row a position.

    Parameters
    ----------
    s, t : (k,) float
        Parameters of the contact.
    contact, normal : (k, 3) float
        Where the mill touches, in m, and the unit normal that points to its side.
    tip, axis : (k, 3) float
        The middle of the mill's lower end, in m, and the unit vector from there to the spindle.
    across : (k, 3) float
        Unit tangent of the characteristic at the contact, which the chain crosses at a right
        angle.
    """

    s: np.ndarray
    t: np.ndarray
    contact: np.ndarray
    normal: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    across: np.ndarray

    def __len__(self):
        return len(self.tip)


@checked
def trace_chain(
    patch: Patch,
    mill: ConicalMill,
    found: Positions,
    row: Whole(0, 10**7),
    *,
    step: Length,
    tolerance: Length0,
    others: Cloud | None = None,
    most: Whole(2, 1000) = 100,
    n: Whole(2, 500) = 121,
):
    """Return the chain of positions through one that was found.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    found : Positions
        Of this mill on this patch.
    row : int
        Which of them, from which the chain goes both ways.
    step : float
        From contact to contact, in m.
    tolerance, others
        As for `find_positions`: where a position doesn't fit the chain ends.
    most : int
        Positions to either side of the start.
    n : int
        As for `find_positions`.

    Returns
    -------
    chain : Chain
        Of the positions that fit, the start among them.

    Raises
    ------
    ValueError
        If there is no such row, or it is no position of this mill on this patch.

    Notes
    -----
    The characteristic of a moving cone that agrees with the surface to second order is conjugate to
    the ruling through the contact. Going at a right angle to it gives the widest strip (Envelopes,
    section 4). Steps are made by the midpoint rule; at each point the cone is taken whose axis
    turns least, by 15 degrees at most.

    Examples
    --------
    >>> from tunneller_lib.milling import find_positions
    >>> patch = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
    >>> mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    >>> found = find_positions(patch, mill, 0.005, 0.002, tolerance=1e-4)
    >>> row = int(np.flatnonzero(found.fits)[0])
    >>> len(trace_chain(patch, mill, found, row, step=1e-3, tolerance=1e-4))
    20
    """
    if row >= len(found):
        raise ValueError(f"row: must be below {len(found)}, the positions found; got {row}.")
    start = found.s[row], found.t[row], found.axis[row]
    back = _trace(patch, mill, *start, -step, most)
    forth = _trace(patch, mill, *start, step, most)
    if not forth:
        raise ValueError("found: must be positions of this mill on this patch; got others.")
    parts = [np.array(column) for column in zip(*back[:0:-1], *forth, strict=True)]
    return _fitting(patch, mill, parts, len(back) - 1, tolerance, others, n)


def _fitting(patch, mill, parts, start, tolerance, others, n):
    """Return the `Chain` of positions that fit without a gap about the start.

    `parts` are the fields of a `Chain`; the other arguments are those of `trace_chain`.
    """

    def gouges(tip, axis):
        own, holder, other = depths_of(patch, mill, tip, axis, others, n)
        return np.flatnonzero((own > tolerance) | (holder > 0) | (other > 0))

    tip, axis = parts[4:6]
    wrong = gouges(tip, axis)
    first = int(wrong[wrong < start].max(initial=-1)) + 1
    last = int(wrong[wrong > start].min(initial=len(tip)))
    # Where the axis turns fast, as near two cones that fall together, the way between two positions
    # that fit may gouge. To cut those off changes the smooth way through the rest, which is then
    # tried anew.
    while last - first >= 4:
        count = last - first - 1
        places = np.linspace(0, count, BETWEEN * count + 1)
        way = motion_through(tip[first:last], axis[first:last])(places)
        wrong = first + places[gouges(*way)]
        if not len(wrong):
            break
        first = int(np.floor(wrong[wrong <= start].max(initial=first - 1))) + 1
        last = int(np.ceil(wrong[wrong > start].min(initial=last)))
    return Chain(*(part[first:last] for part in parts))


def motion_through(tip, axis):
    """Return the smooth motion through four positions or more, tip and axis (k, 3), as a function.

    Its argument (m,) counts positions from 0 to k - 1, in fractions between them; it returns tips
    and unit axes (m, 3). Both are cubic splines. Between two positions their parameter grows by
    the way of the tip and the turn of the axis, which counts as a mean way of the tip a radian.
    """
    from scipy.interpolate import CubicSpline

    if len(tip) < 4:
        raise ValueError(f"chain: must have 4 positions or more; got {len(tip)}.")
    chord = norm(np.diff(tip, axis=0))
    length = chord + chord.mean() * norm(np.diff(axis, axis=0))
    knots = np.append(0.0, np.cumsum(length))
    if not np.all(np.diff(knots) > 0):
        raise ValueError("chain: each position must differ from the next; got equal ones.")
    index = np.arange(len(tip))
    both = CubicSpline(knots, np.hstack([tip, axis]))

    def motion(where):
        tips, axes = np.hsplit(both(np.interp(where, index, knots)), 2)
        return tips, axes / norm(axes)[:, None]

    return motion


def _trace(patch, mill, s, t, axis, step, most):
    """Return the rows of a `Chain` from a start on; a negative step goes backwards."""
    rows = []
    heading = None
    while _within(patch, s, t) and len(rows) <= most:
        here = _taken(patch, mill, s, t, axis, heading, step)
        if here is None:
            break
        row, rate, axis, heading = here
        rows.append(row)
        # Midpoint rule: half a step in the direction of the start; there the direction of the
        # whole step is found.
        middle = s + rate[0] / 2, t + rate[1] / 2
        between = _within(patch, *middle) and _taken(patch, mill, *middle, axis, heading, step)
        if not between:
            break
        _, rate, axis, heading = between
        s, t = s + rate[0], t + rate[1]
    return rows


def _taken(patch, mill, s, t, axis, heading, step):
    """Return the position at a point with the axis nearest to the one before, or None.

    These are a row of a `Chain`, the steps of s and t, the axis and the heading.
    """
    cones = hyperosculating_cones(patch.surface, s, t, half_angle=mill.half_angle, model="space")
    near, far = mill.rulings
    usable = (cones.side == patch.side) & (cones.distance >= near) & (cones.distance <= far)
    turn = np.where(usable, dot(cones.axis, axis), -1.0)
    if turn.max(initial=-1.0) < MOST_TURN:
        return None
    k = int(turn.argmax())
    contact = cones.contact[k]
    axis = cones.axis[k]
    normal = patch.side * cones.normal[k]
    way, inverse = conjugate_frame(patch, s, t, (contact - cones.vertex[k]) / cones.distance[k])
    across = np.cross(normal, way)
    # The first heading's sign is free; afterwards it is that of the step before.
    if (step if heading is None else dot(way, heading)) < 0:
        way = -way
    tip = cones.vertex[k] + mill.below * axis
    return (s, t, contact, normal, tip, axis, across), abs(step) * inverse @ way, axis, way


def conjugate_frame(patch, s, t, ruling):
    """Return the direction across the characteristic, and a matrix from tangents to parameters.

    Parameters
    ----------
    patch : Patch
        The surface.
    s, t : float
        A point.
    ruling : (3,) float
        Unit tangent there, along the ruling of a cone.

    Returns
    -------
    way : (3,) float
        Unit tangent at a right angle to the direction that is conjugate to the ruling. The normal
        turns this way along the ruling.
    inverse : (2, 3) float
        By which a tangent vector, in m, is multiplied to give changes of s and t.
    """
    variables = jet_variables(s, t)
    taylor = np.stack([as_jet(c, variables[0]).c for c in patch.surface(*variables)], axis=-1)
    tangents = taylor[1:3]  # by s and by t
    normal = np.cross(*tangents)
    # The second fundamental form, times the normal's length, which the unit vector doesn't need.
    ss, st, tt = (dot(c, normal) for c in (2 * taylor[3], taylor[4], 2 * taylor[5]))
    inverse = np.linalg.pinv(tangents @ tangents.T) @ tangents
    way = -inverse.T @ (np.array([[ss, st], [st, tt]]) @ inverse @ ruling)
    return way / norm(way), inverse


def _within(patch, s, t):
    """Tell whether parameters are within a patch."""
    return patch.s[0] <= s <= patch.s[1] and patch.t[0] <= t <= patch.t[1]
