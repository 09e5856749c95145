"""Chatter: picks that cut what the picks before them left drive the oil's resonance."""

import numpy as np

from .front import engaged_areas
from .margins import JOINTS, Margin
from .moves import levers

FREQUENCIES = np.linspace(0.2, 60.0, 20_000)  # Hz
PLACES = 21  # of the circuit


def chatter_limit(plant, loop, angle, lever, picks):
    """Return from which damper of the ground on a joint swings up, in N s/m, and at what frequency.

    The force over the feed's speed is the damper, E A / u, only in slow motion. If each pick cuts
    exactly what the one before it left, a time t = 1 / `picks` earlier, a swing x of the cutter
    along its way meets the force damper (x - x(t earlier)) / t, which drives swings
    of one half to one of the picks' frequency, of three halves to two, and so on. On a `lever`, in
    m, at a joint `angle`, in rad, and with the valve hardly open, where oil damps least, the joint
    answers a torque by 1 / Z:

        Z = J s^2 + b s + J w^2 (1 + Kv exp(-late s) / (s (1 + lag s))),

    and swings up from the least damper for which, at some s = 2 pi i f,

        Z + lever^2 damper (1 - exp(-s t)) / t = 0.

    Dry friction and leaks, which damp, and picks out of step are left out.

    Parameters
    ----------
    plant : Compressible
        The axis.
    loop : Loop
        Its position loop, without integral.
    angle, lever : float
        In rad and m.
    picks : float
        How many picks cut in a second, one in the track of the other, in Hz.

    Returns
    -------
    damper, frequency : float
        In N s/m and Hz; infinite and 0 where nothing up to 60 Hz swings up.
    """
    axis = plant.axis
    s = 2j * np.pi * FREQUENCIES
    spring = axis.inertia * axis.natural_frequency(angle) ** 2
    late = loop.tick * (loop.delay + 0.5)
    steered = loop.gain * np.exp(-s * late) / (s * (1 + s * axis.valve_lag))
    stiff = axis.inertia * s**2 + axis.damping * s + spring * (1 + steered)
    needed = -stiff / (lever**2 * picks * (1 - np.exp(-s / picks)))
    # Where it is real a damper can be it; at whole multiples of the picks' frequency it is a pole.
    turns = np.flatnonzero(np.diff(np.sign(needed.imag)))
    real = needed.real[turns]
    near = np.abs(np.diff(needed.imag)[turns]) < np.abs(real)
    turns = turns[(real > 0) & near]
    if not len(turns):
        return np.inf, 0.0
    least = turns[np.argmin(needed.real[turns])]
    return float(needed.real[least]), float(FREQUENCIES[least])


def chatter_margins(plan, plant, loop):
    """Return which damper each joint bears on a circuit if the picks are in step, as `Margin`s.

    Needed is the damper E A / u of the ground where the front of the ball takes most, in N s/m.

    Parameters
    ----------
    plan : Plan
        What is to be done, in ground whose ripple has the picks' frequency.
    plant, loop : pair of Compressible and of Loop
        Of theta and phi.
    """
    circuit = plan.circuit
    ground = plan.limits.ground
    places = np.linspace(0, circuit.profile.perimeter, PLACES)
    at = circuit.position(places)
    lever = levers(circuit.machine.torus, at)
    every = np.linspace(0, circuit.profile.perimeter, 20 * PLACES)  # the front is widest at bends
    needs = float(np.max(ground.force(engaged_areas(circuit, every))))
    found = []
    for joint, name in enumerate(JOINTS):
        has = min(
            chatter_limit(plant[joint], loop[joint], angle, length, ground.ripple_frequency)[0]
            for angle, length in zip(at[:, joint], lever[:, joint], strict=True)
        )
        remedy = "picks that don't follow each other in one track would do"
        found.append(Margin(f"in step, {name}", has, needs, "N s/m", remedy))
    return found
