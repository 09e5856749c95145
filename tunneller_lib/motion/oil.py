"""Hydraulic axes in time: with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Angle, Finite, Rule, checked
from ..surfaces.linkage import check_stroke
from .hydraulics import Hydraulics, displacements_at, load_at, sides_at, speed, volumes_at
from .plant import Lag, ValveResonance
from .quantities import Tick, moderate_array

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
        parts = _parts(tick, tick / STEP)
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
    Lands leak nothing when shut; their flow is the root of the pressure lost, straightened below
    1 bar: where both lose at least p, steady rates are those of `Rigid` to (1 bar / p)^2 / 4 of
    themselves. Oil that would be torn apart stays at pressure zero, and the void isn't remembered.
    The axes don't feel each other.
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
    def rest(self, position: Angle):
        """Return the state at rest at a position, in rad: pressures that sum to the supply."""
        axis = self.axis
        check_stroke(position, axis.low, axis.high, "position")
        (plus, _, load), (minus, _, _) = sides_at(axis, position)
        first = (load + minus * axis.supply) / (plus + minus)
        return position, 0.0, first, axis.supply - first, 0.0

    @checked
    def stepper(self, tick: Tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        axis = self.axis
        fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
        parts = _parts(tick, tick * max(fastest / PHASE, 1 / axis.valve_lag))
        h = tick / parts

        def step(state, u):
            for _ in range(parts):
                k1 = _slopes(axis, state, u)
                k2 = _slopes(axis, [y + h / 2 * k for y, k in zip(state, k1, strict=True)], u)
                k3 = _slopes(axis, [y + h / 2 * k for y, k in zip(state, k2, strict=True)], u)
                k4 = _slopes(axis, [y + h * k for y, k in zip(state, k3, strict=True)], u)
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
        return _slopes(self.axis, state, u)


def _slopes(axis, state, u):
    """Return `Compressible.derivative`, unchecked but for the stroke's ends."""
    angle, rate, first, second, spool = state
    if not axis.low <= angle <= axis.high:
        raise _out_of_stroke(axis, angle)
    plus, minus = displacements_at(axis.linkage, angle)
    plus_volume, minus_volume = volumes_at(axis.linkage, angle, axis.low, axis.high)
    opened = axis.flow * spool
    if spool > 0:
        inflow = opened * _root(axis.supply - first)
        outflow = opened * _root(second - axis.tank)
    else:
        inflow = opened * _root(first - axis.tank)
        outflow = opened * _root(axis.supply - second)
    load = load_at(axis, angle)
    torque = plus * first - minus * second - load - axis.damping * rate
    filling = axis.bulk * (inflow - plus * rate) / (plus_volume + axis.hose)
    emptying = axis.bulk * (minus * rate - outflow) / (minus_volume + axis.hose)
    return (
        rate,
        torque / axis.inertia,
        filling if first > 0 else max(filling, 0.0),
        emptying if second > 0 else max(emptying, 0.0),
        (u - spool) / axis.valve_lag,
    )


def _parts(tick, steps):
    """Return the whole number of steps of the integration in a tick, at least so many."""
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
