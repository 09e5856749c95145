"""A truncated cone, and where lines meet it; Line and finite cylinder foresees this extension."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Directions, Length0, Point, Points, checked, sizes
from ..kernels.elementwise import larger, ratio, smaller, square_root, where, within
from .blocks import meet_in_blocks
from .rod_interval import GUARD, along_lines, flat_interval, frame, nearest_point
from .solid import Solid, hull_of_ends


@dataclass(frozen=True)
@checked
class Frustum(Solid):
    """A cone of revolution cut off at two discs, its surface included: a conical pick.

    Parameters
    ----------
    a, b : (3,) float
        Centres of the discs, in m; where they are the same the frustum is empty.
    radius_a, radius_b : float
        Of the discs, in m; one may be zero, which makes a whole cone.

    Raises
    ------
    ValueError
        If a centre isn't one finite point, a radius is negative, or a size is outside the range
        that `Rod` allows.
    """

    a: Point
    b: Point
    radius_a: Length0
    radius_b: Length0

    def __post_init__(self):
        sizes("b - a", np.abs(np.subtract(self.b, self.a)).max())

    @property
    def hull(self):
        """Return the discs at the frustum's ends, as `Solid` says."""
        return hull_of_ends(self.a, self.b, self.radius_a, self.radius_b)

    @property
    def capsule(self):
        """Return the ends (3,) and the radius of a capsule about the frustum, in m."""
        return np.array(self.a), np.array(self.b), max(self.radius_a, self.radius_b)

    @checked
    def meet_line(self, point: Points, direction: Directions):
        """Return where lines enter and leave the frustum.

        Parameters
        ----------
        point, direction : (..., 3) float
            One point of each line, in m, and its direction, of any length but zero.

        Returns
        -------
        enter, leave : (...) float
            In lengths of the direction; ``inf`` and ``-inf`` where the line misses.

        Notes
        -----
        The depth of a point inside the cone's wall is a concave function along the line. Its
        greatest value between the discs alone decides whether the line meets the frustum, so that
        there is no crack at a rim or at the tip; the roots only say where. The answer is that of a
        frustum whose surface is off by at most 64 eps (radius + run), with the radius of the wider
        disc and with run the length of the axis as the line sees it, for needles and wafers alike:
        a line that touches the frustum is never missed. `Rod.meet_line` says how exact the ends are
        along the line and from how far away this holds.

        Examples
        --------
        >>> enter, leave = Frustum((0, 0, 0), (0, 0, 2), 1, 0).meet_line((-5, 0, 1), (1, 0, 0))
        >>> float(enter), float(leave)
        (4.5, 5.5)

        A line has a direction:

        >>> Frustum((0, 0, 0), (0, 0, 2), 1, 0).meet_line((-5, 0, 1), (0, 0, 0))
        Traceback (most recent call last):
        ValueError: direction: must not be zero; got (0, 0, 0).
        """
        shape = _Numbers(self.a, self.b, self.radius_a, self.radius_b)
        return meet_in_blocks(_carefully, shape, point, direction)


class _Numbers(NamedTuple):
    """A frustum in numbers: the ends of its axis, and the radii there."""

    start: tuple
    end: tuple
    start_radius: float
    end_radius: float


def _carefully(shape, p, u):
    """Return `enter` and `leave` of lines against a frustum."""
    axis = frame(shape.start, shape.end, u)
    # The axis begins at the end that the line passes first.
    first = where(axis.turned, shape.end_radius, shape.start_radius)
    last = where(axis.turned, shape.start_radius, shape.end_radius)
    s, m, z, shift = nearest_point(axis, p, u)
    interval = frustum_interval(axis.run, axis.rise, axis.length, first, last, s, m)
    return along_lines(axis, z, shift, *interval)


def frustum_interval(run, rise, length, first_radius, last_radius, s, m):
    """Return where lines are inside frusta: in the rod of the wider disc, and in a cone's wall.

    Parameters
    ----------
    run, rise, length : (...) float
        Of the axes, in m, as in `Frame`.
    first_radius, last_radius : (...) float
        Of the discs at the starts of the axes, and at their other ends, in m.
    s, m : (...) float
        As of `flat_interval`.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the frustum.
    enter, leave : (...) float
        In m, as by `flat_interval`; meaningless where the line misses.

    Notes
    -----
    Let h = run/length and e = rise/length be the sine and the cosine between line and axis, gain
    the last radius less the first, slant^2 = length^2 + gain^2, c = length/slant, d = gain/slant.
    The point of a line at z is at the height tau = h m + e z over the first disc, and its distance
    from the axis is rho, with rho^2 = s^2 + sigma^2 and sigma = e m - h z.

    It is w - c rho deep inside the wall, in m at right angles to it, where w = c first_radius +
    d tau is c times the wall's own distance from the axis there. Along the line this depth is
    concave. If it has a maximum, this is where sigma/rho = -d e / (c h). The greatest depth within
    the rod tells whether the wall is met. From there the depth falls to zero where x y = (c s)^2
    with x, y = w -+ c sigma, both of which are linear along the line.
    """
    radius = larger(first_radius, last_radius)
    guard = GUARD * (radius + run)
    gain = last_radius - first_radius
    wall = (gain != 0) & (length > guard)  # else a rod, or a disc but for less than the guard
    h, e = ratio(run, length), ratio(rise, length)
    # The rod is made larger by the guard all round. Where a line is nearly level with a disc, or
    # nearly parallel to the axis, rounding moves the rod's ends far along it, away from a touch.
    more = where(wall, guard, 0.0)
    longer = where(wall, length + 2 * more, length)
    hit, enter, leave = flat_interval(
        run + 2 * h * more, rise + 2 * e * more, longer, radius + more, s, m + h * more
    )
    enter, leave = enter - e * more, leave - e * more
    slant = square_root(length * length + gain * gain)
    c, d = ratio(length, slant), ratio(gain, slant)
    up, steep = c * h + abs(d) * e, abs(d) * e - c * h
    # `up` and `steep` are the rates of x and y in `_to_the_wall`, towards the wide end. Where the
    # line is so nearly along a ruling, the wall counts as equally far all along it.
    steep = where(abs(steep) * (radius + length) <= guard, 0.0, steep)
    # The deepest point is where the depth has a maximum, or at the wide end if it only grows.
    turn = where(gain < 0, -1.0, 1.0)
    sigma = ratio(-d * e * abs(s), square_root(-up * steep))
    z = within(where(steep < 0, ratio(e * m - sigma, h), turn * np.inf), enter, leave)
    sigma = e * m - h * z
    w = c * first_radius + d * (h * m + e * z)
    rho = square_root(s * s + sigma * sigma)
    # One guard isn't enough: rounding was seen to leave a touching line 1.07 guards outside.
    hit = hit & (where(wall, w - c * rho, 0.0) >= -2 * guard)
    # The deepest point of a line that meets the wall must be inside it: the wall is moved outwards
    # as far as that takes. For a line along a ruling it is moved by the guard, or else rounding
    # would decide where such a line leaves by the tip.
    w = larger(w, c * rho + where(steep == 0, guard, 0.0))
    before, after = _to_the_wall(w, c * s, turn * c * sigma, up, steep)
    before, after = where(turn < 0, after, before), where(turn < 0, before, after)
    # The planes of the discs aren't moved. A line that is level with them stays between.
    level = rise * radius <= guard * length
    first = where(level, -np.inf, ratio(-run * m, rise))
    last = where(level, np.inf, rise + ratio(run * (run - m), rise))
    # The deepest point is part of the answer, on whichever side of an end rounding puts it.
    inner = smaller(z, larger(larger(enter, first), z - before))
    outer = larger(z, smaller(smaller(leave, last), z + after))
    return hit, where(wall, inner, enter), where(wall, outer, leave)


def _to_the_wall(w, aside, sigma, up, steep):
    """Return how far it is from a point inside a wall back to the wall, and on to it.

    On the line, which leads to the wide end, x = w - sigma grows at the rate `up`, above zero, and
    y = w + sigma at the rate `steep`, which is less. It meets the wall where x y is aside^2.
    """
    x, y = larger(w - sigma, 0.0), larger(w + sigma, 0.0)
    square = smaller(aside * aside, x * y)
    slope = ratio(steep, up)
    # x y = square is a quadratic equation along the line. Each root comes by whichever of x and y
    # is small there, in sums, where nothing cancels.
    half = (y - slope * x) / 2
    both = square_root(larger(half * half + slope * square, 0.0))
    small = where(half >= 0, ratio(square, half + both), ratio(both - half, slope))
    small = where((half >= 0) & (square == 0), 0.0, small)
    before = larger(ratio(x - small, up), 0.0)
    # A line at least as steep as the wall doesn't meet it again.
    return before, where(steep < 0, larger(ratio(y + slope * small, -steep), 0.0), np.inf)
