"""All cones of revolution in third-order contact with a surface (Envelopes, section 5).

At each point `cone_loops` finds the directions of the cones in the adapted frame. Here they become
cones in space, with a verdict on gouging.
"""

import math
from dataclasses import dataclass
from operator import index
from typing import Literal

import numpy as np

from ..arguments import HalfAngle, Reals, checked
from ..kernels import compiled
from ..kernels.elementwise import NUMBERS
from . import cone_loops
from .adapted import FLAT, MOST
from .cone_pose import ConePose, TouchingCone
from .functions import Function, as_jet, coordinates, one_number
from .graph_forms import NOISE
from .jet import jet_variables

BLOCK = 1000  # points at a time, whose jets fit the cache
FEW = 12  # points, up to which plain Python is faster than numpy
# s that compiled loops save a point, of many points and of few, divided by five: these loops take
# five times as long to compile as others.
EACH_OF_MANY, EACH_OF_FEW = 4e-6, 6e-5
_CONTAINED = 1e-9  # relative residual of order 4 below which the contact is of that order


@dataclass(frozen=True, eq=False)
class Cones:
    """Cones in third-order contact with a surface: arrays with a row a cone, and their sequence.

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
        In design space for both models, a row a cone.

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
    flat_s = s.ravel()
    flat_t = t.ravel()
    compiled.expect(s.size * (EACH_OF_FEW if s.size <= FEW else EACH_OF_MANY), "cones")
    rho = 0.5 / math.tan(half_angle)
    parts = []
    for first in range(0, max(s.size, 1), BLOCK):
        block = slice(first, first + BLOCK)
        found = _found(surface, flat_s[block], flat_t[block], rho, model)
        parts.append(_fields(half_angle, rho, model, first, *found))
    *rows, count, state = (
        parts[0] if len(parts) == 1 else map(np.concatenate, zip(*parts, strict=True))
    )
    return Cones(half_angle, *rows, count.reshape(s.shape), state.reshape(s.shape))


def _found(surface, s, t, rho, model):
    """Return what is known of points (n,), and of up to six cones at each.

    Returns
    -------
    defined : (n,) bool
        Whether the surface's derivatives are numbers.
    shapes : (n, 26) float
        As of `cone_loops.shape_in_space`.
    cones : (n, 6, 5) float
        As of `cone_loops.cones_of`.
    """
    variables = jet_variables(s, t)
    few = s.size <= FEW
    ready = compiled.ready("cones")
    with np.errstate(all="ignore"):
        answer = surface(*variables)
        if model == "space":
            three = coordinates("surface", answer, variables[0])
            given = [as_jet(one, variables[0]).c for one in three]
            formula, loop = cone_loops.shape_in_space, cone_loops.fill_space
        else:
            given = [s, t, as_jet(one_number("surface", answer, variables[0]), variables[0]).c]
            formula, loop = cone_loops.shape_in_the_model, cone_loops.fill_model
        finite = [np.isfinite(one) if one.ndim == 1 else np.isfinite(one).all(0) for one in given]
        defined = np.all(finite, axis=0)
        if few:
            shapes = np.empty((s.size, cone_loops.SHAPE))
            rows = [np.array(one.T, order="C") for one in given]
            compiled.call_plain(loop, *rows, shapes, **NUMBERS)
        else:
            shapes = np.stack(np.broadcast_arrays(*formula(*given)), axis=-1)
        if not few and not ready:
            cones = cone_loops.cones_of(shapes.T, rho)
            return defined, shapes, np.stack([np.stack(one, axis=-1) for one in cones], axis=1)
    cones = np.empty((s.size, 6, 5))
    call = compiled.call if ready else compiled.call_plain
    call(cone_loops.fill_cones, shapes, rho, cones, **NUMBERS)
    return defined, shapes, cones


def _fields(half_angle, rho, model, first, defined, shapes, cones):
    """Return the fields of `Cones` but the angle, by what `_found` knows of points from `first`."""
    contact, tangent, other, normal, rest = np.split(shapes, (3, 6, 9, 12), axis=1)
    known, curvature = rest.T[:2]
    # In space a ratio of 0 is a curvature 0: planes that stand still, no graph in the model. The
    # planes of a graph always turn: there it is points of contact that stand still, K infinite.
    flat = curvature <= FLAT
    state = np.where(flat, "flat" if model == "space" else "singular", "regular").astype("<U11")
    # What is too great for products of three derivatives counts as not defined, too. A point that
    # isn't smooth has no curvature to speak of, so this verdict goes before.
    smooth = defined & (known > NOISE) & np.isfinite(contact).all(axis=1)
    state[~(smooth & (flat | (np.abs(rest[:, 2:]).max(axis=1) <= MOST)))] = "outside"
    e_c, e_s, multiplicity, fee, order4 = np.moveaxis(cones, -1, 0)
    regular = state == "regular"
    there = (multiplicity > 0) & regular[:, None]
    count = there.sum(axis=-1)
    # The cubic's mean over the circle is 0, so it has zeros: none means that it is 0 itself.
    state[regular & (count == 0)] = "spherical"
    # From here on a row is a cone: `point` is its point's number, `row` its place among the six
    # there.
    point, row = np.nonzero(there)
    c, s = e_c[point, row], e_s[point, row]
    by_angle = np.lexsort((np.arctan2(s, c), point))
    point, row, c, s = point[by_angle], row[by_angle], c[by_angle, None], s[by_angle, None]
    fee, order4 = fee[point, row], order4[point, row]
    f2 = rest.T[2:5, point]
    # The vertex is off by rho f_ee: nearer than rounding puts it, it is the contact itself.
    near = np.abs(fee) <= 1e-12 * cone_loops.norm2(f2)
    side = np.where(near, 0, np.sign(fee)).astype(int)
    normal = normal[point]
    contact = contact[point]
    w = c * other[point] - s * tangent[point]  # e turned by a right angle: the ruling's line
    vertex = contact - (rho * fee)[:, None] * w
    # This axis belongs to a cone on the normal's side, with the vertex behind along w; on the other
    # side both turn. A vertex in the contact has no side: it keeps the first.
    lean = math.cos(half_angle) * w + math.sin(half_angle) * normal
    axis = np.where(side < 0, -1, 1)[:, None] * lean
    # K > 0: along w, where the cone is straight, the surface bends to the cone's side, and enters.
    # K < 0: along w it bends away; across, in the direction conjugate to w, both agree to order 3,
    # and order 4 tells whether it enters there.
    K = 4 * f2[0] * f2[2] - f2[1] * f2[1]  # its sign is that of the Gaussian curvature
    gouges = (K >= 0) | (side * order4 < -_CONTAINED) | (side == 0)
    undecided = ~gouges & (np.abs(order4) <= _CONTAINED)
    return (
        first + point,
        contact,
        normal,
        vertex,
        axis,
        side,
        np.abs(rho * fee),
        order4,
        gouges,
        undecided,
        multiplicity[point, row].astype(int),
        count,
        state,
    )
