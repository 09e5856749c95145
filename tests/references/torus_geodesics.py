"""Write torus_geodesics.csv: shortest geodesics of tori, by mpmath at 50 digits.

    python -m tests.references.torus_geodesics

Direct solves: both ends' phi, the torus and a start are drawn, the turned angle follows by
quadrature in phi. It is rounded to a double and the geodesic corrected to meet that exactly, so
that every input of the table is a double and every answer belongs to just these doubles.
"""

import math
import random
from pathlib import Path
from typing import NamedTuple

from mpmath import mp, mpf

from tests.references import tables
from tests.references.geodesic_rivals import shortest_rival

TABLE = Path(__file__).with_suffix(".csv")
INPUTS = ["family", "r", "R", "theta1", "phi1", "theta2", "phi2"]
ANSWERS = ["azimuth1", "azimuth2", "length", "clairaut", "reduced"]
COLUMNS = [*INPUTS, *ANSWERS, "kind"]
DIGITS, SEED = 50, 21
LIMIT = math.radians(40)  # of |phi| on the machine's working sheet


class Start(NamedTuple):
    """A geodesic from phi = a >= 0 to phi = b, |b| <= a, with what picks it out of its pencil.

    `way` "wave": between turning points at phi = +-m, m^2 = a^2 + t^2, and `unknown` is t: it
    descends from a at once for t > 0, after rising to m for t < 0. "down" and "over": without
    turning points, over the outer or the inner equator of a ring, and `unknown` is Clairaut's c.
    "meridian" and "equator" (the outer one) are themselves; `unknown` is the equator's angle.
    """

    r: float
    R: float
    a: float
    b: float
    way: str
    unknown: mpf


class Canonical(NamedTuple):
    """A geodesic from a to b with growing theta: the azimuths as sine and cosine times rho."""

    turned: mpf
    length: mpf
    c: mpf
    cos_a: mpf
    cos_b: mpf


def ratio(x):
    """Return sin(x)/x."""
    return mp.sin(x) / x if x else mp.one


def wave(start, t):
    """Return the geodesic between turning points, with rho cos(azimuth) / t at a as well.

    With phi = m cos(s): rho - c = 2 R sin(low) sin(high), low + high = m, and dphi / sqrt(rho - c)
    has no singularity left.
    """
    r, R, a, b = map(mpf, start[:4])
    m = mp.hypot(a, t)
    c = r + R * mp.cos(m)

    def rates(s):
        low = m * (1 - mp.cos(s)) / 2
        high = m - low
        rho = c + 2 * R * mp.sin(low) * mp.sin(high)
        common = mp.sqrt(2 * R / (ratio(low) * ratio(high) * (rho + c)))
        return mp.mpc(c / rho * common, rho * common)

    rest = mp.sqrt(t * t + (a - b) * (a + b))
    first, last = mp.atan2(t, a), mp.atan2(rest, b)
    if t > 0:
        total = mp.quad(rates, [first, last])
    else:
        total = mp.quad(rates, [0, -first]) + mp.quad(rates, [0, last])
    slopes = [
        mp.sqrt(R * (r + R * mp.cos(phi) + c) / 2 * ratio((m + phi) / 2) * ratio((m - phi) / 2))
        for phi in (a, b)
    ]
    return Canonical(total.real, total.imag, c, -t * slopes[0], -rest * slopes[1]), slopes[0]


def pass_by(start, c):
    """Return the geodesic of a ring that never turns: quadrature in z = pi - phi."""
    r, R, a, b = map(mpf, start[:4])

    def excess(z):  # rho - c
        return r - R - c + 2 * R * mp.sin(z / 2) ** 2

    def rates(z):
        over = excess(z)
        rho = over + c
        common = R / mp.sqrt(over * (rho + c))
        return mp.mpc(c / rho * common, rho * common)

    end_a, end_b = mp.pi - a, mp.pi - (b if start.way == "down" else abs(b))
    cos_a, cos_b = (mp.sqrt(excess(z) * (excess(z) + 2 * c)) for z in (end_a, end_b))
    if start.way == "down":
        total, cos_a, cos_b = mp.quad(rates, [end_a, end_b]), -cos_a, -cos_b
    else:
        total = mp.quad(rates, [0, end_a]) + mp.quad(rates, [0, end_b])
    return Canonical(total.real, total.imag, c, cos_a, cos_b)


def along_meridian(start):
    """Return the geodesic along a meridian, the shorter way, and its reduced length."""
    r, R, a, b = map(mpf, start[:4])
    ends = sorted([a, b if r <= R or a - b <= mp.pi else 2 * mp.pi + b])
    heading = 1 if ends[0] == a else -1
    rho_a, rho_b = r + R * mp.cos(a), r + R * mp.cos(b)
    reduced = rho_a * rho_b * mp.quad(lambda phi: R / (r + R * mp.cos(phi)) ** 2, ends)
    cosines = heading * rho_a, heading * rho_b
    return Canonical(mp.zero, R * (ends[1] - ends[0]), mp.zero, *cosines), reduced


def along_equator(start, angle):
    """Return the geodesic along the outer equator and its reduced length: curvature 1/(R rho)."""
    r, R = mpf(start.r), mpf(start.R)
    bend = mp.sqrt(R * (r + R))
    length = (r + R) * angle
    reduced = bend * mp.sin(length / bend)
    return Canonical(angle, length, r + R, mp.zero, mp.zero), reduced


def solve(start, angle=None):
    """Return the geodesic that turns by a given angle near a start, and its reduced length.

    Parameters
    ----------
    start : Start
        A geodesic whose turned angle is within about 1e-15 of the given one.
    angle : float, optional
        In rad, taken exactly; by default, the start's own, rounded to a double.

    Returns
    -------
    found : Canonical
        With `turned` equal to the angle to 1e-28 of it.
    reduced : mpf
        How fast neighbours that leave a spread at b: d(offset) = reduced d(azimuth), in m.
    """
    if start.way == "meridian":
        return along_meridian(start)
    if start.way == "equator":
        return along_equator(start, mpf(float(start.unknown) if angle is None else angle))
    x, R = mpf(start.unknown), mpf(start.R)
    if start.way == "wave":
        square = x * x + (mpf(start.a) - start.b) * (mpf(start.a) + start.b)
        step = min(mp.one, start.r / R + mp.cos(mp.hypot(start.a, x)), mp.sqrt(square), abs(x))
    else:
        step = min(x, start.r - R - x)

    def geodesic(x):
        return wave(start, x)[0] if start.way == "wave" else pass_by(start, x)

    def around(x):  # the turned angle and its rate, to 1e-28
        before, after = geodesic(x - step).turned, geodesic(x + step).turned
        return (after + before) / 2, (after - before) / (2 * step)

    step *= mpf("1e-15")
    turned, rate = around(x)
    angle = mpf(float(turned) if angle is None else angle)
    for _ in range(12):
        x += (angle - turned) / rate
        here = geodesic(x)
        turned = here.turned
        if abs(turned - angle) <= mpf("1e-28") * angle:
            break
    else:
        raise ArithmeticError(f"{start}: the turned angle isn't met.")
    rate = around(x)[1]
    if start.way == "wave":
        m = mp.hypot(start.a, x)
        return here, abs(rate * here.cos_b) * wave(start, x)[1] / (R * ratio(m))
    return here, abs(rate * here.cos_a * here.cos_b)


def from_azimuth(r, R, a, b, azimuth):
    """Return the start of a geodesic with a given azimuth at a, between 0 and pi."""
    rho, azimuth = mpf(r) + mpf(R) * mp.cos(mpf(a)), mpf(azimuth)
    c, cosine = rho * mp.sin(azimuth), mp.cos(azimuth)
    if c > max(mpf(r) - R, 0):
        m = mp.acos((c - r) / R)
        return Start(r, R, a, b, "wave", -mp.sign(cosine) * mp.sqrt(m * m - mpf(a) ** 2))
    if cosine < 0:
        return Start(r, R, a, b, "down", c)
    return Start(r, R, a, -abs(b), "over", c)


def row(family, start, swap=False, mirror=False, side=1):
    """Return the cells of one geodesic, exchanged and mirrored, or None if it isn't shortest.

    The answers' digits: 20 significant ones, the last of them rounded.
    """
    found, reduced = solve(start)
    if found.turned > math.pi or found.length == 0:
        return None
    theta, phis = float(found.turned), [-phi if mirror else phi for phi in start[2:4]]
    phi1, phi2 = phis[::-1] if swap else phis
    side = -side if swap else side  # it was from a to b
    if shortest_rival(start.r, start.R, phi1, phi2, theta, float(found.length)) is not None:
        return None
    inputs = [start.r, start.R, 0.0, phi1, side * theta, phi2]
    cells = answers(found, reduced, swap, mirror, side)
    kind = {"meridian": "meridian", "over": "inner"}.get(start.way, "outer")
    return [family, *(repr(x + 0.0) for x in inputs), *(mp.nstr(x, 20) for x in cells), kind]


def answers(found, reduced, swap, mirror, side):
    """Return the columns `ANSWERS` for ends exchanged, phi mirrored, theta growing by its sign."""
    cosines = [-found.cos_b, -found.cos_a] if swap else [found.cos_a, found.cos_b]
    azimuths = [mp.atan2(side * found.c, -x if mirror else x) for x in cosines]
    return [*azimuths, found.length, side * found.c, reduced]


def again(r, R, phi1, theta2, phi2, azimuth1, azimuth2):
    """Return a geodesic solved anew from its ends and nearly right azimuths.

    Parameters
    ----------
    r, R, phi1, theta2, phi2 : float
        The inputs, taken exactly; theta1 = 0.
    azimuth1, azimuth2 : mpf
        Right to about 1e-15: they tell the class and where Newton's method starts.

    Returns
    -------
    answers : list of mpf
        Of the columns `ANSWERS`.
    """
    # Of two ends as far from the equator, the one comes first that the vertex is near.
    swap = abs(phi2) > abs(phi1) or (phi1 == -phi2 and phi2 * mp.cos(azimuth2) < 0)
    a, b, azimuth = (phi2, phi1, azimuth2 + mp.pi) if swap else (phi1, phi2, azimuth1)
    mirror = a < 0 or (a == b == 0 and mp.cos(azimuth) < 0)
    cosine = mp.cos(azimuth) * (-1 if mirror else 1)
    a, b = abs(a), -b if mirror else b
    if theta2 == 0:
        start = Start(r, R, a, b, "meridian", mp.zero)
    elif a == 0 and abs(cosine) < mpf("1e-15"):
        start = Start(r, R, a, b, "equator", mp.zero)
    else:
        # The azimuth between 0 and pi: towards growing theta.
        start = from_azimuth(r, R, a, b, mp.atan2(abs(mp.sin(azimuth)), cosine))
    return answers(*solve(start, abs(theta2)), swap, mirror, -1 if theta2 < 0 else 1)


def rows(family):
    """Yield the rows of a family, in the order of the table."""
    from .geodesic_families import FAMILIES  # here: it draws with the functions above

    count, draw = FAMILIES[family]
    rng = random.Random(f"{SEED} {family}")
    while count:
        start, flips = draw(rng), [rng.random() < 0.5 for _ in range(2)]
        cells = row(family, start, *flips, rng.choice([-1, 1]))
        if cells:
            count -= 1
            yield cells


if __name__ == "__main__":
    from .geodesic_families import FAMILIES

    mp.dps = DIGITS
    tables.write(TABLE, COLUMNS, (row for family in FAMILIES for row in rows(family)))
