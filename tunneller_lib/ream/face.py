"""The ground at work on the joints: what stands is cut tick by tick, and pushes back.

How much is removed in a second depends on how the cutter moves, and how it moves on the force that
this asks for. Both are found together: the ticks that follow are tried with the front that the last
ones had, the wall tells what they would remove and by which front, and they are tried again until
the ground that the force was for is the ground that the cutter takes.
"""

import numpy as np

from ..kernels.exact import norm
from ..motion.both_joints import Push
from .front import engaged_areas
from .moves import levers
from .outward import gradient
from .wall import intact_wall

EVERY = 8  # ticks, a power of two, that are tried together: fewer where they don't fit
BESIDE = 0.05  # m of ground more, at either end, than planned positions reach
STILL = 1e-6  # m, too short a way to find ground on it
CLOSE = 1e-2  # share by which the ground that the force was for may differ from what is removed
HARDLY = 0.1  # of a whole groove: where less is removed, CLOSE is a share of this
MOST_TRIES = 16  # of a force
BOLD_TRIES = 4  # after which only half of a correction is made


class Face:
    """The ground in the way of a cutter that two joints move; `push` is for `motion.follow`.

    Parameters
    ----------
    plan : Plan
        What is to be done.
    ground : Ground
        What cutting asks for.
    setvalues : (n, 2) float
        Of the entry, all laps and the exit, in rad.
    first : int
        At which of them the first lap begins.
    shape : (2,) int
        Rays of the wall along the tunnel and round.
    thickness : float
        Of the modelled ground, in m.
    pose : Pose, optional
        Where the machine stands instead of where it should.
    noted : (k,) int, optional
        Set-values at which the volume removed so far must be known.
    say : function, optional
        Told the number of the set-value that the run has reached.

    Attributes
    ----------
    wall : DexelGrid
        What stands.
    ends : (float, float)
        From where to where it is modelled along the tunnel's x, in m.
    removed : (n - 1,) float
        Volumes, in m^3, at the ticks by whose ends they were cut.
    front : (n - 1, 2) float
        Ground that is removed for each radian of both joints in each tick, in m^3.
    stepping : (n - 1,) float
        Ground that the machine's own step removes in a second in each tick, in m^3/s.
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
        self._area = np.zeros(3)  # m^2, of the ball's front, as `DexelGrid.front` has it
        rate = engaged_areas(circuit, plan.s) * plan.feed
        self._most = float(rate.max()) * plan.tick  # m^3, that a tick takes of whole grooves
        self._tries = 0
        self._together = EVERY

    def push(self, tick, tried):
        """Return the `Push` of the ticks from `tick` on, or None once force and motion agree.

        `tried` are the positions (m + 1, 2) to which the last answer led; None at first.
        """
        if tried is None:  # new ticks begin with the front that the last ones had
            self._say(tick)
            self._tries = 0
            self._together = EVERY
            return self._pushed(tick)
        self._tries += 1
        # Short moves that weren't cut yet are the beginning of the way.
        way = np.concatenate([self._way[:-1], tried])
        end = tick + len(tried) - 1
        run = slice(end - len(way) + 1, end + 1)
        centres = self._centres(way, run)
        moved = float(np.sum(norm(centres[1:] - centres[:-1])))
        if moved <= STILL:  # what is cut by so little is known later
            self._go_on(way)
            return None
        turns = np.diff(way, axis=0)
        steps = np.diff(self.stepped[run])
        # What the tried motion would remove, beside what the force was for.
        volume, area = self.wall.front(centres, self.radius)
        meant = self._taken(self._area, turns, steps)
        if abs(meant - volume) <= CLOSE * max(volume, HARDLY * self._most):
            self.removed[end - 1] = self.wall.cut_path(centres, self.radius)
            self._go_on(way[-1:])
            return None
        if self._tries == MOST_TRIES:
            if self._together == 1:
                raise ValueError(
                    f"ground: force and motion must agree within {100 * CLOSE:g} %; "
                    f"{self.plan.tick * tick:.2f} s after the entry began the force is that of "
                    f"{1e9 * meant:.3g} mm^3 in a tick, and {1e9 * volume:.3g} mm^3 are removed."
                )
            self._together //= 2  # over fewer ticks the front changes less
            self._tries = 0
        # Far from agreement whole corrections are quickest; near it they may swing for ever.
        found = self._fitting(area, volume, turns, steps)
        self._area = found if self._tries <= BOLD_TRIES else (self._area + found) / 2
        return self._pushed(tick)

    def finish(self, position):
        """Cut what is left of the way, once all positions (n, 2) are known."""
        if len(self._way) > 1:
            centres = self._centres(self._way, slice(len(position) - len(self._way), None))
            self.removed[-1] += self.wall.cut_path(centres, self.radius)

    def force(self, track):
        """Return the force (n - 1,) against the motion at each tick's beginning, in N."""
        rates = np.stack([states[:-1, 1] for states in track.states], axis=-1)
        rate = np.maximum(np.sum(self.front * rates, axis=-1), 0.0)
        return self.stiffness * (rate + self.stepping)

    def _pushed(self, tick):
        """Return the `Push` of the ticks from `tick` on, with the front as it is known."""
        stop = self._stops[np.searchsorted(self._stops, tick, side="right")]
        ticks = slice(tick, min(tick + self._together, stop))
        moves = self._moves
        self.front[ticks] = self._area @ moves
        steps = np.diff(self.stepped[ticks.start : ticks.stop + 1])
        self.stepping[ticks] = np.maximum(-self._area[0] * steps, 0.0) / self.plan.tick
        stiffness = self.stiffness[ticks, None]
        # While the machine steps back, towards -x, the ground drags the cutter the other way.
        dragged = self.across[ticks] - moves[0]
        return Push(
            torque=stiffness * self.stepping[ticks, None] * dragged,
            lever=self.lever[ticks],
            across=self.across[ticks],
            front=stiffness * self.front[ticks],
        )

    def _taken(self, area, turns, steps):
        """Return the volume, in m^3, that a front of this area vector takes in turns and steps."""
        turned = turns @ (area @ self._moves)
        return float(np.maximum(turned, 0.0).sum() + np.maximum(-area[0] * steps, 0.0).sum())

    def _fitting(self, area, volume, turns, steps):
        """Return an area vector (3,) like `area`, by which turns and steps take a volume."""
        taken = self._taken(area, turns, steps)
        if taken > volume:  # in places that were reached on the way
            return area * (volume / taken)
        # On rays that were passed on the way no front is left, and where it turned back, less than
        # none. What lacks faces the way, as straight as `_taken` has it.
        way = self._moves @ turns.sum(axis=0)
        way[0] -= steps.sum()
        return area + (volume - area @ way) * way / max(way @ way, STILL**2)

    def _go_on(self, way):
        """Keep the cutter's way since it was last cut, as joint positions (n, 2).

        And how the cutter moves (3, 2) by each joint at its end, in m/rad: tries ask again.
        """
        self._way = way
        self._moves = self._turned @ self.torus.velocity(way[-1], np.eye(2)).T

    def _centres(self, position, ticks):
        """Return the cutter's centres (n, 3), in m, at positions of some ticks of the run."""
        circuit = self.plan.circuit
        points = self.torus.point(position[:, 0], position[:, 1])
        centres = self._posed(circuit.in_tunnel(points))
        centres[:, 0] -= self.stepped[ticks]
        return centres

    def _posed(self, points):
        """Return points (n, 3) of the tunnel where the machine stands as it does."""
        return points if self.pose is None else self.pose.moved(points, self.joint)
