"""The hydraulic cylinders that turn a joint: lengths, displacements, strokes and oil volumes."""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import MOST, Angle, Length, Rule, Sign, bounded_array, checked
from ..kernels.compiled import root, sine

USUAL_R = 0.80  # m, the reference machine's arm, for which the study's sizes are given


def _joint_angles(name, value):
    """Return joint angles as a float or an array, after checking them."""
    # A single angle stays a float, by which `sine` tells how to compute.
    if type(value) is float and -MOST <= value <= MOST:
        return value
    return bounded_array(name, value)[()]


JointAngles = Annotated[ArrayLike, Rule("(...) float", _joint_angles, "rad")]


def check_stroke(angle, low, high, name="angle"):
    """Raise ValueError where a joint angle isn't from `low` to `high`, all in rad.

    The `name` is for the message. NaN is outside.
    """
    # In a simulation angles come one by one, and Python compares floats ten times as fast as numpy.
    if isinstance(angle, float):
        if low <= angle <= high:
            return
        first = angle
    else:
        outside = ~((low <= angle) & (angle <= high))
        if not outside.any():
            return
        first = angle[outside][0]
    raise ValueError(
        f"{name}: must lie within the stroke, {low:.4g} to {high:.4g} rad; got {first:.4g} rad."
    )


class Cylinders(NamedTuple):
    """A `Linkage` as plain numbers, for functions that simulations call many times a tick.

    Both lengths at the ends of the stroke are zero where nobody asks for volumes.
    """

    a: float
    b: float
    mounting: float
    sense: float
    pair: bool
    whole: float  # m^2, as in `Linkage.areas`
    ring: float
    shortest: float = 0.0
    longest: float = 0.0


def triangle(cylinders, angle, sense):
    """Return length and arm of the cylinder whose gamma is mounting + `sense` `angle`, in m."""
    gamma = cylinders.mounting + sense * angle
    a = cylinders.a
    b = cylinders.b
    # By the law of cosines, with a^2 + b^2 - 2 a b cos(gamma) as (a - b)^2 + 4 a b sin^2(gamma/2):
    # the difference would cancel where the triangle is nearly closed.
    half = sine(gamma / 2)
    length = root((a - b) * (a - b) + 4 * a * b * half * half)
    # The arm, at which the cylinder pushes, is the derivative of the length by the joint's angle.
    return length, sense * a * b * sine(gamma) / length


def side_flows(cylinders, angle, sense):
    """Return the displacements of one cylinder's two sides, in m^3/rad, and their volumes, in m^3.

    The first of each belongs to the side that drives the joint towards positive angles. `sense` is
    1 if the cylinder grows with the joint's `angle`, in rad, else -1.
    """
    length, arm = triangle(cylinders, angle, sense)
    arm = abs(arm)
    # The side without the rod pushes with the whole piston, the other with the ring about the rod.
    pushing = cylinders.whole * arm
    pulling = cylinders.ring * arm
    pushing_volume = cylinders.whole * (length - cylinders.shortest)
    pulling_volume = cylinders.ring * (cylinders.longest - length)
    if sense > 0:
        return pushing, pulling, pushing_volume, pulling_volume
    return pulling, pushing, pulling_volume, pushing_volume


def chambers(cylinders, angle):
    """Return displacements, in m^3/rad, and volumes, in m^3, of the plus and the minus side.

    They are those of `cylinders` at an `angle`, in rad, within the stroke; nothing is checked.
    """
    plus, minus, plus_volume, minus_volume = side_flows(cylinders, angle, cylinders.sense)
    if cylinders.pair:  # the mirrored cylinder adds a chamber to either side
        first, second, first_volume, second_volume = side_flows(cylinders, angle, -cylinders.sense)
        plus = plus + first
        minus = minus + second
        plus_volume = plus_volume + first_volume
        minus_volume = minus_volume + second_volume
    return plus, minus, plus_volume, minus_volume


@dataclass(frozen=True)
@checked
class Linkage:
    """A cylinder between frame and arm, or a push-pull pair of them, that turns one joint.

    Parameters
    ----------
    a, b : float
        Distances of the cylinder's two pivots from the joint, in m.
    mounting : float
        Angle gamma between the lines to both pivots at joint angle 0, in rad.
    sense : {1, -1}
        Whether gamma grows (1) or shrinks (-1) as the joint angle grows.
    bore, rod : float
        Diameters, in m; the rod is thinner than the bore.
    dead_length : float
        Length of the cylinder that isn't stroke, such as of piston, ends and eyes, in m.
    pair : bool
        Whether a second, mirrored cylinder is cross-connected with the first.

    Raises
    ------
    ValueError
        If a size isn't above zero, an angle isn't between 0 and pi, the rod isn't thinner, or
        `sense` is another number.

    Notes
    -----
    The document names hydraulic axes but gives no linkage; this one is the study's assumption.
    Joint angles are floats or arrays, in rad. The plus side is that of the chambers which drive the
    joint towards positive angles, the minus side is the other.

    Examples
    --------
    >>> lever = Linkage(0.45, 0.11, 1.3, -1, 0.05, 0.028, 0.2)
    >>> round(lever.length(0.0), 4)
    0.4337
    """

    a: Length
    b: Length
    mounting: Angle
    sense: Sign
    bore: Length
    rod: Length
    dead_length: Length
    pair: bool = False

    def __post_init__(self):
        if not 0 < self.mounting < np.pi:
            raise ValueError(f"mounting: must lie between 0 and pi rad; got {self.mounting!r}.")
        if self.rod >= self.bore:
            raise ValueError(
                f"rod: must be thinner than the bore {self.bore:g} m; got {self.rod:g} m."
            )

    @property
    def areas(self):
        """Return the areas of the whole piston and of the ring about the rod, in m^2."""
        whole = math.pi / 4 * self.bore**2
        return whole, whole - math.pi / 4 * self.rod**2

    @checked
    def length(self, angle: JointAngles):
        """Return the cylinder's length, in m, at joint angles."""
        return triangle(self, angle, self.sense)[0]

    @checked
    def displacements(self, angle: JointAngles):
        """Return the oil displaced on the plus and the minus side, in m^3/rad, at joint angles."""
        return chambers(self._numbers(0.0, 0.0), angle)[:2]

    @checked
    def volumes(self, angle: JointAngles, low: Angle, high: Angle):
        """Return the oil volumes of the plus and the minus side, in m^3, at joint angles.

        `low` and `high` are the angles at the ends of the stroke. Hoses and ports aren't counted.

        Raises
        ------
        ValueError
            If an angle isn't within the stroke, where a volume would be below zero.
        """
        check_stroke(angle, low, high)
        return chambers(self.cylinders(low, high), angle)[2:]

    @checked
    def cylinders(self, low: Angle, high: Angle):
        """Return the `Cylinders` of a stroke from angle `low` to `high`, in rad."""
        # The length is monotonic between both ends of the stroke, see `check`.
        lengths = [triangle(self, end, self.sense)[0] for end in (low, high)]
        return self._numbers(min(lengths), max(lengths))

    def _numbers(self, shortest, longest):
        """Return the `Cylinders` with these lengths at the ends of the stroke, in m."""
        pivots = self.a, self.b, self.mounting, float(self.sense), self.pair
        return Cylinders(*pivots, *self.areas, shortest, longest)

    @checked
    def check(self, low: Angle, high: Angle):
        """Raise ValueError if the linkage doesn't allow joint angles from `low` to `high`.

        The triangle must neither close nor stretch, and the shortest length must hold the stroke
        and the dead length. A pair needs limits equally far to either side.
        """
        gamma = sorted(self.mounting + self.sense * angle for angle in (low, high))
        if not (low < high and 0 < gamma[0] and gamma[1] < np.pi):
            raise ValueError(
                "stroke: between the limits gamma must stay inside 0 to 180 deg; "
                f"got {math.degrees(gamma[0]):.4g} to {math.degrees(gamma[1]):.4g} deg."
            )
        if self.pair and not math.isclose(-low, high):
            raise ValueError(
                f"low: a pair needs limits as far to either side; got {low:g} rad and {high:g} rad."
            )
        # gamma stays between 0 and a half turn, where the length only grows with it.
        shortest, longest = sorted((self.length(low), self.length(high)))
        if longest - shortest + self.dead_length > shortest:
            raise ValueError(
                f"stroke: {longest - shortest:.3f} m and the dead length {self.dead_length:.3f} m "
                f"must fit into the shortest cylinder; got {shortest:.3f} m."
            )


@checked
def usual_linkages(R: Length):
    """Return the study's linkages of the joints theta and phi for an arm of length `R`, in m.

    Their sizes are given for the reference machine, R = 0.80 m, and grow with R. One cylinder lifts
    the arm, and a pair swings it. `Linkage.check` says whether a machine's joint limits suit them.

    Examples
    --------
    >>> lift, swing = usual_linkages(0.80)
    >>> round(lift.length(0.0), 4)
    0.4347
    >>> lift.rod, swing.rod
    (0.028, 0.022)
    """
    scale = R / USUAL_R
    lift = Linkage(
        a=0.45 * scale,
        b=0.11 * scale,
        mounting=np.radians(75),
        sense=-1,
        bore=0.050 * scale,
        rod=0.028 * scale,
        dead_length=0.20 * scale,
    )
    swing = Linkage(
        a=0.30 * scale,
        b=0.07 * scale,
        mounting=np.radians(90),
        sense=1,
        pair=True,
        bore=0.040 * scale,
        rod=0.022 * scale,
        dead_length=0.16 * scale,
    )
    return lift, swing
