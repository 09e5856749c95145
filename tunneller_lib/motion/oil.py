"""Hydraulic axes in time: with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Angle, Finite, Rule, checked
from ..surfaces.linkage import check_stroke
from .hydraulics import Hydraulics, load_at, sides_at, speed
from .plant import Lag, ValveResonance
from .quantities import Tick, Torque, moderate_array

SLIP = 2e-3  # rad/s, within which dry friction turns from one direction to the other
LAMINAR = 1e5  # Pa, below which the flow through a land turns from its root to a straight line
PHASE = 0.2  # rad of the fastest resonance, the longest step of the integration
STEP = 2e-3  # s, the longest step with rigid oil
MOST_STEPS = 1000  # in a tick


def _state(name, value):
    array = moderate_array(name, value)
    if array.shape != (5,):
        raise ValueError(f"{name}: must be five numbers; got shape {array.shape}.")
    return tuple(array.tolist())


State = Annotated[ArrayLike, Rule("(5,) float", _state)]


@dataclass(frozen=True)
@checked
class Rigid:
    """T2: an axis whose oil doesn't give way; its state is angle and spool.

    Parameters
    ----------
    axis : Hydraulics
        The sizes.
    """

    axis: Hydraulics

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)

    @checked
    def linear(self, angle: Angle):
        """Return the linear plant (T1) of small motions about a joint angle, in rad."""
        return Lag(self.axis.resonance(angle).gain, self.axis.valve_lag)

    @checked
    def rest(self, position: Angle):
        """Return the state at rest at a position, in rad."""
        check_stroke(position, self.axis.low, self.axis.high, "position")
        return position, 0.0

    @checked
    def stepper(self, tick: Tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        axis = self.axis
        parts = parts_of(tick, tick / STEP)
        h = tick / parts
        fall = math.exp(-h / 2 / axis.valve_lag)

        def rate(angle, spool):
            if not axis.low <= angle <= axis.high:
                raise _out_of_stroke(axis, angle)
            forward, backward = sides_at(axis, angle)
            return speed(axis, spool, *forward) if spool > 0 else -speed(axis, -spool, *backward)

        def step(state, u):
            angle, spool = state
            for _ in range(parts):
                middle = u + (spool - u) * fall
                last = u + (middle - u) * fall
                k1 = rate(angle, spool)
                k2 = rate(angle + h / 2 * k1, middle)
                k3 = rate(angle + h / 2 * k2, middle)
                k4 = rate(angle + h * k3, last)
                angle = angle + h / 6 * (k1 + 2 * (k2 + k3) + k4)
                spool = last
            return angle, spool

        return step


@dataclass(frozen=True)
@checked
class Compressible:
    """T3: an axis with compressible oil; its state is angle, rate, both pressures, spool.

    Parameters
    ----------
    axis : Hydraulics
        The sizes.

    Notes
    -----
    The flow of a land is the root of the pressure lost, straightened below 1 bar: where both lose
    at least p and nothing leaks or rubs, steady rates are those of `Rigid` to (1 bar / p)^2 / 4 of
    themselves. Leaks are laminar. Oil that would be torn apart stays at pressure zero, and the void
    isn't remembered. The axes don't feel each other, unless `follow` is given their `Arm`.
    """

    axis: Hydraulics

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)

    @checked
    def linear(self, angle: Angle):
        """Return the linear plant of small swings about rest at a joint angle, in rad.

        A valve that is hardly open lets no oil escape from a load that swings; the further it
        opens the more it damps. So these are the motions that grow first.
        """
        small = Hydraulics.resonance.unchecked(self.axis, angle)
        return ValveResonance(
            gain=float(Hydraulics.swing.unchecked(self.axis, angle)) * small.gain,
            steady=small.gain,
            frequency=small.frequency,
            damping=small.damping,
            lag=self.axis.valve_lag,
        )

    @checked
    def rest(self, position: Angle, load: Torque | None = None):
        """Return the state at rest at a position, in rad: pressures that sum to the supply.

        They hold a `load` in N m that resists positive motion; the axis' own unless told.
        """
        axis = self.axis
        check_stroke(position, axis.low, axis.high, "position")
        (plus, _, own), (minus, _, _) = sides_at(axis, position)
        load = own if load is None else load
        first = (load + minus * axis.supply) / (plus + minus)
        return position, 0.0, first, axis.supply - first, 0.0

    @checked
    def stepper(self, tick: Tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        axis = self.axis
        fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
        slowest = max(fastest / PHASE, 1 / axis.valve_lag, axis.friction / (SLIP * axis.inertia))
        parts = parts_of(tick, tick * slowest)
        h = tick / parts
        slopes = _slopes_of(axis)

        def step(state, u):
            for _ in range(parts):
                k1 = slopes(state, u)
                k2 = slopes([y + h / 2 * k for y, k in zip(state, k1, strict=True)], u)
                k3 = slopes([y + h / 2 * k for y, k in zip(state, k2, strict=True)], u)
                k4 = slopes([y + h * k for y, k in zip(state, k3, strict=True)], u)
                each = zip(state, k1, k2, k3, k4, strict=True)
                state = [y + h / 6 * (a + 2 * (b + c) + d) for y, a, b, c, d in each]
                state[2] = max(state[2], 0.0)
                state[3] = max(state[3], 0.0)
            return tuple(state)

        return step

    @checked
    def derivative(self, state: State, u: Finite):
        """Return the state's rate of change under a command u.

        Parameters
        ----------
        state : (5,) float
            Angle in rad, rate in rad/s, the pressures of the plus and the minus side in Pa, and
            the spool's position.
        u : float
            The spool's position that is asked for.

        Returns
        -------
        rates : tuple of float
            The same by the second.

        Raises
        ------
        ValueError
            If the angle is outside the stroke.
        """
        check_stroke(state[0], self.axis.low, self.axis.high, "state")
        return _slopes_of(self.axis)(state, u)


def _slopes_of(axis):
    """Return the function (state, u) of `Compressible.derivative`, which checks the stroke only."""
    oil = oil_of(axis)

    def slopes(state, u):
        angle, rate, first, second, spool = state
        driven, filling, emptying, opening, _ = oil(angle, rate, first, second, spool, u)
        torque = driven - load_at(axis, angle) - resistance(axis, rate)
        return rate, torque / axis.inertia, filling, emptying, opening

    return slopes


def oil_of(axis):
    """Return the function (state and command) -> what an `axis`' chambers and spool do.

    That is the torque of both pressures, in N m, how these change, in Pa/s, and the spool, in 1/s,
    and the power that compresses the oil, in W. Nothing is checked but the stroke's ends.
    """
    chambers = axis.linkage.chambers(axis.low, axis.high)

    def oil(angle, rate, first, second, spool, u):
        if not axis.low <= angle <= axis.high:
            raise _out_of_stroke(axis, angle)
        plus, minus, plus_volume, minus_volume = chambers(angle)
        inflow, outflow = flows(axis, first, second, spool)
        filling = inflow - plus * rate
        emptying = minus * rate - outflow
        if first <= 0:
            filling = max(filling, 0.0)
        if second <= 0:
            emptying = max(emptying, 0.0)
        return (
            plus * first - minus * second,
            axis.bulk * filling / (plus_volume + axis.hose),
            axis.bulk * emptying / (minus_volume + axis.hose),
            (u - spool) / axis.valve_lag,
            first * filling + second * emptying,
        )

    return oil


def flows(axis, first, second, spool):
    """Return the oil that flows into the plus side and out of the minus side, in m^3/s.

    Of an `axis` at pressures `first` and `second` of both sides, in Pa, and a `spool` position:
    through the lands, past the piston, and past the closed lands to and from either side.
    """
    opened = axis.flow * spool
    if spool > 0:
        inflow = opened * _root(axis.supply - first)
        outflow = opened * _root(second - axis.tank)
    else:
        inflow = opened * _root(first - axis.tank)
        outflow = opened * _root(axis.supply - second)
    past = axis.piston_leak * (first - second)
    both = axis.supply + axis.tank
    inflow += axis.valve_leak * (both - 2 * first) - past
    outflow += axis.valve_leak * (2 * second - both) - past
    return inflow, outflow


def resistance(axis, rate):
    """Return the torque of friction of an `axis`, in N m, at a `rate` in rad/s."""
    drag = axis.damping * rate
    return drag + axis.friction * math.tanh(rate / SLIP) if axis.friction else drag


def parts_of(tick, steps):
    """Return the whole number of `steps` of the integration in a `tick`, at least so many."""
    if steps > MOST_STEPS:
        raise ValueError(
            f"tick: must be at most {tick / steps * MOST_STEPS:.3g} s, which is {MOST_STEPS} steps "
            f"of the integration; got {tick:g} s."
        )
    return math.ceil(steps)


def _root(lost):
    """Return the signed root of a pressure lost, made straight where it is small."""
    return lost / (lost * lost + LAMINAR * LAMINAR) ** 0.25


def _out_of_stroke(axis, angle):
    return ValueError(
        f"setvalues: an axis must stay within its stroke, {math.degrees(axis.low):.1f} to "
        f"{math.degrees(axis.high):.1f} deg; it got to {math.degrees(angle):.1f} deg."
    )
