"""The projected chord: a chord projected normally onto the torus (section 3.3)."""

import math
from functools import partial
from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from ..arguments import Positions, checked
from ..kernels.exact import norm
from ..surfaces import Torus
from ..surfaces.torus import torus_angles, torus_point
from .bounds import Count, check_on_sheet, check_points
from .chord_law import normals
from .quadrature import panels


@checked
def project_chord(
    torus: Torus,
    p: Positions,
    q: Positions,
    n: Count,
    *,
    spacing: Literal["chord", "tangent", "arc"] = "chord",
):
    """Return points of the projected chord between two joint positions.

    Parameters
    ----------
    torus : Torus
        The surface.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends P and Q, in rad; they broadcast.
    n : int
        Number of points, both ends included, from 2 to a million, and at most 5 million of all
        paths together.
    spacing : {"chord", "tangent", "arc"}
        Equal steps along the chord, as in the document; equal angles as seen from the centre of a
        sphere that has the normals' angle 2b between P and Q, which takes two tangents; or equal
        arcs of the path itself.

    Returns
    -------
    path : (..., n, 2) float
        Joint positions (theta, phi) of the feet of M(t), in rad. They are on the working sheet
        where `Torus.foot` says so: a chord that passes near the axis has some beyond it.

    Raises
    ------
    ValueError
        If n is below 2 or asks for too many points, `spacing` is another word, or a position isn't
        (theta, phi) or isn't on the working sheet, r + R cos(phi) >= 0. With equal arcs also where
        `path_length` refuses the path.

    Notes
    -----
    Tunnelling robot, sections 3.3 and 3.3.1: "intervals corresponding to a fairly equal
    separation of successive points". The tangent reparametrisation is
    t = (1 + tan(b (2u - 1)) / tan(b)) / 2, exact on a sphere. Where a chord crosses the axis
    or the ring circle its foot jumps, and there is no path.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Torus
    >>> project_chord(Torus(0.1, 0.9), (0, -0.3), (0, 0.3), 3).round(12) + 0.0
    array([[ 0. , -0.3],
           [ 0. ,  0. ],
           [ 0. ,  0.3]])
    >>> project_chord(Torus(0.1, 0.9), (0, -0.3), (0, 3), 3)
    Traceback (most recent call last):
    ValueError: q: must lie on the working sheet, r + R cos(phi) >= 0; got phi = 3 rad.
    """
    check_on_sheet(torus, p, q)
    check_points(n, np.broadcast_shapes(p.shape, q.shape)[:-1])
    u = np.linspace(0, 1, n)
    if spacing == "chord":
        t = u
    elif spacing == "tangent":
        # Half the angle between the normals at the ends, by the sum and the difference of unit
        # vectors, which keeps its digits for any angle. At zero equal steps are the limit.
        first, last = normals(p), normals(q)
        b = np.arctan2(norm(last - first), norm(last + first))[..., None]
        tan = np.where(b > 0, np.tan(b), 1)
        t = np.where(b > 0, (1 + np.tan(b * (2 * u - 1)) / tan) / 2, u)
    else:
        t = _equal_arcs(torus, p, q, u)
    return projected(torus, p, q, t)


def chord_points(torus, p, q, t):
    """Return the points M (..., n, 3) on chords of a torus from p to q, at shares t (..., n)."""
    start, stop = (torus_point(torus, *np.moveaxis(end, -1, 0)) for end in (p, q))
    return start[..., None, :] + t[..., None] * (stop - start)[..., None, :]


def feet(torus, m):
    """Return the joint positions (..., 2) of the feet on a torus of points m (..., 3), in m."""
    return np.stack(torus_angles(torus, m), axis=-1)


def projected(torus, p, q, t):
    """Return the projected chord (..., n, 2) on a torus from p to q: the feet of M(t), 3.3."""
    return feet(torus, chord_points(torus, p, q, t))


def _equal_arcs(torus, p, q, u):
    """Return t (..., n) at which the path has run the shares u of its length.

    On each panel the speed's series is integrated term by term and inverted by Newton's method,
    each root kept in a bracket.
    """
    p, q = np.broadcast_arrays(p, q)
    found = panels(torus, partial(projected, torus), p.reshape(-1, 2), q.reshape(-1, 2))
    total, run = np.zeros((2, math.prod(p.shape[:-1])))  # `run`: up to the panel at hand
    for panel in found:
        total[panel.rows] += 2 * panel.series[0]
    wanted = total[:, None] * u
    t = np.ones(wanted.shape)
    for rows, low, high, series, _ in found:
        left = wanted[rows] - run[rows, None]
        x = _where_run(series, np.clip(left, 0, 2 * series[0][:, None]))
        # Panels come in order: a place beyond this one is overwritten by a later one.
        t[rows] = np.where(left >= 0, low + (high - low) * (1 + x) / 2, t[rows])
        run[rows] += 2 * series[0]
    return t.reshape(*p.shape[:-1], len(u))


def _where_run(series, run):
    """Return x (k, n), from -1 to 1, up to which paths run so far on a panel.

    Their speeds have the `series` (ORDER, k), and `run` (k, n) is how far.
    """
    arc = legendre.legint(series, lbnd=-1)
    # The first guess is the place at an even speed.
    # The integral over a panel is twice the first Legendre term, the mean.
    whole = 2 * series[0][:, None]
    x = 2 * run / np.where(whole > 0, whole, 1) - 1
    low, high = np.full(run.shape, -1.0), np.full(run.shape, 1.0)
    for _ in range(60):
        left = run - _series(x, arc)
        if np.all(np.abs(left) <= 1e-15 * whole):
            break
        # The arc only grows with x: what is left of it says on which side the root lies.
        low, high = np.where(left > 0, x, low), np.where(left < 0, x, high)
        speed = _series(x, series)
        # Newton's step where it stays in the bracket, else the bracket's middle.
        newton = x + left / np.where(speed > 0, speed, 1)
        x = np.where((low <= newton) & (newton <= high), newton, (low + high) / 2)
    return x


def _series(x, coefficients):
    """Return Legendre series at x (k, n), one of (ORDER, k) for each row."""
    return legendre.legval(x, coefficients[..., None], tensor=False)
