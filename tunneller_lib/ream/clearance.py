"""How far the machine's parts keep from the intact wall."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arguments import Length0, checked
from ..paths.circuit import Circuit
from ..removal.arm_clearance import rod_clearance, solid_clearance
from .pose import Pose

PLACES = 721  # of the circuit, at which the parts are looked at
SMALLER = 0.8, 0.6, 0.4, 0.2  # times a size of the body, as they are tried
BODY_SIZES = {"holder": ("holder_radius", "holder_length"), "box": ("width", "high", "low")}
SAME = 1e-12  # m, within which clearances are taken as equal


class PartClearance(NamedTuple):
    """The clearance between a part of the machine and the wall.

    Parameters
    ----------
    name : str
        "arm", "holder", "box" or "cutter".
    least : float
        Least clearance over the circuit, in m; negative in the ground.
    place : float or None
        Arc length along the offset section at which it is least, in m; None for a part that
        doesn't move.
    """

    name: str
    least: float
    place: float | None

    @property
    def collides(self):
        """Whether the part is in the wall and isn't the cutter."""
        return self.least < 0 and self.name != "cutter"

    @property
    def depth_in_wall(self):
        """Return the end of a sentence that says how deep the part is in the wall, and where."""
        where = "" if self.place is None else f" {self.place:.3f} m along the circuit"
        where = where if self.place else " at the begin of the circuit" if where else ""
        return f"is {-self.least:.2g} m in the wall{where}"


@checked
def part_clearances(circuit: Circuit, arm_radius: Length0, *, pose: Pose | None = None):
    """Return how far the parts of a machine keep from the intact wall.

    Parameters
    ----------
    circuit : Circuit
        The circuit, with machine, section and set-up.
    arm_radius : float
        Radius of a round-ended rod that holds the arm, from the tangential joint to the cutter's
        centre, in m.
    pose : Pose, optional
        By how much the machine stands elsewhere than planned.

    Returns
    -------
    clearances : list of PartClearance
        The arm's; those of the holder and the box of the machine's `Body`, if it has them; and
        that of the cutter's ball, which is as deep in the wall as it cuts.

    Notes
    -----
    The machine steps back along the tunnel, so one lap's clearances are those of all laps.

    Examples
    --------
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> arm, cutter = part_clearances(cutting_circuit(REFERENCE_MACHINE, Egg(0.5)), 0.1)
    >>> round(arm.least, 9), round(cutter.least, 9)
    (0.08, -0.02)
    """
    machine = circuit.machine
    section = circuit.section
    s = np.linspace(0, circuit.profile.perimeter, PLACES)
    position = circuit.position(s)
    joint, centre = circuit.arm(position)
    arm_axes = circuit.arm_axes(position)
    axes = circuit.axes
    foot = circuit.in_tunnel(np.zeros(3))
    if pose is not None:
        joint, centre, foot = (pose.moved(point, foot) for point in (joint, centre, foot))
        turn = replace(pose, y=0.0, z=0.0).moved(np.eye(3), np.zeros(3)).T
        arm_axes = turn @ arm_axes
        axes = turn @ axes
    depths = {"arm": rod_clearance(section, joint, centre, arm_radius)}
    if machine.body is not None:
        if machine.body.has_holder:
            depths["holder"] = solid_clearance(
                section, machine.body.holder, turn=arm_axes, place=centre
            )
        depths["box"] = solid_clearance(section, machine.body.box, turn=axes, place=foot)
    depths["cutter"] = rod_clearance(section, centre, centre, machine.cutter_radius)
    return [_least(name, depth, s) for name, depth in depths.items()]


def clear_size(circuit, arm_radius, part):
    """Return a size, its key and its value in m, with which a part leaves the wall; or None.

    Parameters
    ----------
    circuit : Circuit
        The circuit.
    arm_radius : float
        As of `part_clearances`.
    part : PartClearance
        A part in the wall.
    """
    machine = circuit.machine
    if part.name == "arm":
        thinner = float(f"{0.97 * (arm_radius + part.least):.2g}")
        return ("arm_radius", thinner) if thinner > 0 else None
    for key in BODY_SIZES[part.name]:
        for share in SMALLER:
            size = float(f"{share * getattr(machine.body, key):.2g}")
            try:
                body = replace(machine.body, **{key: size})
                if part.name == "box":  # whose clearance doesn't take a lap of the holder's
                    body = replace(body, holder_radius=0.0)
            except ValueError:  # the underside above the top
                break
            other = replace(circuit, machine=replace(machine, body=body))
            if not any(p.collides for p in part_clearances(other, 0.0) if p.name == part.name):
                return key, size
    return None


def _least(name, depth, s):
    """Return the `PartClearance` of depths at arc lengths s, or of one for a part at rest.

    Examples
    --------
    The place is the first one, but for rounding; a tenth of a nanometre is more than that.

    >>> s = np.array([0.0, 1.0, 2.0])
    >>> [_least("arm", np.array([0.5, 0.1 + more, 0.1]), s).place for more in (1e-15, 1e-10)]
    [1.0, 2.0]
    """
    if np.ndim(depth) == 0:
        return PartClearance(name, float(depth), None)
    # The first of those that differ by rounding only, as all of an aligned arm's do.
    worst = int(np.argmax(depth <= depth.min() + SAME))
    return PartClearance(name, float(depth.min()), float(s[worst]))
