"""Force and motion in the ground agree: however many ticks are tried together, and with a model
of joints, oil and ground that shares no formula with the library and takes a hundred times its
steps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.audit.long import many
from tunneller_lib.motion import Compressible, Loop, Push, follow
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, face, plan
from tunneller_lib.ream.cutting import whole_run
from tunneller_lib.ream.face import Face
from tunneller_lib.ream.front import side_area
from tunneller_lib.ream.wall import intact_wall
from tunneller_lib.removal import DexelGrid, Ground
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

SIZES = usual_sizes(REFERENCE_MACHINE)
AXES = axes_of(REFERENCE_MACHINE, SIZES)
ARM = arm_of(REFERENCE_MACHINE, SIZES)
OILY = [Compressible(axis) for axis in AXES]
CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TICK = 5e-3
LOOP = Loop(10.0, TICK, delay=1, feedforward=1.0)
MORTAR, CONCRETE, ROCK = (Ground(energy, 2.0) for energy in (5e6, 20e6, 80e6))


def planned(ground, **options):
    """Return a plan in a ground for a head of 3 kW."""
    limits = Limits(feed=0.1, acceleration=0.5, power=3000, valve=0.8, flow=SIZES.pump, axes=AXES,
                    ground=ground)  # fmt: skip
    return plan(CIRCUIT, limits, **({"tolerance": 1e-3} | options))


def begun(made, ground, way, shape=(60, 240)):
    """Return the beginning of a run of a plan, from the entry to some way along, in m."""
    setvalues, slopes = whole_run(made)
    first = int(made.entry.ticks.sum())
    ticks = first + int(np.searchsorted(made.reached, way))
    values = setvalues[: ticks + 1]
    front = Face(made, ground, values, first, shape, 0.1)
    track = follow(OILY, LOOP, values, slopes=slopes[:ticks], arm=ARM, push=front.push)
    front.finish(track.position)
    return first, track, front


@pytest.mark.parametrize(
    ("ground", "normal"), [(MORTAR, 2.0), (CONCRETE, 0.0), (ROCK, 1.0)], ids=["5", "20", "80"]
)
def test_force_that_is_renewed_more_often_is_the_same_within_two_percent(
    ground, normal, monkeypatch
):
    ground = replace(ground, normal=normal, ripple=0.3, ripple_frequency=12.0)
    made = planned(ground)
    found = []
    for every in many((8, 1), (8, 4, 2, 1)):
        monkeypatch.setattr(face, "EVERY", every)
        first, track, front = begun(made, ground, 0.08)
        force = front.force(track)[first:]
        off = CIRCUIT.overbreak(track.position[first:])
        found.append([off.min(), force.mean(), front.removed.sum()])
    finest = np.array(found[-1])
    assert finest[0] < -1e-4  # m: what the ground holds back can be seen
    assert np.abs(np.array(found) / finest - 1).max() < 0.02


# A second way: own linkages, oil, arm, loop and wall


HEAD, BEAM, WEIGHT = 30.0, 60.0, 9.81
SUPPLY, TANK, BULK, HOSE = 160e5, 3e5, 1e9, 5e-5
FLOW = 4e-3 / 60 / math.sqrt(35e5)
LEAK, LAG = 1e-13, 4e-3
r, R, BALL = 0.08, 0.80, 0.20
STEPS = 100  # of a tick


class Cylinder:
    """A joint's cylinders between two pivots: what they hold and give, by differences of lengths.

    Either one, or two, cross-connected, the second of which is the mirror image.
    """

    def __init__(self, linkage, low, high, friction, damping):
        self.rods = [(1.0, linkage)] + ([(-1.0, linkage)] if linkage.pair else [])
        self.ends = [sorted((self.length(s, k, low), self.length(s, k, high)))
                     for s, k in self.rods]  # fmt: skip
        self.friction, self.damping = friction, damping
        self.bore = math.pi / 4 * linkage.bore**2
        self.ring = self.bore - math.pi / 4 * linkage.rod**2

    def length(self, side, linkage, angle):
        turned = linkage.mounting + side * linkage.sense * angle
        along = linkage.a - linkage.b * math.cos(turned)
        return math.hypot(along, linkage.b * math.sin(turned))

    def sides(self, angle):
        """Return both sides' displacements by the angle, in m^3/rad, and volumes, in m^3."""
        plus = minus = plus_volume = minus_volume = 0.0
        for (side, linkage), (shortest, longest) in zip(self.rods, self.ends, strict=True):
            h = 1e-4
            reach = self.length(side, linkage, angle)
            lever = (self.length(side, linkage, angle + h)
                     - self.length(side, linkage, angle - h)) / (2 * h)  # fmt: skip
            extended = self.bore * abs(lever), self.bore * (reach - shortest)
            drawn = self.ring * abs(lever), self.ring * (longest - reach)
            first, second = (extended, drawn) if lever > 0 else (drawn, extended)
            plus, plus_volume = plus + first[0], plus_volume + first[1]
            minus, minus_volume = minus + second[0], minus_volume + second[1]
        return plus, minus, plus_volume + HOSE, minus_volume + HOSE

    def opening(self, angle, rate, load):
        """Return the spool of a steady rate, where the pressures balance load and friction."""
        plus, minus, _, _ = self.sides(angle)

        def excess(spool):
            if rate > 0:
                first = SUPPLY - (plus * rate / (FLOW * spool)) ** 2
                second = TANK + (minus * rate / (FLOW * spool)) ** 2
            else:
                first = TANK + (plus * rate / (FLOW * spool)) ** 2
                second = SUPPLY - (minus * rate / (FLOW * spool)) ** 2
            return plus * first - minus * second - load - self.damping * rate

        return math.copysign(brentq(excess, 1e-4, 10.0, xtol=1e-12), rate) if rate else 0.0


def lost(pressure):
    return math.copysign(math.sqrt(abs(pressure)), pressure)


class Roof:
    """Ground behind an arc of radius 0.5 m, as rays from its middle, a few millimetres apart."""

    def __init__(self):
        self.x = np.linspace(-0.12, 0.12, 61)[:, None]
        angles = np.linspace(math.radians(-20), math.radians(70), 401)
        self.out = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self.cell = (self.x[1, 0] - self.x[0, 0]) * (angles[1] - angles[0])
        self.stands = np.full((61, 401), 0.5)

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
    theta, phi = (Cylinder(axis.linkage, axis.low, axis.high, friction, axis.damping)
                  for axis, friction in zip(AXES, (40.0, 20.0), strict=True))  # fmt: skip
    height = REFERENCE_MACHINE.height

    def centre(q):
        reach = r + R * math.cos(q[1])
        return np.array([reach * math.cos(q[0]), R * math.sin(q[1]),
                         height - reach * math.sin(q[0])])  # fmt: skip

    roof = Roof()
    middle = np.zeros(3)
    middle[0] = centre(way[-1])[0]
    for q in way:
        roof.cut(centre(q) - middle)
    (a, v, p1, p2, x), (b, w, p3, p4, y) = states
    waiting = commands
    h = TICK / STEPS
    positions, forces = [], []
    force = 0.0
    for wanted, slope in zip(values, slopes, strict=True):
        openings, waiting = waiting, [
            joint.opening(at, LOOP.gain * (to - at) + rate, load)
            for joint, at, to, rate, load in (
                (theta, a, wanted[0], slope[0], -WEIGHT * (HEAD * (r + R) + BEAM * (r + R / 2))
                 * math.cos(a)),
                (phi, b, wanted[1], slope[1], 0.0),
            )
        ]  # fmt: skip
        total = 0.0
        for _ in range(STEPS):
            d1, d2, vol1, vol2 = theta.sides(a)
            d3, d4, vol3, vol4 = phi.sides(b)
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
            place = centre((a, b)) - middle
            outward = np.array([0.0, *place[1:]]) / math.hypot(*place[1:])
            pushed = -force * (speed / np.linalg.norm(speed) + ground.normal * outward) @ move
            rub = [joint.friction * math.tanh(rate / 2e-3) + joint.damping * rate
                   for joint, rate in ((theta, v), (phi, w))]  # fmt: skip
            v += h / about * (d1 * p1 - d2 * p2 - rub[0] + fall * math.cos(a) - change * v * w
                              + pushed[0])  # fmt: skip
            w += h / second * (d3 * p3 - d4 * p4 - rub[1] - sag + change * v * v / 2 + pushed[1])
            a += h * v
            b += h * w
            force = ground.energy * roof.cut(centre((a, b)) - middle) / h / ground.pick_speed
            total += force / STEPS
        positions.append((a, b))
        forces.append(total)
    return np.array(positions), np.array(forces)


@pytest.mark.parametrize("normal", many((1.2,), (0.0, 0.5, 1.2, 2.0)))
def test_cut_goes_as_an_independent_model_with_tiny_steps_says(normal):
    ground = replace(CONCRETE, normal=normal)
    made = planned(ground)
    first, track, front = begun(made, ground, 0.13, (240, 1440))
    start = first + int(np.searchsorted(made.reached, 0.10))
    states = [tuple(one[start]) for one in track.states]
    rates = made.slopes[start - first : len(track.command) - first]
    positions, forces = own_run(ground, track.setvalue[start:-1], rates, states,
                                track.command[start - 1], track.position[: start + 1])  # fmt: skip
    ours = CIRCUIT.overbreak(track.position[start + 1 :])
    theirs = CIRCUIT.overbreak(positions)
    free = follow(OILY, LOOP, track.setvalue, slopes=np.concatenate(
        [made.entry.slopes, made.slopes])[: len(track.command)], arm=ARM)  # fmt: skip
    without = CIRCUIT.overbreak(free.position[start + 1 :])
    held_back = np.abs(ours - without)
    assert held_back[-1] > 7e-4  # m
    assert np.abs(ours - theirs).max() < 0.01 * held_back.max()
    assert front.force(track)[start:].mean() == pytest.approx(forces.mean(), rel=0.01)


# The front


def test_front_is_how_much_more_a_further_short_move_takes():
    rng = np.random.default_rng(3)
    wall = DexelGrid.radial(-0.3, 0.3, 0.5, 0.7, (300, 2000))
    turn = np.linspace(0.0, 0.5, 400)
    way = np.stack([0 * turn, 0.32 * np.cos(turn), 0.32 * np.sin(turn)], axis=-1)
    wall.cut_path(way[:-1], 0.2)
    volume, area = wall.front(way[-2:], 0.2)
    assert volume == pytest.approx(wall.copy().cut_path(way[-2:], 0.2), rel=1e-12)
    assert area @ (way[-1] - way[-2]) == pytest.approx(volume, rel=0.02)
    wall.cut_path(way[-2:], 0.2)
    ahead = (way[-1] - way[-2]) / np.linalg.norm(way[-1] - way[-2])
    outward = way[-1] / np.linalg.norm(way[-1])
    for share in rng.uniform(0.0, 0.2, 4):  # out of the wall or along it the places stay the same
        turned = ahead + share * outward
        step = 1e-5 * turned / np.linalg.norm(turned)
        further = wall.front(np.stack([way[-1], way[-1] + step]), 0.2)[0]
        assert further == pytest.approx(area @ step, rel=0.05)


def test_front_of_nothing_is_nothing_and_of_one_place_is_refused():
    wall = DexelGrid.radial(-0.3, 0.3, 0.5, 0.7, (30, 90))
    volume, area = wall.front([(0, 0, 0), (0, 0.01, 0)], 0.2)
    assert volume == 0 and not area.any()
    with pytest.raises(ValueError, match=r"^centres: must be at least two; got 1\."):
        wall.front([(0, 0, 0)], 0.2)


def test_push_by_a_front_resists_motion_into_the_ground_alone():
    ramp = np.stack([0.1 + 2e-4 * np.arange(41), 0.2 + 0 * np.arange(41)], axis=-1)
    for sign, felt in ((1.0, True), (-1.0, False)):
        push = Push(front=(sign * 2e4, 0.0), lever=(0.88, 0.80))
        free, pushed = (follow(OILY, LOOP, ramp, slopes=np.diff(ramp, axis=0) / TICK, push=one)
                        for one in (Push(), push))  # fmt: skip
        assert (np.abs(free.position - pushed.position)[20:].max() > 1e-5) == felt


# The step


def test_side_of_the_ball_is_as_large_as_points_in_the_ground_count():
    grid = np.linspace(-0.21, 0.21, 1501)
    y, z = np.meshgrid(grid, grid)
    for s in (0.0, 0.9, 1.9):
        centre = CIRCUIT.profile.point(s)
        beyond = -CIRCUIT.profile.depth(y + centre[0], z + centre[1])
        inside = (y**2 + z**2 < 0.2**2) & (beyond > REFERENCE_MACHINE.offset)
        counted = np.count_nonzero(inside) * (grid[1] - grid[0]) ** 2
        assert side_area(CIRCUIT, s) == pytest.approx(counted, rel=2e-3)


@pytest.mark.parametrize("ground", [CONCRETE], ids=["concrete"])
def test_step_between_laps_keeps_the_power_and_the_volume(ground):
    made = planned(ground, laps=2, advance=0.04)
    speed = np.diff(made.back).max() / TICK
    assert ground.power(side_area(CIRCUIT, 0.0)) * speed == pytest.approx(3000, rel=0.01)
    limits = replace(made.limits, volume=1e-5)
    slow = plan(CIRCUIT, limits, tolerance=1e-3, laps=2, advance=0.04)
    assert side_area(CIRCUIT, 0.0) * np.diff(slow.back).max() / TICK <= 1e-5 * (1 + 1e-9)
    # The wall says the same: what a step takes in a second, in a groove that is as deep as meant.
    wall = intact_wall(CIRCUIT, 0.3, 1.1, (400, 1500))
    centres = made.centres(made.setvalues)
    lap = len(centres) - len(made.back)
    wall.cut_path(centres[: lap + 1 : 20], 0.2)
    rates = []
    for a in range(lap, len(centres) - 1, max(len(made.back) // 20, 1)):
        b = min(a + max(len(made.back) // 20, 1), len(centres) - 1)
        rates.append(wall.cut_path(centres[a : b + 1], 0.2) / (b - a) / TICK)
    assert 0.7 * 3000 < ground.power(max(rates)) < 1.02 * 3000


@pytest.mark.parametrize("energy", [250e6])
def test_cutter_that_is_pushed_back_out_of_its_hole_finds_its_force(energy):
    """From rest in whole ground the first ticks go the other way than the front faces."""
    ground = Ground(energy, 2.0, normal=1.2)
    made = planned(ground)
    values = CIRCUIT.position(made.places[:60])
    front = Face(made, ground, values, 0, (60, 240), 0.1)
    front.wall.cut_path(made.centres(values[:1]), REFERENCE_MACHINE.cutter_radius)
    slopes = np.diff(values, axis=0) / TICK
    track = follow(OILY, LOOP, values, slopes=slopes, arm=ARM, push=front.push)
    front.finish(track.position)
    taken = front.stiffness @ (front.removed / TICK)
    assert front.force(track).sum() == pytest.approx(taken, rel=0.05)


# What doesn't agree is refused


def test_force_that_never_agrees_with_the_motion_is_refused(monkeypatch):
    monkeypatch.setattr(face, "CLOSE", 1e-12)
    monkeypatch.setattr(face, "MOST_TRIES", 2)
    with pytest.raises(ValueError, match=r"^ground: force and motion must agree within 1e-10 %; "):
        begun(planned(CONCRETE), CONCRETE, 0.02)
