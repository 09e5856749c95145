"""The ground's work on the joints: the wall is cut tick by tick and pushes back.

The rate of removal depends on the cutter's motion, and the motion on the force that the removal
asks for. Both are found together: the next ticks are tried with the front of the last ones, the
wall says which volume they would remove and by which front, and they are tried again until the
volume that the force was computed for is the volume that is removed.
"""

import numpy as np

from ..kernels.exact import norm
from ..motion.both_joints import Push
from ..surfaces.torus import torus_point
from .front import engaged_areas
from .moves import levers
from .outward import gradient
from .wall import intact_wall

EVERY = 12  # ticks that are tried together; fewer where they don't converge
BESIDE = 0.05  # m of ground beyond the planned positions, at each end
STILL = 1e-6  # m, a way too short for its removal to be measured
CLOSE = 1e-2  # share by which the volume of the force may differ from the removed one
HARDLY = 0.1  # of a whole groove; CLOSE is a share of at least this
MOST_TRIES = 16  # of a force
BOLD_TRIES = 4  # after which corrections are halved


class Face:
    """The ground in the way of a cutter that two joints move; `push` serves `motion.follow`.

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
    noted : (k,) int, optional
        Set-values at which the volume removed so far must be known.
    say : function, optional
        Called with the number of the set-value that the run has reached.

    Attributes
    ----------
    wall : DexelGrid
        The standing ground.
    ends : (float, float)
        Ends of the modelled ground along the tunnel's x, in m.
    removed : (n - 1,) float
        Volumes cut at the ends of the ticks, each on the way since the cut before, in m^3.
    front : (n - 1, 2) float
        Volume removed per radian of both joints in each tick, in m^3.
    stepping : (n - 1,) float
        Rate of removal by the machine's own step in each tick, in m^3/s.
    """

    def __init__(
        self, plan, ground, setvalues, first, shape, thickness, *, pose=None, noted=(), say=None
    ):
        circuit = plan.circuit
        machine = circuit.machine
        ticks = np.arange(len(setvalues)) - first
        lap = int(plan.ticks.sum())
        inside = (ticks >= 0) & (ticks < lap * plan.laps)
        places = np.where(inside, plan.places[ticks % lap], 0.0)
        self.plan = plan
        self.pose = pose
        self.torus = machine.torus
        self.joint = circuit.in_tunnel(np.zeros(3))
        self.radius = machine.cutter_radius
        self.stepped = plan.stepped(np.clip(ticks, 0, lap * plan.laps))
        self.lever = levers(self.torus, setvalues)[:-1]
        self.across = ground.normal * gradient(circuit, places, setvalues)[:-1]
        time = plan.tick * (np.arange(len(setvalues) - 1) + 0.5)
        self.stiffness = ground.force(ground.pulse(time))
        planned = self._centres(setvalues, slice(None))
        self.ends = (
            planned[:, 0].min() - self.radius - BESIDE,
            planned[:, 0].max() + self.radius + BESIDE,
        )
        self.wall = intact_wall(circuit, *self.ends, shape, thickness=thickness)
        self.removed = np.zeros(len(setvalues) - 1)
        self.front = np.zeros((len(setvalues) - 1, 2))
        self.stepping = np.zeros(len(setvalues) - 1)
        self._stops = np.array([*noted, len(setvalues) - 1])
        self._say = say or (lambda tick: None)
        corners = self._posed(circuit.in_tunnel(np.concatenate([np.zeros((1, 3)), np.eye(3)])))
        self._turned = (corners[1:] - corners[0]).T
        self._go_on(setvalues[:1])
        self._area = np.zeros(3)  # m^2, the ball's front as by `DexelGrid.front`
        rate = engaged_areas(circuit, plan.s) * plan.feed
        self._most = float(rate.max()) * plan.tick  # m^3, removed by a tick in whole grooves
        self._tries = 0
        self._together = EVERY

    def push(self, tick, tried):
        """Return the `Push` of the ticks from `tick` on, or None once force and motion agree.

        `tried` are the positions (m + 1, 2) to which the last answer led, or None at first.
        """
        if tried is None:  # new ticks begin with the front of the last ones
            self._say(tick)
            self._tries = 0
            self._together = EVERY
            return self._pushed(tick)
        self._tries += 1
        # Short moves that weren't cut yet belong to the beginning of the way.
        way = np.concatenate([self._way[:-1], tried])
        end = tick + len(tried) - 1
        run = slice(end - len(way) + 1, end + 1)
        centres = self._centres(way, run)
        moved = float(np.sum(norm(centres[1:] - centres[:-1])))
        if moved <= STILL:  # so short a way is cut together with the next one
            self._go_on(way)
            return None
        turns = np.diff(way, axis=0)
        steps = np.diff(self.stepped[run])
        # The volume that the tried motion would remove, and the one that the force was for.
        volume, area, cut = self.wall.front(centres, self.radius)
        meant = self._taken(self._area, turns, steps)
        if abs(meant - volume) <= CLOSE * max(volume, HARDLY * self._most):
            self.removed[end - 1] = cut()
            self._go_on(way[-1:])
            return None
        if self._tries == MOST_TRIES:
            if self._together == 1:
                raise ValueError(
                    f"ground: force and motion must agree within {100 * CLOSE:g} %; "
                    f"got the force of {1e9 * meant:.3g} mm^3 in a tick that removes "
                    f"{1e9 * volume:.3g} mm^3, {self.plan.tick * tick:.2f} s after the begin."
                )
            self._together //= 2  # over fewer ticks the front changes less
            self._tries = 0
        # Far from agreement whole corrections are quickest; near it they may oscillate for ever.
        found = self._fitting(area, volume, turns, steps)
        self._area = found if self._tries <= BOLD_TRIES else (self._area + found) / 2
        return self._pushed(tick)

    def finish(self, position):
        """Cut the rest of the way once all positions (n, 2) are known."""
        if len(self._way) > 1:
            centres = self._centres(self._way, slice(len(position) - len(self._way), None))
            self.removed[-1] += self.wall.cut_path(centres, self.radius)

    def force(self, track):
        """Return the force (n - 1,) against the motion at the beginning of each tick, in N."""
        rates = np.stack([states[:-1, 1] for states in track.states], axis=-1)
        rate = np.maximum(np.sum(self.front * rates, axis=-1), 0.0)
        return self.stiffness * (rate + self.stepping)

    def _pushed(self, tick):
        """Return the `Push` of the ticks from `tick` on, with the front as known so far."""
        stop = self._stops[np.searchsorted(self._stops, tick, side="right")]
        ticks = slice(tick, min(tick + self._together, stop))
        moves = self._moves
        self.front[ticks] = self._area @ moves
        steps = np.diff(self.stepped[ticks.start : ticks.stop + 1])
        self.stepping[ticks] = np.maximum(-self._area[0] * steps, 0.0) / self.plan.tick
        stiffness = self.stiffness[ticks, None]
        # While the machine steps back, towards -x, the ground pushes the cutter towards +x.
        dragged = self.across[ticks] - moves[0]
        return Push(
            torque=stiffness * self.stepping[ticks, None] * dragged,
            lever=self.lever[ticks],
            across=self.across[ticks],
            front=stiffness * self.front[ticks],
        )

    def _taken(self, area, turns, steps):
        """Return the volume that a front of this area vector removes in turns and steps, in m^3."""
        turned = turns @ (area @ self._moves)
        return float(np.maximum(turned, 0.0).sum() + np.maximum(-area[0] * steps, 0.0).sum())

    def _fitting(self, area, volume, turns, steps):
        """Return an area vector (3,) near `area` that removes a volume in turns and steps."""
        taken = self._taken(area, turns, steps)
        if taken > volume:  # some of the front was only reached on the way
            return area * (volume / taken)
        # Rays that were passed on the way are missing in the front, and count negative where it
        # turned back. The missing area faces the way, taken as straight as in `_taken`.
        way = self._moves @ turns.sum(axis=0)
        way[0] -= steps.sum()
        return area + (volume - area @ way) * way / max(way @ way, STILL**2)

    def _go_on(self, way):
        """Keep the cutter's way since it was last cut, as joint positions (n, 2).

        Keep also the cutter's move (3, 2) per radian of each joint at its end, in m/rad, for which
        each try asks.
        """
        self._way = way
        self._moves = self._turned @ self.torus.velocity(way[-1], np.eye(2)).T

    def _centres(self, position, ticks):
        """Return the cutter's centres (n, 3) at positions in some ticks of the run, in m."""
        circuit = self.plan.circuit
        points = torus_point(self.torus, position[:, 0], position[:, 1])
        centres = self._posed(circuit.in_tunnel(points))
        centres[:, 0] -= self.stepped[ticks]
        return centres

    def _posed(self, points):
        """Return points (n, 3) of the tunnel, moved with the machine by its pose."""
        return points if self.pose is None else self.pose.moved(points, self.joint)
