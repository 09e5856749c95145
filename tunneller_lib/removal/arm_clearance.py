"""How far the arm and the cutter keep from the wall that isn't cut yet, in closed form."""

from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Length0, Lengths, Points, checked
from ..surfaces import Machine, Section


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
