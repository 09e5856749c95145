"""Loops and axes from tick to tick: the loops of `follow`, on numbers, which can be compiled."""

import math
from typing import NamedTuple

import numpy as np

from ..arguments import shown
from ..kernels.compiled import call, call_plain, expect
from .both_joints import ENERGIES, PUSHED, Push, least_parts, machine_of, machine_tick, parts_in
from .hydraulics import spool_at
from .oil import Compressible, out_of_stroke

# Times that a tick and each step of its integration take in plain Python, in s.
PLAIN_TICK, PLAIN_PART = 2e-6, 3e-5


class Control(NamedTuple):
    """A `Loop` as plain numbers."""

    gain: float
    growth: float  # of the integral in a tick, for each radian of following error
    share: float
    count: float
    limit: float
    delay: int


def control_of(loop):
    """Return the `Control` of a `Loop`."""
    return Control(
        loop.gain, loop.integral * loop.tick, loop.feedforward, loop.count, loop.limit, loop.delay
    )


def ticked(plant, state, u):
    """Stand in for the plant's function that returns its state after a tick under a command u."""
    raise NotImplementedError


def commanding(plant, rate, position):
    """Stand in for the plant's function that returns the command of a steady rate in rad/s."""
    raise NotImplementedError


def commanded(plant, control, grown, wanted, slope, position):
    """Return the command of a tick, and the integral `grown` by its following error.

    With the error e = wanted - position, as the encoder measures it, the wanted rate is gain e +
    integral sum(e tick) + share slope, of which the static inverse of the `plant` gives the
    command. `control` is a `Control`; `wanted`, `slope` and `position` are in rad and rad/s.
    """
    # The encoder gives the nearest whole count.
    if control.count > 0:
        position = control.count * nearest(position / control.count)
    error = wanted - position
    u = commanding(plant, control.gain * error + grown + control.share * slope, position)
    # While the valve is fully open the integral waits, lest it grow and overshoot later.
    if u > control.limit:
        u = control.limit
    elif u < -control.limit:
        u = -control.limit
    else:
        grown += control.growth * error
    return u, grown


def delayed(control, memory, tick, u):
    """Return the command that reaches the valve in the `tick` in which the loop asks for u.

    With a delay of n ticks it is the command of n ticks ago. `memory` holds the waiting commands
    from its second place on; `control` is a `Control`.
    """
    if control.delay == 0:
        return u
    place = 1 + tick % control.delay
    waited = memory[place]
    memory[place] = u
    return waited


def nearest(number):
    """Return the nearest whole number as a float; a half is rounded up."""
    # Above 2^52 all floats are whole.
    return float(math.floor(number + 0.5)) if abs(number) < 4.5e15 else number


def run_axis(plant, control, memory, state, setvalues, slopes, states, commands):
    """Run the axis of a `plant`, fill its `states` and `commands`; return the number of full ticks.

    It is less than the number of slopes if the axis left its stroke. `control` is a `Control`,
    `memory` (1 + delay,) the loop's integral and the waiting commands; `setvalues` are in rad,
    `slopes` in rad/s. `states` has a row for each number of the `state`, with which it begins.
    """
    grown = memory[0]
    for tick in range(len(slopes)):
        u, grown = commanded(plant, control, grown, setvalues[tick], slopes[tick], state[0])
        u = delayed(control, memory, tick, u)
        state = ticked(plant, state, u)
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
    """Run both axes of a `machine` from the tick `first` on, as `run_axis` runs one.

    `controls`, `memories` and each row of `setvalues`, `slopes` and `commands` hold theta's and
    phi's; `state` and each row of `states` hold theta's state, phi's, and the energies so far.
    `pushes` are `Push.rows`, `parts` the numbers of steps in the ticks; `tick` is in s.
    """
    theta = machine.theta
    phi = machine.phi
    for n in range(len(parts)):
        openings = opened(machine, controls, memories, first + n, state, setvalues[n], slopes[n])
        state = machine_tick(machine, state, openings, pushes[n], parts[n], tick)
        note(state, openings, states[n + 1], commands[n])
        if not theta.low <= state[0][0] <= theta.high or not phi.low <= state[1][0] <= phi.high:
            return n
    return len(parts)


def opened(machine, controls, memories, tick, state, setvalue, slope):
    """Return the commands that reach the valves of both joints in a tick, and keep their memories.

    The arguments are those of `run_joints`, with the `setvalue` and the `slope` of the tick.
    """
    theta_u, memories[0][0] = commanded(
        machine.theta, controls[0], memories[0][0], setvalue[0], slope[0], state[0][0]
    )
    phi_u, memories[1][0] = commanded(
        machine.phi, controls[1], memories[1][0], setvalue[1], slope[1], state[1][0]
    )
    theta_u = delayed(controls[0], memories[0], tick, theta_u)
    return theta_u, delayed(controls[1], memories[1], tick, phi_u)


def note(state, openings, states, commands):
    """Fill in the row of `states` and of `commands` of a tick of both joints."""
    commands[0] = openings[0]
    commands[1] = openings[1]
    for i in range(5):
        states[i] = state[0][i]
        states[5 + i] = state[1][i]
        states[10 + i] = state[2][i]


def run_each(plants, loops, setvalues, slopes, own_inverse):
    """Return lists of the states and commands of independent `plants` under their `loops`.

    Each has a column of `setvalues` (ticks + 1, n) in rad and of `slopes` (ticks, n) in rad/s;
    `own_inverse` is the caller's, as in `follow`, or None.

    Examples
    --------
    >>> from tunneller_lib.motion import Loop, Rigid
    >>> from tunneller_lib.motion.sizing import axes_of, usual_sizes
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE as reference
    >>> theta, _ = axes_of(reference, usual_sizes(reference))
    >>> sinking = np.linspace(0.0, -1.2, 301)[:, None]  # beyond the stroke
    >>> rates = np.zeros((300, 1))
    >>> run_each([Rigid(theta)], [Loop(10, 0.01)], sinking, rates, None)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: setvalues: an axis must stay within its stroke, -62.0 to 37.0 deg; got -62...
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
        wanted = [np.require(row, requirements="CW") for row in (values, rates)]
        memory = np.zeros(1 + loop.delay)
        given = numbers, control_of(loop), memory, start, *wanted, states, commands
        expect(plain_seconds(numbers, ticks), "axes")
        kept = _run(run_axis, given, own_inverse, **plant.functions())
        if kept < ticks:
            raise out_of_stroke(numbers, states[0, kept + 1])
        all_states.append(states.T)
        all_commands.append(commands)
    return all_states, all_commands


def run_together(plants, loops, setvalues, slopes, own_inverse, arm, push):
    """Return lists of the states and commands of both axes of one machine, and its energies.

    `plants`, `loops`, `setvalues`, `slopes` and `own_inverse` are as in `run_each`, `arm` and
    `push` as in `follow`. Each axis has states (ticks + 1, 5) and commands (ticks,); the energies
    (ticks + 1, 5), in J, are `ENERGIES` since the start.
    """
    if len(plants) != 2 or not all(isinstance(one, Compressible) for one in plants):
        raise ValueError(
            "plant: must be two of class Compressible where the axes share an arm or are pushed; "
            f"got {shown([type(one).__name__ for one in plants])}."
        )
    axes = [one.axis for one in plants]
    # The copies are contiguous and writable, whatever the caller's arrays are, so that one compiled
    # form suffices.
    setvalues = setvalues.copy()
    slopes = slopes.copy()
    tick = loops[0].tick
    ticks = len(slopes)
    loads = [None, None] if arm is None else arm.weight(setvalues[0]).tolist()
    starts = zip(plants, setvalues[0].tolist(), loads, strict=True)
    rests = [plant.rest(angle, load) for plant, angle, load in starts]
    states = np.zeros((ticks + 1, 10 + len(ENERGIES)))
    states[0, :10] = np.ravel(rests)
    commands = np.empty((ticks, 2))
    machine = machine_of(axes, arm)
    controls = tuple(map(control_of, loops))
    memories = np.zeros((2, 1 + max(loop.delay for loop in loops)))
    expect(sum(plain_seconds(plant.numbers(tick), ticks) for plant in plants), "axes")
    least = least_parts(axes, tick)
    begun = machine, tick, controls, memories
    if push is None or isinstance(push, Push):
        rows = np.array(np.broadcast_to((push or Push()).rows, (ticks, PUSHED)))
        state = tuple(map(tuple, states[0].reshape(3, 5).tolist()))
        parts = parts_in(machine, least, rows, tick)
        given = *begun, 0, state, setvalues, slopes, rows, parts, states, commands
        kept = _run(run_joints, given, own_inverse, commanding=spool_at)
    else:
        kept = push.run(*begun, least, setvalues, slopes, states, commands)
    if kept < ticks:
        for axis, angle in zip(axes, states[kept + 1, [0, 5]], strict=True):
            if not axis.low <= angle <= axis.high:
                raise out_of_stroke(axis, angle)
    return [states[:, :5], states[:, 5:10]], list(commands.T), states[:, 10:]


def plain_seconds(numbers, ticks):
    """Return the time that plain Python takes for `ticks` of an axis of these `numbers`, in s.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> oil = SimpleNamespace(parts=2)  # steps of the integration in a tick
    >>> round(plain_seconds(None, 1000), 6), round(plain_seconds(oil, 1000), 6)
    (0.002, 0.062)
    """
    return ticks * (PLAIN_TICK + PLAIN_PART * getattr(numbers, "parts", 0))


def _run(function, given, own_inverse, **parts):
    """Return the answer of `call`; with a caller's own inverse that of plain Python."""
    if own_inverse is None:
        return call(function, *given, kind="axes", **parts)
    parts["commanding"] = lambda plant, rate, position: own_inverse(rate, position)
    return call_plain(function, *given, **parts)
