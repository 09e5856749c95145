"""Write geodesic_sweep.csv: the library's inverse against 200,000 references of random pairs.

    python -m tests.references.geodesic_sweep

The references rest on other integrals than the library's, taken by the double exponential rule in
80-bit floats: roots in double precision first, then Newton's method on Clairaut's constant or the
turning point. Some of them are solved again by mpmath at 50 digits, and searched for rivals.
"""

from functools import partial
from pathlib import Path

import numpy as np
from mpmath import mp, mpf
from scipy.optimize.elementwise import find_root

from tests.references import tables, torus_geodesics
from tests.references.geodesic_rivals import shortest_rival
from tests.references.torus_geodesics import ANSWERS, Canonical
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

TABLE = Path(__file__).with_suffix(".csv")
LONG = np.longdouble
DIGITS = 38  # of mpmath: twice what 80 bits hold
# pi in two parts: the first is a float of 53 bits, the second what it lacks.
PI, PI_REST = LONG(np.pi), LONG("1.2246467991473531772260659322749979970830539012e-16")
PAIRS, BLOCK, CHECKED, SEED = 100_000, 2000, 500, 22
MACHINES = 200  # tori of the working sheet
DEGENERATE = 1e-3  # of the length: a reduced length below that leaves the azimuths uncertain
COLUMNS = [
    "family", "tori", "pairs", "seed", "failures", "wrong branches",
    "worst length error, relative", "worst length error over R",
    "degenerate pairs", "worst azimuth error elsewhere",
    "worst azimuth error times reduced over length",
    "pairs checked", "worst reference length error", "worst reference azimuth error", "rivals",
]  # fmt: skip


def rule(step, real):
    """Return places and weights of the double exponential rule from 0 to 1."""
    t = np.arange(-3.5, 3.5 + step / 2, step, dtype=real)
    half = real(PI) / 2
    x = 1 / (1 + np.exp(-2 * half * np.sinh(t)))
    return x, step * 2 * half * np.cosh(t) * x / (1 + np.exp(2 * half * np.sinh(t)))


def quadrature(rates, start, stop, step):
    """Return two integrals (2, n), of functions of (n, k), from start to stop (n,)."""
    x, weights = rule(step, start.dtype.type)
    width = (stop - start)[:, None]
    return np.sum(rates(start[:, None] + width * x) * (width * weights), axis=-1)


def below_pi(phi):
    """Return pi - phi to the last digit, in the precision of phi."""
    return (phi.dtype.type(PI) - phi) + phi.dtype.type(PI_REST)


def ratio(x):
    """Return sin(x)/x of x > 0."""
    return np.sin(x) / x


def wave(r, R, a, b, t, step):
    """Return geodesics between turning points at +-m, m^2 = a^2 + t^2: phi = m cos(s).

    They descend from a at once for t > 0, after rising for t < 0; and see `torus_geodesics.wave`.
    """
    m, rest = np.hypot(a, t), np.sqrt(t * t + (a - b) * (a + b))
    short = below_pi(m)
    c = r + R * np.cos(m)

    def rates(s, pick=slice(None)):
        m_, short_, c_, R_ = (x[pick, None] for x in (m, short, c, R))
        low = m_ * np.sin(s / 2) ** 2
        sines = np.sin(low) * np.sin(short_ + low)  # sin(high), high = m - low
        rho = c_ + 2 * R_ * sines
        common = np.sqrt(2 * R_ * low * (m_ - low) / (sines * (rho + c_)))
        return np.stack([c_ / rho * common, rho * common])

    first, last = np.arctan2(t, a), np.arctan2(rest, b)
    total = quadrature(rates, np.maximum(first, 0), last, step)
    (rising,) = np.nonzero(first < 0)
    before = -first[rising]
    total[:, rising] += quadrature(partial(rates, pick=rising), 0 * before, before, step)
    slope_a, slope_b = (wave_slope(r, R, phi, m, c) for phi in (a, b))
    return Canonical(*total, c, -t * slope_a, -rest * slope_b)


def wave_slope(r, R, phi, m, c):
    """Return sqrt((rho^2 - c^2) / (m^2 - phi^2))."""
    both = ratio((m + phi) / 2 + 1e-300) * ratio((m - phi) / 2 + 1e-300)
    return np.sqrt(R * (r + R * np.cos(phi) + c) / 2 * both)


def pass_by(r, R, a, b, c, step, *, over):
    """Return geodesics of a ring without turning points, over the inner or the outer equator."""

    def excess(z):
        return r[:, None] - R[:, None] - c[:, None] + 2 * R[:, None] * np.sin(z / 2) ** 2

    def rates(z):
        rho = excess(z) + c[:, None]
        common = R[:, None] / np.sqrt(excess(z) * (rho + c[:, None]))
        return np.stack([c[:, None] / rho * common, rho * common])

    z_a, z_b = below_pi(a), below_pi(np.abs(b) if over else b)
    ends = [np.sqrt(e * (e + 2 * c)) for e in (excess(z[:, None])[:, 0] for z in (z_a, z_b))]
    if not over:
        return Canonical(*quadrature(rates, z_a, z_b, step), c, -ends[0], -ends[1])
    total = quadrature(rates, 0 * z_a, z_a, step) + quadrature(rates, 0 * z_b, z_b, step)
    return Canonical(*total, c, *ends)


def candidate(form, low, high, ends, angle):
    """Return the unknowns (n,) between limits whose geodesics turn by an angle, NaN where none."""
    found = find_root(lambda x, angle, *ends: form(*ends, x, 0.1).turned - angle,
                      (low, high), args=(angle, *ends))  # fmt: skip
    return np.where(found.success, found.x, np.nan)


def classes(r, R, a, b):
    """Yield the classes of geodesics: form, who may belong to it, limits of the unknown."""
    ring, shy = r > R, 1 - 1e-14
    top = np.where(ring, np.pi, np.arccos(np.maximum(-r / R, -1)))
    width = shy * np.sqrt((top - a) * (top + a))
    yield wave, np.ones(a.shape, dtype=bool), -width, width
    if np.any(ring):
        limits = (r - R) * (1 - shy), (r - R) * shy
        yield partial(pass_by, over=False), ring, *limits
        yield partial(pass_by, over=True), ring & (b < 0), *limits


def references(r, R, phi1, phi2, theta2):
    """Return the shortest geodesics from (0, phi1) to (theta2, phi2) as a dict of arrays (n,).

    Every class, either way round, is solved in double precision; the shortest by Newton again in
    80 bits.
    """
    swap = np.abs(phi2) > np.abs(phi1)
    a, b = np.where(swap, (phi2, phi1), (phi1, phi2))
    mirror, sign = np.where(a < 0, -1, 1), np.where(theta2 < 0, -1, 1)
    ends, angle = (r, R, a * mirror, b * mirror), np.abs(theta2)
    back = mirror * np.where(swap, -1, 1)
    routes = [
        (goal, side, *each)
        for goal, side in ((angle, sign), (2 * np.pi - angle, -sign))
        for each in classes(*ends)
    ]
    shortest, best, unknown = np.full(a.size, np.inf), np.full(a.size, -1), np.zeros(a.size)
    for number, (goal, _, form, who, low, high) in enumerate(routes):
        index = np.flatnonzero(who)
        some = [array[index] for array in ends]
        with np.errstate(all="ignore"):
            x = candidate(form, low[index], high[index], some, goal[index])
            length = form(*some, x, 0.05).length
        shorter = length < shortest[index]  # not where there is none, NaN
        index = index[shorter]
        shortest[index], unknown[index], best[index] = length[shorter], x[shorter], number
    if np.any(best < 0):
        raise ArithmeticError(f"{np.sum(best < 0)} pairs have no reference.")
    out = {name: np.zeros(a.size, dtype=LONG) for name in ANSWERS}
    out["kind"] = np.full(a.size, "outer")
    for number, (goal, side, form, *_) in enumerate(routes):
        index = np.flatnonzero(best == number)
        some, x, goal = [array[index].astype(LONG) for array in ends], unknown[index], goal[index]
        track, out["reduced"][index] = polish(form, some, x.astype(LONG), goal.astype(LONG))
        out["length"][index], out["clairaut"][index] = track.length, side[index] * track.c
        far, near = (
            np.arctan2(side[index] * track.c, back[index] * cosine)
            for cosine in (track.cos_a, track.cos_b)
        )
        out["azimuth1"][index], out["azimuth2"][index] = np.where(
            swap[index], (near, far), (far, near)
        )
        out["kind"][index] = "inner" if form is not wave and form.keywords["over"] else "outer"
    return out


def polish(form, ends, x, angle):
    """Return the geodesics and their reduced lengths by Newton's method in 80-bit floats."""
    r, R, a, _ = ends
    step = LONG(2) ** -5
    small = x * LONG(2) ** -27
    if form is not wave:
        small = np.minimum(small, (r - R - x) * LONG(2) ** -27)
    before, after = (form(*ends, x + sign * small, step) for sign in (-1, 1))
    rate = (after.turned - before.turned) / (2 * small)
    for _ in range(3):
        x = x + (angle - form(*ends, x, step).turned) / rate
    track = form(*ends, x, step / 2)
    # What is left of the angle: for given ends the length changes by c times it.
    length = track.length + track.c * (angle - track.turned)
    if form is wave:
        m = np.hypot(a, x)
        slope = wave_slope(r, R, a, m, track.c)
        reduced = np.abs(rate * track.cos_b) * slope * m / (R * np.sin(m))
    else:
        reduced = np.abs(rate * track.cos_a * track.cos_b)
    return track._replace(length=length), reduced


def pairs(family, count, rng):
    """Return r, R, phi1, phi2, theta2 (count,): theta1 is 0, so that no difference is rounded."""
    if family == "ring":
        phi1, phi2, theta2 = rng.uniform(-np.pi, np.pi, (3, count))
        return np.full(count, 3.0), np.ones(count), phi1, phi2, theta2
    machine = REFERENCE_MACHINE
    ratio = 4 * 25 ** rng.uniform(0, 1, MACHINES)
    r = np.resize(machine.R / ratio, count)
    phi1, phi2 = rng.uniform(machine.phi_min, machine.phi_max, (2, count))
    start, stop = rng.uniform(machine.theta_min, machine.theta_max, (2, count))
    return r, np.full(count, machine.R), phi1, phi2, stop - start


def solved(family, count, seed=SEED):
    """Return inputs and references of a family."""
    inputs = pairs(family, count, np.random.default_rng([seed, len(family)]))
    blocks = [references(*(array[start : start + BLOCK] for array in inputs))
              for start in range(0, count, BLOCK)]  # fmt: skip
    return inputs, {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


def library(inputs):
    """Return the library's answers as a dict of arrays (n,), torus by torus."""
    r, R, phi1, phi2, theta2 = inputs
    names = ("azimuth1", "azimuth2", "length", "clairaut", "kind", "converged")
    out = {name: np.zeros(r.size, dtype="<U8" if name == "kind" else float) for name in names}
    ends = np.stack([0 * phi1, phi1], axis=-1), np.stack([theta2, phi2], axis=-1)
    for small in np.unique(r):
        for index in np.array_split(np.flatnonzero(r == small), -(-np.sum(r == small) // BLOCK)):
            found = geodesic_inverse(Torus(small, R[index[0]]), *(end[index] for end in ends))
            for name in names:
                out[name][index] = getattr(found, name)
    return out


def angle_between(one, other):
    """Return the angle between directions."""
    half = PI + PI_REST
    return np.abs(np.remainder(one - other + half, 2 * half) - half)


def compared(inputs, known, found):
    """Return failures, wrong branches and the worst errors, as the table has them."""
    R = inputs[1]
    sound = found["converged"] == 1
    error = np.abs(found["length"] - known["length"])[sound]
    length, reduced = known["length"][sound], known["reduced"][sound]
    off = np.max([angle_between(found[n], known[n])[sound] for n in ANSWERS[:2]], axis=0)
    clear = reduced >= DEGENERATE * length
    wrong = (error > 1e-9 * length) | (off > 1e-6) & clear
    wrong |= (found["kind"] != known["kind"])[sound]
    return [
        int(np.sum(~sound)), int(np.sum(wrong)), np.max(error / length),
        np.max(error / R[sound]), int(np.sum(~clear)), np.max(off[clear]),
        np.max(off * reduced / length),
    ]  # fmt: skip


def exactly(x):
    """Return a float of 80 bits in mpmath's numbers."""
    return mpf(float(x)) + mpf(float(x - LONG(float(x))))


def against_mpmath(inputs, known, index):
    """Return the worst errors of some references, in length, relative, and azimuths."""
    worst = [0.0, 0.0]
    for i in index:
        r, R, phi1, phi2, theta2 = (float(array[i]) for array in inputs)
        *azimuths, length = (exactly(known[name][i]) for name in ANSWERS[:3])
        exact = torus_geodesics.again(r, R, phi1, theta2, phi2, *azimuths)
        off = max(abs(x - y) for x, y in zip(azimuths, exact[:2], strict=True))
        worst = [max(worst[0], abs(length / exact[2] - 1)), max(worst[1], off)]
    return list(map(float, worst))


def rivals(inputs, known, index):
    """Return how many of some references have a rival that is shorter by 1e-4."""
    found = 0
    for i in index:
        r, R, phi1, phi2, theta2 = (array[i] for array in inputs)
        length = float(known["length"][i])
        found += shortest_rival(r, R, phi1, phi2, abs(theta2), length, 1e-4) is not None
    return found


def row(family, count=PAIRS, checked=CHECKED, seed=SEED):
    """Return a family's row of the table."""
    inputs, known = solved(family, count, seed)
    index = np.linspace(0, count - 1, checked).astype(int)
    found = [
        family, len(np.unique(inputs[0])), count, seed, *compared(inputs, known, library(inputs)),
        checked, *against_mpmath(inputs, known, index), rivals(inputs, known, index),
    ]  # fmt: skip
    return [f"{x:.3g}" if np.asarray(x).dtype.kind == "f" else x for x in found]


if __name__ == "__main__":
    mp.dps = DIGITS
    tables.write(TABLE, COLUMNS, map(row, ("working sheet", "ring")))
