"""Write geodesic_sweep.csv: the library's inverse against 200,000 references of random pairs.

    python -m tests.references.geodesic_sweep --references build/geodesic_sweep.npz

The references rest on other integrals than the library's, taken by the double exponential rule in
80-bit floats: roots in double precision first, then Newton's method on Clairaut's constant or the
turning point. Some of them are solved again by mpmath at 50 digits, and searched for rivals. They
are kept in the named file, block by block; a second run takes them from there.
"""

import argparse
import csv
import os
import sys
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf
from scipy.optimize.elementwise import find_root

from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

from . import torus_geodesics
from .geodesic_rivals import shortest_rival

TABLE = Path(__file__).with_suffix(".csv")
LONG = np.longdouble
# pi in two parts: the first is a float of 53 bits, the second what it lacks.
PI, PI_REST = LONG(np.pi), LONG("1.2246467991473531772260659322749979970830539012e-16")
BLOCK, CHECKED, SEED = 2000, 2000, 22
MACHINES = 200  # tori of the working sheet
DEGENERATE = 1e-3  # of the length: a reduced length below that leaves the azimuths uncertain
ANSWERS = ("azimuth1", "azimuth2", "length", "clairaut", "reduced")
COLUMNS = [
    "family", "tori", "pairs", "seed", "failures", "wrong branches",
    "worst length error, relative", "worst length error over R",
    "degenerate pairs", "worst azimuth error elsewhere",
    "worst azimuth error times reduced over length",
    "references in mpmath", "worst reference length error", "worst reference azimuth error",
    "pairs searched for rivals", "rivals",
]  # fmt: skip


class Track(NamedTuple):
    """Geodesics from a to b, arrays (n,): the azimuths as rho times their cosines."""

    turned: np.ndarray
    length: np.ndarray
    c: np.ndarray
    cos_a: np.ndarray
    cos_b: np.ndarray


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
    return Track(*total, c, -t * slope_a, -rest * slope_b)


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
        return Track(*quadrature(rates, z_a, z_b, step), c, -ends[0], -ends[1])
    total = quadrature(rates, 0 * z_a, z_a, step) + quadrature(rates, 0 * z_b, z_b, step)
    return Track(*total, c, *ends)


def candidate(form, low, high, ends, angle):
    """Return the unknowns (n,) between limits whose geodesics turn by an angle, NaN where none."""
    found = find_root(lambda x, angle, *ends: form(*ends, x, 0.1).turned - angle,
                      (low, high), args=(angle, *ends))  # fmt: skip
    return np.where(found.success, found.x, np.nan)


def forms(r, R, a, b, angle):
    """Yield the classes: form, who may belong to it, limits of the unknown. All in doubles."""
    ring = r > R
    top = np.where(ring, np.pi, np.arccos(np.maximum(-r / R, -1)))
    width = np.sqrt((top - a) * (top + a))
    everyone = np.ones(a.shape, dtype=bool)
    margin = 1e-14
    yield wave, everyone, -width * (1 - margin), width * (1 - margin)
    if np.any(ring):
        yield partial(pass_by, over=False), ring, (r - R) * margin, (r - R) * (1 - margin)
        yield partial(pass_by, over=True), ring & (b < 0), (r - R) * margin, (r - R) * (1 - margin)


def references(r, R, phi1, phi2, theta2):
    """Return the shortest geodesics from (0, phi1) to (theta2, phi2) as a dict of arrays (n,).

    Every class, either way round, is solved in double precision; the shortest by Newton again in
    80 bits.
    """
    swap = np.abs(phi2) > np.abs(phi1)
    a, b = np.where(swap, (phi2, phi1), (phi1, phi2))
    mirror = np.where(a < 0, -1.0, 1.0)
    a, b, angle = a * mirror, b * mirror, np.abs(theta2)
    best = {"length": np.full(a.size, np.inf), "form": np.zeros(a.size, int), "x": 0 * a}
    count = 0
    for round_ in (angle, 2 * np.pi - angle):
        for form, who, low, high in forms(r, R, a, b, round_):
            (index,) = np.nonzero(who)
            ends = [array[index] for array in (r, R, a, b)]
            with np.errstate(all="ignore"):
                x = candidate(form, low[index], high[index], ends, round_[index])
                length = form(*ends, np.where(np.isnan(x), high[index] / 2, x), 0.05).length
            shorter = ~np.isnan(x) & (length < best["length"][index])
            index = index[shorter]
            best["length"][index], best["x"][index] = length[shorter], x[shorter]
            best["form"][index] = count
            count += 1
    out = {name: np.zeros(a.size, dtype=LONG) for name in ANSWERS}
    out["kind"] = np.full(a.size, "outer")
    per_round = count // 2
    for k in range(count):
        (index,) = np.nonzero(best["form"] == k)
        if index.size:
            form = [each[0] for each in forms(r, R, a, b, angle)][k % per_round]
            goal = (angle if k < per_round else 2 * np.pi - angle)[index]
            ends = [array[index].astype(LONG) for array in (r, R, a, b)]
            track, reduced = polish(form, ends, best["x"][index].astype(LONG), goal.astype(LONG))
            side = np.where(theta2 < 0, -1, 1)[index] * (1 if k < per_round else -1)
            back = (mirror * np.where(swap, -1, 1))[index]
            far, near = (
                np.arctan2(side * track.c, back * cosine) for cosine in (track.cos_a, track.cos_b)
            )
            first, second = np.where(swap[index], (near, far), (far, near))
            values = (first, second, track.length, side * track.c, reduced)
            for name, value in zip(ANSWERS, values):
                out[name][index] = value
            if getattr(form, "keywords", {}).get("over"):
                out["kind"][index] = "inner"
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


def solved(family, count, seed=SEED, kept=None):
    """Return inputs and references of a family, taken from a file as far as they are there."""
    inputs = pairs(family, count, np.random.default_rng([seed, len(family)]))
    done, rows = {}, []
    if kept and kept.exists():
        with np.load(kept) as file:
            done = dict(file)
    for start in range(0, count, BLOCK):
        name = f"{family} {count} {start}"
        part = [array[start : start + BLOCK] for array in inputs]
        if f"{name} length" not in done:
            for key, value in references(*part).items():
                done[f"{name} {key}"] = value
            if kept:
                beside = kept.with_suffix(".part.npz")
                np.savez(beside, **done)
                os.replace(beside, kept)
            say(f"{family}: references {start + len(part[0])} of {count}")
        rows.append({key: done[f"{name} {key}"] for key in (*ANSWERS, "kind")})
    return inputs, {key: np.concatenate([row[key] for row in rows]) for key in rows[0]}


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
    return np.abs(np.remainder(one - other + PI, 2 * PI) - PI)


def compared(inputs, known, found):
    """Return failures, wrong branches and the worst errors, as the table has them."""
    R = inputs[1]
    sound = found["converged"] == 1
    error = np.abs(found["length"] - known["length"])[sound]
    length, reduced = known["length"][sound], known["reduced"][sound]
    off = np.max([angle_between(found[n], known[n])[sound] for n in ANSWERS[:2]], axis=0)
    clear = reduced >= DEGENERATE * length
    wrong = (error > 1e-9 * length) | (off > 1e-6) & clear
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
        off = max(abs(x - y) for x, y in zip(azimuths, exact))
        worst = [max(x, float(y)) for x, y in zip(worst, (abs(length / exact[2] - 1), off))]
    return worst


def say(text):
    print(text, file=sys.stderr, flush=True)


def main():
    """Write the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--references", type=Path, help="where references are kept (.npz)")
    options.add_argument("--pairs", type=int, default=100_000, help="of each family")
    options.add_argument("--checked", type=int, default=CHECKED, help="of them, by mpmath")
    chosen = options.parse_args()
    mp.dps = torus_geodesics.DIGITS
    table = [COLUMNS]
    for family in ("working sheet", "ring"):
        inputs, known = solved(family, chosen.pairs, kept=chosen.references)
        say(f"{family}: the library")
        row = compared(inputs, known, library(inputs))
        say(f"{family}: {row}; mpmath and rivals")
        index = np.linspace(0, chosen.pairs - 1, chosen.checked).astype(int)
        exact = against_mpmath(inputs, known, index)
        rivals = [
            shortest_rival(r, R, phi1, phi2, abs(theta2), float(length))
            for r, R, phi1, phi2, theta2, length in zip(
                *(array[index] for array in (*inputs, known["length"]))
            )
        ]
        tori = len(np.unique(inputs[0]))
        row = [family, tori, chosen.pairs, SEED, *row, len(index), *exact, len(index),
               sum(rival is not None for rival in rivals)]  # fmt: skip
        table.append([f"{x:.3g}" if isinstance(x, np.floating | float) else x for x in row])
    beside = TABLE.with_suffix(".part")
    with open(beside, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(table)
    os.replace(beside, TABLE)


if __name__ == "__main__":
    main()
