"""Hydraulic axes in time: with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Array, Finite, checked
from ..kernels.compiled import root
from ..surfaces.linkage import chambers, check_stroke
from .hydraulics import Axis, Hydraulics, load_at, sides_at, speed, spool_at
from .plant import Lag, Plant, ValveResonance
from .quantities import Tick, Torque

SLIP = 2e-3  # rad/s, within which dry friction turns from one direction to the other
LAMINAR = 1e5  # Pa, below which the flow through a land turns from its root to a straight line
PHASE = 0.2  # rad of the fastest resonance, the longest step of the integration
STEP = 2e-3  # s, the longest step with rigid oil
MOST_STEPS = 1000  # in a tick


State = Array("(5,) float", low=-1e15, high=1e15)


class _Oily(Plant):
    """What the plants with cylinders share: their `axis`."""

    @property
    def hydraulics(self):
        """Return the sizes of the axis."""
        return self.axis

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)


@dataclass(frozen=True)
@checked
class Rigid(_Oily):
    """T2: an axis whose oil doesn't give way; its state is angle and spool.

    Parameters
    ----------
    axis : Hydraulics
        The sizes.
    """

    axis: Hydraulics

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
    def numbers(self, tick: Tick):
        """Return the `OilTicks` of ticks, in s."""
        parts = parts_of(tick, tick / STEP)
        axis = self.axis.numbers
        fall = math.exp(-tick / parts / 2 / axis.valve_lag)
        return OilTicks(axis.low, axis.high, axis, parts, tick / parts, fall)

    def functions(self):
        """Return the functions that run the plant."""
        return {"ticked": rigid_tick, "commanding": opening_at}

    @checked
    def stepper(self, tick: Tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        return _within_stroke(rigid_tick, self.axis, self.numbers(tick))


@dataclass(frozen=True)
@checked
class Compressible(_Oily):
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
    def linear(self, angle: Angle):
        """Return the linear plant of small swings about rest at a joint angle, in rad.

        A valve that is hardly open lets no oil escape from a load that swings; the further it
        opens the more it damps. So these are the motions that grow first.
        """
        small = self.axis.resonance(angle)
        return ValveResonance(
            gain=float(self.axis.swing(angle)) * small.gain,
            steady=small.gain,
            frequency=small.frequency,
            damping=small.damping,
            lag=self.axis.valve_lag,
        )

    @checked
    def rest(self, position: Angle, load: Torque | None = None):
        """Return the state at rest at a position, in rad: pressures that sum to the supply.

        They hold a `load` in N m that resists positive motion; the axis' own by default.
        """
        axis = self.axis
        check_stroke(position, axis.low, axis.high, "position")
        (plus, _, own), (minus, _, _) = sides_at(axis.numbers, position)
        load = own if load is None else load
        first = (load + minus * axis.supply) / (plus + minus)
        return position, 0.0, first, axis.supply - first, 0.0

    @checked
    def numbers(self, tick: Tick):
        """Return the `OilTicks` of ticks, in s."""
        axis = self.axis.numbers
        parts = parts_of(tick, tick * steps_of(self.axis))
        return OilTicks(axis.low, axis.high, axis, parts, tick / parts)

    def functions(self):
        """Return the functions that run the plant."""
        return {"ticked": compressible_tick, "commanding": opening_at}

    @checked
    def stepper(self, tick: Tick):
        """Return the function (state, command) -> state one tick, in s, later."""
        return _within_stroke(compressible_tick, self.axis, self.numbers(tick))

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
        return compressible_slopes(self.axis.numbers, state, u)


class OilTicks(NamedTuple):
    """An axis with oil, its stroke, and the steps by which its ticks are integrated.

    Parameters
    ----------
    low, high : float
        Joint angles at the ends of the stroke, in rad.
    axis : Axis
        Its cylinders, load, oil and valve.
    parts : int
        Steps of a tick.
    h : float
        Of a step, in s.
    fall : float
        Share of the spool's way that is left after half a step.
    """

    low: float
    high: float
    axis: Axis
    parts: int
    h: float
    fall: float = 0.0


def rigid_tick(plant, state, u):
    """Return the state (angle, spool) of a `plant` of rigid oil a tick under a command u later.

    Once the axis has left its stroke it stays there.
    """
    axis = plant.axis
    h = plant.h
    angle, spool = state
    for _ in range(plant.parts):
        middle = u + (spool - u) * plant.fall
        last = u + (middle - u) * plant.fall
        k1 = rigid_rate(axis, angle, spool)
        k2 = rigid_rate(axis, angle + h / 2 * k1, middle)
        k3 = rigid_rate(axis, angle + h / 2 * k2, middle)
        k4 = rigid_rate(axis, angle + h * k3, last)
        angle = angle + h / 6 * (k1 + 2 * (k2 + k3) + k4)
        spool = last
        if not axis.low <= angle <= axis.high:
            break
    return angle, spool


def rigid_rate(axis, angle, spool):
    """Return the rate, in rad/s, of an `axis` with rigid oil at an angle, in rad, and a spool."""
    forward, backward = sides_at(axis, angle)
    if spool > 0:
        return speed(axis, spool, *forward)
    return -speed(axis, -spool, *backward)


def compressible_tick(plant, state, u):
    """Return the state (5,) of a `plant` of compressible oil a tick under a command u later.

    Once the axis has left its stroke it stays there.
    """
    axis = plant.axis
    h = plant.h
    for _ in range(plant.parts):
        k1 = compressible_slopes(axis, state, u)
        k2 = compressible_slopes(axis, along(state, h / 2, k1), u)
        k3 = compressible_slopes(axis, along(state, h / 2, k2), u)
        k4 = compressible_slopes(axis, along(state, h, k3), u)
        state = with_pressures(mean_step(state, h, k1, k2, k3, k4))
        if not axis.low <= state[0] <= axis.high:
            break
    return state


def compressible_slopes(axis, state, u):
    """Return the changes (5,) of the state of an `axis` under a command u; nothing is checked."""
    driven, filling, emptying, opening, _ = oil_changes(axis, state, u)
    torque = driven - load_at(axis, state[0]) - resistance(axis, state[1])
    return state[1], torque / axis.inertia, filling, emptying, opening


def along(state, h, k):
    """Return the state (5,) a time h, in s, later, as it changes by k (5,) in a second."""
    return (
        state[0] + h * k[0],
        state[1] + h * k[1],
        state[2] + h * k[2],
        state[3] + h * k[3],
        state[4] + h * k[4],
    )


def mean_step(state, h, k1, k2, k3, k4):
    """Return the state (5,) after a step h, in s, of Runge and Kutta's method.

    Its changes in a second are k1, k2, k3 and k4, each (5,), as the method asks for them.
    """
    return (
        state[0] + h / 6 * (k1[0] + 2 * (k2[0] + k3[0]) + k4[0]),
        state[1] + h / 6 * (k1[1] + 2 * (k2[1] + k3[1]) + k4[1]),
        state[2] + h / 6 * (k1[2] + 2 * (k2[2] + k3[2]) + k4[2]),
        state[3] + h / 6 * (k1[3] + 2 * (k2[3] + k3[3]) + k4[3]),
        state[4] + h / 6 * (k1[4] + 2 * (k2[4] + k3[4]) + k4[4]),
    )


def with_pressures(state):
    """Return the state (5,) with pressures that aren't below zero."""
    angle, rate, first, second, spool = state
    return angle, rate, max(first, 0.0), max(second, 0.0), spool


def oil_changes(axis, state, u):
    """Return what the chambers and the spool of an `axis` do under a command u.

    That is the torque of both pressures, in N m, how these change, in Pa/s, and the spool, in 1/s,
    and the power that compresses the oil, in W.
    """
    angle, rate, first, second, spool = state
    plus, minus, plus_volume, minus_volume = chambers(axis.cylinders, angle)
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


def flows(axis, first, second, spool):
    """Return the oil that flows into the plus side and out of the minus side, in m^3/s.

    Of an `axis` at pressures `first` and `second` of both sides, in Pa, and a `spool` position:
    through the lands, past the piston, and past the closed lands to and from either side.
    """
    opened = axis.flow * spool
    if spool > 0:
        inflow = opened * land(axis.supply - first)
        outflow = opened * land(second - axis.tank)
    else:
        inflow = opened * land(first - axis.tank)
        outflow = opened * land(axis.supply - second)
    past = axis.piston_leak * (first - second)
    both = axis.supply + axis.tank
    inflow += axis.valve_leak * (both - 2 * first) - past
    outflow += axis.valve_leak * (2 * second - both) - past
    return inflow, outflow


def land(lost):
    """Return the signed root of a pressure lost at a land, made straight where it is small."""
    return lost / root(root(lost * lost + LAMINAR * LAMINAR))


def resistance(axis, rate):
    """Return the torque of friction of an `axis`, in N m, at a `rate` in rad/s."""
    drag = axis.damping * rate
    return drag + axis.friction * math.tanh(rate / SLIP) if axis.friction > 0 else drag


def opening_at(plant, rate, position):
    """Return the spool position of a steady `rate`, in rad/s, of a `plant` with oil."""
    return spool_at(plant.axis, rate, position)


@lru_cache(64)
def steps_of(axis):
    """Return by how many steps a second an `axis` with compressible oil must be integrated."""
    fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
    return max(fastest / PHASE, 1 / axis.valve_lag, axis.friction / (SLIP * axis.inertia))


def parts_of(tick, steps):
    """Return the whole number of `steps` of the integration in a `tick`, at least so many."""
    if steps > MOST_STEPS:
        raise ValueError(
            f"tick: must be at most {tick / steps * MOST_STEPS:.3g} s, which is {MOST_STEPS} steps "
            f"of the integration; got {tick:g} s."
        )
    return math.ceil(steps)


def _within_stroke(ticked, axis, plant):
    """Return the function (state, command) -> state one tick later, within the stroke."""

    def step(state, u):
        state = ticked(plant, state, u)
        if not axis.low <= state[0] <= axis.high:
            raise out_of_stroke(axis, state[0])
        return state

    return step


def out_of_stroke(axis, angle):
    """Return the error of an `axis` that left its stroke for an angle, in rad."""
    return ValueError(
        f"setvalues: an axis must stay within its stroke, {math.degrees(axis.low):.1f} to "
        f"{math.degrees(axis.high):.1f} deg; it got to {math.degrees(angle):.1f} deg."
    )
