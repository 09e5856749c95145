"""From machine, section and tolerance to knots, setpoints, feed and set-values."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import (
    Coordinate,
    Length,
    Length0,
    NotNegative,
    Point,
    Points,
    Rule,
    Whole,
    checked,
    coordinate,
    positions,
    size,
)
from ..motion import polyline, polyline_slopes, tick_counts
from ..paths import (
    CHORD_PATHS,
    Circuit,
    corrected_chord,
    path_length,
    project_chord,
    projected_length,
)
from ..paths.bounds import Way
from ..removal import removed_volume, rod_clearance
from .feed import Limits

LONGEST_REST = 1e4  # s
MOST_SETPOINTS = 1_000_000  # of a lap
MOST_TICKS = 5_000_000  # of all laps


def _run_of_positions(name, value):
    """Return `value` as a float array (n, 2) of joint positions."""
    run = positions(name, value)
    if run.ndim != 2:
        raise ValueError(f"{name}: must have the shape (n, 2); got {run.shape}.")
    return run


Run = Annotated[ArrayLike, Rule("(n, 2) float", _run_of_positions, "rad")]
Turn = Annotated[float, Rule("float", coordinate, "rad")]
Tick = Annotated[float, Rule("float", size, "s")]


@dataclass(frozen=True)
@checked
class Pose:
    """By how much a machine stands elsewhere than planned, small: in m and rad.

    Parameters
    ----------
    y, z : float
        To the left and up, in m.
    roll, pitch, yaw : float
        About the tunnel's x, y, z through the torus' centre, right-handed, in this order, in rad.

    Raises
    ------
    ValueError
        If a number isn't finite, or above 1e100 in size.
    """

    y: Coordinate = 0.0
    z: Coordinate = 0.0
    roll: Turn = 0.0
    pitch: Turn = 0.0
    yaw: Turn = 0.0

    @checked
    def moved(self, point: Points, centre: Point):
        """Return points (..., 3) turned about a centre (3,) and shifted, in m."""
        turn = np.eye(3)
        for axis, angle in enumerate((self.roll, self.pitch, self.yaw)):
            i, j = [k for k in range(3) if k != axis]
            c = np.cos(angle)
            s = np.sin(angle)
            one = np.eye(3)
            one[[i, j], [i, j]] = c
            # About x and z the first of the other two axes turns to the second, about y back.
            one[i, j], one[j, i] = (s, -s) if axis == 1 else (-s, s)
            turn = one @ turn
        return (point - np.array(centre)) @ turn.T + centre + [0.0, self.y, self.z]


@dataclass(frozen=True)
class Plan:
    """A planned cut, the same in every lap: n knots and m moves, the last of them the rest.

    Parameters
    ----------
    circuit : Circuit
        The wanted path of the cutter's centre.
    limits : Limits
        Of the feed.
    knots : (n,) float
        Arc lengths of the knots along the offset section, in m.
    s : (m + 1,) float
        Arc lengths of the setpoints, in m.
    setpoints : (m + 1, 2) float
        Joint positions (theta, phi) on the paths between knots, in rad.
    feed : (m + 1,) float
        Of the cutter's centre at the setpoints, in m/s.
    counts : (m + 1, 2) int
        The setpoints in whole counts; the last is the first.
    ticks : (m,) int
        Of each move.
    tick : float
        Period of the fast task, in s.
    count : float
        Angle of a count of both joints, in rad.
    laps : int
        How often the circuit is run.
    advance : float
        Step of the machine out of the tunnel, towards -x, after each lap, in m.
    path : {"tangent spheres", "corrected chord"}
        Which of `CHORD_PATHS` joins the knots.
    """

    circuit: Circuit
    limits: Limits
    knots: np.ndarray
    s: np.ndarray
    setpoints: np.ndarray
    feed: np.ndarray
    counts: np.ndarray
    ticks: np.ndarray
    tick: float
    count: float
    laps: int
    advance: float
    path: str = "tangent spheres"

    @property
    def setvalues(self):
        """Return the joint positions (ticks + 1, 2) of one lap, in rad, in whole counts."""
        return self.count * polyline(self.counts, self.ticks)

    @property
    def slopes(self):
        """Return the exact rates (ticks, 2) of `setvalues`, in rad/s."""
        return self.count / self.tick * polyline_slopes(self.counts, self.ticks)

    @property
    def places(self):
        """Return the arc lengths (ticks + 1,) along the offset section, in m, of each tick."""
        ends = np.concatenate([[0], np.cumsum(self.ticks)])
        return np.interp(np.arange(ends[-1] + 1), ends, self.s)

    @property
    def lap_time(self):
        """Return the time of a lap, in s, its rest at the end included."""
        return self.tick * int(self.ticks.sum())

    @checked
    def centres(self, position: Run, *, pose: Pose | None = None):
        """Return the cutter's centres in the frame of the tunnel.

        Parameters
        ----------
        position : (n, 2) float
            Joint positions at every tick of one lap or of all, in rad.
        pose : Pose, optional
            Where the machine stands instead of where it should.

        Returns
        -------
        centres : (n, 3) float
            In m.
        """
        torus = self.circuit.machine.torus
        centre = self.circuit.in_tunnel(torus.point(position[:, 0], position[:, 1]))
        if pose is not None:
            centre = pose.moved(centre, self.circuit.in_tunnel(np.zeros(3)))
        # The machine steps in the first tick of the next lap.
        lap = np.maximum(np.arange(len(centre)) - 1, 0) // int(self.ticks.sum())
        centre[:, 0] -= self.advance * lap
        return centre


@checked
def plan(
    circuit: Circuit,
    limits: Limits,
    *,
    tolerance: Length,
    step: Length = 5e-3,
    tick: Tick = 5e-3,
    count: Turn = 2 * np.pi / 2**16,
    rest: NotNegative = 1.0,
    laps: Whole(1, 10_000) = 1,
    advance: Length0 = 0.0,
    arm_radius: Length0 = 0.0,
    path: Way = "tangent spheres",
):
    """Return how a machine is to cut a section, refused where it can't.

    Parameters
    ----------
    circuit : Circuit
        From `cutting_circuit`: machine, section and pose, within the joint limits.
    limits : Limits
        Of the feed.
    tolerance : float
        Largest over- or underbreak of the paths between knots, in m, that decides their number.
        Moves and counts add theirs, see `budget`.
    step : float
        Greatest distance of the setpoints N on these paths, in m: what the slow task prepares and
        the fast one joins by integer lines. Those of a corrected chord are at equal steps of the
        normals' angle, even to 1e-5 between the knots that a millimetre needs.
    tick : float
        Period of the fast task, in s.
    count : float
        Angle of a count of both joints, in rad.
    rest : float
        Time for which the last set-value of a lap is held, in s.
    laps : int
        How often the circuit is run.
    advance : float
        Step of the machine out of the tunnel, towards -x, after each lap, in m.
    arm_radius : float
        Of a round-ended rod about the arm, in m, that must stay clear of the intact wall.
    path : {"tangent spheres", "corrected chord"}
        Which of `CHORD_PATHS` joins the knots: the paper's, or the one next to a geodesic.

    Returns
    -------
    plan : Plan
        Knots, setpoints, their ticks and feed.

    Raises
    ------
    ValueError
        If an argument is beyond its range, the arm touches the wall (with the place), the feed
        is too fast for the ticks, or there would be too many setpoints or ticks.

    Examples
    --------
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> lap = plan(circuit, Limits(feed=0.1, acceleration=0.5), tolerance=1e-3)
    >>> len(lap.knots), round(lap.lap_time)
    (36, 31)
    """
    if not 1e-9 <= count <= 0.1:
        raise ValueError(f"count: must lie between 1e-9 and 0.1 rad; got {count:g} rad.")
    if rest > LONGEST_REST:
        raise ValueError(f"rest: must be at most {LONGEST_REST:g} s; got {rest:g} s.")
    knots = circuit.knots(tolerance, path=path)
    if len(knots) < 2:
        raise ValueError(
            f"tolerance: must be so small that two knots are needed; got {tolerance:g} m."
        )
    _keep_clear(circuit, arm_radius)
    s, setpoints, lengths = _setpoints(circuit, knots, step, path)
    ground = _ground(circuit, s, lengths, advance if laps > 1 else 0.0)
    feed = limits.profile(lengths, setpoints, ground)
    # The feed changes evenly over a move, so that its mean is that of both ends.
    times = np.concatenate([[0], np.cumsum(2 * lengths / (feed[1:] + feed[:-1]))])
    ticks = tick_counts(times, tick)
    held = max(round(rest / tick), 1)
    total = int(ticks.sum()) + held
    if total * laps > MOST_TICKS:
        raise ValueError(
            f"laps: must take at most {MOST_TICKS} ticks together; got {laps} x "
            f"{total:.12g} ticks of {tick:g} s."
        )
    # The rest is a move that doesn't move.
    setpoints = np.concatenate([setpoints, setpoints[-1:]])
    return Plan(
        circuit=circuit,
        limits=limits,
        knots=knots,
        s=np.append(s, s[-1]),
        setpoints=setpoints,
        feed=np.append(feed, 0.0),
        counts=np.rint(setpoints / count).astype(np.int64),
        ticks=np.append(ticks, held),
        tick=tick,
        count=count,
        laps=laps,
        advance=advance,
        path=path,
    )


def _setpoints(circuit, knots, step, path):
    """Return arc lengths (m + 1,), positions (m + 1, 2) and moves (m,) of the points N."""
    torus = circuit.machine.torus
    ends = np.append(knots, circuit.profile.perimeter)
    at = circuit.position(ends)
    at[-1] = at[0]  # not off by a rounding
    if path == "corrected chord":
        length = path_length(torus, CHORD_PATHS[path], at[:-1], at[1:])
    else:
        length = projected_length(torus, at[:-1], at[1:])
    moves = np.ceil(length / step)
    if not moves.sum() <= MOST_SETPOINTS:
        raise ValueError(
            f"step: must leave at most {MOST_SETPOINTS} setpoints; got {step:g} m, "
            f"which needs {moves.sum():.3g}."
        )
    moves = moves.astype(int)
    s = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(ends[:-1], ends[1:], moves, strict=True)
    ]
    setpoints = join_knots(at[:-1], moves, path_points(torus, path))
    return np.append(np.concatenate(s), ends[-1]), setpoints, np.repeat(length / moves, moves)


def path_points(torus, path):
    """Return the function (p, q, points) -> (k, points, 2) of a path, by even steps."""
    if path == "corrected chord":
        return lambda p, q, n: corrected_chord(torus, p, q, n)
    return lambda p, q, n: project_chord(torus, p, q, n, spacing="arc")


def join_knots(knots, moves, way):
    """Return the positions (m + 1, 2) of so many moves (n,) from each knot (n, 2) to the next.

    The `way` from p to q (k, 2) in points is a function (p, q, points) -> (k, points, 2).
    """
    after = np.roll(knots, -1, axis=0)
    path = np.empty((moves.sum() + 1, 2))
    first = np.cumsum(moves) - moves
    for n in np.unique(moves):  # those of as many moves at once
        rows = np.flatnonzero(moves == n)
        path[first[rows, None] + np.arange(n)] = way(knots[rows], after[rows], n + 1)[:, :-1]
    path[-1] = knots[0]
    return path


def _ground(circuit, s, lengths, advance):
    """Return the ground removed by each metre of the moves between arc lengths s, in m^2.

    Moves are longer than what they cover of the section where the circuit leans out of its plane.
    """
    machine = circuit.machine
    with np.errstate(divide="ignore"):
        wall = 1 / circuit.profile.curvature((s[1:] + s[:-1]) / 2) + machine.offset
    across = np.diff(s) / lengths
    return across * removed_volume(
        machine.cutter_radius, 1.0, machine.depth, wall=wall, pitch=advance or None
    )


def _keep_clear(circuit, arm_radius):
    """Raise ValueError if a round-ended rod about the arm touches the intact wall."""
    s = np.linspace(0, circuit.profile.perimeter, 721)
    ends = circuit.arm(circuit.position(s))
    clear = rod_clearance(circuit.section, *ends, arm_radius)
    worst = int(np.argmin(clear))
    if clear[worst] < 0:
        raise ValueError(
            f"arm_radius: an arm of {arm_radius:g} m is {-clear[worst]:.3f} m in the wall "
            f"{s[worst]:.3f} m along the circuit."
        )
