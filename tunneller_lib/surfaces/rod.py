"""A finite cylinder with flat or round ends, and where lines meet it: Line and finite cylinder."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..arguments import Directions, Length0, Point, Points, Radii, checked, sizes
from ..kernels.elementwise import larger, ratio, smaller, square_root, where, within
from ..kernels.exact import norm
from ..kernels.vectors import differences, lengths, scalar_products, vector_products
from .blocks import meet_in_blocks
from .rod_interval import along_lines, flat_interval, frame, nearest_point, round_interval
from .solid import Solid, hull_of_ends

CLOSE = 1e-6  # of the rod: so near to a touch the careful way decides
RANGE = 1e20  # sizes up to this and down to its inverse: no product of four leaves the floats
MISSED = np.inf, -np.inf, True  # what the quick way says of one line beside a rod
FAR = 6.0  # sizes from the rod, up to which the quick way's roundings are within the promise
PAIRS = 8192  # rods and lines of `meet_rods` treated at once, so that they stay in the cache


@checked
def meet_rods(
    a: Points,
    b: Points,
    radius: Radii,
    point: Points,
    direction: Directions,
    *,
    ends: Literal["flat", "round"] = "flat",
):
    """Return where lines enter and leave rods, a rod for each line, as `Rod.meet_line` does.

    Parameters
    ----------
    a, b : (..., 3) float
        Ends of the axes, in m.
    radius : (...) float
        In m, zero or above.
    point, direction : (..., 3) float
        One point of each line, in m, and its direction, not zero.
    ends : {"flat", "round"}
        Discs, or half balls about a and b.

    Returns
    -------
    enter, leave : (...) float
        In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

    Raises
    ------
    ValueError
        As by `Rod` and `Rod.meet_line`.

    Examples
    --------
    >>> enter, leave = meet_rods((0, 0, 0), (9, 0, 0), [1, 2, 3], (4, 2, 0), (0, 0, 1))
    >>> enter.round(3), leave.round(3)
    (array([   inf,  0.   , -2.236]), array([ -inf, 0.   , 2.236]))
    """
    sizes("b - a", np.abs(b - a).max(axis=-1))
    # Only the careful way takes a rod for each line.
    careful = _round_carefully if ends == "round" else _flat_carefully
    vectors = a, b, point, direction
    shape = np.broadcast_shapes(radius.shape, *(vector.shape[:-1] for vector in vectors))
    a, b, p, u = (np.broadcast_to(v, (*shape, 3)).reshape(-1, 3).T for v in vectors)
    radius = np.broadcast_to(radius, shape).ravel()
    found = np.empty((2, len(radius)))
    with np.errstate(all="ignore"):
        for first in range(0, len(radius), PAIRS):
            some = slice(first, first + PAIRS)
            rods = _Numbers(a[:, some], b[:, some], None, radius[some])
            found[:, some] = careful(rods, p[:, some], u[:, some])
    enter, leave = found.reshape(2, *shape)
    return enter[()], leave[()]


@dataclass(frozen=True)
@checked
class Rod(Solid):
    """A cylinder of finite length, or a capsule, its surface included.

    Parameters
    ----------
    a, b : (3,) float
        Ends of the axis, in m.
    radius : float
        In m, zero or above.
    ends : {"flat", "round"}
        Discs, or half balls about a and b, which make what a ball sweeps from a to b.

    Raises
    ------
    ValueError
        If an end isn't one finite point, the radius is negative, `ends` is another word, or the
        square of a number would over- or underflow: radius and length must be 0 or from 1e-100 to
        1e100, and no coordinate may be greater.

    Notes
    -----
    Line and finite cylinder. A flat rod without length is empty, and a round one is a ball. A rod
    of radius 0 is the segment.
    """

    a: Point
    b: Point
    radius: Length0
    ends: Literal["flat", "round"] = "flat"

    def __post_init__(self):
        sizes("b - a", np.abs(self.axis).max())

    @property
    def axis(self):
        """Return the vector (3,) from a to b, in m."""
        return np.subtract(self.b, self.a)

    @property
    def length(self):
        """Return the length of the axis, in m."""
        return float(norm(self.axis))

    @property
    def hull(self):
        """Return the discs or balls at the rod's ends, as `Solid` says."""
        both = self.radius, self.radius
        return hull_of_ends(self.a, self.b, *both, round_ends=self.ends == "round")

    @property
    def capsule(self):
        """Return the ends (3,) and the radius of the capsule about the rod, in m."""
        return np.array(self.a), np.array(self.b), self.radius

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the rod.

        Parameters
        ----------
        point : (..., 3) float
            One point of each line, in m.
        direction : (..., 3) float
            Direction of each line, of any length but zero; one (3,) for all will do.

        Returns
        -------
        enter, leave : (...) float
            The line is inside where ``enter <= t <= leave``, in lengths of the direction. A line
            that misses gets an empty interval, ``inf`` and ``-inf``.

        Raises
        ------
        ValueError
            If a direction is zero, a number isn't finite, or its square would over- or underflow.

        Notes
        -----
        Line and finite cylinder, "Treating the line as a point within a 2D shape", with the sign of
        its first miss condition corrected and the caps of the ellipses included. The answer is that
        of a rod whose surface is off by at most 64 eps (radius + run), where run is the length of
        the axis as the line sees it: a line that touches the rod is never missed. Along the line
        each end may be off by another 16 eps, of radius + length or of the ends' greater distance
        from the given point. All this holds while that point is at most 1e15 (radius + run) from
        either end of the axis, wherever the origin is; beyond, roundings of the way to the rod add
        to this. A rod that has no size for the line, a point or a segment along it, is met only if
        no rounding is in the way.

        Examples
        --------
        >>> enter, leave = Rod((0, 0, 0), (90, 0, 120), 25).meet_line((16, 15, 0), (0, 0, 1))
        >>> float(enter), round(float(leave), 3)
        (-12.0, 54.667)
        """
        shape = _Numbers(self.a, self.b, differences(self.b, self.a), self.radius)
        flat = self.ends == "flat"
        careful = _flat_carefully if flat else _round_carefully
        quick = _flat_quickly if flat else _round_quickly
        # The roundings of needles and wafers are too great for the quick way.
        least, most = sorted((lengths(shape.axis), shape.radius))
        plain = least > CLOSE * most and least > 1 / RANGE and most < RANGE
        return meet_in_blocks(careful, shape, point, direction, quick=quick, plain=plain)


class _Numbers(NamedTuple):
    """A rod in numbers: the ends of its axis, the vector from one to the other, and the radius."""

    start: tuple
    end: tuple
    axis: tuple | None
    radius: float


def _flat_carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a flat rod."""
    axis = frame(shape.start, shape.end, u)
    s, m, z, shift = nearest_point(axis, p, u)
    interval = flat_interval(axis.run, axis.rise, axis.length, shape.radius, s, m)
    return along_lines(axis, z, shift, *interval)


def _round_carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a capsule."""
    axis = frame(shape.start, shape.end, u)
    s, m, z, shift = nearest_point(axis, p, u)
    interval = round_interval(axis.run, axis.rise, axis.length, shape.radius, s, m)
    return along_lines(axis, z, shift, *interval)


class _Passing(NamedTuple):
    """How lines q + t u pass a rod's axis v; q is counted from the start of the axis, in m.

    Parameters
    ----------
    n : vectors
        The products u x v.
    nn, aside, uu, vv : (...) float
        The products n n, q n, u u and v v.
    size : (...) float
        q^2 u^2 v^2.
    beside : (...) bool
        Which lines pass beside the endless wall by more than rounding, and so surely miss.
    """

    n: tuple
    nn: np.ndarray
    aside: np.ndarray
    uu: np.ndarray
    vv: float
    size: np.ndarray
    beside: np.ndarray


def _passing(shape, q, u):
    """Return the `_Passing` of lines by a rod's axis: `q` and `u` are those of the quick way."""
    n = vector_products(u, shape.axis)
    nn, aside = scalar_products(n, n), scalar_products(q, n)
    uu, vv = scalar_products(u, u), scalar_products(shape.axis, shape.axis)
    size = scalar_products(q, q) * (uu * vv)
    # The second term bounds the square of the error that six roundings make in q n.
    wide = (1 + 10 * CLOSE) * shape.radius * shape.radius * nn + 1e-23 * size
    return _Passing(n, nn, aside, uu, vv, size, aside * aside > wide)


class _Nearest(NamedTuple):
    """Where lines are nearest to a rod's axis v.

    Parameters
    ----------
    qv, uv : (...) float
        The products q v and u v.
    middle : (...) float
        The line's parameter there.
    room : (...) float
        Radius^2 less the squared distance, times n n.
    half : (...) float
        The parameter from the middle to the endless wall.
    sound : (...) bool
        Which lines the quick way may take: their given point is near, and they are no tangents.
    """

    qv: np.ndarray
    uv: np.ndarray
    middle: np.ndarray
    room: np.ndarray
    half: np.ndarray
    sound: np.ndarray


def _nearest(shape, q, u, passing):
    """Return the `_Nearest` of lines to the axis of a rod, by how they are `passing` it."""
    v = shape.axis
    radius = shape.radius
    n, nn, aside, uu, vv, size, _ = passing
    qv, uv = scalar_products(q, v), scalar_products(u, v)
    middle = ratio(-scalar_products(vector_products(q, v), n), nn)
    room = radius * radius * nn - aside * aside
    half = ratio(square_root(room * vv), nn)
    # The given point must be near, the angle between line and axis not small; no square of a
    # direction may be out of range, and the line mustn't be a tangent.
    enough = size <= FAR * FAR * nn * (radius * radius + nn / uu)
    enough = enough & (uu < RANGE * RANGE) & (uu > 1 / RANGE / RANGE)
    sound = enough & (room > CLOSE * radius * radius * nn)
    return _Nearest(qv, uv, middle, room, half, sound)


def _unless_beside(beside, enter, leave, sure):
    """Return `enter`, `leave` and where they are `sure`; lines `beside` a rod surely miss."""
    hit = where(beside, False, enter <= leave)
    return where(hit, enter, np.inf), where(hit, leave, -np.inf), sure | beside


def _flat_quickly(shape, q, u):
    """Return `enter`, `leave` and where they are sure of lines against a flat rod."""
    passing = _passing(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = _nearest(shape, q, u, passing)
    # The planes of the discs: a line that is nearly level with them is left to the careful way.
    at_start, at_end = ratio(-lines.qv, lines.uv), ratio(passing.vv - lines.qv, lines.uv)
    first, last = smaller(at_start, at_end), larger(at_start, at_end)
    steep = lines.uv * lines.uv > CLOSE * CLOSE * passing.uu * passing.vv
    enter = larger(first, lines.middle - lines.half)
    leave = smaller(last, lines.middle + lines.half)
    # Where both ends nearly coincide the line passes close by a rim.
    clear = abs(leave - enter) > CLOSE * (lines.half + (last - first))
    return _unless_beside(passing.beside, enter, leave, steep & clear & lines.sound)


def _round_quickly(shape, q, u):
    """Return `enter`, `leave` and where they are sure of lines against a capsule."""
    passing = _passing(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = _nearest(shape, q, u, passing)
    enter, enters = _end_on_ball(passing, lines, shape.radius, -1.0)
    leave, leaves = _end_on_ball(passing, lines, shape.radius, 1.0)
    return _unless_beside(passing.beside, enter, leave, enters & leaves & lines.sound)


def _end_on_ball(passing, lines, radius, sign):
    """Return where lines enter (-1) or leave (1) a capsule, by the ball there, and if it's sure."""
    # The share of the axis, from its start, that is nearest to the line.
    share = (lines.qv + lines.uv * lines.middle) / passing.vv
    # The ball's centre is where the line meets the endless wall, or the end of the axis that this
    # place is beyond.
    step = lines.half * (lines.uv / passing.vv)
    beside = within(share + sign * step, 0.0, 1.0) - share
    # Radius^2 less the squared distance of that centre from the line.
    nn, uu = passing.nn, passing.uu
    room = ratio(lines.room - beside * beside * (nn * nn / uu), nn)
    end = lines.middle + beside * (lines.uv / uu) + sign * square_root(room / uu)
    return where(room > 0, end, -sign * np.inf), abs(room) > CLOSE * radius * radius
