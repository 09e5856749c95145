"""Surfaces that tools envelop, made from their motions, as functions for the recognisers.

Coordinates are lists of three numbers, arrays or jets: what `moving_cone`, `channel` and `ruled`
return is a surface for `recognise` and `hyperosculating_cones` with model="space". Curves, lines
and motions to give them stand below.
"""

import numpy as np


def moving_cone(motion, half_angle, *, rate=0.0):
    """Return the envelope of a cone of revolution that a motion carries (Eq. 5).

    Parameters
    ----------
    motion : callable
        Of the time v: returns the cone's vertex in m, the vertex' velocity, three unit vectors
        that turn with the cone, the first along its axis, and their angular velocity.
    half_angle : float
        Of the cone at v = 0, in rad.
    rate : float
        How it grows with v; 0 for congruent cones.

    Returns
    -------
    surface : callable
        Coordinates, in m, by the azimuth u of the tangent plane in rad, and v.

    Notes
    -----
    The planes T, T_u and T_v of Eq. 5 by Cramer's rule. The surface isn't regular where the
    characteristic isn't: for a translation, whose characteristic is two rulings, nowhere.
    """

    def surface(u, v):
        vertex, velocity, axes, omega = motion(v)
        angle = half_angle + rate * v
        sine, cosine, c, s = np.sin(angle), np.cos(angle), np.cos(u), np.sin(u)
        across = add(times(c, axes[1]), times(s, axes[2]))
        n = add(times(sine, axes[0]), times(cosine, across))
        nu = times(cosine, add(times(-s, axes[1]), times(c, axes[2])))
        nv = add(cross(omega, n), times(rate, add(times(cosine, axes[0]), times(-sine, across))))
        # n.x = n.m and nu.x = nu.m by the vertex; nv.x = nv.m + n.m' adds along the ruling.
        return add(vertex, times(dot(n, velocity) / dot(nv, cross(n, nu)), cross(n, nu)))

    return surface


def channel(curve, radius, *, growth=0.0):
    """Return the envelope of spheres on a curve, a pipe surface where they are congruent.

    Parameters
    ----------
    curve : callable
        Of a parameter s: centre in m, its first and its second derivative, not parallel.
    radius : float
        Of the sphere at s = 0, in m.
    growth : float
        How it grows with s, in m, slower than the centre moves.

    Returns
    -------
    surface : callable
        Coordinates, in m, by s and the angle around the characteristic circle in rad.
    """

    def surface(s, t):
        centre, velocity, acceleration = curve(s)
        e1, e3 = unit(velocity), unit(cross(velocity, acceleration))
        size = radius + growth * s
        lag = growth / np.sqrt(dot(velocity, velocity))  # sine of the circle's lag on the sphere
        around = add(times(np.cos(t), cross(e3, e1)), times(np.sin(t), e3))
        return add(centre, times(-size * lag, e1), times(size * np.sqrt(1 - lag * lag), around))

    return surface


def ruled(lines, *, offset=0.0):
    """Return a ruled surface, or one at a distance: the envelope of cylinders about its rulings.

    Parameters
    ----------
    lines : callable
        Of a parameter s: a point in m, its derivative, the ruling's direction, its derivative.
    offset : float
        Along the normal of the ruled surface, in m.

    Returns
    -------
    surface : callable
        Coordinates, in m, by s and the multiple t of the direction.
    """

    def surface(s, t):
        point, velocity, direction, turn = lines(s)
        n = unit(cross(add(velocity, times(t, turn)), direction))
        return add(point, times(t, direction), times(offset, n))

    return surface


def helix(s, pitch=0.4):
    """Return a helix about z that rises by `pitch` m a radian, its velocity and acceleration."""
    c, d = np.cos(s), np.sin(s)
    return [c, d, pitch * s], [-d, c, pitch + 0 * s], [-c, -d, 0 * s]


def cubic(s, bend=1.0):
    """Return the curve (s, bend s^2/2, s^3/6), its velocity and acceleration, in m."""
    velocity = [1 + 0 * s, bend * s, s * s / 2]
    return [s, bend * s**2 / 2, s**3 / 6], velocity, [0 * s, bend + 0 * s, s]


def tangents(curve):
    """Return the tangents of a curve, as lines for `ruled`."""

    def lines(s):
        point, velocity, acceleration = curve(s)
        return point, velocity, velocity, acceleration

    return lines


def saddle(s):
    """Return one family of the lines on z = x y, for `ruled`."""
    point, direction = [s, 0 * s, 0 * s], [0 * s, 1 + 0 * s, s]
    return point, [1 + 0 * s, 0 * s, 0 * s], direction, [0 * s, 0 * s, 1 + 0 * s]


def helicoid(s, pitch=1.0):
    """Return lines across the x axis that move by `pitch` m a radian of turn, for `ruled`."""
    c, d, none = np.cos(s), np.sin(s), 0 * s
    return [pitch * s, none, none], [pitch + none, none, none], [none, c, d], [none, -d, c]


def helix_lines(s, twist=0.0, pitch=0.4):
    """Return lines from a helix: its tangents, turned by `twist` in rad, for `ruled`.

    They turn in the osculating planes, towards the axis: pi/2 makes a helicoid. `pitch` is in m a
    radian of s.
    """
    c, d, (point, velocity, acceleration) = np.cos(twist), np.sin(twist), helix(s, pitch)
    jerk = [np.sin(s), -np.cos(s), 0 * s]
    direction = add(times(c, velocity), times(d, acceleration))
    return point, velocity, direction, add(times(c, acceleration), times(d, jerk))


def turning(vertex, velocity, lean, *, rate=1.0, start=1.0):
    """Return a motion whose axes turn about z, for `moving_cone`.

    Parameters
    ----------
    vertex, velocity : callable
        Of the time v: the vertex in m and its derivative.
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
        c, d, p, q = np.cos(rate * v + start), np.sin(rate * v + start), np.cos(lean), np.sin(lean)
        axes = [q * c, q * d, p + 0 * v], [p * c, p * d, -q + 0 * v], [-d, c, 0 * v]
        return vertex(v), velocity(v), axes, [0 * v, 0 * v, rate + 0 * v]

    return motion


def cyclide(x, y):
    """Return f(x, y) = y^2/(x^2 + y^2), in m: planes of a parabolic Dupin cyclide (Example 31)."""
    return y * y / (x * x + y * y)


def cross(a, b):
    """Return the vector product of two lists of coordinates a and b."""
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def dot(a, b):
    """Return the scalar product of two lists of coordinates a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(first, *others):
    """Return the sum of lists of coordinates, the first and the others."""
    for other in others:
        first = [a + b for a, b in zip(first, other, strict=True)]
    return first


def times(c, a):
    """Return the multiple c of a list of coordinates a."""
    return [c * part for part in a]


def unit(a):
    """Return a list of coordinates a, scaled to length 1."""
    return times(1 / np.sqrt(dot(a, a)), a)
