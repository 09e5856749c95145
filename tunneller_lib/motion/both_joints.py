"""Both joints as one machine in time: the oil of both axes, the arm that they share, the ground.

The state of each axis is that of `Compressible`; arm and ground add torques. The energies are
integrated together with the states, so that they can be balanced after each tick.
"""

import math
from abc import ABC, abstractmethod
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .arm import Moments, couplings, lift_inertia, weights
from .hydraulics import Axis, load_at
from .oil import (
    along,
    flows,
    mean_step,
    oil_changes,
    parts_of,
    resistance,
    steps_of,
    with_pressures,
)

# The energy that the pump gives less what the tank gets, and where it goes.
ENERGIES = "supplied", "valves and leaks", "compressed oil", "friction", "ground"

# Longest step, relative to the time constant of a damper that stops the arm. The Runge-Kutta method
# is stable up to 2.78; with this the energies of a lap balance to a millionth.
DAMPED = 1.0
MOST_PARTS = 1_000_000  # integration steps in a tick
PUSHED = 10  # numbers in a row of `Push.rows`


class Push(NamedTuple):
    """The ground's resistance to both joints, in one tick or in several successive ones.

    Joint i, which turns at the rate w_i, moves the cutter at the speed u_i = lever_i w_i + drift_i
    along its own direction, and the machine moves it at drift_n across both. With the whole speed
    v = |u| and the force F = damper v, positive motion of the joint is resisted by the torque
    torque_i + F (lever_i u_i / v + across_i).

    Parameters
    ----------
    torque : (..., 2) float
        Torques that don't depend on the motion, in N m.
    damper : (...) float
        Force against the motion per speed, in N s/m.
    lever : (..., 2) float
        How far a radian of each joint moves the cutter, in m.
    across : (..., 2) float
        Levers of the force's part across the motion, in m.
    drift : (..., 3) float
        Speed of the cutter with the machine, along the ways of both joints and across both, in m/s.

    Examples
    --------
    >>> Push(torque=(20.0, 10.0)).rows.tolist()
    [[20.0, 10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """

    torque: tuple | np.ndarray = (0.0, 0.0)
    damper: float | np.ndarray = 0.0
    lever: tuple | np.ndarray = (0.0, 0.0)
    across: tuple | np.ndarray = (0.0, 0.0)
    drift: tuple | np.ndarray = (0.0, 0.0, 0.0)

    @property
    def rows(self):
        """Return torque, damper, lever, across and drift as rows (n, 10), one for each tick."""
        groups = self.torque, self.lever, self.across, self.drift
        shapes = np.shape(self.damper), *(np.shape(one)[:-1] for one in groups)
        rows = np.empty((*np.broadcast_shapes(*shapes), PUSHED))
        rows[..., :2], rows[..., 3:5], rows[..., 5:7], rows[..., 7:] = groups
        rows[..., 2] = self.damper
        return rows.reshape(-1, PUSHED)


class Resistance(ABC):
    """What resists both joints in the place of a `Push`, where it depends on how they move."""

    @abstractmethod
    def run(self, machine, tick, controls, memories, least, setvalues, slopes, states, commands):
        """Run both joints as `ticks.run_joints` does; return the number of full ticks.

        The arguments are the same, with the `least` number of steps in a tick.
        """


class TwoAxes(NamedTuple):
    """Both axes as plain numbers, and the arm, which counts if it is `shared`."""

    theta: Axis
    phi: Axis
    shared: bool
    arm: Moments


def machine_of(axes, arm):
    """Return the `TwoAxes` of two `Hydraulics` and an `Arm`, or None."""
    theta, phi = (axis.numbers for axis in axes)
    moments = Moments(0.0, 0.0, 0.0, 0.0) if arm is None else arm.moments
    return TwoAxes(theta, phi, arm is not None, moments)


def least_parts(axes, tick):
    """Return how many steps a `tick`, in s, needs for two `Hydraulics` that nothing pushes."""
    return parts_of(tick, tick * max(map(steps_of, axes)))


def parts_in(machine, least, rows, tick):
    """Return the numbers (n,) of steps, at least `least`, for ticks in s of a `machine`.

    The `TwoAxes` are pushed by `rows` of a `Push`.

    Examples
    --------
    >>> from tunneller_lib.motion.sizing import axes_of, usual_sizes
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE as reference
    >>> machine = machine_of(axes_of(reference, usual_sizes(reference)), None)
    >>> parts_in(machine, 4, Push(damper=1e12, lever=(1.0, 1.0)).rows, 0.01)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: ground: must be so soft that a tick takes at most 1000000 steps; got 1e+12 N ...
    """
    inertias = least_inertias(machine)
    parts = np.array([damped_parts(least, inertias, row, tick) for row in rows.tolist()])
    if parts.max(initial=0) > MOST_PARTS:
        raise ValueError(too_hard(rows[:, 2].max()))
    return parts


def damped_parts(least, inertias, push, tick):
    """Return the number of steps, at least `least`, for a tick in s; beyond `MOST_PARTS` one more.

    In hard ground the damper makes the equations stiff: their fastest rate is then the damper times
    lever^2 over the inertia, of which `inertias` are the least ones. `push` is a row of `Push`.
    """
    _, _, damper, theta_lever, phi_lever, theta_across, phi_across, _, _, _ = push
    theta_inertia, phi_inertia = inertias
    along = max(theta_lever * theta_lever / theta_inertia, phi_lever * phi_lever / phi_inertia)
    aside = abs(theta_lever * theta_across) / theta_inertia
    aside += abs(phi_lever * phi_across) / phi_inertia
    parts = tick * damper * (along + aside) / DAMPED
    if not parts <= MOST_PARTS:
        return MOST_PARTS + 1
    return max(least, -math.floor(-parts))


def too_hard(damper):
    """Return the sentence that refuses a ground whose damper, in N s/m, takes too short steps."""
    return (
        f"ground: must be so soft that a tick takes at most {MOST_PARTS} steps; got {damper:.3g} N "
        "for each metre a second."
    )


@lru_cache(64)
def least_inertias(machine):
    """Return the least inertias of theta and phi of a `TwoAxes` over phi's stroke, in kg m^2.

    Examples
    --------
    A bent arm of two kilograms, one of them 1 m beyond phi's joint, is lighter for theta:

    >>> from tunneller_lib.motion.sizing import axes_of, usual_sizes
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE as reference
    >>> machine = machine_of(axes_of(reference, usual_sizes(reference)), None)
    >>> machine = machine._replace(shared=True, arm=Moments(2.0, 1.0, 1.0, 1.0))
    >>> at_the_end = lift_inertia(machine.arm, machine.phi.high)
    >>> theta, phi = least_inertias(machine)
    >>> abs(theta / at_the_end - 1) < 1e-12, phi
    (True, 1.0)
    """
    theta, phi, shared, arm = machine
    if not shared:
        return theta.inertia, phi.inertia
    return float(np.min(lift_inertia(arm, np.linspace(phi.low, phi.high, 181)))), arm.second


def machine_tick(machine, state, openings, push, parts, tick):
    """Return both axes' states and the energies, each (5,), of a `machine` after a tick, in s.

    The classical Runge-Kutta method integrates the tick in `parts` steps, until an axis leaves its
    stroke. The `openings` are the commands of both valves, `push` is a row of `Push.rows`.
    """
    theta, phi = machine.theta, machine.phi
    h = tick / parts
    for _ in range(parts):
        k1 = machine_slopes(machine, state, openings, push)
        k2 = machine_slopes(machine, all_along(state, h / 2, k1), openings, push)
        k3 = machine_slopes(machine, all_along(state, h / 2, k2), openings, push)
        k4 = machine_slopes(machine, all_along(state, h, k3), openings, push)
        state = (
            with_pressures(mean_step(state[0], h, k1[0], k2[0], k3[0], k4[0])),
            with_pressures(mean_step(state[1], h, k1[1], k2[1], k3[1], k4[1])),
            mean_step(state[2], h, k1[2], k2[2], k3[2], k4[2]),
        )
        if not theta.low <= state[0][0] <= theta.high or not phi.low <= state[1][0] <= phi.high:
            break
    return state


def all_along(state, h, k):
    """Return both states and the energies after a time h, in s, at the rates of change k."""
    return along(state[0], h, k[0]), along(state[1], h, k[1]), along(state[2], h, k[2])


def machine_slopes(machine, state, openings, push):
    """Return the rates of change of both states and of the energies, for `machine_tick`.

    The arguments `machine`, `state`, `openings` and `push` are its own. The rates of the energies
    are powers in W, in the order of `ENERGIES`; the torques of the push are those of `Push`.
    """
    of_theta, of_phi, _ = state
    # Of each axis: its angle, its rate, the pressures of the plus and the minus side, its spool.
    theta, v, a, b, x = of_theta
    phi, w, c, d, y = of_phi
    lift, a_slope, b_slope, x_slope, theta_stored = oil_changes(
        machine.theta, of_theta, openings[0]
    )
    swing, c_slope, d_slope, y_slope, phi_stored = oil_changes(machine.phi, of_phi, openings[1])
    theta_rubbed = resistance(machine.theta, v)
    phi_rubbed = resistance(machine.phi, w)
    (
        theta_torque,
        phi_torque,
        damper,
        theta_lever,
        phi_lever,
        theta_across,
        phi_across,
        theta_drift,
        phi_drift,
        drift,
    ) = push
    rise = theta_lever * v + theta_drift
    turn = phi_lever * w + phi_drift
    speed = math.sqrt(rise * rise + turn * turn + drift * drift)
    # The force is damper times speed. Along the motion its lever is lever times the joint's share
    # of the speed, so that the speed cancels.
    theta_pushed = theta_torque + damper * (theta_lever * rise + speed * theta_across)
    phi_pushed = phi_torque + damper * (phi_lever * turn + speed * phi_across)
    lift -= theta_rubbed + theta_pushed
    swing -= phi_rubbed + phi_pushed
    # Theta's inertia of a shared arm depends on phi. Without one each axis has its own weight and
    # inertia.
    if machine.shared:
        theta_weight, phi_weight = weights(machine.arm, theta, phi)
        coriolis, centrifugal = couplings(machine.arm, phi, v, w)
        v_slope = (lift - theta_weight - coriolis) / lift_inertia(machine.arm, phi)
        w_slope = (swing - phi_weight - centrifugal) / machine.arm.second
    else:
        v_slope = (lift - load_at(machine.theta, theta)) / machine.theta.inertia
        w_slope = (swing - load_at(machine.phi, phi)) / machine.phi.inertia
    theta_supplied, theta_lost = powers(machine.theta, a, b, x)
    phi_supplied, phi_lost = powers(machine.phi, c, d, y)
    energies = (
        theta_supplied + phi_supplied,
        theta_lost + phi_lost,
        theta_stored + phi_stored,
        theta_rubbed * v + phi_rubbed * w,
        theta_pushed * v + phi_pushed * w,
    )
    return (
        (v, v_slope, a_slope, b_slope, x_slope),
        (w, w_slope, c_slope, d_slope, y_slope),
        energies,
    )


def powers(axis, first, second, spool):
    """Return the power of the pump less that to the tank, and the loss in valves and leaks, in W.

    `first` and `second` are the pressures of the plus and the minus side of an `axis`, in Pa, at a
    position of its `spool`.
    """
    # Each land and each leak loses its flow times the pressure drop across it. `flows` gives those
    # of lands and leaks together, so that the leaks are taken off again.
    inflow, outflow = flows(axis, first, second, spool)
    past = axis.piston_leak * (first - second)  # past the piston, from plus to minus
    leak = axis.valve_leak
    ps = axis.supply
    pt = axis.tank
    plus_land = inflow + past - leak * (ps + pt - 2 * first)
    minus_land = outflow + past - leak * (2 * second - ps - pt)
    leaks = leak * (2 * ps - first - second)
    returns = leak * (first + second - 2 * pt)
    # The spool joins one side to the supply and the other one to the tank. Flows out of the plus
    # side and into the minus side are negative here.
    if spool > 0:
        drawn = plus_land
        back = minus_land
        lost = plus_land * (ps - first) + minus_land * (second - pt)
    else:
        drawn = -minus_land
        back = -plus_land
        lost = plus_land * (pt - first) + minus_land * (second - ps)
    lost += past * (first - second)
    # Each side leaks past two lands, from the supply and to the tank, whether they are open or not.
    squares = (ps - first) * (ps - first) + (ps - second) * (ps - second)
    squares += (first - pt) * (first - pt) + (second - pt) * (second - pt)
    lost += leak * squares
    return ps * (drawn + leaks) - pt * (back + returns), lost
