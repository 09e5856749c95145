"""Look for a geodesic shorter than a given one among all of them, in floating point.

Every geodesic that leaves a point is followed to each of its meetings with the other point's
parallel; where the turned angle passes the wanted one from one azimuth to the next, it goes there.
Nothing is presumed about the class to which a shortest geodesic may belong.
"""

import numpy as np
from numpy.polynomial.legendre import leggauss

NODES, WEIGHTS = leggauss(80)
PLACES, SPEEDS = ((1 + NODES) / 2) ** 3, 3 / 2 * ((1 + NODES) / 2) ** 2 * WEIGHTS


def shortest_rival(r, R, phi1, phi2, theta, length, shorter=1e-6):
    """Return the length of a geodesic, or a way through a horn's node, that is shorter, or None.

    Parameters
    ----------
    r, R : float
        The torus, in m.
    phi1, phi2 : float
        The ends' angles, in rad.
    theta : float
        The turned angle, from 0 to pi, in rad.
    length : float
        In m.
    shorter : float
        The share of the length by which a rival must be shorter: interpolation isn't exact.

    Returns
    -------
    rival : float or None
        In m.
    """
    rivals = [
        rival
        for ends in ((phi1, phi2), (phi2, phi1))
        for meeting in meetings(r, R, *ends)
        for target in (theta, 2 * np.pi - theta)
        for rival in passing(*meeting, target)
    ]
    if r == R and phi1 * phi2 < 0:  # two arcs of meridians, which meet in the node of a horn
        rivals.append(R * (2 * np.pi - abs(phi1) - abs(phi2)))
    return min((rival for rival in rivals if rival < length * (1 - shorter)), default=None)


def passing(c, turned, reach, target):
    """Return the lengths of sampled geodesics (n,) where their turned angle passes the target."""
    gap = turned - target
    with np.errstate(invalid="ignore"):
        (here,) = np.nonzero((gap[:-1] * gap[1:] <= 0) & (gap[:-1] != gap[1:]))
    share = gap[here] / (gap[here] - gap[here + 1])
    # Between fixed ends dS = c dTheta; c is taken half way to where the target is passed.
    return reach[here] - (c[here] + share * (c[here + 1] - c[here]) / 2) * gap[here]


def azimuths(parting):
    """Return azimuths between 0 and pi/2, close together at both and at a parting of the ways."""
    steps = np.linspace(0, np.pi, 802)[1:-1]
    around = np.geomspace(1e-12, 0.3, 200)
    every = np.concatenate([np.pi / 4 * (1 - np.cos(steps)), parting - around, parting + around])
    return np.unique(every[(every > 0) & (every < np.pi / 2)])


def meetings(r, R, a, b):
    """Yield Clairaut's constant, turned angle and length (n,) of each meeting with phi = b.

    Of all geodesics that leave phi = a; NaN where one doesn't meet that parallel.
    """
    rho, narrow = r + R * np.cos(a), max(r - R, 0)
    c = rho * np.sin(azimuths(np.arcsin(min(narrow / rho, 1))))
    turning = c > narrow
    with np.errstate(invalid="ignore"):
        # Between turning points at +-m, phi = m cos(s): one wave is 2 pi in s.
        m = np.arccos(np.where(turning, (c - r) / R, np.nan))
        at_a, at_b, half = (waves(R, c, m, s) for s in (np.arccos(a / m), np.arccos(b / m), np.pi))
        for turns in range(4):
            for first in (1, -1):
                for last in (1, -1):
                    angle, reach = last * at_b + 2 * turns * half - first * at_a
                    yield c, np.where(reach > 0, angle, np.nan), reach
    if narrow:
        # Round the tube, z = pi - phi: a round is 2 pi in z.
        c = np.where(turning, np.nan, c)
        at_a, at_b, half = (rounds(r, R, c, z) for z in (np.pi - a, np.pi - b, np.pi))
        for turns in range(2):
            for way in (1, -1):
                angle, reach = way * (at_b - at_a) + 2 * turns * half
                yield c, np.where(reach > 0, angle, np.nan), reach


def waves(R, c, m, s):
    """Return turned angle and length (2, n) from a turning point, s = 0, to s <= pi."""

    def integrals(s):
        s = np.broadcast_to(s, c.shape)[:, None]
        low = m[:, None] * np.sin(s * PLACES / 2) ** 2
        high = m[:, None] - low
        rho = c[:, None] + 2 * R * np.sin(low) * np.sin(high)
        sines = np.sinc(low / np.pi) * np.sinc(high / np.pi)
        common = np.sqrt(2 * R / (sines * (rho + c[:, None]))) * s * SPEEDS
        return np.stack([c * np.sum(common / rho, axis=-1), np.sum(rho * common, axis=-1)])

    return mirrored(integrals, s, np.pi)


def rounds(r, R, c, z):
    """Return turned angle and length (2, n) from the inner equator, z = 0, to z <= 2 pi."""

    def integrals(z):
        z = np.broadcast_to(z, c.shape)[:, None]
        over = r - R - c[:, None] + 2 * R * np.sin(z * PLACES / 2) ** 2
        rho = c[:, None] + over
        common = R / np.sqrt(over * (rho + c[:, None])) * z * SPEEDS
        return np.stack([c * np.sum(common / rho, axis=-1), np.sum(rho * common, axis=-1)])

    return mirrored(integrals, z, 2 * np.pi)


def mirrored(integrals, x, whole):
    """Return integrals from 0 to x of functions that repeat backwards after half of `whole`."""
    part = integrals(np.minimum(x, whole - x))
    return np.where(x > whole / 2, 2 * integrals(whole / 2) - part, part)
