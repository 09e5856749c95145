"""All cones of revolution in third-order contact with a surface (Envelopes, section 5).

At each point their directions are the zeros of a trigonometric polynomial in the adapted frame.
Here they become cones in space, with a verdict on gouging.
"""

import math
from dataclasses import dataclass, replace
from operator import index
from typing import Literal

import numpy as np

from ..arguments import Angles, HalfAngle, Length, Reals, checked
from .adapted import FLAT, adapted_frames, isotropic_jet, sound
from .circle_roots import real_zeros
from .cone_pose import ConePose
from .functions import Function
from .isotropic import cone_planes
from .jet import Jet, derivative_along, frobenius, principal_values

BLOCK = 1000  # points at a time, whose jets fit the cache
_CONTAINED = 1e-9  # relative residual of order 4 below which the contact is of that order


@dataclass(frozen=True, eq=False)
class TouchingCone:
    """One cone in third-order contact with a surface, of those that `hyperosculating_cones` finds.

    Parameters
    ----------
    pose : ConePose
        The cone, from its vertex to twice the contact's distance from it.
    contact, normal : (3,) float
        Where it touches, in m, and the surface's unit normal there.
    side : {1, 0, -1}
        As of `Cones`.
    verdict : {"free", "gouges", "undecided"}
        Whether it keeps off the surface near the contact, as far as derivatives to order 4 tell.
    multiplicity : int
        How many cones fell together in this one.
    """

    pose: ConePose
    contact: np.ndarray
    normal: np.ndarray
    side: int
    verdict: str
    multiplicity: int

    @checked
    def planes(self, azimuth: Angles):
        """Return the cone's tangent planes, oriented as the surface is.

        Parameters
        ----------
        azimuth : (...) float
            In rad, about the axis or its opposite.

        Returns
        -------
        n : (..., 3) float
            Unit normals, that of the surface among them.
        h : (...) float
            Constant terms of n.x + h = 0, in m.
        """
        axis = (self.side or 1) * np.array(self.pose.axis)
        return cone_planes(self.pose.vertex, axis, self.pose.half_angle, azimuth)

    @checked
    def tool(self, towards: Length, away: Length):
        """Return the pose of a tool of that cone.

        Parameters
        ----------
        towards, away : float
            How far its rulings reach from the contact to the vertex, at most for four fifths of
            the way, and away from it, in m.

        Returns
        -------
        pose : ConePose
            The cone, cut to that length.
        """
        distance = self.pose.far / 2 if self.side else 0.0  # without a side the vertex touches
        return replace(self.pose, near=max(distance - towards, 0.2 * distance), far=distance + away)


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones in third-order contact with a surface: a sequence, and arrays with a row for each cone.

    ``len(cones)`` is their number and ``cones[k]`` a `TouchingCone`.

    Parameters
    ----------
    half_angle : float
        Of all of them, in rad.
    index : (k,) int
        Which of the points, counted through the flattened arrays.
    contact, normal : (k, 3) float
        Where the cone touches, in m, and the surface's oriented unit normal there.
    vertex, axis : (k, 3) float
        The vertex, in m, and the unit vector along the axis, from the vertex into the half of
        the cone that touches.
    side : (k,) int
        1 where the cone lies on the normal's side of the tangent plane, -1 on the other, 0 where
        the vertex is the contact itself.
    distance : (k,) float
        From vertex to contact, in m (Remark 21).
    order4 : (k,) float
        Residual of fourth-order contact (Eq. 12 in the adapted frame) over the sum of its terms,
        -1 to 1; 0 where the contact is of order 4.
    gouges : (k,) bool
        Whether the cone enters the surface in every neighbourhood of the contact; True where
        `side` is 0.
    undecided : (k,) bool
        Whether derivatives to order 4 can't tell: `order4` vanishes, as it does for the generators
        of an envelope, which don't gouge. Other cones may, by orders 5 and 6. `gouges` is False
        there, and a cone is surely free where neither is True.
    multiplicity : (k,) int
        How many cones fell together in this one.
    count : (...) int
        Number of cones at each of the points, multiple ones once.
    state : (...) str
        What each point is: "regular"; "outside", where the surface isn't defined or smooth;
        "flat", where its Gaussian curvature is 0 (no isotropic model there), or "singular",
        where that is infinite; "spherical", where every direction has its cone. Only regular
        points have rows.
    """

    half_angle: float
    index: np.ndarray
    contact: np.ndarray
    normal: np.ndarray
    vertex: np.ndarray
    axis: np.ndarray
    side: np.ndarray
    distance: np.ndarray
    order4: np.ndarray
    gouges: np.ndarray
    undecided: np.ndarray
    multiplicity: np.ndarray
    count: np.ndarray
    state: np.ndarray

    def __len__(self):
        return len(self.vertex)

    def __getitem__(self, k):
        k = range(len(self))[index(k)]
        # A cone whose vertex is the contact has no distance of its own.
        far = 2 * float(self.distance[k]) or 1.0
        vertex, axis = (tuple(part[k].tolist()) for part in (self.vertex, self.axis))
        pose = ConePose(vertex, axis, self.half_angle, near=0.0, far=far)
        verdict = "gouges" if self.gouges[k] else "undecided" if self.undecided[k] else "free"
        touching = self.contact[k].copy(), self.normal[k].copy(), int(self.side[k])
        return TouchingCone(pose, *touching, verdict, int(self.multiplicity[k]))

    def __iter__(self):
        return (self[k] for k in range(len(self)))


@checked
def hyperosculating_cones(
    surface: Function(2),
    s: Reals,
    t: Reals,
    *,
    half_angle: HalfAngle,
    model: Literal["isotropic", "space"] = "isotropic",
):
    """Return all cones of a half-angle in third-order contact with a surface at points.

    Parameters
    ----------
    surface : callable
        A function of two variables, built from ordinary arithmetic and numpy's functions. What
        it raises itself passes through.
    s, t : (...) float
        Points, that is, values of these two variables.
    half_angle : float
        Angle between axis and rulings, in rad, between 0 and pi/2.
    model : {"isotropic", "space"}
        "isotropic": `surface` is f, in m, of the graph z = f(x, y) that stands for the surface's
        tangent planes; "space": it returns the surface's three coordinates, in m.

    Returns
    -------
    cones : Cones
        In design space for both models.

    Raises
    ------
    ValueError
        If the angle isn't between 0 and pi/2, a point isn't finite, or `surface` is no function
        of two variables or returns something else.

    Notes
    -----
    Envelopes of cones, Eqs 9 to 12 with (12) mended, in the adapted frame: with the ruling
    along w, e across it and rho = cot(half_angle)/2 the contact is of order 3 where
    rho f_eee + 3 f_ew = 0. This trigonometric cubic has mean 0, hence 2, 4 or 6 zeros with their
    multiplicities. The contact is one of tangent planes, and free of gouging where K < 0 and
    rho^2 f_eeee + 6 rho f_eew + 3 (f_ww - f_ee) has the sign of f_ee; with the other sign, or
    where K > 0, the cone gouges, and where that form vanishes it's undecided. The document says
    free always. The verdict is local: other parts of a cone may meet other parts of the surface.
    Towards points of curvature 0 the vertices lose digits, see `adapted.FLAT`.

    Examples
    --------
    >>> cones = hyperosculating_cones(lambda x, y: y**2 / (x**2 + y**2), 0.5, 0.3, half_angle=0.5)
    >>> len(cones.vertex), int(sum(cones.gouges)), int(sum(cones.undecided))
    (6, 4, 2)
    >>> cones[0].multiplicity
    1
    >>> [cone.verdict for cone in cones].count("undecided")
    2
    """
    s, t = np.broadcast_arrays(s, t)
    parts = []
    for first in range(0, max(s.size, 1), BLOCK):
        block = slice(first, first + BLOCK)
        found = _found(surface, s.ravel()[block], t.ravel()[block], half_angle, model)
        parts.append([first + found[0], *found[1:]])
    *rows, count, state = map(np.concatenate, zip(*parts, strict=True))
    return Cones(half_angle, *rows, count.reshape(s.shape), state.reshape(s.shape))


def _found(surface, s, t, half_angle, model):
    """Return the fields of `Cones` but the angle, of all cones at points s, t (n,)."""
    frames = adapted_frames(surface, s, t, model)
    # The ratio |K|/|II|^2 vanishes in two cases. On a surface in space K is 0: the tangent planes
    # stand still along some direction, so that they have no graph in the model. The planes of a
    # graph always turn: there the points of contact stand still, and K is infinite.
    flat = frames.curvature <= FLAT
    state = np.where(flat, "flat" if model == "space" else "singular", "regular").astype("<U11")
    # A point that isn't smooth has no meaningful curvature, so this verdict replaces the others.
    state[~frames.smooth] = "outside"
    point = np.flatnonzero(state == "regular")
    f = isotropic_jet(frames, point)
    # Derivatives too great for products of three count as not defined, too.
    regular = sound(f)
    state[point[~regular]] = "outside"
    point = point[regular]
    f = Jet(f.c[:, regular])

    # With the ruling along w and e across it, contact is of order 3 where rho f_eee + 3 f_ew = 0.
    # Here rho is the radius of the circle over which the cone's planes lie in the adapted frame.
    rho = 0.5 / math.tan(half_angle)
    two, three, four = (frobenius(f, k) for k in (2, 3, 4))

    def third_order(a):
        return rho * derivative_along(f, a, 3) + 3 * derivative_along(f, a, 1, 1)

    angle, multiplicity = real_zeros(third_order, 3, unit=rho * three + 3 * two)
    count = np.zeros(len(s), dtype=int)
    count[point] = np.count_nonzero(multiplicity, axis=-1)
    # The polynomial's mean over the circle is 0, so it has zeros; where none is found it vanishes.
    state[point[count[point] == 0]] = "spherical"
    fee = derivative_along(f, angle, 2)
    terms = [
        rho**2 * derivative_along(f, angle, 4),
        6 * rho * derivative_along(f, angle, 2, 1),
        3 * (derivative_along(f, angle, 0, 2) - fee),
    ]
    # All terms of Eq. 12 may vanish together. What rounding leaves is then compared with a
    # thousandth of the norms of the whole forms.
    floor = 1e-3 * (rho**2 * four + 6 * rho * three + 3 * two)[:, None]
    order4 = sum(terms) / np.maximum(sum(np.abs(term) for term in terms), floor)

    # From here on a row is a cone; `at` is its point's place among the regular ones.
    row = multiplicity > 0
    at, _ = np.nonzero(row)
    angle, multiplicity, fee, order4 = (c[row] for c in (angle, multiplicity, fee, order4))
    point = point[at]
    first, second, normal = np.moveaxis(frames.axes[point], 1, 0)
    contact = frames.contact[point]
    # The vertex is |rho f_ee| from the contact. Where f_ee is 0 within rounding the two are one.
    side = np.where(np.abs(fee) <= 1e-12 * two[at], 0, np.sign(fee)).astype(int)
    # The ruling's line: e turned by a right angle.
    w = np.cos(angle)[:, None] * second - np.sin(angle)[:, None] * first
    vertex = contact - (rho * fee)[:, None] * w
    # Where f_ee > 0 the cone is on the normal's side, and w points from the vertex to the contact:
    # `lean` is then the axis. On the other side both are reversed. A vertex in the contact has no
    # side: it keeps `lean`.
    lean = math.cos(half_angle) * w + math.sin(half_angle) * normal
    axis = np.where(side < 0, -1, 1)[:, None] * lean
    # Along w the cone is straight. If K > 0 the surface bends there to the cone's side, so that the
    # cone gouges. If K < 0 it bends away; but in the direction conjugate to w the two agree to
    # order 3, and order 4 tells whether the cone gouges there. K isn't 0 at a regular point.
    K = principal_values(f).prod(axis=-1)[at]  # of the sign of the Gaussian curvature
    gouges = (K >= 0) | (side * order4 < -_CONTAINED) | (side == 0)
    undecided = ~gouges & (np.abs(order4) <= _CONTAINED)
    distance = np.abs(rho * fee)
    cones = point, contact, normal, vertex, axis, side, distance
    return *cones, order4, gouges, undecided, multiplicity, count, state
