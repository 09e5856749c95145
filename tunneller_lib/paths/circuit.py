"""The closed curve that the cutter's centre must follow: offset tunnel meets torus."""

from dataclasses import dataclass

import numpy as np

from ..arguments import finite, instance, points, positions, positive, real
from ..surfaces import Machine, Section
from .projection import project_chord

SAMPLES = 33  # points of each projected chord at which its depth is looked at
MOST_KNOTS = 20_000  # far beyond any machine: 1e-8 m in a tunnel of a metre


def cutting_circuit(machine, section, *, pitch=0.0, yaw=0.0):
    """Return the circuit of a machine in a tunnel, after checking that it can be run.

    Parameters
    ----------
    machine : Machine
        Sizes, limits, cutter and height of the torus in the section.
    section : Section
        The tunnel's section.
    pitch, yaw : float
        Pose of the machine in the tunnel, right-handed about its own y axis (left) and then
        about the tunnel's z axis (up), in rad; a positive pitch lowers the nose.

    Returns
    -------
    circuit : Circuit
        The closed curve, a function of the arc length along the offset section.

    Raises
    ------
    ValueError
        If the machine can't reach all of it, with the inequality that fails, or with the angles
        that it would need.

    Examples
    --------
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> len(circuit.knots(tolerance=1e-3))
    36
    """
    circuit = Circuit(machine, section, pitch, yaw)
    machine.check(section, aligned=circuit.aligned)
    low, high = circuit.reach()
    if not (machine.within_limits(low) and machine.within_limits(high)):
        needs = ", ".join(
            f"{joint} from {a:.1f} to {b:.1f} deg"
            for joint, a, b in zip(("theta", "phi"), np.degrees(low), np.degrees(high), strict=True)
        )
        raise ValueError(f"machine: can't cut this section; it needs {needs}, beyond its limits.")
    return circuit


@dataclass(frozen=True)
class Circuit:
    """A circuit of the cutter's centre, by arc length s along the offset section, in m.

    `cutting_circuit` makes one after checking that the machine reaches all of it.

    Parameters
    ----------
    machine : Machine
        Sizes, limits, cutter and height of the torus in the section.
    section : Section
        The tunnel's section.
    pitch, yaw : float
        Pose of the machine in the tunnel, right-handed about its own y axis (left) and then
        about the tunnel's z axis (up), in rad; a positive pitch lowers the nose.

    Notes
    -----
    Tunnelling robot, sections 1.1 and 3.2.2. The wanted path is this intersection and not a
    geodesic; straight moves only join its knots. Points are in the frame of the machine (origin
    in the torus' centre), section coordinates (y, z) in the frame of the tunnel.
    """

    machine: Machine
    section: Section
    pitch: float = 0.0
    yaw: float = 0.0

    def __post_init__(self):
        instance("machine", self.machine, Machine)
        instance("section", self.section, Section)
        for name in ("pitch", "yaw"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))

    @property
    def aligned(self):
        """Whether the machine's axes are parallel to the tunnel's."""
        return self.pitch == 0 and self.yaw == 0

    @property
    def profile(self):
        """Return the offset section on which the centre of the cutter stays."""
        return self.section.offset(self.machine.offset)

    @property
    def axes(self):
        """Return the machine's axes in the tunnel's frame, as the columns of a matrix (3, 3)."""
        (c, s), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (self.pitch, self.yaw))
        return np.array([[cy * c, -sy, cy * s], [sy * c, cy, sy * s], [-s, 0.0, c]])

    def position(self, s):
        """Return the joint positions (..., 2) = (theta, phi), in rad, at arc lengths s (...).

        Where the axes are parallel Eq. 5 is biquadratic and the angles follow at once;
        otherwise the ruling meets the torus in up to four points, of which the document takes
        the one of greatest x.

        Raises
        ------
        ValueError
            If a ruling misses the torus.
        """
        y, z = np.moveaxis(self.profile.point(s), -1, 0)
        z = z - self.machine.height
        torus = self.machine.torus
        if self.aligned:
            missed = np.abs(y) > torus.R
            rho = torus.r + np.sqrt(np.where(missed, 0, (torus.R - y) * (torus.R + y)))
            missed |= np.abs(z) > rho
            self._refuse(missed, s)
            return np.stack([np.arcsin(-z / rho), np.arcsin(y / torus.R)], axis=-1)
        a = np.stack([np.zeros(y.size), y.ravel(), z.ravel()], axis=-1) @ self.axes
        along = self.axes[0]  # the tunnel's direction, seen by the machine
        t = torus.meet_line(a, a + along)
        self._refuse(np.isnan(t[:, 0]), s)
        farthest = np.nanargmax(t * along[0], axis=-1)
        point = a + np.take_along_axis(t, farthest[:, None], axis=-1) * along
        return np.stack(torus.angles(point), axis=-1).reshape(*y.shape, 2)

    def _refuse(self, missed, s):
        if np.any(missed):
            first = np.ravel(real("s", s))[np.flatnonzero(missed)[0]]
            raise ValueError(f"machine: can't cut this section; the ruling {first:.3f} m along the "
                             "circuit misses the torus.")  # fmt: skip

    def point(self, s):
        """Return the cutter's centre (..., 3), in m, in the machine's frame, at arc lengths s."""
        position = self.position(s)
        return self.machine.torus.point(position[..., 0], position[..., 1])

    def reach(self):
        """Return the least and the greatest joint positions (2,) on the circuit, in rad.

        Sampled, and sampled anew about each extreme until it is known to rounding.
        """
        step = self.profile.perimeter / 720
        s = step * np.arange(720)
        for _ in range(4):
            position = self.position(s)
            low, high = position.min(axis=0), position.max(axis=0)
            extremes = s[np.concatenate([position.argmin(axis=0), position.argmax(axis=0)])]
            s = (extremes[:, None] + step * np.linspace(-1, 1, 65)).ravel()
            step /= 32
        return low, high

    def in_tunnel(self, point):
        """Return points (..., 3) of the machine's frame in the tunnel's, in m."""
        turned = points("point", point) @ self.axes.T
        return turned + np.array([0.0, 0.0, self.machine.height])

    def arm(self, position):
        """Return the ends of the arm's axis, the tangential joint and the cutter's centre.

        Both (..., 3), in m, in the tunnel's frame, at joint positions (..., 2).
        """
        theta, phi = np.moveaxis(positions("position", position), -1, 0)
        torus = self.machine.torus
        return self.in_tunnel(torus.ring_point(theta)), self.in_tunnel(torus.point(theta, phi))

    def overcut(self, position):
        """Return how far the cutter's centre at joint positions (..., 2) lies outside the
        wanted profile, in m: over-break if positive, under-break if negative."""
        _, centre = self.arm(position)
        return -self.profile.depth(centre[..., 1], centre[..., 2])

    def path_overcut(self, s):
        """Return the over-break (n, SAMPLES), in m, along the tangent-sphere paths that join n
        knots at arc lengths s (n,) to a closed loop."""
        s = real("s", s)
        if s.ndim != 1:
            raise ValueError(f"s: must be a list (n,) of arc lengths; got shape {s.shape}.")
        knots = self.position(s)
        path = project_chord(self.machine.torus, knots, np.roll(knots, -1, axis=0), SAMPLES)
        return self.overcut(path)

    def knots(self, tolerance):
        """Return arc lengths (n,), in m, of knots whose tangent-sphere paths keep the depth.

        Parameters
        ----------
        tolerance : float
            Largest over- or under-break allowed between knots, in m.

        Returns
        -------
        s : (n,) float
            Ascending from 0; the loop closes from the last knot to the first. Every blend of
            the section is a knot, and each arc is divided evenly.

        Raises
        ------
        ValueError
            If the tolerance isn't above zero, or needs more than `MOST_KNOTS` knots.

        Notes
        -----
        The sagitta of a plane chord would ask for steps of sqrt(8 radius tolerance). The normal
        projection undoes part of it where the torus leans against the wall, so each arc starts
        from half as many knots and is divided until the projected paths keep the tolerance.
        """
        tolerance = positive("tolerance", tolerance)
        blends = self.profile.blends
        radius = np.array([arc.radius for arc in self.profile.arcs])
        steps = np.diff(blends) / np.sqrt(8 * radius * tolerance)
        counts = np.maximum(np.ceil(steps / 2), 1)
        while counts.sum() <= MOST_KNOTS:
            counts = counts.astype(int)
            arcs = zip(blends[:-1], blends[1:], counts, strict=True)
            s = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in arcs])
            error = np.max(np.abs(self.path_overcut(s)), axis=-1)
            worst = np.maximum.reduceat(error, np.cumsum(counts) - counts)
            if np.all(worst <= tolerance):
                return s
            # The error falls with the square of the number; approach from below, by one at least.
            more = np.maximum(np.floor(counts * np.sqrt(worst / tolerance)), counts + 1)
            counts = np.where(worst > tolerance, more, counts)
        raise ValueError(f"tolerance: must be such that {MOST_KNOTS} knots keep "
                         f"it; got {tolerance:g} m.")  # fmt: skip
