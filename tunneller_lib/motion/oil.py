"""Hydraulic axes in time: with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass

import numpy as np

from ..arguments import positive
from .hydraulics import Hydraulics
from .plant import Lag, ValveResonance

LAMINAR = 1e5  # Pa, below which the flow through a land turns from its root to a straight line
PHASE = 0.2  # rad of the fastest resonance, the longest step of the integration
STEP = 2e-3  # s, the longest step with rigid oil


@dataclass(frozen=True)
class Rigid:
    """T2: an axis whose oil doesn't give way; its state is angle and spool.

    Parameters
    ----------
    axis : Hydraulics
        The sizes.
    """

    axis: Hydraulics

    def command(self, rate, position):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)

    def linear(self, angle):
        """Return the linear plant (T1) of small motions about a joint angle, in rad."""
        return Lag(self.axis.resonance(angle).gain, self.axis.valve_lag)

    def rest(self, position):
        """Return the state at rest at a position, in rad."""
        return float(position), 0.0

    def stepper(self, tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        axis, tick = self.axis, positive("tick", tick)
        parts = math.ceil(tick / STEP)
        h = tick / parts
        fall = math.exp(-h / 2 / axis.valve_lag)

        def rate(angle, spool):
            if not axis.low <= angle <= axis.high:
                raise _out_of_stroke(axis, angle)
            forward, backward = axis.sides(angle)
            return axis.speed(spool, *forward) if spool > 0 else -axis.speed(-spool, *backward)

        def step(state, u):
            angle, spool = state
            for _ in range(parts):
                middle = u + (spool - u) * fall
                last = u + (middle - u) * fall
                k1 = rate(angle, spool)
                k2 = rate(angle + h / 2 * k1, middle)
                k3 = rate(angle + h / 2 * k2, middle)
                k4 = rate(angle + h * k3, last)
                angle, spool = angle + h / 6 * (k1 + 2 * (k2 + k3) + k4), last
            return angle, spool

        return step


@dataclass(frozen=True)
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

    def command(self, rate, position):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)

    def linear(self, angle):
        """Return the linear plant of small swings about rest at a joint angle, in rad.

        A valve that is hardly open lets no oil escape from a load that swings; the further it
        opens the more it damps. So these are the motions that grow first.
        """
        small, swing = self.axis.resonance(angle), float(self.axis.swing(angle))
        return ValveResonance(swing * small.gain, small.gain, small.frequency, small.damping,
                              self.axis.valve_lag)  # fmt: skip

    def rest(self, position):
        """Return the state at rest at a position, in rad: pressures that sum to the supply."""
        axis, angle = self.axis, float(position)
        plus, minus = axis.linkage.displacements(angle)
        first = (axis.load(angle) + minus * axis.supply) / (plus + minus)
        return angle, 0.0, first, axis.supply - first, 0.0

    def stepper(self, tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        axis, tick = self.axis, positive("tick", tick)
        fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
        parts = math.ceil(tick * max(fastest / PHASE, 1 / axis.valve_lag))
        h = tick / parts

        def step(state, u):
            for _ in range(parts):
                k1 = self.derivative(state, u)
                k2 = self.derivative([y + h / 2 * k for y, k in zip(state, k1, strict=True)], u)
                k3 = self.derivative([y + h / 2 * k for y, k in zip(state, k2, strict=True)], u)
                k4 = self.derivative([y + h * k for y, k in zip(state, k3, strict=True)], u)
                slopes = zip(state, k1, k2, k3, k4, strict=True)
                state = [y + h / 6 * (a + 2 * (b + c) + d) for y, a, b, c, d in slopes]
                state[2], state[3] = max(state[2], 0.0), max(state[3], 0.0)
            return tuple(state)

        return step

    def derivative(self, state, u):
        """Return the state's rate of change under a command u."""
        angle, rate, first, second, spool = state
        axis = self.axis
        if not axis.low <= angle <= axis.high:
            raise _out_of_stroke(axis, angle)
        plus, minus = axis.linkage.displacements(angle)
        plus_volume, minus_volume = axis.linkage.volumes(angle, axis.low, axis.high)
        opened = axis.flow * spool
        if spool > 0:
            inflow = opened * _root(axis.supply - first)
            outflow = opened * _root(second - axis.tank)
        else:
            inflow = opened * _root(first - axis.tank)
            outflow = opened * _root(axis.supply - second)
        torque = plus * first - minus * second - axis.load(angle) - axis.damping * rate
        filling = axis.bulk * (inflow - plus * rate) / (plus_volume + axis.hose)
        emptying = axis.bulk * (minus * rate - outflow) / (minus_volume + axis.hose)
        return (
            rate,
            torque / axis.inertia,
            filling if first > 0 else max(filling, 0.0),
            emptying if second > 0 else max(emptying, 0.0),
            (u - spool) / axis.valve_lag,
        )


def _root(lost):
    """Return the signed root of a pressure lost, made straight where it is small."""
    return lost / (lost * lost + LAMINAR * LAMINAR) ** 0.25


def _out_of_stroke(axis, angle):
    return ValueError(
        f"setvalues: an axis must stay within its stroke, {math.degrees(axis.low):.1f} to "
        f"{math.degrees(axis.high):.1f} deg; it got to {math.degrees(angle):.1f} deg."
    )
