"""Surfaces that tools envelop, as functions made from the tools' motions.

Coordinates are lists of three numbers, arrays or jets. What `moving_cone`, `channel`, `swept_ball`
and `ruled` return is a surface for `recognise` and `hyperosculating_cones` with model="space". The
other functions are curves, lines and motions to make them from.
"""

import numpy as np

from ..arguments import LEAST, Angle, Coordinate, HalfAngle, Length, checked, shown
from .functions import Function, Varying, coordinates, vectors
from .jet import Jet, add, cross_product, dot_product, times, unit_vector


@checked
def moving_cone(motion: Function(1), half_angle: HalfAngle, *, rate: Angle = 0.0):
    """Return the envelope of a cone of revolution that a motion carries (Eq. 5).

    Parameters
    ----------
    motion : callable
        Of the time v: returns the cone's vertex in m, the vertex' velocity, three unit vectors
        that turn with the cone, the first along its axis, and their angular velocity. What it
        raises itself passes through.
    half_angle : float
        Of the cone at v = 0, in rad.
    rate : float
        How fast it grows with v, in rad; 0 for congruent cones.

    Returns
    -------
    surface : callable
        Coordinates, in m, by the azimuth u of the tangent plane in rad, and v.

    Notes
    -----
    The point in the planes T, T_u and T_v of Eq. 5, by Cramer's rule. The surface is regular only
    where the characteristic is: for a translation, whose characteristic is two rulings, nowhere.
    """

    def surface(u, v):
        vertex, velocity, axes, omega = _moved(motion(v), v)
        angle = half_angle + rate * v
        sine = np.sin(angle)
        cosine = np.cos(angle)
        c = np.cos(u)
        s = np.sin(u)
        across = add(times(c, axes[1]), times(s, axes[2]))
        n = add(times(sine, axes[0]), times(cosine, across))
        nu = times(cosine, add(times(-s, axes[1]), times(c, axes[2])))
        opening = add(times(cosine, axes[0]), times(-sine, across))
        nv = add(cross_product(omega, n), times(rate, opening))
        # With the vertex m, T and T_u say n.x = n.m and nu.x = nu.m: x is on a ruling through m.
        # T_v, nv.x = nv.m + n.m', tells how far along it.
        ruling = cross_product(n, nu)
        return add(vertex, times(dot_product(n, velocity) / dot_product(nv, ruling), ruling))

    return surface


def _moved(answer, v):
    """Return the vertex, velocity, axes and angular velocity that a motion returned at time v."""
    try:
        vertex, velocity, axes, omega = answer
    except (TypeError, ValueError):
        raise ValueError(
            "motion: must return vertex, velocity, three axes and angular velocity; "
            f"got {shown(answer)}."
        ) from None
    axes = vectors("motion", axes, 3, v)
    return *vectors("motion", [vertex, velocity], 2, v), axes, coordinates("motion", omega, v)


@checked
def channel(curve: Function(1), radius: Length, *, growth: Coordinate = 0.0):
    """Return the envelope of spheres on a curve, a pipe surface where they are congruent.

    Parameters
    ----------
    curve : callable
        Of a parameter s: centre in m, its first and its second derivative, not parallel. What it
        raises itself passes through.
    radius : float
        Of the sphere at s = 0, in m.
    growth : float
        How fast it grows with s, in m; it must grow more slowly than the centre moves.

    Returns
    -------
    surface : callable
        Coordinates, in m, by s and the angle around the characteristic circle in rad.
    """

    def surface(s, t):
        centre, velocity, acceleration = vectors("curve", curve(s), 3, s)
        e1 = unit_vector(velocity)
        e3 = unit_vector(cross_product(velocity, acceleration))
        size = radius + growth * s
        # The circle of contact lags behind the sphere's equator, as the next sphere is greater:
        # the sine of that angle.
        lag = growth / np.sqrt(dot_product(velocity, velocity))
        around = add(times(np.cos(t), cross_product(e3, e1)), times(np.sin(t), e3))
        return add(centre, times(-size * lag, e1), times(size * np.sqrt(1 - lag * lag), around))

    return surface


@checked
def swept_ball(path: Function(1), radius: Length):
    """Return the envelope of a ball that moves on a curve, a pipe surface.

    It is that of `channel` with congruent spheres, for a path whose acceleration isn't known.

    Parameters
    ----------
    path : callable
        Of a parameter s: centre in m and its derivative, which mustn't be along the x axis. What
        it raises itself passes through.
    radius : float
        Of the ball, in m.

    Returns
    -------
    surface : callable
        Coordinates, in m, by s and the angle around the path in rad.
    """

    def surface(s, t):
        centre, velocity = vectors("path", path(s), 2, s)
        x, y, z = velocity
        # Two unit vectors across the velocity, the first across the x axis as well: they need no
        # second derivative, as Frenet's do.
        n = np.sqrt(y * y + z * z)
        m = np.sqrt(dot_product(velocity, velocity))
        first = [0 * s, -z / n, y / n]
        second = [-n / m, x * y / n / m, x * z / n / m]
        around = add(times(np.cos(t), first), times(np.sin(t), second))
        return add(centre, times(radius, around))

    return surface


@checked
def ruled(lines: Function(1), *, offset: Coordinate = 0.0):
    """Return a ruled surface, or its offset: the envelope of cylinders about its rulings.

    Parameters
    ----------
    lines : callable
        Of a parameter s: a point in m, its derivative, the ruling's direction, its derivative.
        What it raises itself passes through.
    offset : float
        Along the normal of the ruled surface, in m.

    Returns
    -------
    surface : callable
        Coordinates, in m, by s and the multiple t of the direction.
    """

    def surface(s, t):
        point, velocity, direction, turn = vectors("lines", lines(s), 4, s)
        # The derivatives by s and t are velocity + t turn and the direction.
        n = unit_vector(cross_product(add(velocity, times(t, turn)), direction))
        return add(point, times(t, direction), times(offset, n))

    return surface


@checked
def helix(s: Varying, pitch: Coordinate = 0.4):
    """Return a helix about z that rises by `pitch` m a radian, its velocity and acceleration.

    Parameters
    ----------
    s : (...) float or Jet
        Parameter, in rad.
    pitch : float
        In m a radian; the radius is 1 m.

    Returns
    -------
    point, velocity, acceleration : list of three
        Coordinates, in m and by rad.
    """
    c = np.cos(s)
    d = np.sin(s)
    return [c, d, pitch * s], [-d, c, pitch + 0 * s], [-c, -d, 0 * s]


@checked
def cubic(s: Varying, bend: Coordinate = 1.0):
    """Return the curve (s, bend s^2/2, s^3/6), its velocity and acceleration.

    Parameters
    ----------
    s : (...) float or Jet
        Parameter.
    bend : float
        In m; 1 makes it a curve of constant slope.

    Returns
    -------
    point, velocity, acceleration : list of three
        Coordinates, in m.
    """
    point = [s, bend * s**2 / 2, s**3 / 6]
    velocity = [1 + 0 * s, bend * s, s * s / 2]
    return point, velocity, [0 * s, bend + 0 * s, s]


@checked
def tangent_lines(curve: Function(1)):
    """Return the tangents of a curve, as lines for `ruled`.

    Parameters
    ----------
    curve : callable
        As for `channel`.

    Returns
    -------
    lines : callable
        Of the curve's parameter.
    """

    def lines(s):
        point, velocity, acceleration = vectors("curve", curve(s), 3, s)
        return point, velocity, velocity, acceleration

    return lines


@checked
def saddle(s: Varying):
    """Return one family of the lines on z = x y, for `ruled`, by their x (...), in m."""
    point = [s, 0 * s, 0 * s]
    direction = [0 * s, 1 + 0 * s, s]
    return point, [1 + 0 * s, 0 * s, 0 * s], direction, [0 * s, 0 * s, 1 + 0 * s]


@checked
def helicoid(s: Varying, pitch: Coordinate = 1.0):
    """Return lines that cross the x axis and move along it as they turn, for `ruled`.

    Parameters
    ----------
    s : (...) float or Jet
        Turn, in rad.
    pitch : float
        In m a radian.

    Returns
    -------
    point, velocity, direction, turn : list of three
        Coordinates of a point, in m, of the direction, and their derivatives.
    """
    c = np.cos(s)
    d = np.sin(s)
    none = 0 * s
    return [pitch * s, none, none], [pitch + none, none, none], [none, c, d], [none, -d, c]


@checked
def helix_lines(s: Varying, twist: Angle = 0.0, pitch: Coordinate = 0.4):
    """Return the tangents of a helix, turned in the osculating planes, for `ruled`.

    Parameters
    ----------
    s : (...) float or Jet
        The helix' parameter, in rad.
    twist : float
        By how much they are turned towards the axis, in rad: pi/2 makes a helicoid.
    pitch : float
        Of the helix, in m a radian.

    Returns
    -------
    point, velocity, direction, turn : list of three
        Coordinates of a point, in m, of the direction, and their derivatives.
    """
    c = np.cos(twist)
    d = np.sin(twist)
    point, velocity, acceleration = helix(s, pitch)
    # On a helix velocity and acceleration are at right angles: they span the osculating plane.
    jerk = [np.sin(s), -np.cos(s), 0 * s]
    direction = add(times(c, velocity), times(d, acceleration))
    return point, velocity, direction, add(times(c, acceleration), times(d, jerk))


@checked
def turning(
    vertex: Function(1),
    velocity: Function(1),
    lean: Angle,
    *,
    rate: Angle = 1.0,
    start: Angle = 1.0,
):
    """Return a motion whose axes turn about z, for `moving_cone`.

    Parameters
    ----------
    vertex, velocity : callable
        Of the time v: the vertex in m and its derivative. What they raise themselves passes
        through.
    lean : float
        Angle of the first axis, that of the cone, from z, in rad.
    rate, start : float
        Turn of the axes by v, and at v = 0, in rad.

    Returns
    -------
    motion : callable
        Of v.
    """

    def motion(v):
        c = np.cos(rate * v + start)
        d = np.sin(rate * v + start)
        p = np.cos(lean)
        q = np.sin(lean)
        # The second axis leans a right angle more than the first, the third is level.
        axes = [q * c, q * d, p + 0 * v], [p * c, p * d, -q + 0 * v], [-d, c, 0 * v]
        at = coordinates("vertex", vertex(v), v)
        return at, coordinates("velocity", velocity(v), v), axes, [0 * v, 0 * v, rate + 0 * v]

    return motion


@checked
def screwing(radius: Length, pitch: Coordinate, lean: Angle, *, start: Angle = 1.0):
    """Return a motion whose vertex runs on a helix about z as its axes turn, for `moving_cone`.

    Parameters
    ----------
    radius : float
        Of the helix, in m.
    pitch : float
        Its rise, in m a radian.
    lean : float
        Angle of the first axis, that of the cone, from z, in rad.
    start : float
        Turn of the axes at v = 0, in rad.

    Returns
    -------
    motion : callable
        Of the time v.
    """

    def vertex(v):
        return [radius * np.cos(v), radius * np.sin(v), pitch * v]

    def velocity(v):
        return [-radius * np.sin(v), radius * np.cos(v), pitch + 0 * v]

    return turning(vertex, velocity, lean, start=start)


@checked
def cyclide(x: Varying, y: Varying):
    """Return f(x, y) = y^2/(x^2 + y^2): planes of a parabolic Dupin cyclide (Example 31).

    Parameters
    ----------
    x, y : (...) float or Jet
        Place in the model.

    Returns
    -------
    f : (...) float or Jet
        In m.

    Raises
    ------
    ValueError
        If numbers x and y are both below 1e-100 in size; a jet isn't finite there.
    """
    if not isinstance(x, Jet) and not isinstance(y, Jet):
        if np.any(np.maximum(np.abs(x), np.abs(y)) < LEAST):
            raise ValueError(
                "x, y: must not both be below 1e-100, where f has no value; got such a pair."
            )
    return y * y / (x * x + y * y)
