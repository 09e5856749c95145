"""The torus on which the centre of the cutter moves: Tunnelling robot, Eqs 1 to 11."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Angles, Directions, Length, Points, Positions, Rates, checked
from ..kernels.exact import dot, in_blocks, radius_and_excess
from . import torus_line

# The four tangent spheres of a point, by (sigma, eps): which meridian circle, and which end of it.
FEET = ((1, 1), (1, -1), (-1, 1), (-1, -1))


@dataclass(frozen=True)
@checked
class Torus:
    """A torus about the y axis, in the frame of the machine: x forward, y left, z up.

    Parameters
    ----------
    r : float
        Radius of the ring: from the horizontal joint's axis to the tangential joint, in m.
    R : float
        Radius of the tube: from the tangential joint to the cutter's centre, in m.

    Raises
    ------
    ValueError
        If a radius isn't one number from 1e-100 to 1e100.

    Notes
    -----
    Tunnelling robot, section 1.1, with the names set right: the text calls R the "ring centre
    circle radius", but in its Eq. 1 R is the tube's. With R > r the torus meets itself in two nodes
    (0, +-sqrt(R^2 - r^2), 0). Its *working* (outer, "apple") sheet is where r + R cos(phi) >= 0,
    and the inner ("lemon") sheet lies inside it.
    """

    r: Length
    R: Length

    @checked
    def point(self, theta: Angles, phi: Angles):
        """Return the centre of the cutter for joint angles (Eq. 1).

        Parameters
        ----------
        theta, phi : (...) float
            Angles of the horizontal and the tangential joint, in rad; a negative theta lifts.

        Returns
        -------
        point : (..., 3) float
            In m.

        Examples
        --------
        >>> Torus(r=0.1, R=0.9).point(0, 0)
        array([1., 0., 0.])
        """
        return torus_point(self, theta, phi)

    @checked
    def angles(self, point: Points):
        """Return the joint angles of points, the inverse of `point` on the working sheet.

        Parameters
        ----------
        point : (..., 3) float
            Points in m. A point off the working sheet gets the angles of its `foot`.

        Returns
        -------
        theta, phi : (...) float
            In rad, both from -pi to pi. On the axis theta is 0, and on the ring circle phi is 0.
            Near the axis of a spindle the foot may lie on the inner sheet, see `foot`.
        """
        return torus_angles(self, point)

    @checked
    def implicit(self, point: Points):
        """Return the left side of Eq. 2 at points, in m^4: 0 on the torus, infinite beyond 1e77 m.

        It is taken as a product over the two circles in which the meridian plane cuts the torus.
        The printed difference of fourth powers cancels where the ring is small against the tube.
        """
        x, y, z = np.moveaxis(point, -1, 0)
        # Each factor is a difference or a sum of lengths, which is small only near the torus.
        rho, excess = radius_and_excess(x, z, self.r)
        near, far = np.hypot(excess, y), np.hypot(rho + self.r, y)
        with np.errstate(over="ignore"):
            return (near - self.R) * (near + self.R) * (far - self.R) * (far + self.R)

    @checked
    def normal(self, theta: Angles, phi: Angles):
        """Return the unit normals (..., 3), away from the centre of the tube circle (Eq. 7)."""
        return torus_normal(theta, phi)

    @checked
    def ring_point(self, theta: Angles):
        """Return the points (..., 3) of the ring circle, in m, where the tangential joint is."""
        return self.r * _stack(np.cos(theta), np.zeros_like(theta), 0.0 - np.sin(theta))

    @checked
    def tangents(self, theta: Angles, phi: Angles):
        """Return the unit tangents of the meridian and of the parallel.

        Parameters
        ----------
        theta, phi : (...) float
            Joint angles in rad.

        Returns
        -------
        meridian, parallel : (..., 3) float
            Towards growing phi and towards growing theta; with `normal` they are at right angles.
        """
        return torus_tangents(theta, phi)

    @checked
    def velocity(self, position: Positions, rate: Rates):
        """Return the velocity of the cutter's centre, by the first derivative of Eq. 1.

        Parameters
        ----------
        position, rate : (..., 2) float
            Joint positions (theta, phi), in rad, and their rates, in rad/s.

        Returns
        -------
        velocity : (..., 3) float
            In m/s.
        """
        theta, phi, turning, lifting = _joint_motion(position, rate)
        rho, drho = self.r + self.R * np.cos(phi), -self.R * np.sin(phi) * lifting
        return _stack(
            drho * np.cos(theta) - rho * np.sin(theta) * turning,
            self.R * np.cos(phi) * lifting,
            -drho * np.sin(theta) - rho * np.cos(theta) * turning,
        )

    @checked
    def acceleration(self, position: Positions, rate: Rates):
        """Return the acceleration of the cutter's centre while the joint rates are constant.

        Parameters
        ----------
        position, rate : (..., 2) float
            Joint positions (theta, phi), in rad, and their rates, in rad/s.

        Returns
        -------
        acceleration : (..., 3) float
            In m/s^2: the second derivative of Eq. 1 along a straight line in joint space.
        """
        theta, phi, turning, lifting = _joint_motion(position, rate)
        rho, drho = self.r + self.R * np.cos(phi), -self.R * np.sin(phi) * lifting
        radial = -self.R * np.cos(phi) * lifting**2 - rho * turning**2
        sideways = 2 * drho * turning
        return _stack(
            radial * np.cos(theta) - sideways * np.sin(theta),
            -self.R * np.sin(phi) * lifting**2,
            -radial * np.sin(theta) - sideways * np.cos(theta),
        )

    @checked
    def normal_curvature(self, position: Positions, direction: Directions):
        """Return the normal curvature of the torus in tangent directions, by Euler's formula.

        Parameters
        ----------
        position : (..., 2) float
            Joint positions (theta, phi), in rad.
        direction : (..., 3) float
            Unit vectors in the tangent plane.

        Returns
        -------
        curvature : (...) float
            In 1/m, positive where the surface bends away from `normal`.
        """
        # By Euler both principal curvatures are weighed by the squared cosines of the direction.
        cos, _, first, second = self._in_principal_directions(position, direction)
        return first * cos**2 + second * (1 - cos**2)

    @checked
    def geodesic_torsion(self, position: Positions, direction: Directions):
        """Return the torsion of the geodesics that leave in tangent directions.

        Parameters
        ----------
        position : (..., 2) float
            Joint positions (theta, phi), in rad.
        direction : (..., 3) float
            Unit vectors in the tangent plane.

        Returns
        -------
        torsion : (...) float
            In 1/m; zero along meridians and parallels, the lines of curvature.
        """
        cos, sin, first, second = self._in_principal_directions(position, direction)
        return (second - first) * sin * cos

    def _in_principal_directions(self, position, direction):
        """Return cosine and sine from the meridian to a direction, and both curvatures."""
        theta, phi = np.moveaxis(position, -1, 0)
        meridian, parallel = self.tangents(theta, phi)
        return dot(meridian, direction), dot(parallel, direction), *self.curvatures(theta, phi)

    @checked
    def curvatures(self, theta: Angles, phi: Angles):
        """Return the principal curvatures along the meridian and along the parallel.

        Parameters
        ----------
        theta, phi : (...) float
            Joint angles in rad.

        Returns
        -------
        meridian, parallel : (...) float
            In 1/m, positive where the surface bends away from `normal`; the second is infinite
            at a node.
        """
        theta, phi = np.broadcast_arrays(theta, phi)
        with np.errstate(divide="ignore"):
            # By Meusnier: the parallel's curvature, 1 / rho, times the cosine between its plane and
            # the normal, cos(phi).
            parallel = np.cos(phi) / (self.r + self.R * np.cos(phi))
        return np.full(phi.shape, 1 / self.R)[()], parallel

    @checked
    def feet(self, m: Points):
        """Return where the four spheres about points touch the torus (Eqs 6 to 9).

        Parameters
        ----------
        m : (..., 3) float
            Centres M of the spheres, in m.

        Returns
        -------
        feet : (..., 4, 3) float
            Points N, in m, in the order of `FEET`. sigma = +1 is the meridian circle on the side of
            M, and eps = +1 its point on the same side of the circle's centre as M. On the axis of
            revolution, where the feet make a circle, the one at theta = 0 is returned; at a
            circle's centre, from which the whole circle is equally far, the one at phi = 0 or pi.
            At a node two of the feet are the node.

        Notes
        -----
        The closed form takes two square roots, and no more does the quartic Eq. 10 need, which the
        document gets by elimination (`exhibits.quartics.foot_quartic`). Errors stay below 1e-13 of
        the foot's distance from the origin, unless M is nearer to the ring circle than 1e-10 r.

        Examples
        --------
        >>> Torus(r=1, R=2).feet((5, 0, 0))[:, 0]
        array([ 3., -1.,  1., -3.])
        """
        return np.stack([self._foot(m, sigma, eps) for sigma, eps in FEET], axis=-2)

    @checked
    def foot(self, m: Points):
        """Return where a sphere about each point touches the working sheet: `feet` (+, +).

        Parameters
        ----------
        m : (..., 3) float
            Centres M of the spheres, in m.

        Returns
        -------
        foot : (..., 3) float
            Points N where the spheres touch, in m. N is on the working sheet while
            r + R (rho - r) / distance(M, ring circle) >= 0, where rho is the distance of M from the
            axis of revolution. On a spindle a point M near that axis has its foot on the inner
            sheet, beyond the axis. On the axis, where the feet make a circle, N is the one at
            theta = 0; on the ring circle, from which a meridian circle is equally far, the one at
            phi = 0.

        Notes
        -----
        The foot need not be the nearest of the four: a chord that dips deep below the sheet comes
        nearer to another one. For m1 > 0 it has the greatest n1 only if M is far enough from the
        ring circle; rho - r > 2 R / sqrt(27) is enough, as of chords within the joint limits.

        Examples
        --------
        >>> Torus(r=1, R=2).foot([(5, 0, 0), (1, 0, 0), (0, 0, 0)])[:, 0]
        array([ 3.,  3., -1.])
        """
        return self._foot(m, 1, 1)

    def _foot(self, m, sigma, eps):
        """Return the foot (..., 3) of points m (..., 3) that sigma and eps tell, as in `FEET`."""
        return in_blocks(lambda block: self._foot_of_rows(block, sigma, eps), m, 3)

    def _foot_of_rows(self, m, sigma, eps):
        x, y, z = m.T
        with np.errstate(invalid="ignore"):
            rho, excess = radius_and_excess(x, z, self.r)
            # How far M is beyond the circle's centre, away from the axis. Only rho - r can cancel.
            beyond = excess if sigma > 0 else rho + self.r
            distance = np.sqrt(beyond * beyond + y * y)
            on_axis = rho == 0
            on_ring = distance == 0
            # On the axis and on the ring the direction is 0/0: with a 1 added to both it is that of
            # theta = 0 and of phi = 0.
            scale = eps * self.R / (distance + on_ring)
            radius = sigma * self.r + scale * (beyond + on_ring)
            opposed = beyond < 0 if sigma == eps else beyond > 0
            if np.any(opposed):
                # r - R |cos phi| may cancel. As r - R + R (1 - |cos phi|), with the last as a
                # quotient, it keeps its digits.
                cos = np.abs(scale * beyond)[opposed] / self.R
                rest = (scale * y)[opposed] ** 2 / (self.R * (1 + cos))
                radius[opposed] = sigma * (self.r - self.R + rest)
            radius = radius / (rho + on_axis)
            return _stack(radius * (x + on_axis), scale * y, radius * z)

    @checked
    def meet_line(self, a: Points, b: Points):
        """Return where lines through two points meet the torus (Eqs 4 and 5).

        The answers keep their digits for far points and for tangent lines.

        Parameters
        ----------
        a, b : (..., 3) float
            Two different points of each line, in m; the line is a + t (b - a).

        Returns
        -------
        t : (..., 4) float
            Parameters of all real meetings, in ascending order, NaN-padded. A contact counts twice:
            as one parameter, or as two that differ by no more than the square root of a rounding.

        Raises
        ------
        ValueError
            If a and b coincide.

        Examples
        --------
        >>> Torus(r=1, R=2).meet_line((-10, 0, 0), (-9, 0, 0))
        array([ 7.,  9., 11., 13.])
        """
        if np.any(np.all(a == b, axis=-1)):
            raise ValueError("a, b: must differ, or there is no line; got a pair that coincides.")
        lines = np.concatenate(np.broadcast_arrays(a, b), axis=-1)
        return in_blocks(lambda some: torus_line.meet(self, some[:, :3], some[:, 3:]), lines, 4)


# These are the methods of the same names without checks. Paths that may have no answer call them,
# for NaN gives NaN.


def torus_point(torus, theta, phi):
    """Return the point of a torus, in m, at joint angles, in rad."""
    rho = torus.r + torus.R * np.cos(phi)
    return _stack(rho * np.cos(theta), torus.R * np.sin(phi), 0.0 - rho * np.sin(theta))


def torus_angles(torus, point):
    """Return the joint angles, in rad, of points, in m."""
    x, y, z = np.moveaxis(point, -1, 0)
    # Here a zero of either sign becomes +0: else theta could be pi on the axis.
    return np.arctan2(0.0 - z, x + 0.0), np.arctan2(y, radius_and_excess(x, z, torus.r)[1])


def torus_normal(theta, phi):
    """Return the unit normal of any torus at joint angles, in rad."""
    return _stack(np.cos(phi) * np.cos(theta), np.sin(phi), -np.cos(phi) * np.sin(theta))


def torus_tangents(theta, phi):
    """Return the unit tangents of any torus, of the meridian and of the parallel."""
    sin, cos = np.sin(theta), np.cos(theta)
    meridian = _stack(-np.sin(phi) * cos, np.cos(phi), np.sin(phi) * sin)
    return meridian, _stack(-sin, np.zeros_like(sin), -cos)


def _joint_motion(position, rate):
    """Return theta, phi and their rates, an array each."""
    return position[..., 0], position[..., 1], rate[..., 0], rate[..., 1]


def _stack(x, y, z):
    """Return vectors (..., 3) of these components, which broadcast."""
    out = np.empty((*np.broadcast_shapes(x.shape, y.shape, z.shape), 3))
    out[..., 0], out[..., 1], out[..., 2] = x, y, z
    return out
