"""Hydraulic axes in time: with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Finite, checked
from ..kernels.compiled import root
from ..surfaces.linkage import chambers, check_stroke
from .hydraulics import Axis, Hydraulics, load_at, sides_at, speed, spool_at
from .plant import Lag, Plant, ValveResonance
from .quantities import Tick, Torque

SLIP = 2e-3  # rad/s, over which dry friction passes from one direction to the other
LAMINAR = 1e5  # Pa, below which the flow through a land is nearly proportional to the pressure
PHASE = 0.2  # rad of the fastest resonance: the longest step of the integration
STEP = 2e-3  # s, the longest step with rigid oil
MOST_STEPS = 1000  # in a tick


class _Oily(Plant):
    """What the plants with cylinders share: their `axis`."""

    @property
    def hydraulics(self):
        """Return the sizes, a `Hydraulics`."""
        return self.axis

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position of a steady rate, in rad/s, at a position, in rad."""
        return self.axis.command(rate, position)


@dataclass(frozen=True)
@checked
class Rigid(_Oily):
    """T2: an axis with incompressible oil; its state is the angle and the spool's position.

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
        """Return the `OilTicks` of a tick, in s."""
        parts = parts_of(tick, tick / STEP)
        axis = self.axis.numbers
        fall = math.exp(-tick / parts / 2 / axis.valve_lag)
        return OilTicks(axis.low, axis.high, axis, parts, tick / parts, fall)

    def functions(self):
        """Return the functions that run the plant."""
        return {"ticked": rigid_tick, "commanding": opening_at}


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
    The flow through a land goes with the root of the pressure that it loses, and becomes linear
    below 1 bar. Where both lands lose at least p, and nothing leaks or rubs, steady rates differ
    from those of `Rigid` by at most (1 bar / p)^2 / 4 of themselves. Leaks are laminar. A pressure
    doesn't fall below zero; the void that the oil leaves there isn't remembered. The axes don't
    act on each other unless `follow` is given their `Arm`.
    """

    axis: Hydraulics

    @checked
    def linear(self, angle: Angle):
        """Return the linear plant of small swings about rest at a joint angle, in rad.

        A valve that is hardly open lets no oil escape from a swinging load, and the further it
        opens the more it damps. So of all motions those about rest grow first.
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

        They hold a `load` in N m that resists positive motion, by default the axis' own.
        """
        axis = self.axis
        check_stroke(position, axis.low, axis.high, "position")
        (plus, _, own), (minus, _, _) = sides_at(axis.numbers, position)
        load = own if load is None else load
        first = (load + minus * axis.supply) / (plus + minus)
        return position, 0.0, first, axis.supply - first, 0.0

    @checked
    def numbers(self, tick: Tick):
        """Return the `OilTicks` of a tick, in s."""
        axis = self.axis.numbers
        parts = parts_of(tick, tick * steps_of(self.axis))
        return OilTicks(axis.low, axis.high, axis, parts, tick / parts)

    def functions(self):
        """Return the functions that run the plant."""
        return {"ticked": compressible_tick, "commanding": opening_at}


class OilTicks(NamedTuple):
    """An axis with oil, its stroke, and the steps in which a tick is integrated.

    Parameters
    ----------
    low, high : float
        Joint angles at the ends of the stroke, in rad.
    axis : Axis
        Its cylinders, load, oil and valve.
    parts : int
        Number of steps in a tick.
    h : float
        Length of a step, in s.
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
    """Return the state (angle, spool) of a `plant` with rigid oil a tick later, under a command u.

    The integration ends where the axis leaves its stroke.
    """
    axis = plant.axis
    h = plant.h
    angle, spool = state
    for _ in range(plant.parts):
        # The spool follows u exponentially, exactly; the angle by Runge and Kutta's method.
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
    """Return the rate of an `axis` with rigid oil, in rad/s, at an angle and a spool position."""
    forward, backward = sides_at(axis, angle)
    if spool > 0:
        return speed(axis, spool, *forward)
    return -speed(axis, -spool, *backward)


def compressible_tick(plant, state, u):
    """Return the state (5,) of a `plant` with compressible oil a tick later, under a command u.

    The integration, by Runge and Kutta's method, ends where the axis leaves its stroke.
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
    """Return the changes (5,) a second of the state of an `axis` under a command u."""
    driven, filling, emptying, opening, _ = oil_changes(axis, state, u)
    torque = driven - load_at(axis, state[0]) - resistance(axis, state[1])
    return state[1], torque / axis.inertia, filling, emptying, opening


def along(state, h, k):
    """Return the state (5,) + h k, a time h, in s, later at the changes k (5,) a second."""
    return (
        state[0] + h * k[0],
        state[1] + h * k[1],
        state[2] + h * k[2],
        state[3] + h * k[3],
        state[4] + h * k[4],
    )


def mean_step(state, h, k1, k2, k3, k4):
    """Return the state (5,) after a step h, in s, from the four changes a second, each (5,).

    state + h/6 (k1 + 2 k2 + 2 k3 + k4), Runge and Kutta's method.
    """
    return (
        state[0] + h / 6 * (k1[0] + 2 * (k2[0] + k3[0]) + k4[0]),
        state[1] + h / 6 * (k1[1] + 2 * (k2[1] + k3[1]) + k4[1]),
        state[2] + h / 6 * (k1[2] + 2 * (k2[2] + k3[2]) + k4[2]),
        state[3] + h / 6 * (k1[3] + 2 * (k2[3] + k3[3]) + k4[3]),
        state[4] + h / 6 * (k1[4] + 2 * (k2[4] + k3[4]) + k4[4]),
    )


def with_pressures(state):
    """Return the state (5,) with pressures of at least zero."""
    angle, rate, first, second, spool = state
    return angle, rate, max(first, 0.0), max(second, 0.0), spool


def oil_changes(axis, state, u):
    """Return what the chambers and the spool of an `axis` do under a command u.

    That is the torque of both pressures, in N m; the changes of both, in Pa/s, and of the spool, in
    1/s; and the power that compresses the oil, in W.
    """
    angle, rate, first, second, spool = state
    plus, minus, plus_volume, minus_volume = chambers(axis.cylinders, angle)
    inflow, outflow = flows(axis, first, second, spool)
    filling = inflow - plus * rate
    emptying = minus * rate - outflow
    # Oil isn't pulled: at no pressure a chamber may fill, but not empty further.
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

    It flows through the lands that a `spool` opens, past the piston, and past the closed lands of
    an `axis`; `first` and `second` are the pressures of the plus and the minus side, in Pa.
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
    """Return the signed root of the pressure lost at a land, linear where it is small.

    lost / (lost^2 + LAMINAR^2)^(1/4): the root itself has an infinite slope at zero, which no
    step of the integration would be short enough for.
    """
    return lost / root(root(lost * lost + LAMINAR * LAMINAR))


def resistance(axis, rate):
    """Return the torque of viscous and dry friction of an `axis`, in N m, at a rate in rad/s."""
    drag = axis.damping * rate
    return drag + axis.friction * math.tanh(rate / SLIP) if axis.friction > 0 else drag


def opening_at(plant, rate, position):
    """Return the spool position that gives a `plant` with oil a steady rate, in rad/s."""
    return spool_at(plant.axis, rate, position)


@lru_cache(64)
def steps_of(axis):
    """Return in how many steps a second an `axis` with compressible oil must be integrated."""
    fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
    return max(fastest / PHASE, 1 / axis.valve_lag, axis.friction / (SLIP * axis.inertia))


def parts_of(tick, steps):
    """Return the number of `steps` of a `tick`, rounded up; too many raise ValueError."""
    if steps > MOST_STEPS:
        raise ValueError(
            f"tick: must be at most {tick / steps * MOST_STEPS:.3g} s, which is {MOST_STEPS} steps "
            f"of the integration; got {tick:g} s."
        )
    return math.ceil(steps)


def out_of_stroke(axis, angle):
    """Return the error to raise where an `axis` left its stroke and got to an angle, in rad."""
    return ValueError(
        f"setvalues: an axis must stay within its stroke, {math.degrees(axis.low):.1f} to "
        f"{math.degrees(axis.high):.1f} deg; it got to {math.degrees(angle):.1f} deg."
    )
