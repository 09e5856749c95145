"""What a mill leaves that moves along positions: its error, and the width of its strip."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Length, Points, Sign, Whole, checked
from ..envelopes import adapted_frames
from ..envelopes.adapted import tangent_graph
from ..envelopes.jet import derivative
from ..kernels.exact import dot, norm
from .chains import Chain
from .motion import Axes, Tips, motion_through
from .patch import Patch
from .tools import BallMill, ConicalMill, CylinderMill, seen_from

BLOCK = 200_000  # pairs of a place of the mill and a point that are looked at together
CLOSER = 12  # halvings of the step between places: the least distance is off by its square


@checked
def sweep_error(
    points: Points,
    mill: ConicalMill | CylinderMill | BallMill,
    tip: Tips,
    axis: Axes,
    *,
    between: Whole(1, 100) = 8,
):
    """Return how far points are from what a mill sweeps through positions.

    Parameters
    ----------
    points : (..., 3) float
        As of the surface that is wanted, in m.
    mill : ConicalMill, CylinderMill or BallMill
        Only its cutting part counts.
    tip, axis
        Its positions, as for `moved`.
    between : int
        As for `moved`. About the nearest of these places the least distance is looked for closer.

    Returns
    -------
    error : (...) float
        In m: above zero what stays on the surface, below zero how deep it is cut.

    Examples
    --------
    >>> mill = CylinderMill(0.005, 0.02)
    >>> tip = np.stack([np.linspace(0, 0.05, 6), np.zeros(6), np.zeros(6)], axis=-1)
    >>> axis = np.broadcast_to((0.0, 0.0, 1.0), (6, 3))
    >>> sweep_error([0.025, 0.006, 0.01], mill, tip, axis).round(6)
    np.float64(0.001)
    """
    motion = motion_through(tip, axis)
    places = np.linspace(0, len(tip) - 1, (len(tip) - 1) * between + 1)
    tips, axes = motion(places)
    flat = points.reshape(-1, 3)
    error = np.empty(len(flat))
    size = max(1, BLOCK // len(places))
    for first in range(0, len(flat), size):
        part = slice(first, first + size)
        nearest = places[_nearest(mill, *seen_from(flat[part], tips, axes))]
        error[part] = _closer(flat[part], mill, motion, nearest, 1 / between, places[-1])
    return error.reshape(points.shape[:-1])[()]


def _nearest(mill, height, radius):
    """Return at which of k places a mill is nearest to each of n points, seen from there (k, n)."""
    bound = mill.cutting_faces(height, radius)
    point = np.arange(bound.shape[1])
    place = bound.argmin(axis=0)
    least = mill.cutting(height[place, point], radius[place, point])
    # Nowhere else is a mill nearer than its bound says.
    pairs = np.nonzero(bound < least)
    bound[place, point] = least
    bound[pairs] = mill.cutting(height[pairs], radius[pairs])
    return bound.argmin(axis=0)


def _closer(points, mill, motion, where, step, last):
    """Return the least distances (n,) of points from a moving mill, near places (n,) of its way.

    By halving the step to either side: a parabola through three distances would be off where the
    nearest part of the mill changes, as at its edges.
    """

    def distance(where):
        tip, axis = motion(where)
        return mill.cutting(*seen_from(points[:, None], tip, axis))[:, 0]

    least = distance(where)
    for _ in range(CLOSER):
        step /= 2
        for sign in (-1, 1):
            tried = np.clip(where + sign * step, 0, last)
            there = distance(tried)
            where = np.where(there < least, tried, where)
            least = np.minimum(there, least)
    return least


@dataclass(frozen=True, eq=False)
class Strip:
    """What a mill leaves across its way, at each position of a chain.

    Parameters
    ----------
    along : (k, m) float
        Way on the surface from the contact, across the chain, in m.
    error : (k, m) float
        As of `sweep_error`, in m; infinite beyond the patch.
    """

    along: np.ndarray
    error: np.ndarray

    @checked
    def widths(self, tolerance: Length):
        """Return how wide (k,), in m, the error about each contact stays within a tolerance."""
        middle = self.along.shape[1] // 2
        good = np.abs(self.error) <= tolerance
        right = np.logical_and.accumulate(good[:, middle:], axis=1).sum(axis=1) - 1
        left = np.logical_and.accumulate(good[:, middle::-1], axis=1).sum(axis=1) - 1
        row = np.arange(len(good))
        width = self.along[row, middle + right] - self.along[row, middle - left]
        return np.where(good[:, middle], width, 0.0)


@checked
def strip_across(
    patch: Patch,
    mill: ConicalMill | CylinderMill | BallMill,
    chain: Chain,
    tip: Tips,
    axis: Axes,
    *,
    reach: Length,
    m: Whole(1, 500) = 100,
):
    """Return what a mill leaves along lines across a chain, at all but its two first and last.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill, CylinderMill or BallMill
        That moves.
    chain : Chain
        Of six contacts or more; the lines run along its characteristics' tangents.
    tip, axis
        The mill's positions, as for `moved`: those of the chain or of another mill.
    reach : float
        To either side, in m.
    m : int
        Points to either side.

    Returns
    -------
    strip : Strip
        Of k - 4 lines; near its ends a chain cuts with less than its envelope.
    """
    if len(chain) < 6:
        raise ValueError(f"chain: must have 6 positions or more; got {len(chain)}.")
    inner = slice(2, -2)
    s, t = (part[inner] for part in (chain.s, chain.t))
    frames = adapted_frames.unchecked(patch.surface, s, t, "space")
    first = np.stack([np.stack(c.c[1:3], axis=-1) for c in frames.r], axis=1)
    rate = (np.linalg.pinv(first) @ (frames.axes @ chain.across[inner, :, None]))[..., 0]
    away = np.linspace(-reach, reach, 2 * m + 1)
    at_s = s[:, None] + rate[:, :1] * away
    at_t = t[:, None] + rate[:, 1:] * away
    beyond = (at_s < patch.s[0]) | (at_s > patch.s[1]) | (at_t < patch.t[0]) | (at_t > patch.t[1])
    points = patch.points(np.clip(at_s, *patch.s), np.clip(at_t, *patch.t))
    steps = norm(np.diff(points, axis=1))
    along = np.concatenate([np.zeros((len(s), 1)), np.cumsum(steps, axis=1)], axis=1)
    error = sweep_error(points, mill, tip, axis)
    return Strip(along - along[:, m : m + 1], np.where(beyond, np.inf, error))


@checked
def ball_positions(chain: Chain, mill: BallMill):
    """Return tips and axes (k, 3) of a ball that touches where a chain does, in m.

    Ours, to compare with: its axis is the chain's.
    """
    return chain.contact + mill.radius * (chain.normal - chain.axis), chain.axis


@checked
def cylinder_positions(patch: Patch, chain: Chain, mill: CylinderMill, *, which: Sign = 1):
    """Return tips, in m, and axes of a cylinder that touches with its flank where a chain does.

    Ours, to compare with. Its axis lies in the tangent plane so that the gap to the surface
    vanishes to second order in one direction, and is nowhere negative to that order; there are two
    such axes.
    The contact is amid its length.

    Parameters
    ----------
    patch : Patch
        The surface.
    chain : Chain
        Whose contacts are taken.
    mill : CylinderMill
        The cylinder.
    which : {1, -1}
        Of the two axes, to either side of a principal direction.

    Returns
    -------
    tip, axis : (k, 3) float
        The positions.

    Raises
    ------
    ValueError
        If the cylinder is too thick: it gouges at a contact whatever its axis.
    """
    frames = adapted_frames.unchecked(patch.surface, chain.s, chain.t, "space")
    g = tangent_graph(frames, slice(None))
    # Heights bend towards the mill where these are above zero.
    xx, xy, yy = (patch.side * derivative(g, i, 2 - i) for i in (2, 1, 0))
    determinant = xx * yy - xy * xy
    # With the unit vector n across the axis: det(S - n n'/R) = 0 is n' adj(S) n = R det(S).
    mean = (xx + yy) / 2
    size = np.hypot((yy - xx) / 2, xy)
    cosine = (mill.radius * determinant - mean) / size
    if np.any(np.abs(cosine) > 1):
        raise ValueError(
            f"mill: must be thin enough to touch without gouging; got the radius {mill.radius:g} m."
        )
    middle = np.arctan2(-xy, (yy - xx) / 2)
    angle = ((middle + which * np.arccos(cosine)) / 2 + np.pi / 2)[:, None]
    axis = np.cos(angle) * frames.axes[:, 0] + np.sin(angle) * frames.axes[:, 1]
    # A line without a direction: it begins as the chain's axis does, and doesn't turn back.
    turns = dot(axis[1:], axis[:-1])
    first = np.where(dot(axis[0], chain.axis[0]) < 0, -1.0, 1.0)
    signs = first * np.cumprod(np.append(1.0, np.where(turns < 0, -1.0, 1.0)))
    axis = signs[:, None] * axis
    return chain.contact + mill.radius * chain.normal - mill.length / 2 * axis, axis
