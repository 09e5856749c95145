"""Write short_chords.csv: by how much paths over short chords are longer, by mpmath at 60 digits.

    python -m tests.references.short_chords

Double precision sees nothing of an excess below 1e-15, where the laws of short chords begin. A
geodesic of each length is drawn both ways from its middle by a Taylor series; paths between its
ends are polynomials through Gauss-Legendre nodes, whose length the same nodes tell.
"""

import math
from functools import cache
from pathlib import Path

import numpy as np
from mpmath import mp, mpf
from numpy.polynomial.legendre import leggauss

from tests.references import tables

TABLE = Path(__file__).with_suffix(".csv")
DIGITS, NODES, TERMS = 60, 40, 100
PATHS = [
    "projected chord",
    "one-third rule",
    "corrected chord",
    "Simpson rule",
    "completed Simpson",
]
COLUMNS = ["r", "R", "phi", "azimuth", "length", *PATHS]
TORI = [(0.08, 0.8), (1.0, 2.0), (2.0, 1.0)]
DIRECTIONS = [(0.35, 0.7), (0.35, math.pi / 2)]  # phi of the middle, azimuth there: oblique, level
LENGTHS = [2.0**-k for k in range(1, 9)]  # in units of R


def normal(theta, phi):
    level = mp.cos(phi)
    return np.array([level * mp.cos(theta), mp.sin(phi), -level * mp.sin(theta)])


def point(torus, theta, phi):
    r, R = torus
    return R * normal(theta, phi) + r * normal(theta, 0)


def foot(torus, m):
    """Return theta and phi of the foot of a point, and how deep the point lies."""
    r, R = torus
    beyond = mp.hypot(m[0], m[2]) - r
    return mp.atan2(-m[2], m[0]), mp.atan2(m[1], beyond), R - mp.hypot(beyond, m[1])


class Chord:
    """A chord of a torus (r, R) between joint positions p and q, and its paths as feet at t."""

    def __init__(self, torus, p, q):
        self.torus = torus
        self.start, self.stop = point(torus, *p), point(torus, *q)
        self.first, self.last = normal(*p), normal(*q)
        self.middle = self.normal_below((self.start + self.stop) / 2)
        pole = np.cross(self.first, self.last)
        sine = mp.sqrt(pole @ pole)
        self.pole = pole / sine
        self.angle = mp.atan2(sine, self.first @ self.last)
        self.ahead = np.cross(self.pole, self.first)
        self.pushes = self.pushed(self.angle, self.angle)

    def at(self, t):
        return self.start + t * (self.stop - self.start)

    def normal_below(self, m):
        return normal(*foot(self.torus, m)[:2])

    def dropped(self, t, direction=None, shift=0):
        m = self.at(t)
        if direction is not None:
            m = m + foot(self.torus, m)[2] * (direction - self.normal_below(m))
        return foot(self.torus, m + shift)[:2]

    def projected_chord(self, t):
        return self.dropped(t)

    def one_third_rule(self, t):
        return self.dropped(t, (self.normal_below(self.at(t)) + 2 * self.middle) / 3)

    def simpson(self, t):
        between = (1 - t) * self.first + t * self.last
        return (self.normal_below(self.at(t)) + 4 * self.middle + between) / 6

    def simpson_rule(self, t):
        return self.dropped(t, self.simpson(t))

    def completed_simpson(self, t):
        u = t * (1 - t)
        rate = (self.stop - self.start) @ (self.first + self.last)
        return self.dropped(t, self.simpson(t), u * (1 - u) / 6 * rate * (self.last - self.first))

    def psi(self, s):
        m_y = self.first[1] * mp.cos(s) + self.ahead[1] * mp.sin(s)
        return -self.pole[1] * m_y / mp.sqrt(1 - m_y**2)

    def pushed(self, s, angle):
        """Return the integral of psi sin(angle - x) from 0 to s."""
        return mp.quad(lambda x: self.psi(x) * mp.sin(angle - x), [0, s])

    def gap(self, s):
        swing = self.pushed(s, s) - self.pushes * mp.sin(s) / mp.sin(self.angle)
        half = self.angle / 2
        return self.psi(s) * (1 - mp.cos(s - half) / mp.cos(half)) - swing

    def corrected_chord(self, u):
        half = self.angle / 2
        s = u * self.angle
        t = (1 + mp.tan(s - half) / mp.tan(half)) / 2
        shift = -self.torus[0] * self.gap(s) * mp.cos(half) / mp.cos(s - half)
        return self.dropped(t, shift=shift * self.pole)


@cache
def nodes():
    """Return Gauss-Legendre nodes t and weights on (0, 1), and the matrix that differentiates."""

    def legendre(v):
        return mp.legendre(NODES, v)

    x = np.array([mp.findroot(legendre, near) for near in leggauss(NODES)[0].tolist()])
    weights = 2 / ((1 - x**2) * np.array([mp.diff(legendre, one) for one in x]) ** 2)
    # Barycentric weights of these nodes.
    share = (-1) ** np.arange(NODES) * ((1 - x**2) * weights) ** mpf("0.5")
    gaps = x[:, None] - x + np.eye(NODES, dtype=int)
    matrix = share / share[:, None] / gaps * (1 - np.eye(NODES, dtype=int))
    matrix -= np.diag(matrix.sum(axis=1))
    return (1 + x) / 2, weights / 2, 2 * matrix


def path_length(torus, path):
    r, R = torus
    t, weights, matrix = nodes()
    places = np.array([path(one) for one in t])
    theta, phi = (matrix @ places).T
    rho = [r + R * mp.cos(height) for height in places[:, 1]]
    return weights @ [mp.hypot(a * b, R * c) for a, b, c in zip(rho, theta, phi, strict=True)]


def geodesic(torus, phi, azimuth):
    """Return a function of the arc length: where a geodesic from (0, phi) has come, as a series.

    Each rate is a product of series that are known as far as they are needed.
    """
    r, R = torus
    sin, cos, across, along = ([f(v)] for v in (phi, azimuth) for f in (mp.sin, mp.cos))
    bend = [1 / (r + R * cos[0])]  # of the parallel, 1 / rho
    theta, height = [mpf(0)], [phi]
    turning, tilting, turned, square, widening = [], [], [], [], []

    def product(a, b):
        return mp.fdot(a, b[::-1])

    for n in range(1, TERMS):
        turning.append(product(across, bend))
        tilting.append(along[-1] / R)
        turned.append(product(sin, turning))
        square.append(product(bend, bend))
        widening.append(-R * product(sin, tilting))
        rates = [
            (theta, turning[-1]),
            (height, tilting[-1]),
            (sin, product(cos, tilting)),
            (cos, -product(sin, tilting)),
            (across, product(along, turned)),
            (along, -product(across, turned)),
            (bend, -product(square, widening)),
        ]
        for series, rate in rates:
            series.append(rate / n)
    return lambda s: [mp.polyval(series[::-1], s) for series in (theta, height)]


def rows():
    """Yield the rows of the table."""
    with mp.workdps(DIGITS):
        for r, R in TORI:
            torus = mpf(r), mpf(R)
            for phi, azimuth in DIRECTIONS:
                turn = mp.pi / 2 if azimuth == math.pi / 2 else mpf(azimuth)
                ways = [geodesic(torus, mpf(phi), one) for one in (turn + mp.pi, turn)]
                for length in LENGTHS:
                    yield row(torus, (r, R, phi, azimuth, length), ways)


def method(name):
    return name.lower().replace(" ", "_").replace("-", "_")


def row(torus, about, ways):
    """Return a row of the table about a chord from one way's end to the other's."""
    length = torus[1] * mpf(about[-1])
    chord = Chord(torus, *(way(length / 2)[:2] for way in ways))
    excess = [path_length(torus, getattr(chord, method(name))) / length - 1 for name in PATHS]
    return [*map(repr, about), *(mp.nstr(one, 12) for one in excess)]


if __name__ == "__main__":
    tables.write(TABLE, COLUMNS, rows())
