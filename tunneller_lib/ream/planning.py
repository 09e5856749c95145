"""The plan of a cut: from machine, section and tolerance to knots, setpoints and set-values."""

from dataclasses import dataclass, replace

import numpy as np

from ..arguments import LEAST, MOST, Array, Length, Length0, Number, Whole, Wholes, checked
from ..paths.bounds import Way
from ..paths.circuit import Circuit
from .clearance import PartClearance, clear_size, part_clearances
from .feed import Limits
from .front import engaged_areas, push_levers, side_area
from .moves import Moves, levers, move_lengths, move_shares, move_ticks, strains
from .pose import Pose
from .route import Route, path_points, route_through

LONGEST_REST = 1e4  # s
PLACES = 2000  # of a lap, at which the limits are kept
LEAST_PIECES = 8  # into which the way between two knots is divided at least
CORNER_PLACES = 33  # of a rounded corner, at which the limits are kept
EASED = 1.0005  # times a limit; an excess below this is left to a slower run
EASINGS = 6  # most tightenings of the limits
MOST_SLOWINGS = 50
NEWTON_STEPS = 8
GENTLY = 0.1  # of the acceleration, on entry, where an overshoot of the axes is overbreak
MOST_TICKS = 5_000_000  # in all laps


Run = Array("(n, 2) float", "rad", last="theta, phi")
Ticks = Wholes("(...) int", 0, 2**40)
Tick = Number(LEAST, MOST, "s")


@dataclass(frozen=True, eq=False)
class Plan(Moves):
    """A planned cut: the moves of one lap, which all laps repeat; the last move is the rest.

    Parameters
    ----------
    circuit : Circuit
        The wanted path of the cutter's centre.
    limits : Limits
        The limits of the motion.
    knots : (n,) float
        Arc lengths of the knots along the offset section, in m.
    route : Route
        The way through the knots with rounded corners, on which the setpoints are.
    s : (m + 1,) float
        Arc lengths of the setpoints along the offset section, in m.
    feed : (m + 1,) float
        Feed of the cutter's centre at the setpoints, in m/s.
    reached : (ticks + 1,) float
        Planned length of way at each tick, in m; the setpoints are at some of them.
    entry, leave : Moves
        Moves from a position clear of the ground to the lap's begin, and back.
    back : (k + 1,) float
        How far the machine has stepped back at each of the last k ticks of a lap, in m.
    laps : int
        Number of laps.
    advance : float
        Step of the machine out of the tunnel, towards -x, after each lap but the last, in m.
    straight_time : float
        Time of a lap without its rest if corners and bends cost no feed, in s.
    clearances : list of PartClearance
        The clearances of arm, holder, box and cutter from the wall.
    path : {"projected chord", "corrected chord"}
        Which of `CHORD_PATHS` joins the knots.
    """

    circuit: Circuit
    limits: Limits
    knots: np.ndarray
    route: Route
    s: np.ndarray
    feed: np.ndarray
    reached: np.ndarray
    entry: Moves
    leave: Moves
    back: np.ndarray
    laps: int
    advance: float
    straight_time: float
    clearances: list[PartClearance]
    path: str = "projected chord"

    @property
    def places(self):
        """Return the arc lengths (ticks + 1,) along the offset section at each tick, in m."""
        ends = np.concatenate([[0], np.cumsum(self.ticks)])
        return np.interp(np.arange(ends[-1] + 1), ends, self.s)

    @property
    def lap_time(self):
        """Return the time of a lap, including its rest and the step at its end, in s."""
        return self.tick * int(self.ticks.sum())

    @property
    def times(self):
        """Return the times of the parts of a lap and of the whole job in s, as a dict."""
        step = self.tick * (len(self.back) - 1)
        rest = self.tick * int(self.ticks[-1]) - step
        entry, leave = (self.tick * int(moves.ticks.sum()) for moves in (self.entry, self.leave))
        return {
            "straight": self.straight_time,
            "corners": self.lap_time - step - rest - self.straight_time,
            "rest": rest,
            "step": step,
            "entry": entry,
            "exit": leave,
            "all": entry + self.laps * self.lap_time + leave,
        }

    @property
    def shares(self):
        """Return the shares of the limits that the exact slopes of a lap use, at most 1, as a dict.

        The setpoints aren't rounded yet. Speeds are taken amid the moves; an acceleration is the
        change of slope from move to move, within a single tick.
        """
        torus = self.circuit.machine.torus
        ends = self.setpoints
        slopes = np.diff(ends, axis=0) / (self.ticks * self.tick)[:, None]
        still = np.zeros((1, 2))
        changes = np.diff(np.concatenate([still, slopes, still]), axis=0) / self.tick
        speed = np.linalg.norm(torus.velocity((ends[1:] + ends[:-1]) / 2, slopes), axis=-1)
        acceleration = np.linalg.norm(torus.velocity(ends, changes), axis=-1)
        return {
            "feed": float(speed.max() / self.limits.feed),
            "acceleration": float(acceleration.max() / self.limits.acceleration),
        }

    @checked
    def stepped(self, ticks: Ticks):
        """Return how far (...) the machine has stepped back after ticks (...) of all laps, in m."""
        every = int(self.ticks.sum())
        lap = np.maximum(ticks - 1, 0) // every
        last = np.maximum(ticks - lap * every - (every - len(self.back) + 1), 0)
        return self.advance * lap + np.where(lap < self.laps - 1, self.back[last], 0.0)

    @checked
    def centres(self, position: Run, *, pose: Pose | None = None):
        """Return the cutter's centres in the frame of the tunnel.

        Parameters
        ----------
        position : (n, 2) float
            Joint positions at every tick of one lap or of all, in rad.
        pose : Pose, optional
            By how much the machine stands elsewhere than planned.

        Returns
        -------
        centres : (n, 3) float
            Centres, in m.
        """
        torus = self.circuit.machine.torus
        centre = self.circuit.in_tunnel(torus.point(position[:, 0], position[:, 1]))
        if pose is not None:
            centre = pose.moved(centre, self.circuit.in_tunnel(np.zeros(3)))
        centre[:, 0] -= self.stepped(np.arange(len(centre)))
        return centre


@checked
def plan(
    circuit: Circuit,
    limits: Limits,
    *,
    tolerance: Length,
    step: Length = 5e-3,
    tick: Tick = 5e-3,
    count: Number(1e-9, 0.1, "rad") = 2 * np.pi / 2**16,
    rest: Number(0.0, LONGEST_REST, "s") = 1.0,
    laps: Whole(1, 10_000) = 1,
    advance: Length0 = 0.0,
    arm_radius: Length0 = 0.0,
    path: Way = "projected chord",
    clearance: Length0 = 5e-3,
):
    """Return the `Plan` by which a machine cuts a section, or refuse what it can't do.

    Parameters
    ----------
    circuit : Circuit
        The circuit, from `cutting_circuit`, with machine, section and set-up.
    limits : Limits
        The limits of the motion.
    tolerance : float
        Largest over- or underbreak of the paths between knots, in m, which decides their number.
        Rounded corners may miss their knots by half of it. Moves and counts add theirs; see
        `budget`.
    step : float
        Greatest distance between setpoints, in m, which the slow task prepares and the fast one
        joins by integer lines. Where the feed or the direction changes the moves are shorter.
    tick : float
        Period of the fast task, in s.
    count : float
        Angle of a count of both joints, in rad.
    rest : float
        Time for which the last set-value of a lap is held before the machine steps, in s.
    laps : int
        Number of laps.
    advance : float
        Step of the machine out of the tunnel, towards -x, after each lap, in m.
    arm_radius : float
        Radius of a round-ended rod about the arm that must stay clear of the intact wall, in m.
    path : {"projected chord", "corrected chord"}
        The one of `CHORD_PATHS` that joins the knots: the paper's, or the one next to a geodesic.
    clearance : float
        Clearance between the cutter and the intact ground at the begin and the end, in m.

    Returns
    -------
    plan : Plan
        Knots, setpoints, their ticks and feed.

    Raises
    ------
    ValueError
        If an argument is out of its range; if the arm, or the holder or the box of the machine's
        body, is in the wall; if a tick at full feed goes farther than a step; or if there would be
        too many ticks.

    Notes
    -----
    The way is run as fast as all limits allow, sampled at whole ticks, and divided into straight
    moves of whole ticks, as long as `step` and the acceleration allow (`moves.move_lengths`). If
    the samples exceed a limit the whole lap is slowed.

    Examples
    --------
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> lap = plan(circuit, Limits(feed=0.1, acceleration=0.5), tolerance=1e-3)
    >>> len(lap.knots), round(lap.lap_time)
    (36, 31)

    A single lap has its rest, of 1 s, and no step at its end:

    >>> round(lap.times["rest"], 6), round(lap.times["step"], 6)
    (1.0, 0.0)

    A step may be as short as the way of a tick at the greatest feed; then a move is a tick long:

    >>> farthest = float(np.diff(lap.reached).max())
    >>> finest = plan(circuit, lap.limits, tolerance=1e-3, step=farthest)
    >>> int(finest.ticks[:-1].max()), round(finest.lap_time)
    (1, 31)
    """
    knots = circuit.knots(tolerance, path=path)
    if len(knots) < 2:
        raise ValueError(
            f"tolerance: must be so small that two knots are needed; got {tolerance:g} m."
        )
    clearances = _kept_clear(circuit, arm_radius)
    torus = circuit.machine.torus
    way = route_through(circuit, knots, way=path_points(torus, path), blend=tolerance / 2)
    length, speed, moment, straight_time = _eased(
        way, circuit, limits, advance if laps > 1 else 0.0, tick
    )
    back = _stepping(circuit, limits, advance, tick) if laps > 1 else np.zeros(1)
    # The rest holds at least one tick, and the machine steps in its last ones.
    held = max(round(rest / tick), 1) + len(back) - 1
    total = int(min(np.ceil(moment[-1] / tick), 2.0**60)) + held
    if total * laps > MOST_TICKS:
        fits = MOST_TICKS // total
        longer = tick * 1.1 * total / MOST_TICKS
        would_do = f"{fits}" if fits else f"1 lap with a tick of {longer:.2g} s"
        raise ValueError(
            f"{'laps' if laps > 1 else 'tick'}: must take at most {MOST_TICKS} ticks together; "
            f"got {laps} x {total} ticks of {tick:g} s, {would_do} would do."
        )
    along = _at_ticks(way, torus, limits, length, speed, moment, tick)
    farthest = float(np.diff(along).max())
    if step < farthest:
        raise ValueError(
            f"step: must be at least the {farthest:.4g} m of a tick at the greatest feed; "
            f"got {step:g} m, for which the feed may be {step / tick:.4g} m/s."
        )
    positions = way.at(along)
    positions[-1] = positions[0]  # from which it differs by rounding
    ticks = move_lengths(along, strains(torus, positions, tick, limits), step)
    ends = np.concatenate([[0], np.cumsum(ticks)])
    feed = np.gradient(along, tick)
    feed[[0, -1]] = 0
    entry = _entry(circuit, positions[0], limits, clearance, step, tick, count)
    return Plan(
        # The rest is a move from the last setpoint to itself.
        setpoints=positions[np.append(ends, ends[-1])],
        ticks=np.append(ticks, held),
        tick=tick,
        count=count,
        circuit=circuit,
        limits=limits,
        knots=knots,
        route=way,
        s=way.place(along[np.append(ends, ends[-1])]),
        feed=np.append(feed[ends], 0.0),
        reached=np.append(along, np.full(held, along[-1])),
        entry=entry,
        leave=replace(entry, setpoints=entry.setpoints[::-1], ticks=entry.ticks[::-1]),
        back=back,
        laps=laps,
        advance=advance,
        straight_time=straight_time,
        clearances=clearances,
        path=path,
    )


def _eased(way, circuit, limits, advance, tick):
    """Return lengths of way (k + 1,), feeds and moments there, and the time without turning in s.

    The limits of acceleration are tightened where the run between two places exceeds them.
    """
    length = _places(way)
    at = way.at(length)
    moves = np.diff(length)
    load = _loads(way, circuit, limits, advance, length)
    torus = circuit.machine.torus
    turns = np.stack([way.at(length, order=1), way.at(length, order=2), levers(torus, at)])
    straight = limits.profile(moves, at, **load)
    ease = np.ones_like(length)
    for _ in range(EASINGS):
        eased = turns * np.stack([ease, ease, np.ones_like(ease)])[..., None]
        speed = limits.profile(moves, at, **load, turns=eased)
        moment = _moments(moves, speed)
        if not tick * MOST_TICKS > moment[-1]:
            break  # `plan` refuses so many ticks
        i, along = _sampled(length, speed, moment, tick)
        strain = strains(torus, way.at(along), tick, limits)
        if strain.max() <= EASED:
            break
        # Between two places the run may exceed a limit that both keep, which is then tightened.
        worse = np.ones_like(length)
        for place in (i, i + 1):
            np.maximum.at(worse, place, strain)
        ease = ease * worse
    return length, speed, moment, float(_moments(moves, straight)[-1])


def _loads(way, circuit, limits, advance, length):
    """Return the ground's arguments of `profile` for moves between lengths of way (k + 1,)."""
    places = way.place(length)
    middle = (places[1:] + places[:-1]) / 2
    # The areas take a quarter of a plan's time, and only a limit of the volume needs them.
    limited = limits.volume < np.inf
    load = {"ground": engaged_areas(circuit, middle, advance) if limited else np.zeros_like(middle)}
    if limits.ground is not None:
        whole = limited and not advance  # grooves, which `ground` has already
        load["groove"] = load["ground"] if whole else engaged_areas(circuit, middle)
        slopes = way.at(length, order=1)
        load["pushed"] = push_levers(circuit, limits.ground, places, way.at(length), slopes)
    return load


def _moments(moves, speed):
    """Return the moments (k + 1,) in s at which moves (k,) end that have a speed (k + 1,) there."""
    # The feed changes evenly in time over a move, so its mean is that of both ends.
    return np.concatenate([[0.0], np.cumsum(2 * moves / (speed[1:] + speed[:-1]))])


def _sampled(length, speed, moment, tick):
    """Return the place before each whole tick, and the lengths of way (ticks + 1,) there.

    Examples
    --------
    A way that is over at a whole tick but for rounding asks for no other one:

    >>> rounded = np.array([0.0, 1 + 1e-10])
    >>> _sampled(np.array([0.0, 1.0]), np.array([1.0, 1.0]), rounded, 0.25)[1].round(6).tolist()
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """
    time = tick * np.arange(max(np.ceil(moment[-1] / tick - 1e-9), 1.0) + 1)
    i = np.clip(np.searchsorted(moment, time, side="right") - 1, 0, len(moment) - 2)
    # At constant acceleration between two places, also if the run is slower than its feed.
    share = np.minimum((time - moment[i]) / (moment[i + 1] - moment[i]), 1.0)
    mean = (speed[i] + (speed[i + 1] - speed[i]) * share / 2) / (speed[i] + speed[i + 1])
    return i, length[i] + 2 * (length[i + 1] - length[i]) * share * mean


def _places(way):
    """Return the lengths of way (k + 1,) at which limits are kept, denser at rounded corners."""
    pieces = np.maximum(LEAST_PIECES, np.ceil(np.diff(way.ends) * PLACES / way.length)).astype(int)
    spans = zip(way.ends[:-1], way.ends[1:], pieces, strict=True)
    even = [np.linspace(a, b, n, endpoint=False) for a, b, n in spans]
    rounded = way.ends[:, None] + way.halves[:, None] * np.linspace(-1, 1, CORNER_PLACES)
    every = np.concatenate([*even, rounded.ravel(), [way.length]])
    length = np.unique(every.clip(0, way.length))
    # Of places that differ by rounding only the first counts, or the way's end.
    least = 1e-9 * way.length
    length = length[(np.diff(length, prepend=-np.inf) > least) & (length < way.length - least)]
    return np.append(length, way.length)


def _at_ticks(way, torus, limits, length, speed, moment, tick):
    """Return the lengths of way (ticks + 1,) at whole ticks, slowed until the limits are kept."""
    slower = 1.0
    for _ in range(MOST_SLOWINGS):
        _, along = _sampled(length, speed, slower * moment, tick)
        excess = max(
            np.sqrt(strains(torus, way.at(along), tick, limits).max()),
            np.max(np.diff(along) / tick / limits.feed),
        )
        if excess <= 1 + 1e-7:
            return along
        slower *= excess * (1 + 1e-6)
    raise ValueError(
        f"limits: must be such that a slower lap keeps them; got none that does in {MOST_SLOWINGS}."
    )


def _stepping(circuit, limits, advance, tick):
    """Return how far (k + 1,) the machine has stepped back at each tick of its step, in m.

    The limits of power and volume bound the step, too, since the ball meets ground at its side.
    """
    if not advance:
        return np.zeros(1)
    area = side_area(circuit, 0.0)
    speed = min(limits.feed, limits.volume / area)
    if limits.ground is not None:
        speed = min(speed, limits.power / limits.ground.power(area))
    ticks = move_ticks(advance, speed, limits.acceleration, tick)
    return advance * move_shares(ticks)


def _entry(circuit, end, limits, clearance, step, tick, count):
    """Return the `Moves` from a position clear of the ground to the lap's begin."""
    machine = circuit.machine
    torus = machine.torus
    start = _withdrawn(circuit, end, machine.depth + clearance)
    if not machine.within_limits(start):
        raise ValueError(
            f"clearance: must leave the cutter where the joints reach it; got {clearance:g} m."
        )
    turn = end - start
    ends = np.stack([start, (start + end) / 2, end])
    distance = float(np.linalg.norm(levers(torus, ends) * turn, axis=-1).max())
    # At the greatest depth the plunging ball has its whole cap in the ground.
    cap = np.pi * machine.depth * (2 * machine.cutter_radius - machine.depth)
    slopes = np.tile(turn / distance, (3, 1))
    speed = limits.bounds(
        np.full(2, distance / 2),
        ends,
        np.zeros(2),
        groove=np.full(2, cap),
        pushed=levers(torus, ends) ** 2 * slopes,
    ).min()
    ticks = move_ticks(distance, float(speed), GENTLY * limits.acceleration, tick)
    shares = move_shares(ticks)
    positions = start + shares[:, None] * turn
    positions[-1] = end
    moves = move_lengths(distance * shares, strains(torus, positions, tick, limits), step)
    at = np.concatenate([[0], np.cumsum(moves)])
    return Moves(setpoints=positions[at], ticks=moves, tick=tick, count=count)


def _withdrawn(circuit, position, distance):
    """Return the joint position (2,) at which the cutter is a distance in m inside its circuit.

    To first order the way there is the shortest on the torus.
    """
    torus = circuit.machine.torus
    outward = circuit.profile.normal(0.0) @ circuit.axes[1:]
    # Newton's method, each step along the joints' move that gains most depth per way of the cutter.
    found = np.array(position)
    for _ in range(NEWTON_STEPS):
        slope = torus.velocity(np.stack([found, found]), np.eye(2)) @ outward
        way = slope / levers(torus, found) ** 2
        found = found - (distance + circuit.overbreak(found)) * way / (slope @ way)
    return found


def _kept_clear(circuit, arm_radius):
    """Return the clearances of the machine's parts; one that is in the wall raises ValueError."""
    found = part_clearances(circuit, arm_radius)
    for part in found:
        if part.collides:
            arm = part.name == "arm"
            what = f"arm_radius: an arm of {arm_radius:g} m" if arm else f"body: its {part.name}"
            clear = clear_size(circuit, arm_radius, part)
            would_do = f"; {clear[0]} = {clear[1]:g} would do" if clear else ""
            raise ValueError(f"{what} {part.depth_in_wall}{would_do}.")
    return found
