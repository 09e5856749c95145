"""Other ways between two joint positions that could stand in for a geodesic.

All of them but the straight line in joint space drop the points M(t) of the chord onto the torus;
they differ in the direction along which they do.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..arguments import Positions, checked, positions
from ..kernels.exact import dot, norm, radius_and_excess
from ..surfaces import Torus
from ..surfaces.torus import torus_angles, torus_normal
from .bounds import Row, check_on_sheet
from .chord_law import normals
from .correction import corrected_points
from .projection import chord_points, feet, projected
from .quadrature import path_lengths

ROUNDS = 8  # of Newton's method, each of which doubles the digits; four do on a working sheet


@dataclass(frozen=True)
@checked
class ChordPath:
    """A way that could stand in for a geodesic, and how drawings show it.

    Parameters
    ----------
    name : str
        Its name in tables and legends.
    way : callable
        Returns the positions (..., n, 2) for a torus, positions p and q (..., 2), in rad, and
        shares t (n,), 0 at p and 1 at q.
    colour : str
        Its role in `kit.COLOURS`.
    line : str or tuple
        Its line style in matplotlib, by which it can be told in grey as well.
    """

    name: str
    way: Callable[[Torus, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    colour: str
    line: str | tuple

    @checked
    def __call__(self, torus: Torus, p: Positions, q: Positions, t: Row):
        """Return the joint positions (..., n, 2), in rad, at the shares t of the way from p to q.

        Parameters
        ----------
        torus : Torus
            The surface.
        p, q : (..., 2) float
            Joint positions (theta, phi) of the ends, in rad, on the working sheet.
        t : (n,) float
            Shares of the way, 0 at p and 1 at q.

        Raises
        ------
        ValueError
            If an end isn't on the working sheet, or no path leads from one to the other, as along
            a chord through the centre of the torus.

        Examples
        --------
        A path may give up by numbers that aren't finite:

        >>> lost = ChordPath("mine", lambda torus, p, q, t: np.full((3, 2), np.nan), "error", "-")
        >>> lost(Torus(1, 0.5), (0, 0), (1, 0), (0.0, 0.5, 1.0))  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ValueError: p, q: must be ends that mine can join, with a chord that ...; got others.
        """
        check_on_sheet(torus, p, q)
        with np.errstate(all="ignore"):  # where there is no path the next lines raise
            found = self.way(torus, p, q, t)
        if not np.all(np.isfinite(found)):
            raise ValueError(
                f"p, q: must be ends that {self.name} can join, with a chord that keeps away from "
                "the axis and the torus' centre; got others."
            )
        return positions(self.name, found)


def _one_third_rule(torus, p, q, t):
    """Return the path on a torus from p to q that mixes the normals at M(t) and at the middle.

    This is our proposal: with a third of M's own normal and two thirds of the middle's the leading
    term of the projected chord's error cancels. So m is moved to m - 2/3 d (n - n0) before it is
    projected, where d is its depth below the surface, n the outward normal at its own foot, and n0
    that at the middle's.
    """
    m = chord_points(torus, p, q, t)
    depth = _depth(torus, m)[..., None]
    return feet(torus, m - depth * (_normal(torus, m) - _middle_normal(torus, p, q)) * (2 / 3))


def _simpson_rule(torus, p, q, t):
    """Return the path on a torus from p to q that weighs normals as Simpson's rule does.

    M(t) is dropped along (n + 4 n0 + nc) / 6, where nc is the point at t of the chord between the
    ends' normals. That cancels the effects of torsion and of its rate; that of the rate of
    curvature is left.
    """
    return feet(torus, _simpson_points(torus, p, q, t))


def _completed_simpson_rule(torus, p, q, t):
    """Return Simpson's path on a torus from p to q, less the effect of the rate of curvature.

    The ends alone tell that effect: (Q - P) . (nP + nQ) is the rate of curvature times l^3 / 6, and
    nQ - nP is, across the chord, the torsion times l.
    """
    first, last = normals(p), normals(q)
    start, stop = (chord_points(torus, p, q, np.array([end]))[..., 0, :] for end in (0.0, 1.0))
    u = (t * (1 - t))[:, None]
    rate = dot(stop - start, first + last)[..., None, None]
    left = u * (1 - u) / 6 * rate * (last - first)[..., None, :]
    return feet(torus, _simpson_points(torus, p, q, t) + left)


def _simpson_points(torus, p, q, t):
    """Return M(t), moved so that its foot is where Simpson's rule drops M(t)."""
    m = chord_points(torus, p, q, t)
    normal = _normal(torus, m)
    between = (1 - t)[:, None] * normals(p)[..., None, :]
    between = between + t[:, None] * normals(q)[..., None, :]
    # From there M drops along its own normal to where it would drop along the mean.
    mean = (normal + 4 * _middle_normal(torus, p, q) + between) / 6
    return m + _depth(torus, m)[..., None] * (mean - normal)


def _plane_section(torus, p, q, t):
    """Return the torus' section from p to q by the plane of the chord and the middle's normal."""
    return _dropped(torus, chord_points(torus, p, q, t), _middle_normal(torus, p, q))


def _radial_projection(torus, p, q, t):
    """Return the chord from p to q, each M(t) projected from the centre of the torus."""
    m = chord_points(torus, p, q, t)
    return _dropped(torus, m, m / norm(m)[..., None])


def _joint_line(_, p, q, t):
    """Return the straight line from p to q in the plane of the joint angles, on any torus."""
    return p[..., None, :] + t[..., None] * (q - p)[..., None, :]


# Another path is one more entry here; `make atlas` then adds it to the atlas of ratios.
CHORD_PATHS = {
    path.name: path
    for path in (
        ChordPath("projected chord", projected, "tangent sphere", "-"),
        ChordPath("one-third rule", _one_third_rule, "correct", "--"),
        ChordPath("plane section", _plane_section, "offset", "-."),
        ChordPath("radial projection", _radial_projection, "printed", ":"),
        ChordPath("joint space", _joint_line, "error", (0, (6, 1.5, 1, 1.5, 1, 1.5))),
        ChordPath("corrected chord", corrected_points, "corrected", (0, (8, 2))),
    )
}
# These are the better the shorter the chord is, but poor from corner to corner.
SHORT_CHORD_PATHS = {
    path.name: path
    for path in (
        ChordPath("Simpson rule", _simpson_rule, "cutter", (0, (3, 1, 1, 1))),
        ChordPath("completed Simpson", _completed_simpson_rule, "T1", (0, (1, 1))),
    )
}


@checked
def path_length(torus: Torus, path: ChordPath, p: Positions, q: Positions):
    """Return the length of a path between joint positions.

    Parameters
    ----------
    torus : Torus
        The surface.
    path : ChordPath
        One of `CHORD_PATHS`, or another.
    p, q : (..., 2) float
        Joint positions (theta, phi) of the ends, in rad; they broadcast.

    Returns
    -------
    length : (...) float
        In m, right to 1e-9 of itself, or to 1e-13 (r + R) where that is more, and mostly to
        rounding. The angles may be of any size.

    Raises
    ------
    ValueError
        If an end isn't on the working sheet, or the path doesn't join the ends: there may be none,
        or it jumps, or all but jumps, as where a chord passes the axis or the ring circle far
        nearer than 1e-6 (r + R).

    Notes
    -----
    The path is cut into panels, as many as its swings take, and polynomials are laid through each.
    Their speed is integrated by Gauss and Legendre's quadrature, see `quadrature.panels`.

    Examples
    --------
    >>> path = CHORD_PATHS["joint space"]
    >>> round(float(path_length(Torus(0.1, 0.9), path, (0, -0.3), (0, 0.4))), 12)
    0.63
    """
    check_on_sheet(torus, p, q)
    # A turn about the axis moves the torus into itself. So theta is counted from p where it is
    # beyond a turn: the roundings of great angles would pass for steps of the path.
    far = np.maximum(np.abs(p[..., 0]), np.abs(q[..., 0])) > 2 * np.pi
    start = np.stack([np.where(far, p[..., 0], 0.0), np.zeros_like(far, float)], axis=-1)
    p, q = p - start, q - start
    return path_lengths(torus, partial(path, torus), p, q)


def _middle_normal(torus, p, q):
    """Return the normal (..., 1, 3) at the foot of each chord's middle."""
    return _normal(torus, chord_points(torus, p, q, np.array([0.5])))


def _normal(torus, m):
    """Return the normals (..., 3) at the feet of points M (..., 3)."""
    return torus_normal(*torus_angles(torus, m))


def _depth(torus, m):
    """Return how deep points lie below the tube's surface, negative outside of it."""
    x, y, z = np.moveaxis(m, -1, 0)
    # rho - r to its last digits: near the ring circle a plain difference would lose them.
    return torus.R - np.hypot(radius_and_excess(x, z, torus.r)[1], y)


def _dropped(torus, m, direction):
    """Return where points meet the torus along unit directions, by Newton's method on the depth."""
    # The depth falls along the direction by the cosine of its angle to the normal.
    for _ in range(ROUNDS):
        step = _depth(torus, m) / dot(_normal(torus, m), direction)
        m = m + step[..., None] * direction
    return feet(torus, m)
