"""The ground at work on the joints: what stands is cut tick by tick, and pushes back."""

import numpy as np

from ..exact import norm
from ..motion.both_joints import Push
from .moves import levers
from .outward import gradient
from .wall import intact_wall

EVERY = 8  # ticks after which the wall is cut and the ground in the cutter's way is known again
BESIDE = 0.05  # m of ground more, at either end, than planned positions reach
STILL = 1e-6  # m, too short a way to find ground on it


class Face:
    """The ground in the way of a cutter that two joints move; `push` is for `motion.follow`.

    The ground that is removed for each metre of way is that of the last `EVERY` ticks, or of fewer
    where one is `noted`.

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
    pose : Pose or None
        Where the machine stands instead of where it should.
    shape : (int, int)
        Rays of the wall along the tunnel and round.
    thickness : float
        Of the modelled ground, in m.
    noted : (k,) int
        Set-values up to which the removed volumes are to be known.
    say : function
        Told at which set-value the run is.

    Attributes
    ----------
    wall : DexelGrid
        What stands.
    ends : (float, float)
        From where to where it is modelled along the tunnel's x, in m.
    removed : (n - 1,) float
        Volumes, in m^3, at the ticks by whose ends they were cut.
    area : (n - 1,) float
        Ground that is removed for each metre of way in each tick, in m^2.
    damper : (n - 1,) float
        Force against the motion over the cutter's speed in each tick, in N s/m.
    """

    def __init__(self, plan, ground, setvalues, first, pose, shape, thickness, noted, say):
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
        self.area = np.zeros(len(setvalues) - 1)
        self.damper = np.zeros(len(setvalues) - 1)
        self._stops = np.append(noted, len(setvalues) - 1)
        self._say = say
        self._way = np.empty((0, 2))
        self._ahead = 0.0
        self._asked = 0

    def push(self, tick, reached):
        """Return the `Push` of the next ticks, once the cutter has `reached` positions (m, 2)."""
        self._cut(tick, reached)
        self._asked = tick
        self._say(tick)
        stop = self._stops[np.searchsorted(self._stops, tick, side="right")]
        ticks = slice(tick, min(tick + EVERY, stop))
        self.area[ticks] = self._ahead
        self.damper[ticks] = self._ahead * self.stiffness[ticks]
        return Push(damper=self.damper[ticks], lever=self.lever[ticks], across=self.across[ticks])

    def finish(self, position):
        """Cut what is left of the way, once all positions (n, 2) are known."""
        self._cut(len(position) - 1, position[self._asked :])

    def _cut(self, tick, reached):
        """Cut the way up to a tick, through the positions (m, 2) that were reached since."""
        # Where the cutter hardly moved what it cuts is known later.
        self._way = np.concatenate([self._way[:-1], reached])
        begun = tick - len(self._way) + 1
        centres = self._centres(self._way, slice(begun, tick + 1))
        moved = float(np.sum(norm(centres[1:] - centres[:-1])))
        if moved > STILL:
            cut_path = self.wall.cut_path.unchecked
            self.removed[tick - 1] = cut_path(self.wall, centres, self.radius)
            self._ahead = self.removed[tick - 1] / moved
            self._way = self._way[-1:]

    def force(self, track):
        """Return the force (n - 1,) against the motion at each tick's beginning, in N."""
        rates = np.stack([states[:-1, 1] for states in track.states], axis=-1)
        return self.damper * np.linalg.norm(self.lever * rates, axis=-1)

    def _centres(self, position, ticks):
        """Return the cutter's centres (n, 3), in m, at positions of some ticks of the run."""
        circuit = self.plan.circuit
        points = self.torus.point.unchecked(self.torus, position[:, 0], position[:, 1])
        centres = circuit.in_tunnel.unchecked(circuit, points)
        if self.pose is not None:
            centres = self.pose.moved(centres, self.joint)
        centres[:, 0] -= self.stepped[ticks]
        return centres
