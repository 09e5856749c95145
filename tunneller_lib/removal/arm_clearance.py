"""How far the arm, the cutter and other solids keep from the wall that isn't cut yet."""

import numpy as np

from ..arguments import Angle, Array, Length0, Points, Radii, checked
from ..surfaces import Machine, Section
from ..surfaces.solid import Solid, outermost

ANGLES = 360  # angles from y at which the outermost points of a solid are looked at first
GOLDEN = (np.sqrt(5) - 1) / 2
SECTIONS = 34  # golden ones; then an angle has half of its digits, and a least depth all
POSES = 512  # handled together, to save memory
AS_GIVEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)  # a frame that isn't turned
ROUNDED = 1e-9  # by how much products of the rows of a rotation may be off


@checked
def rod_clearance(section: Section, a: Points, b: Points, radius: Radii):
    """Return how far round-ended rods stay inside a section, in closed form.

    Parameters
    ----------
    section : Section
        The tunnel's, which is convex.
    a, b : (..., 3) float
        Ends of the rods' axes in the frame of the tunnel, in m.
    radius : (...) float
        Of the rods, in m, zero or above.

    Returns
    -------
    clearance : (...) float
        Least distance to the wall, in m; if negative, how deep the rod is in the ground.

    Raises
    ------
    ValueError
        If a radius is negative.

    Notes
    -----
    The depth inside a convex curve is concave along a segment, so the least is at an end. In the
    ground the distance is convex and the greatest is at an end again.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Egg
    >>> float(rod_clearance(Egg(0.5), (0, 0, -0.4), (0.8, 0.3, 0), 0.1).round(12))
    0.1
    """
    depths = [section.depth(end[..., 1], end[..., 2]) for end in (a, b)]
    return np.minimum(*depths) - radius


def _turn_frames(turn):
    """Return whether matrices have perpendicular rows of length 1."""
    return np.all(np.abs(turn @ np.moveaxis(turn, -1, -2) - np.eye(3)) <= ROUNDED)


_ROWS = "hold rows that are perpendicular and 1 long"
Turns = Array("(..., 3, 3) float", also=(_ROWS, _turn_frames))


@checked
def solid_clearance(
    section: Section, solid: Solid, *, turn: Turns = AS_GIVEN, place: Points = (0.0, 0.0, 0.0)
):
    """Return how far a solid stays inside a section: a cutter's part, a piece of the machine.

    Parameters
    ----------
    section : Section
        The tunnel's, which is convex.
    solid : Solid
        A `Rod`, `Frustum` or `Box` in a frame of its own, which is that of the
        tunnel unless the next two are given.
    turn : (..., 3, 3) float
        The axes of its frame in that of the tunnel, as the columns of matrices.
    place : (..., 3) float
        Its frame's origin in the tunnel, in m.

    Returns
    -------
    clearance : (...) float
        Least distance to the wall, in m; if negative, how deep the solid is in the ground;
        ``inf`` for an empty one.

    Notes
    -----
    Both are convex. Across the wall, in the plane x = 0, the least depth is that of the point where
    the solid reaches farthest along the wall's normal there, so that one angle is looked for. The
    points are those at which planes touch the solid's `hull`. Those at `ANGLES` angles
    tell where the depth has valleys, whose lowest points are found by golden sections.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Egg, Rod
    >>> capsule = Rod((0, 0, -0.4), (0.8, 0.3, 0), 0.1, ends="round")
    >>> float(solid_clearance(Egg(0.5), capsule).round(12))
    0.1
    >>> float(solid_clearance(Egg(0.5), capsule, place=(0, 0.05, 0)).round(12))
    0.05
    >>> float(solid_clearance(Egg(0.5), capsule, turn=AS_GIVEN).round(12))
    0.1
    """
    turn, place = np.array(turn), np.array(place)
    shape = np.broadcast_shapes(turn.shape[:-2], place.shape[:-1])
    # Only what is across the tunnel counts.
    across = np.broadcast_to(turn[..., 1:, :], (*shape, 2, 3)).reshape(-1, 2, 3)
    middle = np.broadcast_to(place[..., 1:], (*shape, 2)).reshape(-1, 2)
    least = np.empty(len(across))
    for start in range(0, len(across), POSES):
        some = slice(start, start + POSES)
        least[some] = _least_depths(section, solid, across[some], middle[some])
    return least.reshape(shape)[()]


def _least_depths(section, solid, across, middle):
    """Return least depths (n,) of a solid in n poses, as `_depths` has them."""
    step = 2 * np.pi / ANGLES
    angle = step * np.arange(ANGLES)
    each = np.repeat(np.arange(len(across)), ANGLES)
    depths = _depths(section, solid, across[each], middle[each], np.tile(angle, len(across)))
    depths = depths.reshape(-1, len(across), ANGLES)
    least = depths.min(axis=(0, 2), initial=np.inf)
    # Each point's valleys of the depth, between the neighbours of a sample.
    valley = (depths < np.roll(depths, 1, axis=2)) & (depths <= np.roll(depths, -1, axis=2))
    which, pose, sample = np.nonzero(valley)
    if not len(which):
        return least
    pick = which, np.arange(len(which))
    posed = across[pose], middle[pose]
    low, high = angle[sample] - step, angle[sample] + step
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one, at_other = (_depths(section, solid, *posed, x)[pick] for x in (one, other))
    for _ in range(SECTIONS):
        # One of both places is kept, so that each section costs one depth.
        lower = at_one < at_other
        low, high = np.where(lower, low, one), np.where(lower, other, high)
        new = np.where(lower, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        at_new = _depths(section, solid, *posed, new)[pick]
        one, other = np.where(lower, new, other), np.where(lower, one, new)
        at_one, at_other = np.where(lower, at_new, at_other), np.where(lower, at_one, at_new)
    np.minimum.at(least, pose, np.minimum(at_one, at_other))
    return least


def _depths(section, solid, across, middle, angle):
    """Return depths (k, n) of a solid's k outermost points, at angles (n,).

    It stands with its origin at `middle` (n, 2), and `across` (n, 2, 3) turns it into the plane of
    y and z.
    """
    normal = np.cos(angle) * across[:, 0].T + np.sin(angle) * across[:, 1].T
    start, parts = solid.hull
    if not parts:
        return np.empty((0, len(angle)))
    points = [start[:, None] + way for way in outermost(parts, normal)]
    y, z = np.einsum("nij,kjn->ikn", across, points) + middle.T[:, None]
    return section.depth(y, z)


@checked
def circuit_clearance(
    machine: Machine, section: Section, lowest: Angle, highest: Angle, arm_radius: Length0
):
    """Return how far the arm stays inside a section over a whole circuit, in closed form.

    Parameters
    ----------
    machine : Machine
        Sizes, cutter and height; its axes are the tunnel's.
    section : Section
        The tunnel's, on whose offset the cutter's centre moves.
    lowest, highest : float
        Range of theta over the circuit, in rad.
    arm_radius : float
        Of the round-ended rod about the arm, in m.

    Returns
    -------
    clearance : float
        Least distance of the arm to the wall, in m; negative in the ground.

    Raises
    ------
    ValueError
        If `lowest` is above `highest`, or one of them isn't from -pi/2 to pi/2.

    Notes
    -----
    The cutter's end of the arm keeps the offset; the joint's end moves on the ring in the plane
    y = 0, where the depth is concave in z, so that its least is at an end of its range. Nothing is
    sampled.
    """
    if not -np.pi / 2 <= lowest <= highest <= np.pi / 2:
        raise ValueError(
            "lowest: must be at most highest, both from -pi/2 to pi/2 rad; "
            f"got {lowest:g} and {highest:g}."
        )
    heights = machine.height - machine.r * np.sin([lowest, highest])
    joint = np.min(section.depth(np.zeros(2), heights))
    return min(float(joint), machine.offset) - arm_radius
