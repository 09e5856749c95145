"""Whose fault is which part of the wall's error: each source switched on alone."""

from collections.abc import Callable
from functools import partial

from ..arguments import checked
from ..motion.arm import Arm
from ..removal import Ground
from .both_axes import Loops, Plants
from .faults import (
    corner_fault,
    count_fault,
    encoder_fault,
    following_fault,
    knot_fault,
    pose_fault,
    ripple_fault,
    setpoint_fault,
    tangent_sphere_fault,
)
from .ground_faults import LoadedLaps, arm_fault, ground_fault, picks_fault
from .planning import Plan, check_unheld
from .pose import Pose

OF_PLAN = knot_fault, tangent_sphere_fault, corner_fault, setpoint_fault, count_fault, ripple_fault
OF_AXES = following_fault, encoder_fault


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
    plan : Plan
        What is to be done.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops.
    pose : Pose, optional
        Where the machine stands instead of where it should.
    arm : Arm, optional
        The masses on both joints, for two `Compressible` plants.
    ground : Ground, optional
        What pushes back, for two `Compressible` plants.
    say : function, optional
        Told which source is next.

    Returns
    -------
    faults : list of Fault
        Knots, projected chord, corners, setpoints, counts, feed ripple, following, encoder and, if
        asked for, both joints, the ground's mean force, its picks' ripple and pose. Their
        deviations across the path add up to that of all together, but for products: where the path
        turns a trailing axis cuts the corner, by more than its fault alone.

    Raises
    ------
    ValueError
        If the plan waits, or the loops have another tick, an integral or a dead band.

    Notes
    -----
    The ideal lap has the cutter's centre on the circuit at every tick of the plan.
    """
    check_unheld(plan)
    sources = fault_sources(plan, plant, loop, pose=pose, arm=arm, ground=ground)
    faults = []
    for number, source in enumerate(sources, start=1):
        if say is not None:
            say(f"budget: source {number} of {len(sources)}")
        faults.append(source())
    return faults


def fault_sources(plan, plant, loop, *, pose=None, arm=None, ground=None):
    """Return a function without arguments for each `Fault` of a `budget`, in its order.

    The arguments are those of `budget`: a `plan`, pairs for `plant` and `loop`; `pose`, `arm` and
    `ground` may be left out. Laps under loads that several ask for are run once.
    """
    sources = [partial(source, plan) for source in OF_PLAN]
    sources += [partial(source, plan, plant, loop) for source in OF_AXES]
    laps = LoadedLaps(plan, plant, loop)
    if arm is not None:
        sources.append(partial(arm_fault, plan, plant, loop, arm, laps=laps))
    if ground is not None:
        for source in (ground_fault, picks_fault):
            sources.append(partial(source, plan, plant, loop, ground, arm=arm, laps=laps))
    if pose is not None:
        sources.append(partial(pose_fault, plan, pose))
    return sources
