"""Sections of a tunnel: closed convex curves of arcs and lines, and the depth of points in them."""

from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Angle, Angles, Each, Finite, Lengths, NotNegative, checked

CLOSED = 1e-12  # of the perimeter: the largest gap between pieces that counts as none
SMOOTH = 1e-12  # rad: a greater turn between pieces is a corner
SNAP = 1e-6  # m, by which pieces may miss each other by default


@dataclass(frozen=True)
@checked
class Arc:
    """An arc, counter-clockwise in the plane of y (left) and z (up).

    Parameters
    ----------
    y, z : float
        Its centre, in m.
    radius : float
        In m; above zero in a section that closes.
    start, sweep : float
        Where it begins, and the angle over which it runs, in rad, from y to z.
    """

    y: Finite
    z: Finite
    radius: Finite
    start: Angle
    sweep: Angle

    @property
    def length(self):
        """Return the arc's length, in m."""
        return self.radius * self.sweep

    @property
    def headings(self):
        """Return the arc's directions at start and end, in rad from y to z."""
        return self.start + np.pi / 2, self.start + self.sweep + np.pi / 2

    @checked
    def locate(self, s: Lengths):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        angle = self.start + s / self.radius
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.array([self.y, self.z]) + self.radius * normal, normal

    @checked
    def depth(self, y: Lengths, z: Lengths, slack: NotNegative):
        """Return how deep points lie behind the arc, in m; inf outside of its sector.

        The sector is widened at both ends by `slack`, in m on the arc, so that at a blend no point
        falls between two pieces.
        """
        dy, dz = y - self.y, z - self.z
        # Counted from the arc's start, angles need one comparison, even where the arc passes pi.
        wider = 1e-12 + slack / self.radius
        turned = np.mod(np.arctan2(dz, dy) - self.start + wider, 2 * np.pi)
        return np.where(turned <= self.sweep + 2 * wider, self.radius - np.hypot(dy, dz), np.inf)

    @checked
    def inset(self, d: Finite):
        """Return the arc at a distance d, in m, on the inner side."""
        return replace(self, radius=self.radius - d)

    @property
    def swept(self):
        """Return twice the area between the arc and the origin, in m^2."""
        # Green's theorem: the integral of y dz - z dy along the arc.
        start, end = self.start, self.start + self.sweep
        moment = self.y * (np.sin(end) - np.sin(start)) - self.z * (np.cos(end) - np.cos(start))
        return self.radius * (self.radius * self.sweep + moment)


@dataclass(frozen=True)
@checked
class Line:
    """A straight piece in the plane of y (left) and z (up).

    Parameters
    ----------
    y, z : float
        Where it begins, in m.
    heading : float
        Its direction, in rad from y to z.
    length : float
        In m; above zero in a section that closes.
    """

    y: Finite
    z: Finite
    heading: Angle
    length: Finite

    @property
    def radius(self):
        """Return the line's radius of curvature, which is infinite."""
        return np.inf

    @property
    def headings(self):
        """Return the line's direction, at start and end, in rad from y to z."""
        return self.heading, self.heading

    @checked
    def locate(self, s: Lengths):
        """Return points and outward unit normals (..., 2) at lengths s (...) from the start."""
        along = np.array([np.cos(self.heading), np.sin(self.heading)])
        points = np.array([self.y, self.z]) + s[..., None] * along
        return points, np.broadcast_to([along[1], -along[0]], points.shape)

    @checked
    def depth(self, y: Lengths, z: Lengths, slack: NotNegative):
        """Return how deep points lie behind the line, in m; inf beyond its ends and `slack`."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        dy, dz = y - self.y, z - self.z
        along = cos * dy + sin * dz
        # Only in the strip across the line can it be the nearest piece.
        within = (-slack <= along) & (along <= self.length + slack)
        return np.where(within, cos * dz - sin * dy, np.inf)

    @checked
    def inset(self, d: Finite):
        """Return the line at a distance d, in m, on the inner side."""
        return replace(
            self, y=self.y - d * np.sin(self.heading), z=self.z + d * np.cos(self.heading)
        )

    @property
    def swept(self):
        """Return twice the area between the line and the origin, in m^2."""
        return self.length * (self.y * np.sin(self.heading) - self.z * np.cos(self.heading))


class Section:
    """A closed convex curve of arcs and lines in the plane (y, z), counter-clockwise.

    A shape derives from it and gives its pieces as `arcs`, as `Egg` does. Arc length s counts from
    the start of the first piece and repeats with the perimeter.
    """

    arcs: tuple
    slack: float = 0.0  # m, by which pieces may miss each other, see `closed_profile`

    @property
    def blends(self):
        """Return the arc lengths (n + 1,) at which the pieces begin, and the perimeter."""
        return np.concatenate([[0], np.cumsum([arc.length for arc in self.arcs])])

    @property
    def perimeter(self):
        """Return the length of the curve, in m."""
        return float(self.blends[-1])

    @property
    def area(self):
        """Return the area within the curve, in m^2, by Green's theorem on each piece."""
        return float(sum(arc.swept for arc in self.arcs) / 2)

    @property
    def box(self):
        """Return the least and the greatest (y, z), (2, 2), in m."""
        ends = [arc.locate(np.array([0.0, arc.length]))[0] for arc in self.arcs]
        for arc in self.arcs:
            if np.isfinite(arc.radius):
                quarters = np.arange(4) * np.pi / 2  # where an arc runs along y or z
                turned = np.mod(quarters - arc.start, 2 * np.pi)
                ends.append(arc.locate(arc.radius * turned[turned < arc.sweep])[0])
        points = np.concatenate(ends)
        return np.array([points.min(axis=0), points.max(axis=0)])

    @property
    def least_radius(self):
        """Return the radius of the tightest bend, in m: 0 where there is a corner."""
        corner = np.any(self._turns() > SMOOTH + self.slack / self.perimeter)
        return 0.0 if corner else float(min(arc.radius for arc in self.arcs))

    def _turns(self):
        """Return by how much the direction turns where each piece begins, in rad."""
        # Between -pi and pi: a turn to the right is negative.
        starts, ends = np.transpose([arc.headings for arc in self.arcs])
        return np.mod(starts - np.roll(ends, 1) + np.pi, 2 * np.pi) - np.pi

    @checked
    def point(self, s: Lengths):
        """Return the points (..., 2) = (y, z), in m, at arc lengths s (...), in m."""
        return self._locate(s)[0]

    @checked
    def normal(self, s: Lengths):
        """Return the outward unit normals (..., 2) = (y, z) at arc lengths s (...), in m."""
        return self._locate(s)[1]

    @checked
    def curvature(self, s: Lengths):
        """Return the curvatures (...), in 1/m, at arc lengths s (...), in m; 0 on lines.

        Examples
        --------
        >>> closed_profile([Arc(0.0, 0.0, 0.5, 0.0, 2 * np.pi)]).curvature([0.1, 1.0])
        array([2., 2.])
        """
        return 1 / np.array([arc.radius for arc in self.arcs])[self._place(s)[1]]

    def _place(self, s):
        """Return arc lengths (...) within one round, and the indices of the pieces there."""
        s = np.mod(s, self.perimeter)
        # A blend belongs to the piece that begins there.
        index = np.searchsorted(self.blends, s, side="right") - 1
        return s, np.clip(index, 0, len(self.arcs) - 1)

    def _locate(self, s):
        """Return points and outward unit normals (..., 2) at arc lengths s (...), in m."""
        s, index = self._place(s)
        blends = self.blends
        point, normal = np.empty((2, *s.shape, 2))
        for k, arc in enumerate(self.arcs):
            here = index == k
            point[here], normal[here] = arc.locate(s[here] - blends[k])
        return point, normal

    @checked
    def depth(self, y: Lengths, z: Lengths):
        """Return how far points lie inside the curve.

        Parameters
        ----------
        y, z : (...) float
            In m.

        Returns
        -------
        depth : (...) float
            Distance to the curve, in m: positive inside, negative in the ground.

        Notes
        -----
        The nearest point of a convex curve lies on a piece whose sector or strip holds the given
        point. Only outside of a corner there is no such piece, and the corner is nearest.
        """
        y, z = np.broadcast_arrays(y, z)
        arcs = self.arcs
        slack = 2 * CLOSED * self.perimeter  # more than any gap, lest a point fall into it
        slack += 2 * self.slack
        inside = np.min([arc.depth(y, z, slack) for arc in arcs], axis=0)
        if np.all(np.isfinite(inside)):
            return inside[()]
        # Outside of a corner, which is nearest.
        corners = [arc.locate(np.zeros(()))[0] for arc in arcs]
        corner = np.min([np.hypot(y - a, z - b) for a, b in corners], axis=0)
        return np.where(np.isfinite(inside), inside, -corner)[()]

    @checked
    def offset(self, d: Finite):
        """Return the `Profile` at a distance d, in m, inside the section; negative: outside.

        Raises
        ------
        ValueError
            If the section's tightest bend isn't wider than d, or it has a corner.
        """
        if self.least_radius == 0:
            raise ValueError("d: a section with a corner has no offset; got one, round it first.")
        if d >= self.least_radius:
            raise ValueError(
                f"d: must be below the section's least radius {self.least_radius:g} m; got {d:g} m."
            )
        # Where a blend turns a little, by up to slack / perimeter, its offset opens a gap.
        wider = self.slack * (1 + abs(d) / self.perimeter)
        return Profile(tuple(arc.inset(d) for arc in self.arcs), wider)

    @checked
    def ray(self, angle: Angles):
        """Return the distances (...), in m, from the origin to the curve at angles in rad from y.

        Raises
        ------
        ValueError
            If the origin isn't inside the section.
        """
        if not self.depth(0.0, 0.0) > 0:
            raise ValueError("section: must have the origin of its plane inside; it hasn't.")
        cos, sin = np.cos(angle), np.sin(angle)
        low, high = np.zeros(cos.shape), np.full(cos.shape, 2 * self.perimeter)
        pieces = Profile(self.arcs, self.slack)  # so that they are made once
        for _ in range(60):  # the depth in a convex section changes its sign once along a ray
            middle = (low + high) / 2
            inside = pieces.depth(middle * cos, middle * sin) > 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return low


@dataclass(frozen=True)
class Profile(Section):
    """A section given by its pieces, such as the offset of an egg.

    Parameters
    ----------
    arcs : tuple of Arc or Line
        In counter-clockwise order. Each begins where the last one ends, as `closed_profile` checks.
    slack : float
        By how much they may miss each other, in m.
    """

    arcs: tuple
    slack: float = 0.0


@checked
def closed_profile(pieces: Each(Arc, Line), *, snap: NotNegative = SNAP):
    """Return the section that some pieces make, after checking that they close.

    Parameters
    ----------
    pieces : list of Arc or Line
        In counter-clockwise order.
    snap : float, optional
        In m, at most a thousandth of the perimeter; by default 1e-6 m, which is 0.001 mm. Ends that
        are no farther apart count as one point, and turns up to snap / perimeter as none, for a
        drawing has only so many digits. The section is as exact as its pieces meet.

    Returns
    -------
    section : Profile
        The section.

    Raises
    ------
    ValueError
        If there is no piece; if one is empty or doesn't begin where the one before it ended, with
        the first one that does (whether the first piece meets the last one is checked at the end);
        if one begins with a turn to the right, with the one that turns most; if the pieces go round
        more or less than once; or if `snap` is too large.

    Examples
    --------
    >>> round(closed_profile([Arc(0.0, 0.0, 0.5, 0.0, 2 * np.pi)]).area, 4)
    0.7854
    """
    section = Profile(tuple(pieces))
    # Each piece is checked by itself.
    for k, piece in enumerate(section.arcs):
        if not piece.length > 0 or not piece.radius > 0:
            raise ValueError(
                "pieces: each needs a length and a radius above 0, counter-clockwise; "
                f"{k + 1} hasn't, of length {piece.length:g} m and radius {piece.radius:g} m."
            )
    if not section.arcs:
        raise ValueError("pieces: must be at least one; got none.")
    perimeter = section.perimeter
    if snap > perimeter / 1000:
        raise ValueError(
            "snap: must be at most a thousandth of the perimeter, "
            f"{perimeter / 1000:.3g} m; got {snap:g} m."
        )
    # Each must begin where the one before it ends. The first is checked last: a gap before it means
    # that the curve isn't closed, which has a message of its own.
    ends = np.array([arc.locate(np.array([0.0, arc.length]))[0] for arc in section.arcs])
    gaps = np.linalg.norm(ends[:, 0] - np.roll(ends[:, 1], 1, axis=0), axis=-1)
    for k in [*range(1, len(gaps)), 0]:
        if gaps[k] > CLOSED * perimeter + snap:
            what = "doesn't begin where the last one ended" if k else "isn't met: it isn't closed"
            raise ValueError(f"pieces: {k + 1} of {len(gaps)} {what}; the gap is {gaps[k]:.3g} m.")
    # With a corner to the left the section is still convex, with one to the right it isn't.
    turns = section._turns()
    smooth = SMOOTH + snap / perimeter
    if np.any(turns < -smooth):
        k = int(np.argmin(turns))
        raise ValueError(
            f"pieces: must never turn to the right; {k + 1} of {len(turns)} begins with "
            f"{np.degrees(-turns[k]):.3g} deg."
        )
    # Pieces and corners together turn by a whole number of full circles, for the direction comes
    # back to the first one. It must be one circle, or the curve crosses itself.
    round_once = sum(b - a for a, b in (arc.headings for arc in section.arcs)) + turns.sum()
    if abs(round_once - 2 * np.pi) > SMOOTH:
        raise ValueError(
            "pieces: must go round once, counter-clockwise; they turn by "
            f"{np.degrees(round_once):.4g} deg."
        )
    # The slack is what pieces miss each other by, in place and in direction. Pieces that meet and
    # blend to rounding need none.
    bend = np.max(np.abs(turns[np.abs(turns) <= smooth]), initial=0)
    if gaps.max() <= CLOSED * perimeter and bend <= SMOOTH:
        return section
    return Profile(section.arcs, float(gaps.max() + bend * perimeter))
