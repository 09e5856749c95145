"""The tunnelling machine: its sizes, joint limits and cutter, and what it reaches in a section."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Coordinate, Finite, Length, Length0, NotNegative, Positions, checked
from .box import Box
from .rod import Rod
from .section import Section
from .torus import Torus


class Requirement(NamedTuple):
    """One inequality that a machine must meet.

    Parameters
    ----------
    what : str
        What is compared, in words and in letters.
    left : float
        The side that should be smaller, in m.
    strict : bool
        Whether left < right is required, or left <= right.
    right : float
        The side that should be greater, in m.
    """

    what: str
    left: float
    strict: bool
    right: float

    @property
    def met(self):
        """Return whether it holds."""
        return self.left < self.right or (self.left == self.right and not self.strict)

    def __str__(self):
        sign = "<" if self.strict else "<="
        verdict = "holds" if self.met else f"fails by {self.left - self.right:.2g} m"
        return f"{self.what}: {self.left:.4g} m {sign} {self.right:.4g} m {verdict}"


@dataclass(frozen=True)
@checked
class Body:
    """The body of a machine, an upright box, and the holder of its cutter.

    Parameters
    ----------
    length, width : float
        Of the box, in m: backwards from the horizontal joint, and across, half on either side.
    low, high : float
        Heights of its underside and of its top above that joint, in m.
    holder_radius, holder_length : float
        Of the cylinder about the arm that carries the cutter, from the cutter's centre backwards,
        in m. If either is 0 there is no holder.

    Raises
    ------
    ValueError
        If length or width isn't above zero, a size of the holder is below zero, or the underside
        isn't below the top.

    Examples
    --------
    >>> Body(length=1.2, width=0.3, low=-0.2, high=0.1).holder_length
    0.0
    """

    length: Length
    width: Length
    low: Coordinate
    high: Coordinate
    holder_radius: Length0 = 0.0
    holder_length: Length0 = 0.0

    def __post_init__(self):
        if not self.low < self.high:
            raise ValueError(f"low: must be below high; got {self.low:g} and {self.high:g} m.")

    @property
    def box(self):
        """Return the `Box`, in the machine's frame."""
        corner = -self.length, -self.width / 2, self.low
        return Box(corner, (self.length, 0, 0), (0, self.width, 0), (0, 0, self.high - self.low))

    @property
    def holder(self):
        """Return the holder as a `Rod` along the arm, here -x, to the cutter's centre, here 0."""
        return Rod((-self.holder_length, 0, 0), (0, 0, 0), self.holder_radius)

    @property
    def has_holder(self):
        """Return whether there is a holder."""
        return self.holder_radius > 0 and self.holder_length > 0


@dataclass(frozen=True)
@checked
class Machine:
    """A machine with two joints that reams a section, its axes along the tunnel's.

    Parameters
    ----------
    r, R : float
        Radii of the cutter centre's `Torus`, in m.
    theta_min, theta_max, phi_min, phi_max : float
        Joint limits in rad; a negative theta lifts the cutter.
    cutter_radius : float
        Radius of the spherical cutter, in m.
    depth : float
        Depth that it cuts behind the given wall, in m, from 0 to less than its radius.
    height : float
        Height of the torus' centre above the origin of the section, an egg's centre of the roof,
        in m.
    body : Body, optional
        What else of the machine takes up room; without it only arm and cutter do.

    Raises
    ------
    ValueError
        If a size isn't above zero, the depth isn't from 0 to below the cutter's radius, a limit
        isn't an angle in rad or a range is empty.

    Notes
    -----
    Tunnelling robot, section 1.1. The joint limits are as printed, with the relations mended:
    "about -40 >= phi <= 40" can only mean -40 <= phi <= 40 (degrees).

    Examples
    --------
    >>> from dataclasses import replace
    >>> replace(REFERENCE_MACHINE, phi_min=1.0, phi_max=1.0)
    Traceback (most recent call last):
    ValueError: phi_min: must be below phi_max, both in rad from -pi to pi; got 1 and 1.
    """

    r: Length
    R: Length
    theta_min: Angle
    theta_max: Angle
    phi_min: Angle
    phi_max: Angle
    cutter_radius: Length
    depth: NotNegative
    height: Finite
    body: Body | None = None

    def __post_init__(self):
        for joint in ("theta", "phi"):
            low, high = getattr(self, f"{joint}_min"), getattr(self, f"{joint}_max")
            if not -np.pi <= low < high <= np.pi:
                raise ValueError(
                    f"{joint}_min: must be below {joint}_max, both in rad from -pi to pi; "
                    f"got {low:g} and {high:g}."
                )
        if self.depth >= self.cutter_radius:
            raise ValueError(
                f"depth: must be below the cutter's radius {self.cutter_radius:g} m; "
                f"got {self.depth:g} m."
            )

    @property
    def torus(self):
        """Return the surface on which the cutter's centre moves."""
        return Torus(self.r, self.R)

    @property
    def offset(self):
        """Return how far inside the wall the cutter's centre moves, in m."""
        return self.cutter_radius - self.depth

    @checked
    def within_limits(self, position: Positions):
        """Return whether joint positions (..., 2) = (theta, phi), in rad, are inside the limits."""
        low = np.array([self.theta_min, self.phi_min])
        high = np.array([self.theta_max, self.phi_max])
        return np.all((low <= position) & (position <= high), axis=-1)

    @checked
    def requirements(self, section: Section):
        """Return what the machine must meet to cut the whole of a section.

        Parameters
        ----------
        section : Section
            The tunnel's, symmetric about the vertical plane or not.

        Returns
        -------
        requirements : tuple of Requirement
            Bend, width, crown and floor; `str` of each is a line with its numbers. The egg with a
            roof of radius a has the least radius a/2 and reaches in height from -2a to a.

        Notes
        -----
        They are necessary, and for an egg sufficient. sin(phi) = y / R is greatest where the
        section is widest. Along the offset section sin(theta) = -(z - height) / rho with
        rho = r + sqrt(R^2 - y^2), and

            rho d(sin(theta)) = -dz + sin(theta) y dy / sqrt(R^2 - y^2).

        While |sin(theta)| < 1 the last term is the smaller one, since
        |y dy| <= sqrt(R^2 - y^2) |dz|: squared, on an arc of radius k about (y0, z0), that says
        k |y| <= R |y - y0|. The width keeps the roof's radius a - d below R. Roof and invert have
        y0 = 0 and k <= a - d; on a wall |y| / |y - y0| is greatest beside the roof, (a - d) / k.
        So the sine grows all the way from crown to floor while it is between -1 and 1. It is so at
        both, and can't leave that range between them: it could come back only by falling.
        """
        # The centre of the cutter runs on the section's offset by d.
        d = self.offset
        reach = self.r + self.R
        (right, floor), (left, crown) = section.box
        half = max(left, -right) - d
        # The sine's greatest value within each range of angles; past a right angle it falls again.
        swing, lift, drop = (
            np.sin(min(angle, np.pi / 2))
            for angle in (min(self.phi_max, -self.phi_min), -self.theta_min, self.theta_max)
        )
        return (
            Requirement("bend, offset < least radius", d, True, section.least_radius),
            Requirement("width, half width - offset <= R sin(phi)", half, False, self.R * swing),
            Requirement(
                "crown, roof - offset - height <= (r + R) sin(-theta_min)",
                crown - d - self.height,
                False,
                reach * lift,
            ),
            Requirement(
                "floor, height - floor - offset <= (r + R) sin(theta_max)",
                self.height - floor - d,
                False,
                reach * drop,
            ),
        )

    @checked
    def heights(self, section: Section):
        """Return the lowest and the highest `height`, in m, that reach crown and floor."""
        # Both inequalities are linear in the height: what is missing, or to spare, moves it.
        crown, floor = self.requirements(section)[2:]
        return self.height + crown.left - crown.right, self.height - floor.left + floor.right

    @checked
    def check(self, section: Section, *, aligned: bool = True):
        """Raise ValueError with the inequalities that fail where the machine can't cut a section.

        Parameters
        ----------
        section : Section
            The tunnel's.
        aligned : bool
            Whether the machine's axes are parallel to the tunnel's. If not, only the tightest bend
            is checked, because the reach depends on the pose.
        """
        # The first requirement, that the cutter fits the tightest bend, holds in any pose.
        requirements = self.requirements(section)[: None if aligned else 1]
        failing = [str(requirement) for requirement in requirements if not requirement.met]
        if failing:
            raise ValueError(f"machine: can't cut this section; {'; '.join(failing)}.")


# The document gives no sizes; these are the study's own, for a section with a = 0.5 m.
REFERENCE_MACHINE = Machine(
    r=0.08,
    R=0.80,
    theta_min=np.radians(-60),
    theta_max=np.radians(35),
    phi_min=np.radians(-40),
    phi_max=np.radians(40),
    cutter_radius=0.20,
    depth=0.02,
    height=-0.36,
)
