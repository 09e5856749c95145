"""Loops and axes from tick to tick: what `follow` asks for, in numbers that can be compiled."""

import math
from typing import NamedTuple

import numpy as np

from ..arguments import shown
from ..kernels.compiled import call, call_plain, expect
from .both_joints import ENERGIES, Push, least_parts, machine_of, machine_tick, parts_in
from .hydraulics import spool_at
from .oil import Compressible, out_of_stroke

# About how long a tick takes in plain Python, in s: of any loop, and for each part of it.
PLAIN_TICK, PLAIN_PART = 2e-6, 3e-5


class Control(NamedTuple):
    """A `Loop` as plain numbers."""

    gain: float
    growth: float  # of the sum, by tick and following error
    share: float
    count: float
    limit: float
    dead: float
    compensated: bool
    delay: int


def control_of(loop):
    """Return the `Control` of a `Loop`."""
    return Control(
        loop.gain,
        loop.integral * loop.tick,
        loop.feedforward,
        loop.count,
        loop.limit,
        loop.dead_band,
        loop.compensated,
        loop.delay,
    )


def ticked(plant, state, u):
    """Stand in for what takes the state of a `plant` under a command u a tick further."""
    raise NotImplementedError


def commanding(plant, rate, position):
    """Stand in for the command of a steady `rate` of a `plant` at a position, in rad/s and rad."""
    raise NotImplementedError


def commanded(plant, control, grown, wanted, slope, position):
    """Return the command of a tick, for a set-value and its slope at a measured position.

    Of the following error e the loop makes the rate gain e + integral sum(e tick) + share slope,
    and the static inverse of the `plant` says which command gives it. `control` is a `Control`,
    `grown` the integral so far, which is returned as well, with this tick's share. `wanted`,
    `slope` and `position` are in rad and rad/s.
    """
    # The encoder tells whole counts, the nearest.
    if control.count > 0:
        position = control.count * nearest(position / control.count)
    error = wanted - position
    u = commanding(plant, control.gain * error + grown + control.share * slope, position)
    # Compensated, a command begins where the valve's dead band ends. One choice of two sums would
    # hold up every tick of a compiled loop by a quarter, whether there is a dead band or not.
    if control.compensated and control.dead > 0:
        if u > 0:
            u = (1 - control.dead) * u + control.dead
        elif u < 0:
            u = (1 - control.dead) * u - control.dead
    # While the valve is fully open the sum waits: it would only grow, and overshoot later.
    if u > control.limit:
        u = control.limit
    elif u < -control.limit:
        u = -control.limit
    else:
        grown += control.growth * error
    return u, grown


def delayed(control, memory, tick, u):
    """Return the command that reaches the valve in a tick in which the loop answers u.

    With a delay of n ticks it is that of n ticks ago. `control` is a `Control`; `memory` holds the
    commands that wait, from its second place on.
    """
    if control.delay == 0:
        return u
    place = 1 + tick % control.delay
    waited = memory[place]
    memory[place] = u
    return waited


def nearest(number):
    """Return the whole number, a float, that is nearest; of two the greater."""
    # Above 2^52 all are whole.
    return float(math.floor(number + 0.5)) if abs(number) < 4.5e15 else number


def opened(u, dead):
    """Return how far a valve opens whose first `dead` share of the command u does nothing."""
    if dead == 0:
        return u
    beyond = abs(u) - dead
    if beyond <= 0:
        return 0.0
    return (beyond if u > 0 else -beyond) / (1 - dead)


def run_axis(plant, control, memory, state, setvalues, slopes, states, commands):
    """Run the axis of a `plant`, fill its states and commands, and return the ticks run.

    They are fewer than there are slopes where it left its stroke. `control` is a `Control`,
    `memory` (1 + delay,) the loop's integral, and its commands that wait; `setvalues` and `slopes`,
    in rad and rad/s, and `commands` are rows, `states` are as many rows as the `state` has numbers,
    which begin with it.
    """
    grown = memory[0]
    for tick in range(len(slopes)):
        u, grown = commanded(plant, control, grown, setvalues[tick], slopes[tick], state[0])
        u = delayed(control, memory, tick, u)
        state = ticked(plant, state, opened(u, control.dead))
        commands[tick] = u
        for i in range(len(state)):
            states[i][tick + 1] = state[i]
        if not plant.low <= state[0] <= plant.high:
            return tick
    return len(slopes)


def run_joints(
    machine,
    tick,
    controls,
    memories,
    first,
    state,
    setvalues,
    slopes,
    pushes,
    parts,
    states,
    commands,
):
    """Run both axes of a `machine` from tick `first` on, as `run_axis` does one.

    Rows are of theta and phi: `controls`, `memories`, `setvalues`, `slopes`, `commands`; those of
    `states` and the `state` to begin with are of theta, of phi, and the energies so far. `tick` is
    in s, `pushes` are `Push.rows`, `parts` those of the ticks.
    """
    theta = machine.theta
    phi = machine.phi
    for n in range(len(parts)):
        theta_u, memories[0][0] = commanded(
            theta, controls[0], memories[0][0], setvalues[n][0], slopes[n][0], state[0][0]
        )
        phi_u, memories[1][0] = commanded(
            phi, controls[1], memories[1][0], setvalues[n][1], slopes[n][1], state[1][0]
        )
        theta_u = delayed(controls[0], memories[0], first + n, theta_u)
        phi_u = delayed(controls[1], memories[1], first + n, phi_u)
        openings = opened(theta_u, controls[0].dead), opened(phi_u, controls[1].dead)
        state = machine_tick(machine, state, openings, pushes[n], parts[n], tick)
        commands[n][0] = theta_u
        commands[n][1] = phi_u
        for i in range(5):
            states[n + 1][i] = state[0][i]
            states[n + 1][5 + i] = state[1][i]
            states[n + 1][10 + i] = state[2][i]
        if not theta.low <= state[0][0] <= theta.high or not phi.low <= state[1][0] <= phi.high:
            return n
    return len(parts)


def run_each(plants, loops, setvalues, slopes, own_inverse):
    """Return states and commands, a list of each, of `plants` under `loops` that share nothing.

    The columns of `setvalues` (ticks + 1, n), in rad, and of `slopes` (ticks, n), in rad/s, are
    theirs; `own_inverse` is a caller's, as in `follow`, or None.
    """
    all_states = []
    all_commands = []
    ticks = len(slopes)
    for plant, loop, values, rates in zip(plants, loops, setvalues.T, slopes.T, strict=True):
        numbers = plant.numbers(loop.tick)
        start = tuple(map(float, plant.rest(float(values[0]))))
        states = np.empty((len(start), ticks + 1))
        states[:, 0] = start
        commands = np.empty(ticks)
        given = (
            numbers,
            control_of(loop),
            np.zeros(1 + loop.delay),
            start,
            *(np.require(row, requirements="CW") for row in (values, rates)),
            states,
            commands,
        )
        expect(plain_seconds(numbers, ticks), "axes")
        kept = _run(run_axis, given, own_inverse, **plant.functions())
        if kept < ticks:
            raise out_of_stroke(numbers, states[0, kept + 1])
        all_states.append(states.T)
        all_commands.append(commands)
    return all_states, all_commands


def run_together(plants, loops, setvalues, slopes, own_inverse, arm, push):
    """Return what `run_each` does, of both axes of one machine, and the energies (ticks + 1, 5).

    `plants`, `loops`, `setvalues` (ticks + 1, 2), `slopes` (ticks, 2), `own_inverse`, `arm` and
    `push` are as in `follow`.
    """
    if len(plants) != 2 or not all(isinstance(one, Compressible) for one in plants):
        raise ValueError(
            "plant: must be two of class Compressible where the axes share an arm or are pushed; "
            f"got {shown([type(one).__name__ for one in plants])}."
        )
    axes = [one.axis for one in plants]
    setvalues = setvalues.copy()
    slopes = slopes.copy()
    tick = loops[0].tick
    ticks = len(slopes)
    if not callable(push):
        every = np.broadcast_to((push or Push()).rows, (ticks, 9))
    loads = [None, None] if arm is None else arm.weight(setvalues[0]).tolist()
    starts = zip(plants, setvalues[0].tolist(), loads, strict=True)
    rests = [plant.rest(angle, load) for plant, angle, load in starts]
    states = np.zeros((ticks + 1, 10 + len(ENERGIES)))
    states[0, :10] = np.ravel(rests)
    commands = np.empty((ticks, 2))
    machine = machine_of(axes, arm)
    controls = tuple(map(control_of, loops))
    memories = np.zeros((2, 1 + max(loop.delay for loop in loops)))
    expect_run(plants, tick, ticks)
    least = least_parts(axes, tick)
    done = 0
    while done < ticks:
        answer = push(done, None) if callable(push) else every
        state = tuple(map(tuple, states[done].reshape(3, 5).tolist()))
        remembered = memories.copy()
        while answer is not None:
            rows = answer.rows if callable(push) else every
            rows = np.array(rows[: ticks - done], order="C")  # in one order, for one compiled form
            end = done + len(rows)
            memories[:] = remembered
            given = (
                machine,
                tick,
                controls,
                memories,
                done,
                state,
                setvalues[done:end],
                slopes[done:end],
                rows,
                parts_in(machine, least, rows, tick),
                states[done : end + 1],
                commands[done:end],
            )
            kept = _run(run_joints, given, own_inverse, commanding=spool_at)
            if kept < len(rows):
                for axis, angle in zip(axes, states[done + kept + 1, [0, 5]], strict=True):
                    if not axis.low <= angle <= axis.high:
                        raise out_of_stroke(axis, angle)
            answer = push(done, states[done : end + 1, [0, 5]]) if callable(push) else None
        done = end
    return [states[:, :5], states[:, 5:10]], list(commands.T), states[:, 10:]


def plain_seconds(numbers, ticks):
    """Return about how long an axis of such `numbers` takes in plain Python for `ticks`, in s."""
    return ticks * (PLAIN_TICK + PLAIN_PART * getattr(numbers, "parts", 0))


def expect_run(plants, tick, ticks):
    """Say that `plants` will be run for so many `ticks` of a `tick` in s: see `compiled.expect`."""
    expect(sum(plain_seconds(plant.numbers(tick), ticks) for plant in plants), "axes")


def _run(function, given, own_inverse, **parts):
    """Return what `call` does; in plain Python with a caller's own inverse, of rate and angle."""
    if own_inverse is None:
        return call(function, *given, kind="axes", **parts)
    parts["commanding"] = lambda plant, rate, position: own_inverse(rate, position)
    return call_plain(function, *given, **parts)
