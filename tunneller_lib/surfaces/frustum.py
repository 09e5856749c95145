"""A truncated cone against lines, to which Line and finite cylinder expects to be extended."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Directions, Length0, Point, Points, checked, sizes
from ..exact import cross, dot, norm
from .rod_interval import GUARD, frame, nearest_point


@dataclass(frozen=True)
@checked
class Frustum:
    """A cone of revolution cut off at two discs, its surface included: a conical pick.

    Parameters
    ----------
    a, b : (3,) float
        Centres of the discs, in m; not the same.
    radius_a, radius_b : float
        Of the discs, in m; one may be zero, for a whole cone.

    Raises
    ------
    ValueError
        If a centre isn't one finite point, the centres coincide, a radius is negative, or a size
        is outside the range that `Rod` allows.
    """

    a: Point
    b: Point
    radius_a: Length0
    radius_b: Length0

    def __post_init__(self):
        if self.a == self.b:
            raise ValueError(f"b: must differ from a, or there is no axis; got {self.b}.")
        sizes("b - a", np.abs(np.subtract(self.b, self.a)).max())

    @checked
    def contains(self, points: Points):
        """Return whether points (..., 3), in m, are inside or, within rounding, on the surface."""
        q = points - self.a
        v = np.subtract(self.b, self.a)
        length = float(norm(v))
        along = dot(q, v) / length
        off = norm(cross(q, np.broadcast_to(v, q.shape))) / length
        guard = GUARD * (self.radius_a + self.radius_b + length)
        wide = self.radius_a + (self.radius_b - self.radius_a) * along / length
        return (along >= -guard) & (along <= length + guard) & (off <= wide + guard)

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
        How far a point is inside the cone's wall is a concave function along the line. Its signs
        at the discs' planes and at its greatest tell the surfaces that are met, each decided
        once, so that there is no crack at a rim or at the apex; the roots only say where.

        Examples
        --------
        >>> enter, leave = Frustum((0, 0, 0), (0, 0, 2), 1, 0).meet_line((-5, 0, 1), (1, 0, 0))
        >>> float(enter), float(leave)
        (4.5, 5.5)
        """
        a, b = np.array(self.a), np.array(self.b)
        axis = frame(a, b, direction)
        turned = np.any(axis.start != a, axis=-1)
        r = np.where(turned, self.radius_b, self.radius_a)
        gain = np.where(turned, self.radius_a, self.radius_b) - r
        s, m, z, shift = nearest_point(axis, point, direction)
        hit, enter, leave = _interval(axis, r, gain, np.abs(s), m)
        enter = np.where(hit, shift + (enter - z) / axis.speed, np.inf)
        leave = np.where(hit, shift + (leave - z) / axis.speed, -np.inf)
        return enter[()], leave[()]


def _interval(axis, r, gain, s, m):
    """Return hits and intervals along lines at (m, s), of frusta of radii r and r + gain.

    A line's point z is at tau = h m + e z along the axis, and beside it at s and at
    sigma = e m - h z, with h and e the sine and cosine between line and axis.
    """
    run, rise, length = axis.run, axis.rise, axis.length
    guard = GUARD * (r + np.abs(gain) + run)
    h, e, g = run / length, rise / length, gain / length
    # A line across the axis, within rounding, meets neither disc: the slab between their planes
    # holds it all or misses it. Any bound beyond the frustum serves as its ends.
    level = rise * (r + np.abs(gain)) <= guard * length
    far = 4 * (r + np.abs(gain) + run)
    with np.errstate(all="ignore"):
        # The discs' planes: tau = 0 and tau = length.
        first = np.where(level, -far, -run * m / rise)
        last = np.where(level, far, rise + run * (run - m) / rise)
        slab = ~level | ((m >= -guard) & (m <= run + guard))
        k = g * e
        # The wall is where (r + g tau)^2 - s^2 - sigma^2 = -A z^2 + 2 B z + C vanishes; the
        # discriminant B^2 + A C is (h r + g m)^2 - A s^2, in which nothing is lost.
        A = (h - k) * (h + k)
        wide, aside = r + g * h * m, e * m
        B, C = wide * k + aside * h, (wide - s) * (wide + s) - aside**2
        root = np.sqrt(np.maximum((h * r + g * m) ** 2 - A * s * s, 0))
        # Of the two forms of each root the one whose sum doesn't cancel. A is negative where the
        # line is steeper than the wall, which it then meets once on this half of the cone.
        enter = np.where(B > 0, -C / (B + root), (B - root) / A)
        leave = np.where(B >= 0, (B + root) / A, C / (root - B))
        # Deepest inside the wall: where it's as steep as the line, or at an end.
        deepest = np.where(A > 0, (aside + k * s / np.sqrt(A)) / h, np.where(k > 0, last, first))
        deepest = np.clip(np.where(np.isnan(deepest), first, deepest), first, last)

    def depth(z):
        return r + g * (h * m + e * z) - np.hypot(s, e * m - h * z)

    # The depth is concave: it grows from the first plane to the deepest point and falls from there
    # to the last. Its signs at these three say which of disc and wall is met on either side.
    hit = slab & (depth(deepest) >= -guard)
    enter = np.clip(np.where(np.isnan(enter), first, enter), first, deepest)
    leave = np.clip(np.where(np.isnan(leave), last, leave), deepest, last)
    return hit, np.where(depth(first) >= 0, first, enter), np.where(depth(last) >= 0, last, leave)
