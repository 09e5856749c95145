"""The fastest feed along a path under limits of speed, power, oil and acceleration.

The acceleration a along the way changes the square x = v^2 of the feed v by dx/dl = 2 a. At each
place the joints' accelerations q' a + q'' x are linear in both, so the cutter's limit is an ellipse
about the origin in the plane of a and x. A pass backwards finds the greatest x from which the rest
can still be run; a pass forwards then goes as fast as these allow.
"""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from ..arguments import LEAST, MOST, Array, Number, Size, checked
from ..motion.hydraulics import Hydraulics
from ..motion.quantities import Pair
from ..removal import Ground

Bound = Number(
    LEAST,
    np.inf,
    also=(f"be of at most {MOST:g}, or infinite", lambda bound: bound <= MOST or bound == np.inf),
)
Moves = Array("(m,) float", "m", low=LEAST)
Areas = Array("(m,) float", low=0.0)
Ends = Array("(m + 1, 2) float", "rad", last="theta, phi")
Turns = Array("(3, m + 1, 2) float", last="theta, phi")


@dataclass(frozen=True)
@checked
class Limits:
    """The limits of the motion; an infinite limit bounds nothing.

    Parameters
    ----------
    feed : float
        Greatest feed, in m/s.
    acceleration : float
        Greatest acceleration of the cutter, in m/s^2: the root of the sum of squares of the joints'
        accelerations, each times its lever, so that corners cost feed as well.
    volume : float
        Greatest rate of removal by the cutter's front, in m^3/s (section 3.3.2), on the circuit;
        between knots the ball removes somewhat more or less.
    flow : float
        Greatest flow of oil from the pump to both axes together, in m^3/s; needs `axes`.
    valve : float
        Greatest opening of the valves in steady motion, at most 1; needs `axes`.
    axes : (Hydraulics, Hydraulics), optional
        The axes theta and phi.
    power : float
        Greatest power of the cutter head on whole grooves, as in a first lap, in W; needs
        `ground`.
    ground : Ground, optional
        The law of the cutting force, which, with its ripple, loads the valves of the `axes`.

    Raises
    ------
    ValueError
        If a number is out of its range, the valve is above 1 and finite, or a limit needs axes or
        ground that aren't given.
    """

    feed: Size
    acceleration: Size
    volume: Bound = np.inf
    flow: Bound = np.inf
    valve: Bound = np.inf
    axes: Pair(Hydraulics) | None = None
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
        groove: Areas | None = None,
        pushed: Ends | None = None,
        turns: Turns | None = None,
    ):
        """Return the fastest feed from rest to rest.

        Parameters
        ----------
        lengths, positions, ground, groove, pushed
            As for `bounds`, in m, rad and m^2.
        turns : (3, m + 1, 2) float, optional
            First and second derivatives of the positions by the length of way, in rad/m and
            rad/m^2, and the levers of both joints, in m. Without them the way is taken as straight.

        Returns
        -------
        feed : (m + 1,) float
            The greatest feed at the ends of the moves that no limit forbids, in m/s; it changes
            at a constant acceleration over each move.

        Raises
        ------
        ValueError
            As by `bounds`, or if a move is too long for the bend of the way at its beginning.
        """
        bound = self.bounds(lengths, positions, ground, groove=groove, pushed=pushed)
        # A place belongs to the move before it and to the one after it.
        square = np.minimum(np.append(bound, np.inf), np.append(np.inf, bound)) ** 2
        if turns is None:
            turns = np.tile([[[1.0, 0.0]], [[0.0, 0.0]], [[1.0, 1.0]]], (1, len(square), 1))
        _check_shapes(len(lengths), turns=turns[0])
        return np.sqrt(fastest(lengths, square, self.acceleration, turns))

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
        """Return the greatest steady feed in each move.

        Parameters
        ----------
        lengths : (m,) float
            Lengths of the cutter's moves, in m.
        positions : (m + 1, 2) float
            Joint positions at their ends, in rad; the moves are straight in joint space.
        ground : (m,) float
            Volume removed per metre of each move, in m^2.
        groove : (m,) float, optional
            The same in a whole groove, beside which nothing is cut yet; by default `ground`.
        pushed : (m + 1, 2) float, optional
            Levers of the ground's force at both joints at the ends of the moves, in m: the torque
            against positive motion, in N m, per newton against the feed. By default zero.

        Returns
        -------
        feed : (m,) float
            In m/s.

        Raises
        ------
        ValueError
            If the shapes don't fit each other, a length isn't positive, or ground is negative.
        """
        groove = ground if groove is None else groove
        pushed = np.zeros_like(positions) if pushed is None else pushed
        fitting = {"positions": positions, "ground": ground, "groove": groove, "pushed": pushed}
        _check_shapes(len(lengths), **fitting)
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
        if self.valve < np.inf:
            for axis, rate, angle, torque in zip(
                self.axes, rates.T, middle.T, torques.T, strict=True
            ):
                bound = np.minimum(bound, axis.loaded(angle, rate, torque, self.valve))
        with np.errstate(divide="ignore", over="ignore"):
            return np.minimum(bound, self.flow / drawn_oil(self.axes, middle, rates))


def drawn_oil(axes, positions, rates):
    """Return the flow (n,) from the pump to both `axes` at positions and rates (n, 2), in m^3/s.

    These are in rad and rad/s; for rates per metre, in rad/m, the flow is per metre, too.
    """
    drawn = 0.0
    for axis, angle, rate in zip(axes, positions.T, rates.T, strict=True):
        # The pump fills one side of a cylinder in forward motion and the other in backward motion.
        forward, backward = axis.linkage.displacements(angle)
        drawn = drawn + np.abs(rate) * np.where(rate > 0, forward, backward)
    return drawn


def _check_shapes(moves, **arrays):
    """Raise ValueError unless arrays have one entry a move, or two joints' at the moves' ends."""
    if moves < 2:
        raise ValueError(f"lengths: must be of at least two moves; got {moves}.")
    for name, array in arrays.items():
        wanted = (moves,) if array.ndim == 1 else (moves + 1, 2)
        if array.shape != wanted:
            raise ValueError(f"{name}: must be {wanted} for {moves} moves; got {array.shape}.")


def fastest(lengths, square, acceleration, turns):
    """Return the squares (m + 1,) of the greatest feed from rest to rest over m moves, in m^2/s^2.

    The acceleration is constant over each move and within the cutter's limit at its beginning. A
    move that is too long for that at any feed raises ValueError.

    Parameters
    ----------
    lengths : (m,) float
        Lengths of the moves, in m.
    square : (m + 1,) float
        Greatest squares of the feed at their ends by limits of speed, in m^2/s^2.
    acceleration : float
        Limit of the cutter, in m/s^2.
    turns : (3, m + 1, 2) float
        As of `Limits.profile`.
    """
    slope, bend, lever = turns
    # The cutter's limit |lever (slope a + bend x)| <= acceleration is the inside of the ellipse
    # g11 a^2 + 2 g12 a x + g22 x^2 = acceleration^2.
    ellipse = (
        np.sum((lever * slope) ** 2, -1),
        np.sum(lever * slope * (lever * bend), -1),
        np.sum((lever * bend) ** 2, -1),
    )
    g11, g12, g22 = ellipse
    with np.errstate(divide="ignore", over="ignore"):
        # Its greatest x is acceleration / sqrt(g22 - g12^2 / g11).
        rise = np.sqrt(np.maximum(g22 - g12**2 / g11, 0))
        top = np.minimum(square, acceleration / rise).tolist()
    ellipses = list(zip(*(part.tolist() for part in ellipse), strict=True))
    top[0] = top[-1] = 0.0
    limit = acceleration * acceleration
    steps = (2 * lengths).tolist()  # dx = 2 a dl: a move changes x by step times a
    # Backwards: the greatest x from which braking as hard as allowed still gets down to `goal`, the
    # greatest x at the move's end.
    for i in reversed(range(len(steps))):
        step = steps[i]
        goal = top[i + 1]
        best = top[i]
        g11, g12, g22 = ellipses[i]
        # With a = (goal - x) / step, which just reaches the goal, the ellipse becomes
        # p x^2 + 2 h x + g11 goal^2 - step^2 limit = 0. Its greater root bounds x only if that a is
        # the least that the ellipse allows at x, so less than -g12 x / g11, the middle of the two
        # that it has there: else harder braking gets down to the goal from a greater x, too.
        p = g11 - 2 * step * g12 + step * step * g22
        h = goal * (step * g12 - g11)
        under = h * h - p * (g11 * goal * goal - step * step * limit)
        if under >= 0:  # otherwise every a in the ellipse leads below the goal: no bound
            x = (sqrt(under) - h) / p if under < inf else inf
            if x < best and (goal - x) * g11 <= -g12 * x * step:
                best = x
        top[i] = best
    # Forwards from rest: x grows by the most that the ellipse allows, up to what the first pass
    # left. Where the ellipse allows no growth x falls. It falls below 0 only where step g12 > g11:
    # over so long a move the way bends too much for one acceleration.
    found = [0.0]
    for i, step in enumerate(steps):
        x = found[-1]
        g11, g12, g22 = ellipses[i]
        most = (sqrt(max(g12 * g12 * x * x - g11 * (g22 * x * x - limit), 0.0)) - g12 * x) / g11
        if x + step * most < 0:
            raise ValueError(
                f"lengths: a move must be shorter than {g11 / g12 / 2:.3g} m where the way bends "
                f"as after move {i}; got {step / 2:.3g} m."
            )
        found.append(min(top[i + 1], x + step * most))
    return np.array(found)
