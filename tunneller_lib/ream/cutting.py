"""A planned cut run through controller and axes, and the wall that the cutter leaves."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arguments import Each, Length, Whole, checked
from ..motion import follow
from ..motion.arm import Arm
from ..motion.servo import Track
from ..motion.stability import stable_gains
from ..motion.tasks import Task, hand_over
from ..removal import DexelGrid, Ground
from ..removal.dexel import Shape
from .both_axes import Loops, Plants, check_ticks
from .face import BESIDE, TOGETHER, Face
from .planning import Plan, Run
from .pose import Pose
from .wall import intact_wall, overbreak, standing

CHUNK = 48  # ticks after which the removed volume is noted
SILENCE = 5.0  # s, the shortest time between two reports of progress within a lap
Cost = Whole(1, 2**31 - 1)


@dataclass(frozen=True, eq=False)
class Cut:
    """The result of a simulated cut.

    Parameters
    ----------
    plan : Plan
        The plan that was run.
    track : Track or None
        The joints' motion in the laps; None if positions were given, as to `carve`.
    centres : (ticks + 1, 3) float
        The cutter's centre in the tunnel's frame, in m, after each tick of all laps.
    wall : DexelGrid
        The ground that stands at the end.
    noted : (k + 1,) int
        Ticks at which the removed volume was noted: at the ends of laps, and at some between.
    removed : (k,) float
        Volumes removed between those ticks, in m^3.
    before, after : (j, 3) float
        The cutter's centres on the entry and on the exit; none if only laps were carved.
    plunged : float
        Volume removed on the entry and the exit together, in m^3.
    force : (ticks,) float or None
        The ground's force against the cutter's way, its mean over each tick, in N; None if the
        ground doesn't push.
    """

    plan: Plan
    track: Track | None
    centres: np.ndarray
    wall: DexelGrid
    noted: np.ndarray
    removed: np.ndarray
    before: np.ndarray
    after: np.ndarray
    plunged: float
    force: np.ndarray | None = None

    @property
    def ends(self):
        """Return the least and the greatest x (2,) of the tunnel that the laps reach, in m."""
        return _ends(self.centres, self.plan.circuit.machine.cutter_radius)

    @property
    def deviation(self):
        """Return how far (ticks + 1,) the cutter's centre is outside the offset section, in m.

        This is the overbreak that it leaves there, or the underbreak where it is negative.
        """
        return -self.plan.circuit.profile.depth(*self.centres[:, 1:].T)

    @property
    def lap_deviations(self):
        """Return the `deviation` (laps, ticks + 1) of each lap at the ticks of its plan, in m."""
        ticks = int(self.plan.ticks.sum())
        return self.deviation[ticks * np.arange(self.plan.laps)[:, None] + np.arange(ticks + 1)]

    @cached_property
    def overbreak(self):
        """Return the overbreak of the wall (n, m), in m, see `wall.overbreak`."""
        return overbreak(self.wall, self.plan.circuit)

    @property
    def around(self):
        """Return the greatest overbreak (m,) at each ray's angle, in m: the grooves' bottom."""
        return self.overbreak.max(axis=0)

    @property
    def reamed(self):
        """Return which rays (n, m) lie between the bottoms of the first and of the last groove."""
        circuit = self.plan.circuit
        lines = self.wall.lines
        # The place along the tunnel at which the first lap's groove is deepest, by the angle.
        s = np.linspace(0, circuit.profile.perimeter, 2000)
        touch = circuit.profile.point(s) + circuit.machine.cutter_radius * circuit.profile.normal(s)
        angle = np.arctan2(touch[:, 1], touch[:, 0])
        x = circuit.in_tunnel(circuit.point(s))[:, 0]
        first = np.interp(np.arctan2(lines.sin, lines.cos), angle, x, period=2 * np.pi)
        last = first - self.plan.advance * (self.plan.laps - 1)
        return (last <= lines.x[:, None]) & (lines.x[:, None] <= first)

    @property
    def rate(self):
        """Return the mean rate of removal (k,) between the ticks `noted`, in m^3/s."""
        return self.removed / (self.plan.tick * np.diff(self.noted))

    @property
    def lap_volumes(self):
        """Return the volume (laps,) removed in each lap and in the step before it, in m^3."""
        every = int(self.plan.ticks.sum())
        stepping = len(self.plan.back) - 1
        first = (self.noted[:-1] + stepping) % every == 0
        first &= self.noted[:-1] + stepping < every * self.plan.laps  # no lap follows the last one
        first[0] = True
        return np.add.reduceat(self.removed, np.flatnonzero(first))


@checked
def simulate(
    plan: Plan,
    plant: Plants,
    loop: Loops,
    *,
    pose: Pose | None = None,
    shape: Shape = (400, 720),
    thickness: Length = 0.1,
    arm: Arm | None = None,
    ground: Ground | None = None,
    say: Callable[[str], object] | None = None,
):
    """Return the `Cut` of a plan whose set-values the axes follow while the ball cuts the wall.

    Parameters
    ----------
    plan : Plan
        The plan to run.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick.
    pose : Pose, optional
        By how much the machine stands elsewhere than planned.
    shape : (2,) int
        Numbers of rays of the wall along the tunnel and around it.
    thickness : float
        Thickness of the modelled ground, in m.
    arm : Arm, optional
        The masses on both joints, for two `Compressible` plants; see `follow`.
    ground : Ground, optional
        The ground that pushes back on two `Compressible` plants; by default nothing pushes.
    say : function, optional
        Called with a sentence about the progress, at least after each lap.

    Returns
    -------
    cut : Cut
        Track of the joints, centres of the cutter, the wall and the removed volumes.

    Raises
    ------
    ValueError
        If a loop is unstable, or the cutter leaves the modelled ground.
    """
    check_ticks(plan, loop)
    setvalues, slopes = whole_run(plan)
    first = int(plan.entry.ticks.sum())
    last = first + plan.laps * int(plan.ticks.sum())
    face = None
    if ground is not None:
        report = _progress(plan, say, first)
        face = Face(plan, ground, setvalues, first, shape, thickness, pose=pose, say=report)
    track = follow(plant, loop, setvalues, slopes=slopes, arm=arm, push=face)
    for joint, name in enumerate(("theta", "phi")):
        if track.stable[joint] is False:
            raise ValueError(_unstable(name, plant[joint], loop[joint], setvalues[:, joint]))
    ends = track.position[: first + 1], track.position[last:]
    laps = track.between(first, last)
    if face is None:
        return replace(_carved(plan, laps.position, ends, pose, shape, thickness, say), track=laps)
    centres, before, after = _centres(plan, laps.position, ends, pose)
    radius = plan.circuit.machine.cutter_radius
    start, stop = _ends(np.concatenate([before, centres, after]), radius)
    if start < face.ends[0] or stop > face.ends[1]:
        raise ValueError(
            f"ground: must hold the cutter back by less than {BESIDE:g} m along the tunnel, since "
            "no ground is modelled beyond."
        )
    standing(face.wall)  # raises if a ray is cut through
    noted = _noted(plan)
    removed = np.add.reduceat(face.removed[first:last], noted[:-1])
    plunged = float(face.removed[:first].sum() + face.removed[last:].sum())
    force = face.force[first:last]
    return Cut(plan, laps, centres, face.wall, noted, removed, before, after, plunged, force)


def _unstable(name, plant, loop, reached):
    """Return the sentence that refuses an unstable loop, with the gains at which it is stable."""
    low, high = stable_gains(plant, loop, np.linspace(reached.min(), reached.max(), 5))
    span = f"must be from {low:.3g} to {high:.3g} 1/s" if low < high else "is never small enough"
    return (
        f"loop: must be stable; at its tick and integral {name}'s gain {span}; got "
        f"{loop.gain:g} 1/s."
    )


def whole_run(plan):
    """Return the set-values (n + 1, 2) and slopes (n, 2) of entry, laps and exit in a row."""
    # Each run ends where the next begins, and the tick between them counts once.
    runs = [plan.entry, *[plan] * plan.laps, plan.leave]
    setvalues = [run.setvalues for run in runs]
    return (
        np.concatenate([setvalues[0][:1], *(values[1:] for values in setvalues)]),
        np.concatenate([run.slopes for run in runs]),
    )


@checked
def carve(
    plan: Plan,
    position: Run,
    *,
    pose: Pose | None = None,
    shape: Shape = (400, 720),
    thickness: Length = 0.1,
    say: Callable[[str], object] | None = None,
):
    """Return the `Cut` of joints that pass exactly through given positions.

    Parameters
    ----------
    plan : Plan
        The plan, for its machine, section, laps and advance.
    position : (n, 2) float
        Joint positions at every tick of all laps, or of one lap that is repeated, in rad.
    pose, shape, thickness, say
        As for `simulate`: a `Pose`, two numbers of rays, a length in m and a function.

    Returns
    -------
    cut : Cut
        Without a ``track``.

    Raises
    ------
    ValueError
        If the positions aren't those of one lap or of all, or the cutter leaves the modelled
        ground.
    """
    ticks = int(plan.ticks.sum())
    if position.shape == (ticks + 1, 2):
        position = np.concatenate([position[:1], np.tile(position[1:], (plan.laps, 1))])
    if position.shape != (ticks * plan.laps + 1, 2):
        raise ValueError(
            f"position: must be ({ticks + 1}, 2) for one lap or ({ticks * plan.laps + 1}, 2) for "
            f"all; got {position.shape}."
        )
    ends = position[:0], position[:0]
    return _carved(plan, position, ends, pose, shape, thickness, say)


def _carved(plan, position, ends, pose, shape, thickness, say):
    """Return the `Cut` of the positions in all laps and of the `ends` before and after them."""
    centres, before, after = _centres(plan, position, ends, pose)
    reach = plan.circuit.machine.cutter_radius
    start, stop = _ends(np.concatenate([before, centres, after]), reach)
    wall = intact_wall(plan.circuit, start, stop, shape, thickness=thickness)
    noted = _noted(plan)
    plunged = wall.cut_path(before, reach) if len(before) else 0.0
    report = _progress(plan, say)
    volumes = []
    for a in range(0, noted[-1], TOGETHER):
        volumes.append(wall.cut_moves(centres[a : a + TOGETHER + 1], reach))
        report(min(a + TOGETHER, noted[-1]))
    removed = np.add.reduceat(np.concatenate(volumes), noted[:-1])
    plunged += wall.cut_path(after, reach) if len(after) else 0.0
    standing(wall)  # raises if a ray is cut through
    return Cut(plan, None, centres, wall, noted, removed, before, after, plunged)


def _centres(plan, position, ends, pose):
    """Return the cutter's centres in all laps, on the entry and on the exit."""
    centres = plan.centres(position, pose=pose)
    before = plan.centres(ends[0], pose=pose)
    after = plan.centres(ends[1], pose=pose) - [plan.advance * (plan.laps - 1), 0.0, 0.0]
    return centres, before, after


def _noted(plan):
    """Return the ticks (k + 1,) of all laps at which the removed volume is noted."""
    # Every lap and every step between laps ends at one of them.
    ticks = int(plan.ticks.sum())
    within = np.union1d(np.arange(0, ticks, CHUNK), [ticks - len(plan.back) + 1])
    starts = ticks * np.arange(plan.laps)
    return np.append(np.add.outer(starts, within[within < ticks]).ravel(), ticks * plan.laps)


def _progress(plan, say, first=0):
    """Return a function that reports at ticks of a run whose first lap begins at tick `first`."""
    lap = int(plan.ticks.sum())
    said = time.monotonic()

    def cut_to(tick):
        nonlocal said
        done = tick - first
        within = done % lap
        if say is None or not 0 < done <= lap * plan.laps:
            return
        if within and time.monotonic() - said < SILENCE:
            return
        said = time.monotonic()
        share = f", {100 * within // lap} % of it" if within else ""
        say(f"cutting: lap {(done - 1) // lap + 1} of {plan.laps}{share}")

    return cut_to


def _ends(centres, reach):
    """Return the least and the greatest x that a cutter of radius `reach` touches, in m."""
    x = centres[:, 0]
    return float(x.min()) - reach, float(x.max()) + reach


@checked
def starved(plan: Plan, tasks: Each(Task), cost: Cost):
    """Return the `Plan` as it runs when the slow task is late and the last set-value is held.

    Parameters
    ----------
    plan : Plan
        The plan to run.
    tasks : list of Task
        The controller's tasks, in microseconds; the first, with the plan's tick, interpolates.
    cost : int
        Processor time that the preparation of a setpoint takes, in microseconds.

    Returns
    -------
    plan : Plan
        The same lap, in which a setpoint at which the line waits appears twice, the second time
        after the lost ticks. Ticks lost between laps aren't counted.

    Raises
    ------
    ValueError
        If the first task doesn't have the plan's tick, or no time is left for the preparation.
    """
    period = round(1e6 * plan.tick)
    if not tasks or tasks[0].period != period:
        came = f"{tasks[0].period} us" if tasks else "no task"
        raise ValueError(f"tasks: the first must have the tick's period {period} us; got {came}.")
    run = hand_over(tasks, [cost] * len(plan.ticks), plan.ticks.tolist())
    held = np.array([0, *run.starved[1:]])  # ticks, before each move but the first
    twice = np.repeat(np.arange(len(plan.s)), 1 + np.append(held > 0, False))
    ticks = np.stack([held, plan.ticks], axis=-1).ravel()
    return replace(
        plan,
        s=plan.s[twice],
        setpoints=plan.setpoints[twice],
        feed=plan.feed[twice],
        ticks=ticks[ticks > 0],
    )
