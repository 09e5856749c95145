"""The wall's error by its sources, each switched on alone.

A source is one row of `SOURCES` and one function of a `Case`, which returns by how much the wall is
off and what a closed form says.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..arguments import checked, shown
from ..motion import Compressible
from ..motion.arm import Arm
from ..removal import Ground
from . import faults, loads
from .both_axes import Loops, Plants, check_linear, check_ticks
from .planning import Plan
from .pose import Pose

HALF = 0.4, 0.6  # share of a fault that is left if it is called halved
TRIES = 2  # of a factor; the second follows from the power that the first one showed
FARTHEST = 8  # greatest factor, or divisor, that is worth advising
UNCHANGED = 0.97  # share that is left if a change doesn't matter to a fault


@dataclass(frozen=True, eq=False)
class Fault:
    """One source of error, alone.

    Parameters
    ----------
    source : str
        The source that is switched on; everything else is ideal.
    kind : {"chosen", "machine", "ground", "paper"}
        The origin of the error.
    deviation : (ticks + 1,) float
        Overbreak at each tick of a lap, in m, negative for underbreak; of an error `along` the
        path, by how much the set-values are ahead.
    closed : float or None
        The closed form, in m; None if there is none.
    measure : {"largest", "rms"}
        The measure of the deviation that the closed form gives.
    remedies : tuple of (str, float)
        What may halve the error, the likeliest first, and the factors with which `halving` begins.
    along : bool
        Whether the error is along the path, not across it.
    """

    source: str
    kind: str
    deviation: np.ndarray
    closed: float | None
    measure: str = "largest"
    remedies: tuple = ()
    along: bool = False

    @property
    def over(self):
        """Return the greatest overbreak, in m, at least 0."""
        return max(0.0, float(self.deviation.max()))

    @property
    def under(self):
        """Return the greatest underbreak, in m, at least 0."""
        return max(0.0, float(-self.deviation.min()))

    @property
    def rms(self):
        """Return the root mean square over the lap, in m."""
        return float(np.sqrt(np.mean(self.deviation**2)))

    @property
    def measured(self):
        """Return the measure of the deviation that `closed` is compared with, in m."""
        return self.rms if self.measure == "rms" else max(self.over, self.under)

    @property
    def ratio(self):
        """Return `measured` over `closed`; None if there is no closed form, or it is zero."""
        return self.measured / self.closed if self.closed else None


class Source(NamedTuple):
    """A source of error, with the function that switches it on alone.

    Parameters
    ----------
    kind : {"chosen", "machine", "ground", "paper"}
        The origin of the error.
    alone : callable
        Function of a `Case` that returns the fault's deviation and its closed form.
    remedies : tuple of (str, float)
        As of a `Fault`.
    asked : callable
        Function of a `Case` that returns whether it has all that the source needs.
    check : callable
        Function of a `Case` that raises ValueError if the closed form doesn't hold.
    measure : {"largest", "rms"}
        As of a `Fault`.
    along : bool
        As of a `Fault`.
    """

    kind: str
    alone: Callable
    remedies: tuple
    asked: Callable = lambda case: True
    check: Callable = lambda case: None
    measure: str = "largest"
    along: bool = False


def _having(*names):
    return lambda case: all(getattr(case, name) is not None for name in names)


def _on(path):
    return lambda case: case.plan.path == f"{path} chord"


def _unheld(case):
    if np.any(np.diff(case.plan.s[:-1]) <= 0):
        raise ValueError(
            "plan: must not wait between setpoints, since its path is compared; got one that does."
        )


def _linear(case):
    check_ticks(case.plan, case.loop)
    check_linear(case.loop)


def _oily(case):
    _linear(case)
    if not all(isinstance(one, Compressible) for one in case.plant):
        raise ValueError(
            "plant: must be of class Compressible, which alone feels a load; got "
            f"{' and '.join(type(one).__name__ for one in case.plant)}."
        )


AXES = _having("plant", "loop")
ARM = _having("plant", "loop", "arm")
GROUND = _having("plant", "loop", "ground")
# A load of the ground goes with the feed's square: through the force and through the speed.
SLOWER = ("power", 2**-0.5), ("feed", 2**-0.5)
GAIN = ("gain", 2.0)
RIPPLE = ("step", 2**-0.5), ("acceleration", 1 / 2)
# A tolerance goes with the square of the chords' length, the error of paths with its third or
# fourth power. Corners may miss their knots by a share of the tolerance.
SECOND, THIRD, FOURTH = ((("tolerance", 2 ** (-2 / power)),) for power in (2, 3, 4))
SOURCES = {
    "knots": Source("chosen", faults.knot_fault, SECOND, check=_unheld),
    "projected chord": Source("paper", faults.projected_fault, THIRD, _on("projected"), _unheld),
    "corrected chord": Source("paper", faults.corrected_fault, FOURTH, _on("corrected"), _unheld),
    "corners": Source("chosen", faults.corner_fault, SECOND, check=_unheld),
    "setpoints": Source("machine", faults.setpoint_fault, (("step", 2**-0.5),)),
    "counts": Source("machine", faults.count_fault, (("count", 1 / 2),), measure="rms"),
    "feed ripple": Source("machine", faults.ripple_fault, RIPPLE, check=_unheld, along=True),
    "following": Source("machine", faults.following_fault, (GAIN, *SLOWER[::-1]), AXES, _linear),
    "encoder": Source("machine", faults.encoder_fault, (("encoder", 1 / 2),), AXES, _linear, "rms"),
    "both joints": Source("machine", loads.arm_fault, (GAIN,), ARM, _oily),
    "ground, mean": Source("ground", loads.ground_fault, (*SLOWER, GAIN), GROUND, _oily),
    "ground, picks": Source("ground", loads.picks_fault, (*SLOWER, GAIN), GROUND, _oily),
    "pose": Source("chosen", faults.pose_fault, (("pose", 1 / 2),), _having("pose")),
}


@dataclass(frozen=True, eq=False)
@checked
class Case:
    """The case of an error budget: a plan, the axes that run it, and their surroundings.

    Parameters
    ----------
    plan : Plan
        The plan to run.
    plant : Plant or a pair of them, optional
        The axes theta and phi.
    loop : Loop or a pair of them, optional
        Their position loops, with the plan's tick and without integral.
    pose : Pose, optional
        By how much the machine stands elsewhere than planned.
    arm : Arm, optional
        The masses on both joints, for two `Compressible` plants.
    ground : Ground, optional
        The ground that pushes back on two `Compressible` plants.
    """

    plan: Plan
    plant: Plants | None = None
    loop: Loops | None = None
    pose: Pose | None = None
    arm: Arm | None = None
    ground: Ground | None = None

    @property
    def sources(self):
        """Return the names of the `SOURCES` for which the case has all that they need."""
        return [name for name, source in SOURCES.items() if source.asked(self)]

    @checked
    def fault(self, source: Literal[tuple(SOURCES)]):
        """Return the `Fault` of a source, switched on alone.

        Raises
        ------
        ValueError
            If the case lacks what the source needs; for knots, path or feed, if the plan waits; for
            axes, if their tick isn't the plan's or they have an integral; for loads, if the axes
            aren't `Compressible`.
        """
        about = SOURCES[source]
        if not about.asked(self):
            raise ValueError(
                f"source: must be one of those for which the case is complete, "
                f"{', '.join(self.sources)}; got {source!r}."
            )
        about.check(self)
        deviation, closed = about.alone(self)
        told = about.measure, about.remedies, about.along
        return Fault(source, about.kind, deviation, closed, *told)


@checked
def budget(
    plan: Plan,
    plant: Plants,
    loop: Loops,
    *,
    pose: Pose | None = None,
    arm: Arm | None = None,
    ground: Ground | None = None,
    say: Callable[[str], object] | None = None,
):
    """Return the faults of a planned lap, each switched on alone.

    Parameters
    ----------
    plan, plant, loop, pose, arm, ground
        As of a `Case`: a `Plan`, axes and their loops and, if given, a `Pose`, an `Arm` and a
        `Ground`.
    say : function, optional
        Called with a sentence about the next source.

    Returns
    -------
    faults : list of Fault
        Knots, the path between them, corners, setpoints, counts, feed ripple, following, encoder
        and, if given, both joints, the ground's mean force, its picks' ripple and pose. To first
        order their deviations across the path add up to the deviation of all together; where the
        path turns, a trailing axis cuts the corner by more than its fault alone.

    Raises
    ------
    ValueError
        As by `Case.fault`.

    Notes
    -----
    In the ideal lap the cutter's centre is on the circuit at every tick of the plan.
    """
    case = Case(plan, plant, loop, pose, arm, ground)
    found = []
    for number, source in enumerate(case.sources, start=1):
        if say is not None:
            say(f"budget: source {number} of {len(case.sources)}")
        found.append(case.fault(source))
    return found


class Remedy(NamedTuple):
    """A change that halves a fault, as a simulation confirms.

    Parameters
    ----------
    what : str
        The option of the plan, of its limits or of the loops that is changed.
    factor : float
        The factor by which it is multiplied.
    left : float
        The share of the fault that is left.
    """

    what: str
    factor: float
    left: float


@checked
def halving(fault: Fault, again: Callable[[str, float], object]):
    """Return the first of a fault's remedies that halves it in another simulation.

    Parameters
    ----------
    fault : Fault
        One source of error, alone.
    again : function
        (what, factor) -> `Fault` of the same source, with one of its ``remedies`` multiplied by a
        factor; None if that isn't possible.

    Returns
    -------
    remedy : Remedy or None
        The remedy, with a factor of two decimals; None if none leaves 0.4 to 0.6 of the fault.
    """
    for what, factor in fault.remedies if fault.measured else ():
        for _ in range(TRIES):
            factor = round(factor, 2)
            if not 1 / FARTHEST <= factor <= FARTHEST:
                break
            run = again(what, factor)
            if run is None:
                break
            if not isinstance(run, Fault):
                raise ValueError(f"again: must return a Fault or None; got {shown(run)}.")
            left = run.measured / fault.measured
            if HALF[0] <= left <= HALF[1]:
                return Remedy(what, factor, left)
            if not 0 < left < UNCHANGED:
                break
            # If the fault is a power of what is changed, this factor leaves a half.
            factor **= math.log(1 / 2) / math.log(left)
    return None
