"""A surface at its points, in the frame where everything is simplest (Envelopes, section 6).

The adapted frame has its origin in the point and its third axis along the normal: there
x = y = f = fx = fy = 0 in the isotropic model, and f's Hessian has the eigenvalues 2 R1, 2 R2.
"""

from typing import Literal, NamedTuple

import numpy as np

from ..arguments import Finite, Reals, checked
from .functions import Function, as_jet, coordinates, one_number
from .jet import Jet, by_slopes, cross_product, differentiated, jet_variables

# |K|/|II|^2, up to which a point counts as one of Gaussian curvature 0. Rounding grows towards it:
# at 1e-3 vertices of cones are known to 1e-10 of their distance, at 1e-6 to 1e-6.
FLAT = 1e-6
_NOISE = 1e-12  # share of its terms up to which a number counts as rounding
MOST = 1e90  # of a jet's coefficients: products of three, and their sums, are then numbers


class AdaptedFrames(NamedTuple):
    """What `adapted_frames` finds at n points of a surface.

    Parameters
    ----------
    contact : (n, 3) float
        The points of the surface, in m.
    axes : (n, 3, 3) float
        Rows: two unit tangents and the unit normal.
    curvature : (n,) float
        |K| / |II|^2, from 0 to 1/2; 0 where both curvatures vanish.
    smooth : (n,) bool
        Whether point, tangent plane and derivatives exist.
    r, n : list of three Jet
        The surface in these frames, in m, and its unit normal, to order 3 at least.
    """

    contact: np.ndarray
    axes: np.ndarray
    curvature: np.ndarray
    smooth: np.ndarray
    r: list
    n: list


@checked
def adapted_frames(surface: Function(2), s: Reals, t: Reals, model: Literal["isotropic", "space"]):
    """Return a surface's points with their frames, and its jets seen from there.

    Parameters
    ----------
    surface : callable
        A function of two variables, built from ordinary arithmetic and numpy's functions. What
        it raises itself passes through.
    s, t : (...) float
        Points, that is, values of these two variables; n of them in all.
    model : {"isotropic", "space"}
        "isotropic": `surface` returns f(x, y), in m; "space": it returns three coordinates, in m.

    Returns
    -------
    frames : AdaptedFrames
        At these points, counted through the flattened arrays.

    Raises
    ------
    ValueError
        If `surface` is no function of two variables or returns something else.

    Examples
    --------
    >>> frames = adapted_frames(lambda s, t: [s, t, s * t], 0.0, 0.0, "space")
    >>> frames.axes[0, 2]
    array([0., 0., 1.])
    """
    s, t = np.broadcast_arrays(s, t)
    return frames_by(surface, *jet_variables(s.ravel(), t.ravel()), model)


@checked
def frames_along(surface: Function(2), s: Finite, t: Reals):
    """Return frames along one line of a ruled surface, whose first axes point along the line.

    The `surface` returns three coordinates, in m, by the line s and the place t (...) along it.
    """
    places = np.full(t.shape, s)
    return adapted_frames(lambda t, s: surface(s, t), t, places, "space")


def frames_by(surface, s, t, model):
    """Return the adapted frames of a surface whose variables are given as jets.

    Parameters
    ----------
    surface : callable
        As for `adapted_frames`.
    s, t : Jet
        The two variables, at n points.
    model : {"isotropic", "space"}
        As for `adapted_frames`.

    Returns
    -------
    frames : AdaptedFrames
        At these points.
    """
    with np.errstate(all="ignore"):
        answer = surface(s, t)
        if model == "isotropic":
            # The graph's point (x, y, f) stands for a plane: its normal depends on x and y alone,
            # and the point of contact follows from f and its slopes.
            f = as_jet(one_number("surface", answer, s), s)
            n = normal(s, t)
            r = contact_point(s, t, f, differentiated(f, 0), differentiated(f, 1))
            tangent = [differentiated(c, 0) for c in n]
            known = 1.0  # the tangent's length is 2/(x^2 + y^2 + 1), never zero
        else:
            # Two tangents span the plane, unless they are parallel within rounding; `known` is the
            # sine of their angle.
            r = [as_jet(c, s) for c in coordinates("surface", answer, s)]
            tangent = [differentiated(c, 0) for c in r]
            other = [differentiated(c, 1) for c in r]
            known = _ratio(tangent, other)
            n = cross_product(tangent, other)
            length = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            n = [c / length for c in n]
        # The frame's axes: along one tangent, across it, along the normal. The jets are moved and
        # turned into this frame, where the surface's height and slopes vanish at the point.
        third = np.stack([c.value for c in n], axis=-1)
        first = np.stack([c.value for c in tangent], axis=-1)
        first = first / np.linalg.norm(first, axis=-1, keepdims=True)
        axes = np.stack([first, np.cross(third, first), third], axis=-2)
        contact = np.stack([c.value for c in r], axis=-1)
        r = _turned(axes, [c - c.value for c in r])
        n = _turned(axes, n)
        # The first ten coefficients are those to order 3, to which both r and n are known.
        finite = np.all([np.isfinite(c.c[:10]).all(0) for c in (*r, *n)], axis=0)
        return AdaptedFrames(contact, axes, _curvature(r, n), (known > _NOISE) & finite, r, n)


def isotropic_jet(frames, where):
    """Return f's jets, of the surface's order, in the adapted frames of some points.

    Parameters
    ----------
    frames : AdaptedFrames
        Of n points.
    where : (n,) bool, indices or slice
        Which of them; only smooth ones where the curvature isn't 0.

    Returns
    -------
    f : Jet
        In m.
    """
    r = [Jet(c.c[:, where]) for c in frames.r]
    n = [Jet(c.c[:, where]) for c in frames.n]
    x, y, _, fx, fy = isotropic_derivatives(r, n)
    # The normal is a derivative of the surface, so it is known to one order less, and so are the
    # slopes by Eqs 18 and 19. From them f follows to the full order, where Eq. 17 doesn't give it.
    return by_slopes(x, y, fx, fy)


def sound(f):
    """Return where (n,) all coefficients of a jet f are at most `MOST` in size."""
    return np.abs(f.c).max(axis=0) <= MOST


@checked
def model_jet(surface: Function(2), s: Reals, t: Reals):
    """Return a surface's graph in the isotropic model, in the document's own coordinates.

    Parameters
    ----------
    surface : callable
        Of two variables: three coordinates in m, with curvature nowhere 0. What it raises itself
        passes through.
    s, t : (...) float
        Points, with no normal (0, 0, -1); n of them in all.

    Returns
    -------
    x, y : (n,) float
        Places in the model.
    f : Jet
        There, of order 4, in m.

    Raises
    ------
    ValueError
        If the surface isn't smooth at a point, or has no isotropic model there.
    """
    found = adapted_frames(surface, s, t, "space")
    back = np.swapaxes(found.axes, 1, 2)
    r = _turned(back, found.r)
    n = _turned(back, found.n)
    r = [jet + moved for jet, moved in zip(r, found.contact.T, strict=True)]
    x, y, value, fx, fy = isotropic_derivatives(r, n)
    f = by_slopes(x, y, fx, fy)
    f.c[0] = value.value
    if not np.all(found.smooth & (found.curvature > FLAT) & sound(f) & sound(x) & sound(y)):
        raise ValueError(
            "surface: must be smooth at every point, of a Gaussian curvature not 0 and with a "
            "normal other than (0, 0, -1); got one where it isn't."
        )
    return x.value, y.value, f


def tangent_graph(frames, where):
    """Return the jets of a surface as a graph over its tangent planes.

    Parameters
    ----------
    frames : AdaptedFrames
        Of n points.
    where : (n,) bool, indices or slice
        Which of them; only smooth ones.

    Returns
    -------
    g : Jet
        Heights along the normal, in m, to order 3 at least.
    """
    # Its slopes are those of the normal, -n1/n3 and -n2/n3.
    x, y, _ = (Jet(c.c[:, where]) for c in frames.r)
    a, b, c = (Jet(part.c[:, where]) for part in frames.n)
    return by_slopes(x, y, -a / c, -b / c)


def _curvature(r, n):
    """Return |K|/|II|^2 from first derivatives of points and normals, in the frames."""
    (_, xs, xt), (_, ys, yt) = (c.c[:3] for c in r[:2])
    (_, ns, nt), (_, ms, mt) = (c.c[:3] for c in n[:2])
    # The matrix of the shape operator times the area xs yt - xt ys, which may be zero.
    a = ns * yt - nt * ys
    b = nt * xs - ns * xt
    c = ms * yt - mt * ys
    d = mt * xs - ms * xt
    square = a * a + b * b + c * c + d * d
    # Normals count as constant where they turn by no more than rounding in second derivatives.
    bend = sum(np.abs(part.c[3:6]).sum(axis=0) for part in r[:2])
    turn = np.hypot(np.hypot(ns, nt), np.hypot(ms, mt))
    run = np.hypot(np.hypot(xs, xt), np.hypot(ys, yt))
    plane = turn * run <= _NOISE * bend
    return np.where(plane | (square == 0), 0.0, np.abs(a * d - b * c) / (square + (square == 0)))


def _turned(axes, vector):
    """Return three jets as the components of a vector along other axes (n, 3, 3)."""
    c = np.stack([jet.c for jet in vector], axis=1)  # (terms, 3, n)
    turned = np.einsum("nik,ckn->icn", axes, c)
    return [Jet(part) for part in turned]


def _ratio(a, b):
    """Return the sine of the angle between two tangents, NaN where one of them is zero."""
    a, b = (np.stack([c.value for c in v], axis=-1) for v in (a, b))
    return np.linalg.norm(np.cross(a, b), axis=-1) / np.prod(
        [np.linalg.norm(v, axis=-1) for v in (a, b)], axis=0
    )


# ---- from a graph in the model to its surface, and back; numbers, arrays or jets -----------------


def normal(x, y):
    """Return the components of the unit normal of the planes over a place (Eq. 21)."""
    p = x * x + y * y + 1
    return 2 * x / p, 2 * y / p, 2 / p - 1


def contact_point(x, y, f, fx, fy):
    """Return the point where the plane over (x, y) touches the surface of f (Eq. 20).

    `f`, `fx`, `fy` are the function and its derivatives there; all lengths are in m.
    """
    p = x * x + y * y + 1
    # The third coordinate as printed; r1 and r2 by Eqs 18 and 19, which take fewer products.
    r3 = 2 * (x * fx + y * fy - f) / p
    return x * r3 - fx, y * r3 - fy, r3


def isotropic_derivatives(r, n):
    """Return x, y, f, fx, fy by points of a surface and unit normals there (Eqs 17 to 19)."""
    below = n[2] + 1
    x = n[0] / below
    y = n[1] / below
    f = -(n[0] * r[0] + n[1] * r[1] + n[2] * r[2]) / below
    return x, y, f, x * r[2] - r[0], y * r[2] - r[1]
