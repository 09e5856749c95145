"""All cones of revolution in third-order contact with a surface (Envelopes, section 5)."""

from dataclasses import dataclass

import numpy as np

from ..arguments import finite
from .forms import along, circle_roots, size
from .frame import FLAT, finite_points, frames, isotropic_jet

BLOCK = 1000  # points at a time, whose jets fit the cache
_CONTAINED = 1e-9  # relative residual of order 4 below which the contact is of that order


@dataclass(frozen=True)
class Cones:
    """Cones in third-order contact with a surface, a row a cone; made by `hyperosculating_cones`.

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


def hyperosculating_cones(surface, s, t, *, half_angle, model="isotropic"):
    """Return all cones of a half-angle in third-order contact with a surface at points.

    Parameters
    ----------
    surface : callable
        A function of two variables, built from ordinary arithmetic and numpy's functions.
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
        If the angle is not between 0 and pi/2, or a point not finite, or `surface` wrong.

    Notes
    -----
    Envelopes of cones, Eqs 9 to 12 with (12) mended, in the adapted frame: with the ruling
    along w, e across it and rho = cot(half_angle)/2 the contact is of order 3 where
    rho f_eee + 3 f_ew = 0. This trigonometric cubic has mean 0, hence 2, 4 or 6 zeros with their
    multiplicities. The contact is one of tangent planes, and free of gouging where K < 0 and
    rho^2 f_eeee + 6 rho f_eew + 3 (f_ww - f_ee) has the sign of f_ee; with the other sign, or
    where K > 0, the cone gouges, and where that form vanishes it's undecided. The document says
    free always. The verdict is local: other parts of a cone may meet other parts of the surface.
    Towards points of curvature 0 the vertices lose digits, see `frame.FLAT`.

    Examples
    --------
    >>> cones = hyperosculating_cones(lambda x, y: y**2 / (x**2 + y**2), 0.5, 0.3, half_angle=0.5)
    >>> len(cones.vertex), int(sum(cones.gouges)), int(sum(cones.undecided))
    (6, 4, 2)
    """
    half_angle = finite("half_angle", half_angle)
    if not 0 < half_angle < np.pi / 2:
        raise ValueError("half_angle: must lie between 0 and pi/2, both left out; "
                         f"got {half_angle!r}.")  # fmt: skip
    s, t = finite_points(s, t)
    flat = s.ravel(), t.ravel()
    parts = [
        _of_block(surface, *(a[first : first + BLOCK] for a in flat), first, half_angle, model)
        for first in range(0, max(s.size, 1), BLOCK)
    ]
    *rows, count, state = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Cones(half_angle, *rows, count.reshape(s.shape), state.reshape(s.shape))


def _of_block(surface, s, t, first, half_angle, model):
    """Return the fields of `Cones` but the angle, for points counted from `first`."""
    found = frames(surface, s, t, model)
    flat = found.curvature <= FLAT
    state = np.where(flat, "flat" if model == "space" else "singular", "regular")
    state = np.where(found.smooth, state, "outside").astype("<U11")
    where = np.flatnonzero(state == "regular")
    f = isotropic_jet(found, where)
    rho = 0.5 / np.tan(half_angle)
    angle, multiplicity = third_order(f, rho)
    count = np.zeros(s.size, dtype=int)
    count[where] = np.isfinite(angle).sum(axis=-1)
    state[where[count[where] == 0]] = "spherical"  # a mean of 0 leaves no other way to none
    point, row = np.nonzero(np.isfinite(angle))
    fee, order4 = (values[point, row] for values in order_four(f, angle, rho))
    K = (f.derivative(2, 0) * f.derivative(0, 2) - f.derivative(1, 1) ** 2)[point]
    # A vertex nearer than rounding puts it is the contact.
    side = np.where(np.abs(fee) > 1e-12 * size(f, 2)[point], np.sign(fee), 0).astype(int)
    tangent, other, normal = np.moveaxis(found.axes[where[point]], 1, 0)
    e = angle[point, row, None]
    w = np.cos(e) * other - np.sin(e) * tangent
    contact = found.contact[where[point]]
    lean = np.cos(half_angle) * w + np.sin(half_angle) * normal
    gouges = (K >= 0) | (side * order4 < -_CONTAINED) | (side == 0)
    return (
        first + where[point],
        contact,
        normal,
        contact - (rho * fee)[:, None] * w,
        np.where(side < 0, -1, 1)[:, None] * lean,
        side,
        np.abs(rho * fee),
        order4,
        gouges,
        ~gouges & (np.abs(order4) <= _CONTAINED),
        multiplicity[point, row],
        count,
        state,
    )


def third_order(f, rho):
    """Return all directions of cones in contact of order 3, and their multiplicities.

    Parameters
    ----------
    f : Jet
        In adapted frames, at n points.
    rho : float
        cot(half_angle)/2.

    Returns
    -------
    angle : (n, 6) float
        Angles of e in the tangent planes, in rad, NaN-padded; none where every one would do.
    multiplicity : (n, 6) int
        How many fell together.
    """
    unit = rho * size(f, 3) + 3 * size(f, 2)
    return circle_roots(lambda a: rho * along(f, a, 3) + 3 * along(f, a, 1, 1), 3, unit=unit)


def order_four(f, angle, rho):
    """Return f_ee and the residual of fourth-order contact over the sum of its terms.

    Parameters
    ----------
    f : Jet
        In adapted frames, at n points.
    angle : (n, m) float
        Direction angles of e, in rad; NaN gives NaN.
    rho : float or (n, m) float
        cot(half_angle)/2.

    Returns
    -------
    fee : (n, m) float
        In m.
    residual : (n, m) float
        Eq. 12, from -1 to 1.
    """
    fee = along(f, angle, 2)
    terms = [
        rho**2 * along(f, angle, 4),
        6 * rho * along(f, angle, 2, 1),
        3 * (along(f, angle, 0, 2) - fee),
    ]
    total = sum(np.abs(term) for term in terms)
    # All terms may vanish together: then rounding is compared with the jet as a whole.
    norm = rho**2 * size(f, 4) + 6 * rho * size(f, 3) + 3 * size(f, 2)
    floor = np.maximum(total, 1e-3 * norm[:, None])
    return fee, sum(terms) / (floor + (floor == 0))
