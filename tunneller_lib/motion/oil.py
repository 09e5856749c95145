"""Hydraulic axes in time, with rigid oil (T2) and with compressible oil (T3)."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Finite, checked
from ..kernels.compiled import root
from ..kernels.repeatable import tangent
from ..surfaces.linkage import chambers, check_stroke
from .hydraulics import Axis, Hydraulics, load_at, sides_at, speed, spool_at
from .plant import Lag, Plant, ValveResonance
from .quantities import Tick, Torque

SLIP = 2e-3  # rad/s, the scale of rates on which dry friction changes its direction
LAMINAR = 1e5  # Pa, below which a land's flow is nearly proportional to its pressure drop
PHASE = 0.2  # rad of the fastest resonance, the longest step of the integration
STEP = 2e-3  # s, the longest step with rigid oil
MOST_STEPS = 1000  # in a tick


class _Oily(Plant):
    """A plant with cylinders, the sizes of which are its `axis`."""

    @property
    def hydraulics(self):
        """Return the sizes, a `Hydraulics`."""
        return self.axis

    @checked
    def command(self, rate: Finite, position: Angle):
        """Return the spool position of a steady rate in rad/s at a position in rad."""
        return self.axis.command(rate, position)


@dataclass(frozen=True)
@checked
class Rigid(_Oily):
    """T2: an axis with incompressible oil; its state is the angle and the spool position.

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
        """Return the functions that run the plant, by their names in `ticks`."""
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
    The flow through a land goes with the root of its pressure drop, and becomes linear below 1
    bar. Where both lands drop at least p, and without leaks and dry friction, steady rates differ
    from those of `Rigid` by at most the share (1 bar / p)^2 / 4. Leaks are laminar. A pressure
    doesn't fall below zero; the void that then forms isn't modelled. The axes act on each other
    only if `follow` is given their `Arm`.
    """

    axis: Hydraulics

    @checked
    def linear(self, angle: Angle):
        """Return the linear plant of small swings about rest at a joint angle, in rad.

        A valve that is hardly open lets no oil escape from a swinging load, and damps more the
        further it opens. So motions about rest become unstable first.
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
        """Return the state at rest at a position in rad, with pressures that sum to the supply.

        They hold a `load` in N m that resists positive motion, by default the axis' own weight.
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
        """Return the functions that run the plant, by their names in `ticks`."""
        return {"ticked": compressible_tick, "commanding": opening_at}


class OilTicks(NamedTuple):
    """An axis with oil as numbers: its stroke, and the steps in which a tick is integrated.

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
    """Return the state (angle, spool) of a `plant` with rigid oil after a tick under a command u.

    The integration ends where the axis leaves its stroke.
    """
    axis = plant.axis
    h = plant.h
    angle, spool = state
    for _ in range(plant.parts):
        # The spool's exponential is exact; the angle goes by the classical Runge-Kutta method.
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
    """Return the state (5,) of a `plant` with compressible oil after a tick under a command u.

    The classical Runge-Kutta integration ends where the axis leaves its stroke.
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
    """Return the rates of change (5,) of the state of an `axis` under a command u."""
    driven, filling, emptying, opening, _ = oil_changes(axis, state, u)
    torque = driven - load_at(axis, state[0]) - resistance(axis, state[1])
    return state[1], torque / axis.inertia, filling, emptying, opening


def along(state, h, k):
    """Return the state (5,) + h k after a time h in s at the rates of change k (5,)."""
    return (
        state[0] + h * k[0],
        state[1] + h * k[1],
        state[2] + h * k[2],
        state[3] + h * k[3],
        state[4] + h * k[4],
    )


def mean_step(state, h, k1, k2, k3, k4):
    """Return state + h/6 (k1 + 2 k2 + 2 k3 + k4), each (5,), after a Runge-Kutta step h in s."""
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
    """Return the torque of the oil of an `axis`, rates of change under a command u, and a power.

    The torque is in N m; the rates are those of both pressures, in Pa/s, and of the spool, in 1/s;
    the power, in W, compresses the oil.
    """
    angle, rate, first, second, spool = state
    plus, minus, plus_volume, minus_volume = chambers(axis.cylinders, angle)
    inflow, outflow = flows(axis, first, second, spool)
    filling = inflow - plus * rate
    emptying = minus * rate - outflow
    # Oil bears no tension: a chamber at zero pressure may fill, but not empty further.
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
    """Return the flows of oil into the plus side and out of the minus side, in m^3/s.

    The oil passes the two lands that a `spool` opens, and leaks past the piston and all four lands
    of an `axis`; `first` and `second` are the pressures of the plus and the minus side, in Pa.
    """
    opened = axis.flow * spool
    # A land whose pressure drop is negative lets the oil flow backwards, by the sign of `land`.
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
    """Return the signed root of the pressure drop `lost` at a land, linear where it is small.

    The form lost / (lost^2 + LAMINAR^2)^(1/4) has a finite slope at zero; with that of the root
    itself, which is infinite, no step of the integration would be short enough.
    """
    return lost / root(root(lost * lost + LAMINAR * LAMINAR))


def resistance(axis, rate):
    """Return the torque of viscous and dry friction of an `axis`, in N m, at a rate in rad/s."""
    drag = axis.damping * rate
    return drag + axis.friction * tangent(rate / SLIP) if axis.friction > 0 else drag


def opening_at(plant, rate, position):
    """Return the spool position of a steady rate in rad/s of a `plant` with oil at a `position`."""
    return spool_at(plant.axis, rate, position)


@lru_cache(64)
def steps_of(axis):
    """Return the number of steps per second that an `axis` with compressible oil needs."""
    fastest = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
    return max(fastest / PHASE, 1 / axis.valve_lag, axis.friction / (SLIP * axis.inertia))


def parts_of(tick, steps):
    """Return the number of `steps` of a `tick` in s, rounded up; too many raise ValueError.

    Examples
    --------
    >>> parts_of(0.01, 12.5), parts_of(0.01, 1000)
    (13, 1000)
    >>> parts_of(0.01, 2000)
    Traceback (most recent call last):
    ValueError: tick: must be at most 0.005 s, which is 1000 steps of the integration; got 0.01 s.
    """
    if steps > MOST_STEPS:
        raise ValueError(
            f"tick: must be at most {tick / steps * MOST_STEPS:.3g} s, which is {MOST_STEPS} steps "
            f"of the integration; got {tick:g} s."
        )
    return math.ceil(steps)


def out_of_stroke(axis, angle):
    """Return the error to raise for an `axis` that left its stroke and reached an angle in rad."""
    return ValueError(
        f"setvalues: an axis must stay within its stroke, {math.degrees(axis.low):.1f} to "
        f"{math.degrees(axis.high):.1f} deg; got {math.degrees(angle):.1f} deg."
    )
