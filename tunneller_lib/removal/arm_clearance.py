"""How far the arm, the cutter and other solids keep from the wall that isn't cut yet."""

from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Length0, Lengths, Points, checked
from ..surfaces import Box, Frustum, Machine, Rod, RoundedDisc, Section
from ..surfaces.touching import outline, touches_of_planes

ANGLES = 360  # from y, at which a solid's outermost points are looked at first
THIRDS = 40  # after which an angle is known to its half of the digits, and a least depth to all


class Clearance(NamedTuple):
    """What is left between arm and wall over a circuit, and how deep the cutter goes.

    Parameters
    ----------
    arm, cutter : float
        Least distances to the wall, in m; negative in the ground.
    """

    arm: float
    cutter: float


@checked
def rod_clearance(section: Section, a: Points, b: Points, radius: Lengths):
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
    if not np.all(radius >= 0):
        raise ValueError(f"radius: must not be below zero; got {np.min(radius):g} m.")
    depths = [section.depth(end[..., 1], end[..., 2]) for end in (a, b)]
    return np.minimum(*depths) - radius


@checked
def solid_clearance(section: Section, solid: Rod | Frustum | Box | RoundedDisc):
    """Return how far a solid stays inside a section: a cutter's part, a piece of the machine.

    Parameters
    ----------
    section : Section
        The tunnel's, which is convex.
    solid : Rod, Frustum, Box or RoundedDisc
        In the frame of the tunnel, in any pose.

    Returns
    -------
    clearance : float
        Least distance to the wall, in m; if negative, how deep the solid is in the ground;
        ``inf`` for an empty one.

    Notes
    -----
    Both are convex. Across the wall, in the plane x = 0, the least depth is that of the point where
    the solid reaches farthest along the wall's normal there, so that one angle is looked for. The
    points are those at which planes touch the solid, as in `meet_facets`. Those at `ANGLES` angles
    tell where the depth has valleys, whose lowest points are found by thirds.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Egg
    >>> capsule = Rod((0, 0, -0.4), (0.8, 0.3, 0), 0.1, ends="round")
    >>> round(solid_clearance(Egg(0.5), capsule), 12)
    0.1
    """
    body = outline(solid)
    angle = 2 * np.pi / ANGLES * np.arange(ANGLES)
    depths = _depths(section, body, angle)
    # Each point's valleys of the depth, between the neighbours of a sample.
    valley = (depths < np.roll(depths, 1, axis=1)) & (depths <= np.roll(depths, -1, axis=1))
    which, sample = np.nonzero(valley)
    if not len(which):
        return float(depths.min(initial=np.inf))
    pick = which, np.arange(len(which))
    low, high = angle[sample] - angle[1], angle[sample] + angle[1]
    for _ in range(THIRDS):
        one, other = low + (high - low) / 3, high - (high - low) / 3
        nearer = _depths(section, body, one)[pick] < _depths(section, body, other)[pick]
        low, high = np.where(nearer, low, one), np.where(nearer, other, high)
    return float(min(depths.min(), _depths(section, body, low)[pick].min()))


def _depths(section, body, angle):
    """Return depths (k, n) of the k points of an `Outline` that planes touch, at angles (n,)."""
    normal = np.stack([np.zeros(len(angle)), np.cos(angle), np.sin(angle)])
    points = [body.start[:, None] + point for point in touches_of_planes(body, normal)]
    if not points:
        return np.empty((0, len(angle)))
    _, y, z = np.moveaxis(points, 1, 0)
    return section.depth(y, z)


@checked
def circuit_clearance(
    machine: Machine, section: Section, lowest: Angle, highest: Angle, arm_radius: Length0
):
    """Return the clearance over a whole circuit of the aligned machine, in closed form.

    Parameters
    ----------
    machine : Machine
        Sizes, cutter and height.
    section : Section
        The tunnel's, on whose offset the cutter's centre moves.
    lowest, highest : float
        Range of theta over the circuit, in rad.
    arm_radius : float
        Of the round-ended rod about the arm, in m.

    Returns
    -------
    clearance : Clearance
        Of the arm; of the cutter it is less than zero by the depth of cut.

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
    arm = min(float(joint), machine.offset) - arm_radius
    return Clearance(arm, machine.offset - machine.cutter_radius)
