"""A cut in the ground goes as a second model says, which shares no formula with the library.

It has its own linkages, oil, arm, loop and wall, and takes a hundred times the steps.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.audit.long import many
from tests.independent.section import BALL, centre
from tests.independent.section import LARGE as R
from tests.independent.section import SMALL as r
from tests.independent.test_second_control import BEAM, BULK, HEAD, LIFT, SWING, oil
from tests.test_ground_coupling import (
    ARM,
    AXES,
    CIRCUIT,
    CONCRETE,
    LOOP,
    OILY,
    TICK,
    begun,
    planned,
)
from tunneller_lib.motion import follow

WEIGHT, SUPPLY, TANK = 9.81, 160e5, 3e5
FLOW = 4e-3 / 60 / math.sqrt(35e5)
LEAK, LAG = 1e-13, 4e-3
FRICTION, DAMPING = (40.0, 20.0), [axis.damping for axis in AXES]
STEPS = 100  # of a tick


def opening(joint, angle, rate, load, damping):
    """Return the spool of a steady rate, where the pressures balance load and friction."""
    (plus, _), (minus, _) = oil(joint, angle)
    high, low = (SUPPLY, TANK) if rate > 0 else (TANK, SUPPLY)
    sign = math.copysign(1.0, rate)

    def excess(spool):
        first = high - sign * (plus * rate / (FLOW * spool)) ** 2
        second = low + sign * (minus * rate / (FLOW * spool)) ** 2
        return plus * first - minus * second - load - damping * rate

    return sign * brentq(excess, 1e-4, 10.0, xtol=1e-12) if rate else 0.0


def lost(pressure):
    return math.copysign(math.sqrt(abs(pressure)), pressure)


class Roof:
    """Ground behind an arc of radius 0.5 m, as rays from its middle, a few millimetres apart."""

    def __init__(self):
        self.x = np.linspace(-0.12, 0.12, 61)[:, None]
        angles = np.linspace(math.radians(-20), math.radians(43), 281)
        self.out = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self.cell = (self.x[1, 0] - self.x[0, 0]) * (angles[1] - angles[0])
        self.stands = np.full((61, 281), 0.5)

    def cut(self, centre):
        """Take a ball away and return the volume, in m^3."""
        near = self.out @ centre[1:]
        square = near**2 - centre[1:] @ centre[1:] + BALL**2 - (self.x - centre[0]) ** 2
        reach = near + np.sqrt(np.maximum(square, 0.0))
        taken = (square > 0) & (reach > self.stands)
        volume = self.cell * np.sum((reach**2 - self.stands**2)[taken]) / 2
        self.stands = np.where(taken, reach, self.stands)
        return volume


def own_run(ground, values, slopes, states, commands, way):
    """Return positions and mean forces of ticks from states on, in ground that was cut on a way."""
    roof = Roof()
    middle = np.zeros(3)
    middle[0] = centre(*way[-1])[0]
    for q in way:
        roof.cut(centre(*q) - middle)
    (a, v, p1, p2, x), (b, w, p3, p4, y) = states
    waiting = commands
    h = TICK / STEPS
    positions, forces = [], []
    force = 0.0
    for wanted, slope in zip(values, slopes, strict=True):
        openings, waiting = waiting, [
            opening(joint, at, LOOP.gain * (to - at) + rate, load, damping)
            for joint, at, to, rate, load, damping in zip(
                (LIFT, SWING), (a, b), wanted, slope,
                (-WEIGHT * (HEAD * (r + R) + BEAM * (r + R / 2)) * math.cos(a), 0.0),
                DAMPING, strict=True,
            )
        ]  # fmt: skip
        total = 0.0
        (d1, vol1), (d2, vol2) = oil(LIFT, a).tolist()  # it hardly changes in a tick
        (d3, vol3), (d4, vol4) = oil(SWING, b).tolist()
        for _ in range(STEPS):
            x += h / LAG * (openings[0] - x)
            y += h / LAG * (openings[1] - y)
            pressures = []
            for spool, first, second, in_, out, rate, one, two in (
                (x, p1, p2, d1, d2, v, vol1, vol2), (y, p3, p4, d3, d4, w, vol3, vol4),
            ):  # fmt: skip
                filled = lost(SUPPLY - first) if spool > 0 else lost(first - TANK)
                emptied = lost(second - TANK) if spool > 0 else lost(SUPPLY - second)
                past = LEAK * (first - second)
                gain = FLOW * spool * filled + LEAK * (SUPPLY + TANK - 2 * first) - past
                loss = FLOW * spool * emptied - LEAK * (SUPPLY + TANK - 2 * second) - past
                pressures += [first + h * BULK / one * (gain - in_ * rate),
                              second + h * BULK / two * (out * rate - loss)]  # fmt: skip
            p1, p2, p3, p4 = pressures
            # Lagrange's equations of the head, a point, and of the arm, an even rod.
            c, s = math.cos(b), math.sin(b)
            reach = r + R * c
            second = BEAM * R * R / 3 + HEAD * R * R
            about = HEAD * reach**2 + BEAM * (r * r + r * R * c + (R * c) ** 2 / 3)
            change = -2 * HEAD * reach * R * s - BEAM * (r * R * s + 2 * R * R * c * s / 3)
            fall = WEIGHT * (HEAD * reach + BEAM * (r + R * c / 2))
            sag = WEIGHT * math.sin(a) * (HEAD + BEAM / 2) * R * s
            # The ground's force on the cutter, by what the last step took.
            move = np.array([[-reach * math.sin(a), -R * s * math.cos(a)], [0.0, R * c],
                             [-reach * math.cos(a), R * s * math.sin(a)]])  # fmt: skip
            speed = move @ (v, w)
            place = centre(a, b) - middle
            outward = np.array([0.0, *place[1:]]) / math.hypot(*place[1:])
            pushed = -force * (speed / np.linalg.norm(speed) + ground.normal * outward) @ move
            dry = np.multiply(FRICTION, np.tanh([v / 2e-3, w / 2e-3]))
            rub = dry + np.multiply(DAMPING, (v, w))
            v += h / about * (d1 * p1 - d2 * p2 - rub[0] + fall * math.cos(a) - change * v * w
                              + pushed[0])  # fmt: skip
            w += h / second * (d3 * p3 - d4 * p4 - rub[1] - sag + change * v * v / 2 + pushed[1])
            a += h * v
            b += h * w
            force = ground.energy * roof.cut(centre(a, b) - middle) / h / ground.pick_speed
            total += force / STEPS
        positions.append((a, b))
        forces.append(total)
    return np.array(positions), np.array(forces)


@pytest.mark.parametrize("normal", many((1.2,), (0.0, 0.5, 1.2, 2.0)))
def test_cut_goes_as_an_independent_model_with_tiny_steps_says(normal):
    ground = replace(CONCRETE, normal=normal)
    made = planned(ground)
    first, track, front = begun(made, ground, 0.13, (240, 1440), last=150)
    start = first + int(np.searchsorted(made.reached, 0.11))
    states = [tuple(one[start]) for one in track.states]
    rates = made.slopes[start - first : len(track.command) - first]
    positions, forces = own_run(ground, track.setvalue[start:-1], rates, states,
                                track.command[start - 1], track.position[: start + 1])  # fmt: skip
    ours = CIRCUIT.overbreak(track.position[start + 1 :])
    theirs = CIRCUIT.overbreak(positions)
    free = follow(OILY, LOOP, track.setvalue, slopes=np.concatenate(
        [made.entry.slopes[-first:], made.slopes])[: len(track.command)], arm=ARM)  # fmt: skip
    without = CIRCUIT.overbreak(free.position[start + 1 :])
    held_back = np.abs(ours - without)
    assert held_back[-1] > (7e-4 if normal else 2e-4)  # m
    assert np.abs(ours - theirs).max() < 0.01 * held_back.max()
    assert front.force[start:].mean() == pytest.approx(forces.mean(), rel=0.01)
