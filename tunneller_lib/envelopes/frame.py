"""A surface at its points, in the frame where everything is simplest (Envelopes, section 6).

The adapted frame has its origin in the point and its third axis along the normal: there
x = y = f = fx = fy = 0 in the isotropic model, and f's Hessian has the eigenvalues 2 R1, 2 R2.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import real
from .isotropic import contact_point, isotropic_derivatives, normal
from .jet import EXPONENTS, Jet, compose, inverse, variables

# |K|/|II|^2, below which a point counts as one of Gaussian curvature 0. Rounding grows towards it:
# at 1e-3 vertices of cones are known to 1e-10 of their distance, at 1e-6 to 1e-6.
FLAT = 1e-6
_NOISE = 1e-12


class Frames(NamedTuple):
    """Surfaces' points and what `frames` finds there; n points."""

    contact: np.ndarray  # (n, 3) points of the surface, in m
    axes: np.ndarray  # (n, 3, 3) rows: two tangents and the unit normal
    curvature: np.ndarray  # (n,) |K| / |II|^2, 0 to 1/2; 0 where all curvatures vanish
    smooth: np.ndarray  # (n,) whether point, tangent plane and derivatives exist
    r: tuple  # three jets of the surface in these frames, of order 3
    n: tuple  # three jets of its unit normal


def finite_points(s, t):
    """Return two arrays of finite numbers, brought to one shape."""
    s, t = real("s", s), real("t", t)
    for name, value in (("s", s), ("t", t)):
        if not np.isfinite(value).all():
            first = value[~np.isfinite(value)][0]
            raise ValueError(f"{name}: must hold finite numbers; got {first}.")
    try:
        return np.broadcast_arrays(s, t)
    except ValueError:
        raise ValueError(f"t: must go with the shape {s.shape} of s; got {t.shape}.") from None


def frames(surface, s, t, model):
    """Return a surface's points with their frames, and its jets seen from there.

    Parameters
    ----------
    surface : callable
        A function of two variables, built from ordinary arithmetic and numpy's functions.
    s, t : (n,) float
        Points.
    model : {"isotropic", "space"}
        "isotropic": `surface` returns f(x, y), in m; "space": it returns three coordinates, in m.

    Returns
    -------
    frames : Frames
        At these points.

    Raises
    ------
    ValueError
        If `model` is another word or `surface` returns something else.
    """
    s, t = variables(s, t)
    with np.errstate(all="ignore"):
        if model == "isotropic":
            f = _one(surface(s, t), s)
            n = normal(s, t)
            r = contact_point(s, t, f, f.d(0), f.d(1))
            tangent, known = [c.d(0) for c in n], 1.0  # of length 2/(x^2 + y^2 + 1), never zero
        elif model == "space":
            r = _three(surface(s, t), s)
            tangent, other = [c.d(0) for c in r], [c.d(1) for c in r]
            n, known = _cross(tangent, other), _ratio(tangent, other)
            length = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            n = [c / length for c in n]
        else:
            raise ValueError(f'model: must be "isotropic" or "space"; got {model!r}.')
        third = np.stack([c.value for c in n], axis=-1)
        first = np.stack([c.value for c in tangent], axis=-1)
        first = first / np.linalg.norm(first, axis=-1, keepdims=True)
        axes = np.stack([first, np.cross(third, first), third], axis=-2)
        contact = np.stack([c.value for c in r], axis=-1)
        r = _turned(axes, [c - c.value for c in r])
        n = _turned(axes, n)
        smooth = (known > _NOISE) & np.all([np.isfinite(c.c[:10]).all(0) for c in (*r, *n)], axis=0)
        return Frames(contact, axes, _curvature(r, n), smooth, r, n)


def isotropic_jet(frames, where):
    """Return f's jets, of order 4, in the adapted frames of some points.

    Parameters
    ----------
    frames : Frames
        Of n points.
    where : (n,) bool, indices or slice
        Which: smooth ones where the curvature isn't 0.

    Returns
    -------
    f : Jet
        In m.
    """
    r, n = ([Jet(c.c[:, where]) for c in jets] for jets in (frames.r, frames.n))
    x, y, _, fx, fy = isotropic_derivatives(r, n)
    f = _integrated(*compose([fx, fy], *inverse(x, y)))
    f.c[:3] = 0.0
    return f


def model_jet(surface, s, t):
    """Return a surface in the isotropic model as it stands, without an adapted frame.

    Parameters
    ----------
    surface : callable
        Of two variables: three coordinates in m, with curvature nowhere 0.
    s, t : (n,) float
        Points, with no normal near (0, 0, -1).

    Returns
    -------
    x, y : (n,) float
        Places in the model.
    f : Jet
        There, of order 4, in m.
    """
    found = frames(surface, s, t, "space")
    r, n = (_turned(np.swapaxes(found.axes, 1, 2), jets) for jets in (found.r, found.n))
    r = [jet + moved for jet, moved in zip(r, found.contact.T, strict=True)]
    x, y, value, fx, fy = isotropic_derivatives(r, n)
    f = _integrated(*compose([fx, fy], *inverse(x, y)))
    f.c[0] = value.value
    return x.value, y.value, f


def _integrated(fx, fy):
    """Return a jet of order 4 from its first derivatives, its value left 0."""
    f = np.zeros_like(fx.c)
    # f itself would need the surface to order 5; its derivatives don't (Eqs 18 and 19).
    for place, (i, j) in enumerate(EXPONENTS[1:], start=1):
        part, i, j, times = (fx, i - 1, j, i) if i else (fy, i, j - 1, j)
        f[place] = part.c[EXPONENTS.index((i, j))] / times
    return Jet(f)


def tangent_graph(frames, where):
    """Return jets, of order 3, of the surface as a graph over its tangent planes.

    Parameters
    ----------
    frames : Frames
        Of n points.
    where : (n,) bool, indices or slice
        Which; only smooth ones.

    Returns
    -------
    g : Jet
        Heights along the normal, in m.
    """
    x, y, z = (Jet(c.c[:, where]) for c in frames.r)
    return compose([z], *inverse(x, y))[0]


def _curvature(r, n):
    """Return |K|/|II|^2 from first derivatives of points and normals, in the frames."""
    (_, xs, xt), (_, ys, yt) = (c.c[:3] for c in r[:2])
    (_, ns, nt), (_, ms, mt) = (c.c[:3] for c in n[:2])
    # The matrix of the shape operator times the area xs yt - xt ys, which may be zero.
    a, b = ns * yt - nt * ys, nt * xs - ns * xt
    c, d = ms * yt - mt * ys, mt * xs - ms * xt
    square = a * a + b * b + c * c + d * d
    # Normals that turn no more than the second derivatives' rounding don't turn.
    bend = sum(np.abs(part.c[3:6]).sum(axis=0) for part in r[:2])
    still = np.hypot(np.hypot(ns, nt), np.hypot(ms, mt)) * np.hypot(np.hypot(xs, xt),
                                                                   np.hypot(ys, yt))  # fmt: skip
    plane = still <= _NOISE * bend
    return np.where(plane | (square == 0), 0.0, np.abs(a * d - b * c) / (square + (square == 0)))


def _turned(axes, vector):
    return [sum(vector[k] * axes[:, i, k] for k in range(3)) for i in range(3)]


def _cross(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def _ratio(a, b):
    """Return how far two tangents are from being parallel or zero, 0 to 1."""
    a, b = (np.stack([c.value for c in v], axis=-1) for v in (a, b))
    return np.linalg.norm(np.cross(a, b), axis=-1) / np.prod(
        [np.linalg.norm(v, axis=-1) for v in (a, b)], axis=0
    )


def _one(value, like):
    if isinstance(value, Jet):
        return value
    try:
        return like * 0.0 + real("surface", value)
    except ValueError:
        raise ValueError(f"surface: must return one value f(x, y); got {value!r}.") from None


def _three(value, like):
    try:
        x, y, z = value
    except (TypeError, ValueError):
        raise ValueError(f"surface: must return three coordinates; got {value!r}.") from None
    return [_one(part, like) for part in (x, y, z)]
