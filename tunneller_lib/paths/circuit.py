"""The closed curve that the cutter's centre must follow: offset tunnel meets torus."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arguments import Angle, Lengths, Points, Positions, Positive, checked
from ..surfaces import Machine, Section
from .bounds import Row, Way
from .chord_paths import CHORD_PATHS

PLACES = 33  # of each path between knots at which its overbreak is taken
LEAST_SIZE, MOST_SIZE = 1e-6, 1e6  # m
MOST_KNOTS = 20_000  # far more than any machine needs: they keep 1e-8 m in a tunnel of a metre


@checked
def cutting_circuit(machine: Machine, section: Section, *, pitch: Angle = 0.0, yaw: Angle = 0.0):
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
        If the machine can't reach all of it. The message has the inequality that fails, or the
        angles that it would need.

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
@checked
class Circuit:
    """A circuit of the cutter's centre, as a function of arc length s along the offset section.

    `cutting_circuit` makes one after checking that the machine reaches all of it; s is in m.

    Parameters
    ----------
    machine : Machine
        Sizes, limits, cutter and height of the torus in the section.
    section : Section
        The tunnel's section.
    pitch, yaw : float
        Pose of the machine in the tunnel, right-handed about its own y axis (left) and then
        about the tunnel's z axis (up), in rad; a positive pitch lowers the nose.

    Raises
    ------
    ValueError
        If r + R of the machine isn't from 1e-6 to 1e6 m.

    Notes
    -----
    Tunnelling robot, sections 1.1 and 3.2.2. The wanted path is this intersection, not a geodesic;
    paths that stand in for geodesics only join its knots. Points are in the frame of the machine,
    with the origin in the torus' centre, section coordinates (y, z) in the frame of the tunnel.
    """

    machine: Machine
    section: Section
    pitch: Angle = 0.0
    yaw: Angle = 0.0

    def __post_init__(self):
        size = self.machine.r + self.machine.R
        if not LEAST_SIZE <= size <= MOST_SIZE:
            raise ValueError(
                f"machine: r + R must be from {LEAST_SIZE:g} to {MOST_SIZE:g} m, for rulings are "
                f"given by points a metre apart; got {size:g} m."
            )

    @property
    def aligned(self):
        """Return whether the machine's axes are parallel to the tunnel's."""
        return self.pitch == 0 and self.yaw == 0

    @cached_property
    def profile(self):
        """Return the offset section on which the centre of the cutter stays."""
        return self.section.offset(self.machine.offset)

    @property
    def axes(self):
        """Return the machine's axes in the tunnel's frame, as the columns of a matrix (3, 3)."""
        c, s = np.cos(self.pitch), np.sin(self.pitch)
        cy, sy = np.cos(self.yaw), np.sin(self.yaw)
        # The pitch turns about the machine's y axis first, then the yaw about the tunnel's z axis.
        return np.array([[cy * c, -sy, cy * s], [sy * c, cy, sy * s], [-s, 0.0, c]])

    @checked
    def position(self, s: Lengths):
        """Return the joint positions of the circuit.

        Parameters
        ----------
        s : (...) float
            Arc lengths along the offset section, in m.

        Returns
        -------
        position : (..., 2) float
            (theta, phi), in rad.

        Raises
        ------
        ValueError
            If a ruling misses the torus.

        Notes
        -----
        Where the axes are parallel, Eq. 5 is biquadratic and the angles follow at once. Otherwise
        the ruling meets the torus in up to four points, of which the document takes the one with
        the greatest x.
        """
        y, z = np.moveaxis(self.profile.point(s), -1, 0)
        z = z - self.machine.height
        torus = self.machine.torus
        if self.aligned:
            # y alone gives phi, and with it the radius rho of the parallel on which z lies.
            missed = np.abs(y) > torus.R
            rho = torus.r + np.sqrt(np.where(missed, 0, (torus.R - y) * (torus.R + y)))
            missed |= np.abs(z) > rho
            self._refuse(missed, s)
            return np.stack([np.arcsin(-z / rho), np.arcsin(y / torus.R)], axis=-1)
        # A product with the axes from the right takes vectors to the machine's frame.
        a = np.stack([np.zeros(y.size), y.ravel(), z.ravel()], axis=-1) @ self.axes
        along = self.axes[0]  # the tunnel's direction, seen by the machine
        # A ruling so far off misses for sure, and needn't be solved for.
        self._refuse(np.hypot(y, z).ravel() > 2 * (torus.r + torus.R), s)
        t = torus.meet_line(a, a + along)
        self._refuse(np.isnan(t[:, 0]), s)
        farthest = np.nanargmax(t * along[0], axis=-1)
        point = a + np.take_along_axis(t, farthest[:, None], axis=-1) * along
        return np.stack(torus.angles(point), axis=-1).reshape(*y.shape, 2)

    def _refuse(self, missed, s):
        """Raise ValueError with the first arc length s whose ruling has `missed` the torus."""
        if np.any(missed):
            first = np.ravel(s)[np.flatnonzero(missed)[0]]
            raise ValueError(
                f"machine: can't cut this section; the ruling {first:.3f} m along the circuit "
                "misses the torus."
            )

    @checked
    def point(self, s: Lengths):
        """Return the cutter's centre (..., 3), in m, in the machine's frame, at arc lengths s."""
        position = self.position(s)
        return self.machine.torus.point(position[..., 0], position[..., 1])

    @checked
    def reach(self):
        """Return the least and the greatest joint positions (2,) on the circuit, in rad.

        The circuit is sampled, and sampled anew about each extreme until that is known to rounding.
        """
        step = self.profile.perimeter / 720
        s = step * np.arange(720)
        for _ in range(4):
            position = self.position(s)
            low = position.min(axis=0)
            high = position.max(axis=0)
            extremes = s[np.concatenate([position.argmin(axis=0), position.argmax(axis=0)])]
            # The next samples lie within a step of each extreme, 32 times as close.
            s = (extremes[:, None] + step * np.linspace(-1, 1, 65)).ravel()
            step /= 32
        return low, high

    @checked
    def in_tunnel(self, point: Points):
        """Return points (..., 3) of the machine's frame in the tunnel's, in m."""
        return point @ self.axes.T + np.array([0.0, 0.0, self.machine.height])

    @checked
    def arm(self, position: Positions):
        """Return the ends of the arm's axis at joint positions.

        Parameters
        ----------
        position : (..., 2) float
            Joint positions (theta, phi), in rad.

        Returns
        -------
        joint, centre : (..., 3) float
            The tangential joint and the cutter's centre, in m, in the tunnel's frame.
        """
        theta, phi = np.moveaxis(position, -1, 0)
        torus = self.machine.torus
        joint = torus.ring_point(theta)
        centre = torus.point(theta, phi)
        return self.in_tunnel(joint), self.in_tunnel(centre)

    @checked
    def arm_axes(self, position: Positions):
        """Return the arm's axes at joint positions, in the tunnel's frame.

        Parameters
        ----------
        position : (..., 2) float
            Joint positions (theta, phi), in rad.

        Returns
        -------
        axes : (..., 3, 3) float
            As the columns of a matrix: along the arm, to its left, and upwards.
        """
        theta, phi = np.moveaxis(position, -1, 0)
        level = np.stack([np.cos(theta), 0 * theta, -np.sin(theta)], axis=-1)
        up = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)
        left = np.array([0.0, 1.0, 0.0])
        c, s = np.cos(phi)[..., None], np.sin(phi)[..., None]
        # At phi = 0 the arm lies along `level`, and phi turns it to the left, about `up`.
        return self.axes @ np.stack([c * level + s * left, c * left - s * level, up], axis=-1)

    @checked
    def overbreak(self, position: Positions):
        """Return how far the cutter's centre lies outside the wanted profile.

        Parameters
        ----------
        position : (..., 2) float
            Joint positions (theta, phi), in rad.

        Returns
        -------
        overbreak : (...) float
            In m: overbreak if positive, underbreak if negative.
        """
        _, centre = self.arm(position)
        return -self.profile.depth(centre[..., 1], centre[..., 2])

    @checked
    def path_overbreak(self, s: Row, *, path: Way = "projected chord"):
        """Return the overbreak along the paths that join knots to a closed loop.

        Parameters
        ----------
        s : (n,) float
            Arc lengths of the knots, in m.
        path : {"projected chord", "corrected chord"}
            Which of `CHORD_PATHS` joins them.

        Returns
        -------
        overbreak : (n, 33) float
            At 33 places of each path, both ends included, in m.
        """
        position = self.position(s)
        after = np.roll(position, -1, axis=0)
        way = CHORD_PATHS[path](self.machine.torus, position, after, np.linspace(0, 1, PLACES))
        return self.overbreak(way)

    @checked
    def knots(self, tolerance: Positive, *, path: Way = "projected chord"):
        """Return arc lengths of knots between which the paths keep to the profile.

        Parameters
        ----------
        tolerance : float
            Largest over- or underbreak allowed between knots, in m.
        path : {"projected chord", "corrected chord"}
            Which of `CHORD_PATHS` joins them.

        Returns
        -------
        s : (n,) float
            In m, ascending from 0; the last path leads back to the first knot. Every blend of the
            section is a knot, and each arc between blends is divided evenly.

        Raises
        ------
        ValueError
            If the tolerance isn't above zero, or needs more than `MOST_KNOTS` knots.

        Notes
        -----
        By the sagitta of a plane chord steps would be sqrt(8 radius tolerance) long. Normal
        projection undoes part of the sagitta where the torus leans against the wall. So each arc
        starts with half as many knots, and is divided until the paths keep the tolerance.
        """
        blends = self.profile.blends
        radius = np.array([arc.radius for arc in self.profile.arcs])
        with np.errstate(over="ignore", divide="ignore"):  # infinitely many are refused below
            steps = np.diff(blends) / np.sqrt(8 * radius * tolerance)
        counts = np.maximum(np.ceil(steps / 2), 1)
        while counts.sum() <= MOST_KNOTS:
            counts = counts.astype(int)
            arcs = zip(blends[:-1], blends[1:], counts, strict=True)
            s = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in arcs])
            error = np.max(np.abs(self.path_overbreak(s, path=path)), axis=-1)
            worst = np.maximum.reduceat(error, np.cumsum(counts) - counts)
            kept = worst <= tolerance
            if np.all(kept):
                return s
            # The error falls with the square of the number. There is one knot more at least, also
            # where the error is NaN: `fmax` passes over it.
            more = np.fmax(np.floor(counts * np.sqrt(worst / tolerance)), counts + 1)
            counts = np.where(kept, counts, more)
        raise ValueError(
            f"tolerance: must be such that {MOST_KNOTS} knots keep it; got {tolerance:g} m."
        )
