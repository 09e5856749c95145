"""The planned cut run through controller and axes, and the wall that the cutter leaves."""

import time
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..arguments import Each, Length, Whole, checked
from ..kernels.compiled import expect
from ..motion import Push, follow
from ..motion.arm import Arm
from ..motion.servo import Track
from ..motion.stability import stable_gains
from ..motion.tasks import Task, hand_over
from ..motion.ticks import expect_run
from ..removal import DexelGrid, Ground
from ..removal.dexel import MOVE, Shape
from .both_axes import Loops, Plants, check_ticks
from .face import BESIDE, Face
from .planning import Plan, Run
from .pose import Pose
from .wall import intact_wall, overbreak, standing

CHUNK = 48  # ticks after which the removed volume is noted
SILENCE = 5.0  # s after which the cutting says how far it is
PROBE = 400  # ticks of the axes that tell how long all take
PROBED = 4  # chunks of the wall that tell the same of it
Cost = Whole(1, 2**31 - 1)


@dataclass(frozen=True, eq=False)
class Cut:
    """A cut that was simulated.

    Parameters
    ----------
    plan : Plan
        What was to be done.
    track : Track or None
        What the joints did in the laps; None where positions were given, as to `carve`.
    centres : (ticks + 1, 3) float
        Of the cutter in the tunnel's frame, in m, after each tick of all laps.
    wall : DexelGrid
        What stands at the end.
    noted : (k + 1,) int
        Ticks at which the removed ground was noted: ends of laps, and some between.
    removed : (k,) float
        Volumes removed between them, in m^3.
    before, after : (j, 3) float
        Centres of the cutter while it entered and left; none where only laps were carved.
    plunged : float
        Volume removed by both, in m^3.
    force : (ticks,) float or None
        Of the ground against the feed at each tick's beginning, in N; None where it doesn't push.
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
        """Return the ends (2,) of the ground that laps may reach along the tunnel's x, in m."""
        return _ends(self.centres, self.plan.circuit.machine.cutter_radius)

    @property
    def deviation(self):
        """Return how far (ticks + 1,) the cutter's centre is outside the offset section, in m.

        So much overbreak it leaves there, or underbreak where negative, in its real pose.
        """
        return -self.plan.circuit.profile.depth(*self.centres[:, 1:].T)

    @property
    def lap_deviations(self):
        """Return the `deviation` of each lap (laps, ticks + 1), in m, at the ticks of its plan."""
        ticks = int(self.plan.ticks.sum())
        return self.deviation[ticks * np.arange(self.plan.laps)[:, None] + np.arange(ticks + 1)]

    @cached_property
    def overbreak(self):
        """Return the overbreak of the wall (n, m), in m, see `wall.overbreak`."""
        return overbreak(self.wall, self.plan.circuit)

    @property
    def around(self):
        """Return the greatest overbreak (m,) on each ray's angle, in m: the groove's bottom."""
        return self.overbreak.max(axis=0)

    @property
    def reamed(self):
        """Return which rays (n, m) are between the bottoms of the first and of the last lap."""
        circuit = self.plan.circuit
        lines = self.wall.lines
        # Where the cutter's lowest point touches the wanted wall in the first lap, by the angle.
        s = np.linspace(0, circuit.profile.perimeter, 2000)
        touch = circuit.profile.point(s) + circuit.machine.cutter_radius * circuit.profile.normal(s)
        angle = np.arctan2(touch[:, 1], touch[:, 0])
        x = circuit.in_tunnel(circuit.point(s))[:, 0]
        first = np.interp(np.arctan2(lines.sin, lines.cos), angle, x, period=2 * np.pi)
        last = first - self.plan.advance * (self.plan.laps - 1)
        return (last <= lines.x[:, None]) & (lines.x[:, None] <= first)

    @property
    def rate(self):
        """Return the ground removed in a second (k,), in m^3/s, between the ticks `noted`."""
        return self.removed / (self.plan.tick * np.diff(self.noted))

    @property
    def lap_volumes(self):
        """Return the ground removed in each lap (laps,), its step before it included, in m^3."""
        every = int(self.plan.ticks.sum())
        stepping = len(self.plan.back) - 1
        first = (self.noted[:-1] + stepping) % every == 0
        first &= self.noted[:-1] + stepping < every * self.plan.laps  # no lap is behind the last
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
    """Return the `Cut` that a plan makes: axes follow its set-values, and the ball cuts the wall.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    plant : Plant or a pair of them
        The axes theta and phi.
    loop : Loop or a pair of them
        Their position loops, with the plan's tick.
    pose : Pose, optional
        Where the machine stands instead of where it should.
    shape : (2,) int
        Rays of the wall along the tunnel and round.
    thickness : float
        Of the modelled ground, in m.
    arm : Arm, optional
        The masses on both joints, for two `Compressible` plants; see `follow`.
    ground : Ground, optional
        What pushes back on two `Compressible` plants while they cut; nothing by default.
    say : function, optional
        Told after each lap how far the cutting is.

    Returns
    -------
    cut : Cut
        Track of the joints, centres of the cutter, the wall and what was removed.

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
        noted = first + _noted(plan)
        tell = _Teller(plan, say, first)
        wall = setvalues, first, shape, thickness
        face = Face(plan, ground, *wall, pose=pose, noted=noted, say=tell.cut_to)
    push = face and face.push
    track = follow(plant, loop, setvalues, slopes=slopes, arm=arm, push=push)
    for joint, name in enumerate(("theta", "phi")):
        if track.stable[joint] is False:
            raise ValueError(_unstable(name, plant[joint], loop[joint], setvalues[:, joint]))
    ends = track.position[: first + 1], track.position[last:]
    laps = track.between(first, last)
    if face is None:
        return replace(_carved(plan, laps.position, ends, pose, shape, thickness, say), track=laps)
    face.finish(track.position)
    centres, before, after = _centres(plan, laps.position, ends, pose)
    start, stop = _ends(np.concatenate([before, centres, after]), face.radius)
    if start < face.ends[0] or stop > face.ends[1]:
        raise ValueError(
            f"ground: must hold the cutter back by less than {BESIDE:g} m along the tunnel, beyond "
            "which no ground is modelled."
        )
    standing(face.wall)  # refuses a wall that is cut through
    so_far = np.concatenate([[0.0], np.cumsum(face.removed)])
    removed = np.diff(so_far[noted])
    plunged = float(so_far[-1] - removed.sum())
    force = face.force(track)[first:last]
    return Cut(
        plan, laps, centres, face.wall, noted - first, removed, before, after, plunged, force
    )


def _unstable(name, plant, loop, reached):
    """Return the sentence that refuses an unstable loop, with the gains that would do."""
    low, high = stable_gains(plant, loop, np.linspace(reached.min(), reached.max(), 5))
    allowed = f"the gain must be below {high:.3g} 1/s"
    if loop.integral:
        allowed = f"the gain must be from {low:.3g} to {high:.3g} 1/s" if low < high else None
        allowed = f"with an integral of {loop.integral:g} 1/s^2 {allowed or 'no gain would do'}"
    return (
        f"loop: must be stable; that of {name} isn't at its gain and tick: {allowed}; "
        f"got {loop.gain:g} 1/s."
    )


def whole_run(plan):
    """Return set-values (n + 1, 2) and slopes (n, 2) from the entry to the exit."""
    # The cutter rests at the lap's begin, so that runs one after the other share a tick there.
    runs = [plan.entry, *[plan] * plan.laps, plan.leave]
    setvalues = [run.setvalues for run in runs]
    return (
        np.concatenate([setvalues[0][:1], *(values[1:] for values in setvalues)]),
        np.concatenate([run.slopes for run in runs]),
    )


@checked
def expected_seconds(
    plan: Plan,
    plant: Plants,
    loop: Loops,
    *,
    shape: Shape = (400, 720),
    thickness: Length = 0.1,
    arm: Arm | None = None,
    ground: Ground | None = None,
):
    """Return about how long `simulate` will take on this computer, in s.

    Parameters
    ----------
    plan, plant, loop, shape, thickness, arm, ground
        As for `simulate`: a `Plan`, axes, loops, the numbers of rays, in m, an `Arm`, a `Ground`.

    Returns
    -------
    axes, wall : float
        For running the axes and for cutting the wall: as long as a few of its ticks take, here
        and now, times their number.
    """
    setvalues, slopes = whole_run(plan)
    expect_run(plant, plan.tick, len(slopes))
    expect(MOVE * len(slopes), "grid")
    tried = min(PROBE, len(slopes))

    def run(ticks, push):
        begun = time.perf_counter()
        follow(plant, loop, setvalues[: ticks + 1], slopes=slopes[:ticks], arm=arm, push=push)
        return (time.perf_counter() - begun) * len(slopes) / ticks

    push = ground and Push()
    run(1, push)  # imports, and compiles, what the run will need
    axes = run(tried, push)
    if ground is not None:
        first = int(plan.entry.ticks.sum())
        noted = first + _noted(plan)
        face = Face(plan, ground, setvalues, first, shape, thickness, noted=noted)
        # Compiles what it will need: a cut of a copy, and one tick, by which nothing is cut yet.
        face.wall.copy().cut_path(plan.centres(plan.setvalues[:2]), face.radius)
        run(1, copy(face).push)
        return axes, max(run(tried, face.push) - axes, 0.0)
    centres = plan.centres(plan.setvalues)
    reach = plan.circuit.machine.cutter_radius
    wall = intact_wall(plan.circuit, *_ends(centres, reach), shape, thickness=thickness)
    chunks = [centres[a : a + CHUNK + 1] for a in range(0, len(centres) - 1, CHUNK)]
    some = chunks[:: max(len(chunks) // PROBED, 1)]
    wall.copy().cut_path(centres[:2], reach)  # compiled, if it will be
    begun = time.perf_counter()
    for chunk in some:
        wall.cut_path(chunk, reach)
    return axes, (time.perf_counter() - begun) * len(slopes) / sum(len(c) - 1 for c in some)


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
    """Return the `Cut` of joints that are exactly at given positions.

    Parameters
    ----------
    plan : Plan
        Machine, section, laps and advance.
    position : (n, 2) float
        Joint positions at every tick of all laps, or of one that all repeat, in rad.
    pose, shape, thickness, say
        As for `simulate`: a `Pose`, the numbers of rays, in m, called after each lap.

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
    """Return the `Cut` of positions in all laps, and of those before and after them."""
    centres, before, after = _centres(plan, position, ends, pose)
    reach = plan.circuit.machine.cutter_radius
    start, stop = _ends(np.concatenate([before, centres, after]), reach)
    wall = intact_wall(plan.circuit, start, stop, shape, thickness=thickness)
    noted = _noted(plan)
    plunged = wall.cut_path(before, reach) if len(before) else 0.0
    removed = []
    tell = _Teller(plan, say)
    for a, b in pairwise(noted):
        removed.append(wall.cut_path(centres[a : b + 1], reach))
        tell.cut_to(b)
    plunged += wall.cut_path(after, reach) if len(after) else 0.0
    standing(wall)  # refuses a wall that is cut through
    return Cut(plan, None, centres, wall, noted, np.array(removed), before, after, plunged)


def _centres(plan, position, ends, pose):
    """Return the cutter's centres in all laps, and before and after them."""
    centres = plan.centres(position, pose=pose)
    before = plan.centres(ends[0], pose=pose)
    after = plan.centres(ends[1], pose=pose) - [plan.advance * (plan.laps - 1), 0.0, 0.0]
    return centres, before, after


def _noted(plan):
    """Return the ticks (k + 1,) of all laps at which the removed ground is noted."""
    # Whatever their ticks, laps and steps end where something is noted.
    ticks = int(plan.ticks.sum())
    within = np.union1d(np.arange(0, ticks, CHUNK), [ticks - len(plan.back) + 1])
    starts = ticks * np.arange(plan.laps)
    return np.append(np.add.outer(starts, within[within < ticks]).ravel(), ticks * plan.laps)


class _Teller:
    """Says how far the cutting is: at the end of each lap, and after a silence."""

    def __init__(self, plan, say, first=0):
        self.say = say
        self.first = first
        self.laps = plan.laps
        self.ticks = int(plan.ticks.sum())
        self.begun = self.said = time.monotonic()

    def cut_to(self, tick):
        """Say how far the cutting is at a tick of the run, whose first lap begins at `first`."""
        done = tick - self.first
        now = time.monotonic()
        if self.say is None or not 0 < done <= self.ticks * self.laps:
            return
        if done % self.ticks and now - self.said < SILENCE:
            return
        self.said = now
        lap, within = divmod(done - 1, self.ticks)
        part = f", {100 * (within + 1) // self.ticks} % of it" if done % self.ticks else ""
        every = self.ticks * self.laps
        left = (now - self.begun) * (every - done) / done
        # What begins once, as compilers do, is most of the first hundredth.
        to_go = f"; about {left:.0f} s to go" if left >= 1 and 100 * done >= every else ""
        self.say(f"cutting: lap {lap + 1} of {self.laps}{part}{to_go}")


def _ends(centres, reach):
    """Return how far, in m, a cutter of this reach gets along the tunnel."""
    x = centres[:, 0]
    return float(x.min()) - reach, float(x.max()) + reach


@checked
def starved(plan: Plan, tasks: Each(Task), cost: Cost):
    """Return the `Plan` as it runs where the slow task is late and the last set-value is held.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    tasks : list of Task
        The controller's tasks in microseconds, the interpolation first, with the plan's tick.
    cost : int
        What the slow preparation of a setpoint costs, in microseconds.

    Returns
    -------
    plan : Plan
        A setpoint at which the line waits stands there twice, the second time after the ticks that
        are lost. What is lost between laps isn't counted.

    Raises
    ------
    ValueError
        If the first task hasn't the plan's tick, or the tasks leave no time for the preparation.
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
