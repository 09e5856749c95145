"""How fast the cutter may go along its path: as fast as the limits let it."""

from dataclasses import dataclass

import numpy as np

from ..arguments import LEAST, MOST, Array, Number, Size, checked
from ..motion.hydraulics import Hydraulics
from ..motion.quantities import Pair
from ..removal import Ground
from .timing import Places, fastest

Bound = Number(
    LEAST, np.inf,
    also=(f"be of at most {MOST:g}, or infinite", lambda bound: bound <= MOST or bound == np.inf),
)  # fmt: skip
Moves = Array("(m,) float", "m", low=LEAST)
Areas = Array("(m,) float", low=0.0)
Ends = Array("(m + 1, 2) float", "rad", last="theta, phi")
Slopes = Array("(m + 1, 2) float", "rad/m", last="theta, phi")
Bends = Array("(m + 1, 2) float", last="theta, phi")
Levers = Array("(m + 1, 2) float", "m", last="theta, phi")


@dataclass(frozen=True)
@checked
class Limits:
    """What bounds the motion; a limit that is infinite bounds nothing.

    Parameters
    ----------
    feed : float
        Greatest feed, in m/s.
    acceleration : float
        Of the cutter, in m/s^2: the joints' accelerations, each times its lever, so that corners
        cost feed, too. Every lap starts and ends at rest.
    volume : float
        Ground that the cutter's front may remove, in m^3/s (section 3.3.2), where it is on the
        circuit. Between knots the ball takes somewhat more and less.
    flow : float
        Oil that the pump delivers to both axes together, in m^3/s; needs `axes`.
    valve : float
        Opening of the valve, 1 at most, that the steady motion may ask for; needs `axes`.
    axes : (Hydraulics, Hydraulics), optional
        The axes theta and phi.
    joint_speed, joint_acceleration : float
        Of each joint, in rad/s and rad/s^2.
    power : float
        Of the cutter head, in W, on whole grooves, as those of a first lap; needs `ground`.
    ground : Ground, optional
        What cutting asks for; its force, with its ripple, loads the valves of the `axes`.

    Raises
    ------
    ValueError
        If a number isn't above zero or is out of its range, the valve above 1 but not infinite, or
        a limit needs axes that aren't given.
    """

    feed: Size
    acceleration: Size
    volume: Bound = np.inf
    flow: Bound = np.inf
    valve: Bound = np.inf
    axes: Pair(Hydraulics) | None = None
    joint_speed: Bound = np.inf
    joint_acceleration: Bound = np.inf
    power: Bound = np.inf
    ground: Ground | None = None

    def __post_init__(self):
        if self.ground is None and self.power < np.inf:
            raise ValueError("ground: must be given for a limit of power; got None.")
        if 1 < self.valve < np.inf:
            raise ValueError(f"valve: must be at most 1, the open valve; got {self.valve!r}.")
        if self.axes is None and min(self.flow, self.valve) < np.inf:
            raise ValueError("axes: must be given for a limit of flow or of valves; got None.")

    @checked
    def profile(
        self,
        lengths: Moves,
        positions: Ends,
        ground: Areas,
        *,
        slopes: Slopes | None = None,
        bends: Bends | None = None,
        levers: Levers | None = None,
        groove: Areas | None = None,
        pushed: Ends | None = None,
    ):
        """Return the fastest feed from rest to rest.

        Parameters
        ----------
        lengths : (m,) float
            Of the moves of the cutter's centre, in m.
        positions : (m + 1, 2) float
            Joint positions at their ends, in rad; straight in joint space between.
        ground : (m,) float
            Ground removed by each metre of a move, in m^2.
        slopes : (m + 1, 2) float, optional
            First derivatives of the positions by the length of way, in rad/m; without them the way
            is straight and limits of the joints are left out.
        bends : (m + 1, 2) float, optional
            Their second derivatives, in rad/m^2; needed with `slopes`.
        levers : (m + 1, 2) float, optional
            How far the cutter moves by a radian of each joint, in m; needed with `slopes`.
        groove : (m,) float, optional
            As for `bounds`, in m^2.
        pushed : (m + 1, 2) float, optional
            As for `bounds`, in m.

        Returns
        -------
        feed : (m + 1,) float
            At the ends, in m/s, changing by a constant acceleration over each move: the greatest
            that no limit forbids.

        Raises
        ------
        ValueError
            As `bounds`, or if only some of slopes, bends and levers are given.
        """
        bound = self.bounds(lengths, positions, ground, groove=groove, pushed=pushed)
        # A place belongs to the moves before and after it.
        square = np.minimum(np.append(bound, np.inf), np.append(np.inf, bound)) ** 2
        joint = np.array([self.joint_acceleration] * 2)
        turns = slopes, bends, levers
        if any(turn is None for turn in turns) != (slopes is None):
            raise ValueError("slopes: bends and levers must be given with them; got one alone.")
        if slopes is None:
            straight = np.tile([1.0, 0.0], (len(square), 1))
            places = Places(
                square,
                self.acceleration,
                np.full(2, np.inf),
                straight,
                0 * straight,
                np.ones_like(straight),
            )
            return np.sqrt(fastest(lengths, places))
        if any(turn.shape != positions.shape for turn in turns):
            raise ValueError(
                f"slopes: must have the shape {positions.shape} of the positions, and bends "
                f"and levers too; got {', '.join(str(turn.shape) for turn in turns)}."
            )
        with np.errstate(divide="ignore", over="ignore"):
            fastest_turn = (self.joint_speed / np.max(np.abs(slopes), axis=-1)) ** 2
        square = np.minimum(square, fastest_turn)
        places = Places(square, self.acceleration, joint, slopes, bends, levers)
        return np.sqrt(fastest(lengths, places))

    @checked
    def bounds(
        self,
        lengths: Moves,
        positions: Ends,
        ground: Areas,
        *,
        groove: Areas | None = None,
        pushed: Ends | None = None,
    ):
        """Return the greatest steady feed on each move.

        Parameters
        ----------
        lengths : (m,) float
            Of the moves of the cutter's centre, in m.
        positions : (m + 1, 2) float
            Joint positions at their ends, in rad; straight in joint space between.
        ground : (m,) float
            Ground removed by each metre of a move, in m^2.
        groove : (m,) float, optional
            The same of a whole groove, beside which nothing is cut yet; that of `ground` unless
            told.
        pushed : (m + 1, 2) float, optional
            Levers of the ground's force at both joints, in m: what torque resists positive motion
            at the ends of the moves, in N m, by a newton against the feed. None pushes by default.

        Returns
        -------
        feed : (m,) float
            In m/s.

        Raises
        ------
        ValueError
            If the shapes don't fit each other, a length isn't above zero, or ground is below it.
        """
        m = lengths.size
        if m < 2 or ground.shape != (m,) or positions.shape != (m + 1, 2):
            raise ValueError(
                "lengths: must be (m,) with ground (m,) and positions (m + 1, 2), and "
                f"m >= 2; got {lengths.shape}, {ground.shape}, {positions.shape}."
            )
        groove = ground if groove is None else groove
        pushed = np.zeros_like(positions) if pushed is None else pushed
        if groove.shape != (m,) or pushed.shape != (m + 1, 2):
            raise ValueError(
                f"groove: must be ({m},), and pushed ({m + 1}, 2), as the moves; "
                f"got {groove.shape} and {pushed.shape}."
            )
        with np.errstate(divide="ignore", over="ignore"):
            bound = np.minimum(self.feed, self.volume / ground)
            if self.ground is not None:
                bound = np.minimum(bound, self.power / self.ground.power(groove))
        if self.axes is None:
            return bound
        rates = np.diff(positions, axis=0) / lengths[:, None]  # rad for each metre
        middle = (positions[1:] + positions[:-1]) / 2
        torques = np.zeros_like(middle)
        if self.ground is not None:
            greatest = (1 + self.ground.ripple) * self.ground.force(groove)  # at a feed of 1 m/s
            torques = greatest[:, None] * (pushed[1:] + pushed[:-1]) / 2
        drawn = 0.0  # oil, in m^3 for each metre of the move
        for axis, rate, angle, torque in zip(self.axes, rates.T, middle.T, torques.T, strict=True):
            # The pump fills one side of a cylinder in forward motion, the other in backward motion.
            (forward, _, _), (backward, _, _) = axis.sides(angle)
            drawn = drawn + np.abs(rate) * np.where(rate > 0, forward, backward)
            if self.valve < np.inf:
                bound = np.minimum(bound, axis.loaded(angle, rate, torque, self.valve))
        with np.errstate(divide="ignore", over="ignore"):
            return np.minimum(bound, self.flow / drawn)
