"""Both joints as one machine in time: oil of both axes, the arm that they share, and the ground.

The state of each axis is that of `Compressible`. What the arm and the ground add are torques; where
the energy goes is integrated along, so that a balance can be drawn after each tick.
"""

import math
from typing import NamedTuple

import numpy as np

from .arm import GRAVITY
from .hydraulics import load_at
from .oil import PHASE, SLIP, flows, oil_of, parts_of, resistance

# What the oil from the pump brings, less what it still holds in the tank's line, and where it goes.
ENERGIES = "supplied", "valves and leaks", "compressed oil", "friction", "ground"

DAMPED = 0.33  # of the time in which a damper alone stops the arm, the longest step


class Push(NamedTuple):
    """What the ground does to both joints during a tick.

    It resists positive motion of the joint i, at the rate w_i, by the torque torque_i +
    damper (lever_i^2 w_i + v across_i), with the cutter's speed v = |(lever_i w_i)|.
    """

    torque: tuple = (0.0, 0.0)  # N m, whatever the rates
    damper: float = 0.0  # N s/m, the force against the motion over the speed
    lever: tuple = (0.0, 0.0)  # m, how far the cutter moves by a radian of each joint
    across: tuple = (0.0, 0.0)  # m, levers of the share of the force that pushes out of the wall


def stepper(axes, arm, tick):
    """Return the function (states, commands, push) -> states one `tick`, in s, later.

    States are those of both axes and the energies (5,) so far, in J; `axes` are two `Hydraulics`,
    `arm` an `Arm` or None.
    """
    fastest = max(_fastest(axis) for axis in axes)
    least = parts_of(tick, tick * fastest)
    slopes = _slopes_of(axes, arm)

    def step(states, commands, push):
        state = [y for each in states for y in each]
        # The damper is stiff where the ground is hard, and changes from tick to tick.
        stiff = push.damper * max(
            lever * lever / axis.inertia for lever, axis in zip(push.lever, axes, strict=True)
        )
        parts = max(least, parts_of(tick, tick * stiff / DAMPED))
        h = tick / parts
        for _ in range(parts):
            k1 = slopes(state, commands, push)
            k2 = slopes([y + h / 2 * k for y, k in zip(state, k1, strict=True)], commands, push)
            k3 = slopes([y + h / 2 * k for y, k in zip(state, k2, strict=True)], commands, push)
            k4 = slopes([y + h * k for y, k in zip(state, k3, strict=True)], commands, push)
            each = zip(state, k1, k2, k3, k4, strict=True)
            state = [y + h / 6 * (a + 2 * (b + c) + d) for y, a, b, c, d in each]
            for side in (2, 3, 7, 8):
                state[side] = max(state[side], 0.0)
        return tuple(state[:5]), tuple(state[5:10]), tuple(state[10:])

    return step


def _fastest(axis):
    """Return by how many steps a second an axis must be integrated."""
    frequency = np.max(axis.natural_frequency(np.linspace(axis.low, axis.high, 181)))
    return max(frequency / PHASE, 1 / axis.valve_lag, axis.friction / (SLIP * axis.inertia))


def _slopes_of(axes, arm):
    """Return the function (state, commands, push) -> the changes of states and energies."""
    theta_axis, phi_axis = axes
    theta_oil = oil_of(theta_axis)
    phi_oil = oil_of(phi_axis)
    if arm is not None:
        mass, first, second = arm.moments

    def slopes(state, commands, push):
        theta, v, a, b, x, phi, w, c, d, y, *_ = state
        lift, a_slope, b_slope, x_slope, theta_stored = theta_oil(theta, v, a, b, x, commands[0])
        swing, c_slope, d_slope, y_slope, phi_stored = phi_oil(phi, w, c, d, y, commands[1])
        rubbed = resistance(theta_axis, v), resistance(phi_axis, w)
        lift -= rubbed[0]
        swing -= rubbed[1]
        along, across = push.lever, push.across
        speed = math.hypot(along[0] * v, along[1] * w)
        pushed = (
            push.torque[0] + push.damper * (along[0] * along[0] * v + speed * across[0]),
            push.torque[1] + push.damper * (along[1] * along[1] * w + speed * across[1]),
        )
        lift -= pushed[0]
        swing -= pushed[1]
        ground = pushed[0] * v + pushed[1] * w
        if arm is None:
            v_slope = (lift - load_at(theta_axis, theta)) / theta_axis.inertia
            w_slope = (swing - load_at(phi_axis, phi)) / phi_axis.inertia
        else:
            cos, sin = math.cos(phi), math.sin(phi)
            half = -sin * (arm.r * first + second * cos)
            inertia = mass * arm.r**2 + 2 * arm.r * first * cos + second * cos * cos
            weight = GRAVITY * math.cos(theta) * (mass * arm.r + first * cos)
            v_slope = (lift + weight - 2 * half * v * w) / inertia
            w_slope = (swing - GRAVITY * math.sin(theta) * first * sin + half * v * v) / second
        theta_supplied, theta_lost = _powers(theta_axis, a, b, x)
        phi_supplied, phi_lost = _powers(phi_axis, c, d, y)
        friction = rubbed[0] * v + rubbed[1] * w
        return (
            v, v_slope, a_slope, b_slope, x_slope,
            w, w_slope, c_slope, d_slope, y_slope,
            theta_supplied + phi_supplied, theta_lost + phi_lost, theta_stored + phi_stored,
            friction, ground,
        )  # fmt: skip

    return slopes


def _powers(axis, first, second, spool):
    """Return what the pump gives less what the tank gets, and what valves and leaks take, in W."""
    # Of each land and leak the flow times the pressure that it loses.
    inflow, outflow = flows(axis, first, second, spool)
    past = axis.piston_leak * (first - second)
    leak = axis.valve_leak
    ps, pt = axis.supply, axis.tank
    plus_land = inflow + past - leak * (ps + pt - 2 * first)
    minus_land = outflow + past - leak * (2 * second - ps - pt)
    leaks = leak * (2 * ps - first - second)
    returns = leak * (first + second - 2 * pt)
    if spool > 0:
        drawn, back = plus_land, minus_land
        lost = plus_land * (ps - first) + minus_land * (second - pt)
    else:
        drawn, back = -minus_land, -plus_land
        lost = plus_land * (pt - first) + minus_land * (second - ps)
    lost += past * (first - second)
    lost += leak * ((ps - first) ** 2 + (ps - second) ** 2 + (first - pt) ** 2 + (second - pt) ** 2)
    return ps * (drawn + leaks) - pt * (back + returns), lost
