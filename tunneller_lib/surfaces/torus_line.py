"""Where lines meet a torus, without loss of digits: Eq. 4 solved between its quartic's extremes."""

import numpy as np

from ..kernels.exact import cross, dot, norm

# Distances below this share of r + R, a few roundings of the arithmetic here, count as contact.
CONTACT = 8 * np.finfo(float).eps


def meet(torus, a, b):
    """Return the parameters (..., 4) of `Torus.meet_line`, ascending and NaN-padded.

    The line is first referred to its point nearest the origin, which comes from the moment a x b
    with all its digits, so that far points cost none. Between two neighbours of the at most three
    extremes of the quartic there is at most one meeting. It is found in that bracket, as a zero of
    the product of the distances to both meridian circles. An extreme that touches the torus counts
    as crossed, so that no tangent is lost.
    """
    from scipy.optimize.elementwise import find_root  # here, for it takes longer to load than numpy

    u = b - a
    longest = np.max(np.abs(u), axis=-1, initial=0)  # so that no square underflows
    e = u / longest[..., None]
    length = longest * norm(e)
    e = e / norm(e)[..., None]
    size = torus.r + torus.R
    r, R = torus.r / size, torus.R / size
    # The point nearest the origin, right to a few roundings of itself wherever a and b lie.
    foot = cross(e, cross(a, b)) / (length * size)[..., None]
    line = [*np.moveaxis(foot, -1, 0), *np.moveaxis(np.broadcast_to(e, foot.shape), -1, 0)]

    # In lengths of r + R the torus lies within -1 to 1 on the line, so that 2 is beyond it. The two
    # walls and the three extremes are five nodes, with four brackets between.
    extremes, single = _extremes(foot, e, r, R)
    walls = np.full((1, *length.shape), 2.0)
    nodes = np.concatenate([-walls, extremes, walls])
    near, far = _distances(nodes, *line, r, R)
    value = near * far
    contact = np.minimum(np.abs(near), np.abs(far)) <= CONTACT
    inside = (value < 0) | contact
    # The middle extreme is a maximum: there a contact counts as outside. A single extreme stands in
    # all three places.
    inside[2] = np.where(single, inside[1], (value[2] < 0) & ~contact[2])

    s = np.full((4, *length.shape), np.nan)
    low, high = nodes[:-1], nodes[1:]
    f_low, f_high = value[:-1], value[1:]
    crossed = inside[:-1] != inside[1:]
    # Where the side changes only by a contact, the extreme itself is the meeting.
    s[crossed] = np.where(np.abs(f_low) < np.abs(f_high), low, high)[crossed]
    solve = crossed & (f_low * f_high < 0)
    if np.any(solve):
        lines = [np.broadcast_to(c, solve.shape)[solve] for c in line]
        brackets = (low[solve], high[solve])
        with np.errstate(invalid="ignore"):  # find_root tries interpolations that have no value
            # The product of both distances is below zero inside of the torus.
            inside = lambda s, *line: np.multiply(*_distances(s, *line))  # noqa: E731
            s[solve] = find_root(inside, brackets, args=(*lines, r, R)).x
    t = -dot(a, e) / length + s * (size / length)
    return np.sort(np.moveaxis(t, 0, -1), axis=-1)


def _distances(s, x, y, z, ex, ey, ez, r, R):
    """Return how far foot + s e lies outside of the two circles of its meridian plane."""
    rho = np.hypot(x + s * ex, z + s * ez)
    height = y + s * ey
    return np.hypot(rho - r, height) - R, np.hypot(rho + r, height) - R


def _extremes(foot, e, r, R):
    """Return the ascending real roots (3, ...) of the quartic's derivative, s^3 + P s + Q = 0.

    The quartic of a line from its point nearest the origin has no cubic term:
    (s^2 + c)^2 - 4 r^2 (R^2 - (y + e_y s)^2) with c = |foot|^2 - r^2 - R^2. Where there is a single
    real root it comes three times. The second array tells where that is.
    """
    height = foot[..., 1]
    slope = e[..., 1]
    P = dot(foot, foot) - r * r - R * R + 2 * (r * slope) ** 2
    Q = 2 * r * r * slope * height
    with np.errstate(all="ignore"):  # a line 1e100 away has a cube that is infinite
        # By the sign of the discriminant there is one real root or there are three.
        single = 4 * P**3 + 27 * Q**2 > 0
        # With s = scale x and scale^2 = 4 |P| / 3 it has the form of a triple angle: 4x^3 - 3x is
        # cos(3a) of x = cos(a), and 4x^3 + 3x is sinh(3a) of x = sinh(a), where `ratio` or its
        # negative is the value. Unlike Cardano's sum of cube roots these don't cancel.
        scale = 2 * np.sqrt(np.abs(P) / 3)
        ratio = np.where(scale > 0, 3 * Q / (P * scale), 0)
        # Three roots, P < 0: cosines of angles a third of a turn apart.
        angle = np.arccos(np.clip(ratio, -1, 1)) / 3
        thirds = 2 * np.pi / 3 * np.arange(3).reshape(3, *[1] * P.ndim)
        three = scale * np.cos(angle - thirds)
        # One root of a cubic that only rises, P > 0.
        rising = -scale * np.sinh(np.arcsinh(ratio) / 3)
        # One root of a cubic with two bends on one side of zero, P < 0: |x| > 1 is a cosh. The root
        # has the sign of -Q; if P is zero it is a cube root.
        falling = -np.sign(Q) * scale * np.cosh(np.arccosh(np.maximum(np.abs(ratio), 1)) / 3)
        falling = np.where(scale > 0, falling, -np.cbrt(Q))
        roots = np.where(single, np.where(P > 0, rising, falling), three)
    return np.clip(np.sort(roots, axis=0), -2, 2), single
