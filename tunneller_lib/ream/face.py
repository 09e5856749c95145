"""The ground's work on the joints: the wall is cut tick by tick and pushes back.

The rate of removal depends on the cutter's motion, and the motion on the force that the removal
asks for. Both are found together, tick by tick. The force is that of a damper, stiffness times area
times speed: the cutter sweeps an `area` A across its way, so that it removes A for each metre of
it. For an area the joints' motion follows, and on that way the wall gives the volume V that goes.
Force and motion agree where

    A |way| - V = 0.

A ball sweeps at most its great circle, pi R^2, so that this is at least zero for the area of that
circle, and at most zero for none. Both V and the way go on without jumps as A grows, so that there
is always a root between, and a secant that is kept within the bracket ends at it. The usual tick
takes a try or two, since the area hardly differs from that of the tick before.

Tried beside it on a lap of the reference job: the area vector of the ball's front, corrected until
it fits over twelve ticks together, took eight times as long, and found no answer where the cutter
bounces while it steps sideways. A miss of 1 % in the place of 0.3 % saves a fifth of the tries, one
of 0.1 % costs as many, and both leave the same underbreak to a hundredth of a millimetre.
"""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.compiled import call
from ..kernels.repeatable import sine_cosine
from ..motion.both_joints import (
    MOST_PARTS,
    Push,
    Resistance,
    damped_parts,
    least_inertias,
    machine_tick,
    too_hard,
)
from ..motion.hydraulics import spool_at
from ..motion.ticks import note, opened
from ..removal.sweep import ARRAYS, LOOPS, room_on, sweep, take, way_between
from ..surfaces.torus import torus_point
from .front import engaged_areas
from .moves import levers
from .outward import gradient
from .wall import intact_wall

BESIDE = 0.05  # m of ground beyond the planned positions, at each end
CLOSE = 3e-3  # share by which the volume of the force may differ from the removed one
HARDLY = 0.1  # of what a tick takes in whole grooves; CLOSE is a share of at least this
CLOSED = 1e-9  # of the great circle: so narrow a bracket holds a jump, where rays come or go
BOLD = 8  # tries by secants, after which the bracket is halved
TOGETHER = 512  # ticks between two reports of progress
TINY = 1e-30  # m
FULL, TOO_HARD = 1, 2  # why a run stops: a ray needs another slot, a tick too many steps


class Place(NamedTuple):
    """Where the cutter's centre is: a torus, turned and moved into the tunnel's frame.

    x, y, z are the rows of the turn, `origin` the place of the torus' centre, in m; `radius` is the
    ball's, in m.
    """

    r: float
    R: float
    x: tuple
    y: tuple
    z: tuple
    origin: tuple
    radius: float


class Face(Resistance):
    """The ground in the way of a cutter that two joints move, for `motion.follow`.

    Parameters
    ----------
    plan : Plan
        The plan that is run.
    ground : Ground
        The law of the cutting force.
    setvalues : (n, 2) float
        Set-values of the entry, all laps and the exit, in rad.
    first : int
        Number of the set-value at which the first lap begins.
    shape : (2,) int
        Numbers of rays of the wall along the tunnel and around it.
    thickness : float
        Thickness of the modelled ground, in m.
    pose : Pose, optional
        By how much the machine stands elsewhere than planned.
    say : function, optional
        Called with the number of the set-value that the run has reached.

    Attributes
    ----------
    wall : DexelGrid
        The standing ground.
    ends : (float, float)
        Ends of the modelled ground along the tunnel's x, in m.
    removed : (n - 1,) float
        Volume cut in each tick, in m^3.
    areas : (n,) float
        Area that the cutter sweeps across its way in each tick, in m^2, behind a zero.
    force : (n - 1,) float
        The ground's force against the cutter's way, in N: its mean over each tick.
    """

    def __init__(self, plan, ground, setvalues, first, shape, thickness, *, pose=None, say=None):
        circuit = plan.circuit
        machine = circuit.machine
        ticks = np.arange(len(setvalues)) - first
        lap = int(plan.ticks.sum())
        inside = (ticks >= 0) & (ticks < lap * plan.laps)
        places = np.where(inside, plan.places[ticks % lap], 0.0)
        self.torus = machine.torus
        self.stepped = plan.stepped(np.clip(ticks, 0, lap * plan.laps))
        corners = circuit.in_tunnel(np.concatenate([np.zeros((1, 3)), np.eye(3)]))
        if pose is not None:
            corners = pose.moved(corners, corners[0])
        turn = (corners[1:] - corners[0]).T
        rows = (tuple(row) for row in turn.tolist())
        origin = tuple(corners[0].tolist())
        self.place = Place(machine.r, machine.R, *rows, origin, machine.cutter_radius)
        self.push = _pushes(plan, ground, setvalues[:-1], places[:-1], self.stepped, turn)
        planned = turn @ torus_point(self.torus, *setvalues.T).T
        x = planned[0] + corners[0, 0] - self.stepped
        reach = machine.cutter_radius + BESIDE
        self.ends = x.min() - reach, x.max() + reach
        self.wall = intact_wall(circuit, *self.ends, shape, thickness=thickness)
        self.removed = np.zeros(len(setvalues) - 1)
        self.force = np.zeros(len(setvalues) - 1)
        self.areas = np.zeros(len(setvalues))
        rate = engaged_areas(circuit, plan.s) * plan.feed
        self._least = HARDLY * float(rate.max()) * plan.tick  # m^3
        self._say = say or (lambda tick: None)

    def run(self, machine, tick, controls, memories, least, setvalues, slopes, states, commands):
        """Run both joints in the ground, and return the number of full ticks.

        The arguments are those of `motion.ticks.run_joints`, with the `least` number of steps in a
        tick. It is less than all ticks if an axis leaves its stroke.
        """
        found = room_on(self.wall.rows, math.inf)
        done = resumed = 0
        while done < len(slopes):
            end = min(done + TOGETHER, len(slopes))
            part = slice(done, end)
            ends = slice(done, end + 1)
            kept, why = call(
                run_in_ground, machine, tick, controls, memories, done, resumed, least,
                least_inertias(machine), setvalues[part], slopes[part], self.push[part], self.place,
                self.stepped[ends], self._least, self.wall.rows, found, states[ends],
                commands[part], self.areas[ends], self.removed[part], self.force[part],
                kind="axes", arrays=ARRAYS, commanding=spool_at, **LOOPS,
            )  # fmt: skip
            done += kept
            resumed = int(why == FULL)
            if why == TOO_HARD:
                raise ValueError(too_hard(self.push[done, 2] * self.areas[done]))
            if resumed:
                self.wall.add_slot()
            elif done < end:
                break
            self._say(done)
        return done


def _pushes(plan, ground, setvalues, places, stepped, turn):
    """Return rows (n, 10) of a `Push` for n ticks, whose dampers are those of an area of 1 m^2."""
    torus = plan.circuit.machine.torus
    lever = levers(torus, setvalues)
    time = plan.tick * (np.arange(len(setvalues)) + 0.5)
    # The ways of both joints in the tunnel's frame, along x, towards which the machine comes from.
    moves = torus.velocity(setvalues[:, None], np.eye(2)) / lever[..., None] @ turn[0]
    speed = np.diff(stepped) / plan.tick
    along = -speed[:, None] * moves
    aside = np.sqrt(np.maximum(speed**2 - np.sum(along**2, axis=-1), 0.0))
    return Push(
        damper=ground.force(ground.pulse(time)),
        lever=lever,
        across=ground.normal * gradient(plan.circuit, places, setvalues),
        drift=np.concatenate([along, aside[:, None]], axis=-1),
    ).rows


def run_in_ground(
    machine,
    tick,
    controls,
    memories,
    first,
    resumed,
    least,
    inertias,
    setvalues,
    slopes,
    pushes,
    place,
    stepped,
    least_volume,
    grid,
    found,
    states,
    commands,
    areas,
    volumes,
    forces,
):
    """Run both axes of a `machine` while its cutter removes ground, from the tick `first` on.

    Arguments as of `run_joints`; and `inertias`, the least ones; `pushes`, for an area of 1 m^2;
    `place`, and how far the machine has `stepped` back, in m; the `grid` of the ground, and what is
    `found` there. `areas`, `volumes` and `forces` are filled, from the first area on. A `resumed`
    run has the commands of its first tick.

    Returns
    -------
    kept, why : int
        The number of full ticks, and why they aren't all: `FULL`, `TOO_HARD`, or 0 where an axis
        has left its stroke.
    """
    theta = machine.theta
    phi = machine.phi
    whole = math.pi * place.radius * place.radius
    state = (
        (states[0][0], states[0][1], states[0][2], states[0][3], states[0][4]),
        (states[0][5], states[0][6], states[0][7], states[0][8], states[0][9]),
        (states[0][10], states[0][11], states[0][12], states[0][13], states[0][14]),
    )
    here = centre(place, state, stepped[0])
    slope = 0.0
    for n in range(len(slopes)):
        if resumed and n == 0:
            openings = (commands[0][0], commands[0][1])
        else:
            openings = opened(
                machine, controls, memories, first + n, state, setvalues[n], slopes[n]
            )
        # The area goes on as it changed in the tick before.
        area = areas[n]
        if n > 0:
            area = min(max(2 * area - areas[n - 1], 0.0), whole)
        low = 0.0
        high = whole
        before = 0.0
        missed = 0.0
        tries = 0
        while True:
            push = with_area(pushes[n], area)
            parts = damped_parts(least, inertias, push, tick)
            if parts > MOST_PARTS:
                areas[n] = area
                return n, TOO_HARD
            after = machine_tick(machine, state, openings, push, parts, tick)
            there = centre(place, after, stepped[n + 1])
            way = way_between(here, there)
            volume, count, split, _ = sweep(grid, here, there, place.radius, 0, found)
            miss = area * way - volume
            tries += 1
            if abs(miss) <= CLOSE * max(volume, least_volume) or high - low <= CLOSED * whole:
                break
            if miss < 0:
                low = area
            else:
                high = area
            # A step by the secant, first by that of the ticks before. Where it leaves the bracket,
            # or takes too long, the bracket's middle.
            if tries > 1 and miss != missed:
                slope = (miss - missed) / (area - before)
            last = area
            area = last - miss / slope if slope > 0 else volume / max(way, TINY)
            if not low < area < high or tries > BOLD:
                area = (low + high) / 2
            before = last
            missed = miss
        if split:
            commands[n][0] = openings[0]
            commands[n][1] = openings[1]
            return n, FULL
        take(grid, found, count)
        state = after
        here = there
        note(state, openings, states[n + 1], commands[n])
        areas[n + 1] = area
        volumes[n] = volume
        forces[n] = push[2] * way / tick
        if not theta.low <= state[0][0] <= theta.high or not phi.low <= state[1][0] <= phi.high:
            return n, 0
    return len(slopes), 0


def with_area(row, area):
    """Return a row of pushes as numbers, with the damper of an area in m^2."""
    return (row[0], row[1], row[2] * area, row[3], row[4], row[5], row[6], row[7], row[8], row[9])


def centre(place, state, stepped):
    """Return the cutter's centre (x, y, z), in m, in a state of both axes."""
    theta, phi, _ = state
    sine, cosine = sine_cosine(theta[0])
    up, level = sine_cosine(phi[0])
    rho = place.r + place.R * level
    a = rho * cosine
    b = place.R * up
    c = -rho * sine
    x, y, z = place.origin
    return (
        x + (place.x[0] * a + place.x[1] * b + place.x[2] * c) - stepped,
        y + (place.y[0] * a + place.y[1] * b + place.y[2] * c),
        z + (place.z[0] * a + place.z[1] * b + place.z[2] * c),
    )
