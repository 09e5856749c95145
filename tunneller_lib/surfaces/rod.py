"""A finite cylinder, flat or round at its ends, against lines: Line and finite cylinder."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..arguments import Directions, Length0, Lengths, Point, Points, checked, sizes
from ..elementwise import larger, ratio, smaller, square_root, where, within
from ..exact import cross, dot, norm
from .blocks import (
    CLOSE,
    MISSED,
    between_planes,
    meet_in_blocks,
    meet_one_by_one,
    nearest_to_axis,
    not_beside,
    past_an_axis,
    share_of_axis,
    well_shaped,
    with_those_beside,
)
from .rod_interval import GUARD, flat_interval, frame, nearest_point, round_interval
from .vectors import differences, lengths

BLOCK = 16384  # parallel lines treated at once, so that they stay in the cache


@checked
def meet_rods(
    a: Points,
    b: Points,
    radius: Lengths,
    point: Points,
    direction: Directions,
    *,
    ends: Literal["flat", "round"] = "flat",
):
    """Return where lines enter and leave rods, one rod a line: `Rod.meet_line` of many.

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
    check_rods(a, b, radius)
    careful = _meet_capsules if ends == "round" else _meet_flat
    return meet_one_by_one(careful, [a, b, point, direction], [radius])


def check_rods(a, b, radius):
    """Raise ValueError where a radius (...) is negative, or it or an axis has no sound square.

    `a` and `b` (..., 3) are the axes' ends, in m, as the radius.
    """
    if not np.all(radius >= 0):
        raise ValueError(f"radius: must not be below zero; got {np.min(radius):g} m.")
    sizes("radius", radius)
    sizes("b - a", np.abs(b - a).max(axis=-1))


def _meet_flat(a, b, p, u, radius):
    """Return `enter` and `leave` of lines against flat rods, vectors and numbers."""
    return _meet_seen(frame(a, b, u), p, u, radius)


def _meet_capsules(a, b, p, u, radius):
    """Return the same of capsules."""
    return _meet_seen_round(frame(a, b, u), p, u, radius)


def _meet_seen(axis, p, u, radius):
    """Return `enter` and `leave` of lines p along u, which see a flat rod's axis so."""
    s, m, z, shift = nearest_point(axis, p, u)
    interval = flat_interval(axis.run, axis.rise, axis.length, radius, s, m)
    return _along_lines(axis, z, shift, *interval)


def _meet_seen_round(axis, p, u, radius):
    """Return the same of capsules."""
    s, m, z, shift = nearest_point(axis, p, u)
    interval = round_interval(axis.run, axis.rise, axis.length, radius, s, m)
    return _along_lines(axis, z, shift, *interval)


def _along_lines(axis, z, shift, hit, enter, leave):
    """Return `enter` and `leave` as parameters of lines that see an axis so."""
    enter = where(hit, shift + (enter - z) / axis.speed, np.inf)
    return enter, where(hit, shift + (leave - z) / axis.speed, -np.inf)


@dataclass(frozen=True)
@checked
class Rod:
    """A cylinder of finite length, or a capsule, its surface included.

    Parameters
    ----------
    a, b : (3,) float
        Ends of the axis, in m.
    radius : float
        In m, zero or above.
    ends : {"flat", "round"}
        Discs, or half balls about a and b: the sweep of a ball from a to b.

    Raises
    ------
    ValueError
        If an end isn't one finite point, the radius is negative, `ends` is another word, or a
        number is too small or too great for its square: radius and length must be 0 or from 1e-100
        to 1e100, and no coordinate above that.

    Notes
    -----
    Line and finite cylinder. A flat rod without length is empty, a round one is a ball. With
    radius 0 it's the segment.
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

    @checked
    def contains(self, points: Points):
        """Return whether points (..., 3), in m, are inside or, within rounding, on the surface.

        Examples
        --------
        >>> Rod((0, 0, 0), (4, 0, 0), 1).contains([(4, 0, 1), (4.5, 0, 0)])
        array([ True, False])
        """
        q = points - self.a
        v = self.axis
        length = self.length
        if length == 0:
            return (norm(q) <= self.radius * (1 + GUARD)) & (self.ends == "round")
        guard = GUARD * (self.radius + length)
        along = dot(q, v) / length
        off = norm(cross(q, np.broadcast_to(v, q.shape))) / length
        beyond = np.maximum(np.maximum(-along, along - length), 0)
        if self.ends == "round":
            return np.hypot(beyond, off) <= self.radius + guard
        return (beyond <= guard) & (off <= self.radius + guard)

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the rod.

        Parameters
        ----------
        point : (..., 3) float
            One point of each line, in m.
        direction : (..., 3) float
            Direction of each line, of any length but zero. Many lines of one direction (3,) are
            first looked at in the plane across it, which is faster.

        Returns
        -------
        enter, leave : (...) float
            The line is inside where ``enter <= t <= leave``, in lengths of the direction; for a
            line that misses ``inf`` and ``-inf``, an empty interval.

        Raises
        ------
        ValueError
            If a direction is zero, or a number isn't finite or too great or small for its square.

        Notes
        -----
        Line and finite cylinder, "Treating the line as a point within a 2D shape", with the
        sign of its first miss condition corrected and the ellipses' caps included. The answer is
        that of a rod whose surface is off by at most 64 eps (radius + run), with run the length
        of the axis as the line sees it, however far away the given point or the origin is: a
        line that touches the rod is never missed.

        Examples
        --------
        >>> enter, leave = Rod((0, 0, 0), (90, 0, 120), 25).meet_line((16, 15, 0), (0, 0, 1))
        >>> float(enter), round(float(leave), 3)
        (-12.0, 54.667)
        """
        if direction.ndim > 1 or point.ndim == 1:
            return self._meet_any(point, direction)
        enter = np.empty(point.shape[:-1])
        leave = np.empty(point.shape[:-1])
        rows = point.reshape(-1, 3)
        firsts = enter.reshape(-1)
        lasts = leave.reshape(-1)
        u = direction.tolist()
        axis = frame(self.a, self.b, u)
        for start in range(0, len(rows), BLOCK):
            block = slice(start, start + BLOCK)
            self._meet_parallel(axis, rows[block], u, firsts[block], lasts[block])
        return enter, leave

    def _meet_any(self, point, direction):
        """Return `enter` and `leave` of lines of any directions (..., 3)."""
        shape = _Numbers(self.a, self.b, differences(self.b, self.a), self.radius)
        flat = self.ends == "flat"
        careful = _flat_carefully if flat else _round_carefully
        quick = _flat_quickly if flat else _round_quickly
        plain = well_shaped(lengths(shape.axis), shape.radius)
        return meet_in_blocks(quick, careful, shape, plain, point, direction)

    def _meet_parallel(self, axis, p, u, enter, leave):
        """Write `enter` and `leave` of lines p (n, 3) of one direction."""
        bound = max(-p.min(), p.max()) + max(map(abs, axis.start))
        r = self.radius
        run = axis.run
        rise = axis.rise
        # Off the coordinate axes the product with a far point isn't good enough to go on with.
        noise = GUARD * (bound if np.count_nonzero(u) > 1 else 0.0)
        reach = r + 2 * GUARD * (r + run) + noise
        # First one product a line: most pass beside the rod, |s| > reach, and need no more.
        s = _along(p, axis.start, axis.across)
        w = (r - s) * (r + s)
        close = w >= (r - reach) * (r + reach)
        # The short formulas serve flat rods that the lines see neither end-on (run) nor level
        # (rise), given by points that are near enough to be exact.
        plain = noise <= GUARD * (r + run) < min(run, rise * r / max(axis.length, r))
        if not plain or self.ends == "round":
            enter[:], leave[:] = np.inf, -np.inf
            near = np.flatnonzero(close)
            m = _along(p[near], axis.start, axis.flat)
            near = near[(m >= -reach) & (m <= run + reach)]
            enter[near], leave[near] = self._carefully(axis, p[near], u)
        elif 2 * np.count_nonzero(close) > len(p):  # to pick them out would cost too much
            self._meet_plainly(axis, p, s, w, u, (enter, leave))
        else:
            enter[:], leave[:] = np.inf, -np.inf
            near = np.flatnonzero(close)
            found = np.empty((2, len(near)))
            self._meet_plainly(axis, p[near], s[near], w[near], u, found)
            enter[near], leave[near] = found

    def _meet_plainly(self, axis, p, s, w, u, found):
        """Write to `found` where lines enter and leave that pass at s, with w = r^2 - s^2."""
        r = self.radius
        run = axis.run
        rise = axis.rise
        length = axis.length
        # `flat_interval` with the tests for special cases left out, in as few passes as can be.
        m = _along(p, axis.start, axis.flat)
        off = np.abs(m - run / 2)  # from the middle of the shadow, whose half length is k
        with np.errstate(invalid="ignore"):
            np.sqrt(w, out=w)  # not a number beside the rod, where no comparison holds
            k = w * (rise / length) + run / 2
        missed = ~(off <= k)
        w *= length / run
        disc = m * (-run / rise)
        middle = m * (rise / run)
        z = _along(p, axis.start, axis.along)
        apart = length**2 / rise  # the two discs' planes, along the lines
        first, last = np.maximum(disc, middle - w), np.minimum(disc + apart, middle + w)
        # Disc and wall ought to agree at a rim; where rounding parts them, and within the guard,
        # whose root is the most that it adds to k, the careful way decides.
        guard = 3 * GUARD * (r + run)  # the most that `reach` adds to r
        more = np.sqrt(guard * (2 * r + guard))
        edge = np.flatnonzero(missed)
        edge = edge[
            (np.abs(s[edge]) <= r + guard) & (off[edge] <= np.fmax(k[edge], run / 2) + more)
        ]
        edge = np.append(edge, np.flatnonzero(~missed & (last < first)))
        for t, end, none in zip(found, (first, last), (np.inf, -np.inf), strict=True):
            np.subtract(end, z, out=t)
            if axis.speed != 1:
                t /= axis.speed
            np.copyto(t, none, where=missed)
        if len(edge):
            found[0][edge], found[1][edge] = self._carefully(axis, p[edge], u)

    def _carefully(self, axis, p, u):
        """Return `enter` and `leave` of lines p (n, 3) of one direction."""
        meet = _meet_seen_round if self.ends == "round" else _meet_seen
        with np.errstate(all="ignore"):
            return meet(axis, p.T.copy(), u, self.radius)


class _Numbers(NamedTuple):
    """A rod in numbers: the ends of its axis, the vector from one to the other, the radius."""

    start: tuple
    end: tuple
    axis: tuple
    radius: float


def _flat_carefully(shape, p, u):
    return _meet_flat(shape.start, shape.end, p, u, shape.radius)


def _round_carefully(shape, p, u):
    return _meet_capsules(shape.start, shape.end, p, u, shape.radius)


def _flat_quickly(shape, q, u):
    passing = past_an_axis(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = nearest_to_axis(shape, not_beside(passing))
    return with_those_beside(passing.beside, *_inside_rod(lines))


def _round_quickly(shape, q, u):
    passing = past_an_axis(shape, q, u)
    if passing.beside is True:
        return MISSED
    lines = nearest_to_axis(shape, not_beside(passing))
    return with_those_beside(passing.beside, *_inside_capsule(lines, shape.radius))


def _inside_rod(lines):
    """Return where lines enter and leave a rod, and where that is sure."""
    first, last, steep = between_planes(lines)
    enter = larger(first, lines.middle - lines.half)
    leave = smaller(last, lines.middle + lines.half)
    clear = abs(leave - enter) > CLOSE * (lines.half + (last - first))
    return enter, leave, steep & clear & lines.sound


def _inside_capsule(lines, radius):
    """Return where lines enter and leave a capsule, by the balls on which they do."""
    enter, enters = _end_on_ball(lines, radius, -1.0)
    leave, leaves = _end_on_ball(lines, radius, 1.0)
    return enter, leave, enters & leaves & lines.sound


def _end_on_ball(lines, radius, sign):
    """Return where lines enter (-1) or leave (1) that ball of a capsule, and where it's sure."""
    share = share_of_axis(lines)
    step = lines.half * (lines.uv / lines.vv)
    beside = within(share + sign * step, 0.0, 1.0) - share
    room = lines.room - beside * beside * (lines.nn * lines.nn / lines.uu)
    room = ratio(room, lines.nn)
    end = lines.middle + beside * (lines.uv / lines.uu) + sign * square_root(room / lines.uu)
    clear = abs(room) > CLOSE * radius * radius
    return where(room > 0, end, -sign * np.inf), clear


def _along(p, start, unit):
    """Return the products of p - start with a unit vector, perhaps a view of p."""
    parts = []
    for i in np.flatnonzero(unit):
        part = p[:, i] - start[i] if start[i] else p[:, i]
        parts.append(part * unit[i] if unit[i] != 1 else part)
    return sum(parts[1:], parts[0]) if parts else np.zeros(len(p))
