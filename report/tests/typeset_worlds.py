"""Values for the letters of each displayed equation, at which the equation must hold.

A world is a dict: a number by the name of each letter, an array for a vector, a function for a
letter that is applied. The values come from the library, or are constructed or searched for in
another way; none by typing the equation again. Besides letters a world may have

values
    What the expressions of the display are that stand without "=".
truth
    Whether one of the display's conditions, parted by "or", must hold.
outside
    Changed letters, for which the display must fail: where a range ends.
defined
    Letters that the display itself defines.
tolerance
    Allowed error over the size of the terms, if not 1e-9.

"eq11/printed" names worlds for that form alone, "eq03/case" those in which an imprecise form, as
printed, is true.
"""

from functools import cache

import numpy as np
from mpmath import mp
from numpy.polynomial import Polynomial
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from tests.shapes import half_swing
from tests.symbols_envelopes import EQ11, EQ12, EQ25, at, example
from tunneller_lib.envelopes import jet_variables
from tunneller_lib.envelopes.isotropic import (
    plane_to_point,
    sphere_point,
    surface_points,
    top_circle,
)
from tunneller_lib.envelopes.pseudo import double_root, pseudo_envelope
from tunneller_lib.motion import Resonance, reference_axes, time_bresenham
from tunneller_lib.motion.stability import ripple
from tunneller_lib.paths import ChordLaw, ConeChord, cutting_circuit
from tunneller_lib.ream.wall import pass_distance
from tunneller_lib.removal.volume import bowl, groove_area, half_lens, removed_volume, ring
from tunneller_lib.surfaces import REFERENCE_MACHINE, Cone, Egg, Rod, Torus

WORLDS = {}


def worlds(*names, count=4):
    """Register a function of a generator as what makes the worlds of these equations.

    WORLDS then holds a function of a seed, which returns `count` of them.
    """

    def register(make):
        for name in names:
            WORLDS[name] = lambda seed: [
                make(np.random.default_rng((seed, i))) for i in range(count)
            ]
        return make

    return register


def numbered(letter, values, first=1):
    """Return values by the names of a letter's indices: n_1, n_2, .."""
    return {f"{letter}_{first + i}": float(value) for i, value in enumerate(values)}


def signed(rng, low, high, n):
    """Return numbers of either sign, none near zero."""
    return rng.uniform(low, high, n) * rng.choice([-1, 1], n)


# ---- the torus ------------------------------------------------------------------------------


def some_torus(rng):
    return Torus(rng.uniform(0.3, 0.6), rng.uniform(0.9, 1.4))


def quartic_along(torus, start, along):
    """Return the polynomial of degree 4 that Eq. 2's left side is along a line."""
    t = np.linspace(-1, 1, 5)
    left = torus.implicit(start + t[:, None] * along)
    return Polynomial.fit(t, left, 4).convert()


@worlds("eq01", "eq02", "eq04", "eq06")
def on_torus(rng):
    torus = some_torus(rng)
    theta, phi = rng.uniform(-1, -0.2), rng.uniform(0.2, 0.7)
    x, y, z = point = torus.point(theta, phi)
    return {"r": torus.r, "R": torus.R, "theta": theta, "phi": phi, "x": x, "y": y, "z": z,
            "rho": np.hypot(x, z), "f": 0.0, **numbered("q", point),
            **numbered("n", point)}  # fmt: skip


@worlds("meridian-circles", count=6)
def on_either_sheet(rng):
    torus = some_torus(rng)
    x, y, z = torus.point(-0.5, rng.choice([0, np.pi]) + rng.uniform(0.2, 0.6))
    return {"r": torus.r, "R": torus.R, "rho": np.hypot(x, z), "y": y}


@worlds("eq03", count=2)
def on_cyclide(rng, w=None):
    """A torus seen in a mirror ball is a cyclide; its coefficients are fitted to points of it."""
    torus, centre, rho = some_torus(rng), np.array([0.3, 0.4, -0.5]), rng.uniform(0.5, 1.5)
    points = torus.point(*rng.uniform(-3, 3, (2, 400))) - centre
    points = points / np.sum(points**2, axis=1)[:, None] + [0.2, -0.1, 0.15]
    x, y, z = points.T
    powers = [(i, j, k, 3 - i - j - k) for i in range(4) for j in range(4) for k in range(4)
              if i + j + k <= 3]  # fmt: skip
    # Over the greatest coefficient: (x^2 + y^2 + z^2)^2 and 20 products of three of 1, x, y, z.
    terms = [x**j * y**k * z**m for _, j, k, m in powers]
    square = x * x + y * y + z * z
    found = np.linalg.lstsq(np.transpose(terms), -((square - rho**2) ** 2), rcond=None)[0]
    w = rng.uniform(1.5, 2) if w is None else w  # homogeneous: any multiple is the same point
    coefficients = {
        letter + "_" + "".join(map(str, power)): value
        for letter in "ck" for power, value in zip(powers, found, strict=True)
    }  # fmt: skip
    return {**coefficients, "w": w, "x": w * x[0], "y": w * y[0], "z": w * z[0],
            "mu": rho, "rho": rho, "tolerance": 1e-8}  # fmt: skip


@worlds("eq03/case", count=2)
def on_cyclide_with_its_weight(rng):
    return on_cyclide(rng, 1.0)


@worlds("eq05")
def line_quartic(rng):
    torus = some_torus(rng)
    a, b = signed(rng, 0.5, 1.5, (2, 3))
    along = b - a
    coefficients = quartic_along(torus, a, along).coef
    return {"r": torus.r, "R": torus.R, "a_2": a[1], "b_2": b[1], "t_4": along @ along,
            "t_3": a @ along, "t_2": a @ a - torus.r**2 - torus.R**2,
            **numbered("T", coefficients, 0)}  # fmt: skip


@worlds("circuit")
def on_ruling(rng):
    torus, y, z = some_torus(rng), rng.uniform(0.2, 0.5), rng.uniform(-0.6, -0.2)
    x = np.nanmax(torus.meet_line((0, y, z), (1, y, z)))
    theta, phi = torus.angles((x, y, z))
    return {"r": torus.r, "R": torus.R, "x": x, "y": y, "z": z, "theta": float(theta),
            "phi": float(phi), "rho": np.hypot(x, z)}  # fmt: skip


# ---- tangent spheres ------------------------------------------------------------------------


@worlds("eq07")
def gradient(rng):
    torus, n = some_torus(rng), signed(rng, 0.4, 1.2, 3)
    rates = [quartic_along(torus, n, axis).coef[1] for axis in np.eye(3)]
    return {"r": torus.r, "R": torus.R, "bold n": n, "E_N": n @ n, "gradient f": np.array(rates),
            **numbered("n", n)}  # fmt: skip


@worlds("eq07/case")
def direction_of_gradient(rng):
    world = gradient(rng)
    return {**world, "gradient f": world["gradient f"] / 4}


@worlds("eq08", "eq09")
def along_normal(rng):
    torus = some_torus(rng)
    theta, phi = rng.uniform(-1, -0.2), rng.uniform(0.2, 0.7)
    n = torus.point(theta, phi)
    m = n + rng.uniform(0.2, 0.5) * torus.normal(theta, phi)
    return {"r": torus.r, "R": torus.R, "E_N": n @ n, **numbered("n", n), **numbered("m", m)}


SIGNS = ((1, 1), (1, -1), (-1, 1), (-1, -1))  # the order of `Torus.feet`


@worlds("feet", count=8)
def one_foot(rng):
    torus, m = some_torus(rng), signed(rng, 0.4, 1.2, 3)
    which = rng.integers(4)
    sigma, epsilon = SIGNS[which]
    foot, rho = torus.feet(m)[which], np.hypot(m[0], m[2])
    return {"r": torus.r, "R": torus.R, "sigma": sigma, "epsilon": epsilon, "N": foot, "rho": rho,
            "rho_N": (foot[0] * m[0] + foot[2] * m[2]) / rho,
            "d_sigma": np.linalg.norm(m - sigma * torus.r * m * [1, 0, 1] / rho),
            **numbered("m", m)}  # fmt: skip


@worlds("eq10")
def foot_quartic(rng):
    """The feet's quartic, and others: N_3 is zero for the feet, which would hide its power."""
    torus, m = some_torus(rng), signed(rng, 0.4, 1.2, 3)
    roots = torus.feet(m)[:, 0] + rng.choice([0, 0.3])
    return {"n_1": rng.choice(roots), **numbered("N", rng.uniform(1, 2) * np.poly(roots)[::-1], 0)}


def quartic_of_feet(rng, power):
    """Return the letters of Eq. 11, the N with m1 to some power for a common factor."""
    torus, m = some_torus(rng), signed(rng, 0.6, 1.2, 3)
    feet, rho = torus.feet(m)[:, 0], np.hypot(m[0], m[2])
    # nu_4 is the squared distances of M from the centres of both circles, multiplied.
    centres = [np.hypot(rho - sign * torus.r, m[1]) for sign in (1, -1)]
    leading = m[0] ** power * rho**4 * np.prod(np.square(centres))
    N = leading * np.poly(feet)[::-1]
    assert abs(N[3]) < 1e-12 * leading
    N[3] = 0
    return {"r": torus.r, "R": torus.R, "s": rho**2, **numbered("m", m), **numbered("N", N, 0),
            "defined": ("nu_4", "nu_2", "nu_0")}  # fmt: skip


@worlds("eq11")
def quartic_of_feet_shortened(rng):
    return quartic_of_feet(rng, 0)


@worlds("eq11/printed", "eq11/reads")
def quartic_of_feet_with_factor(rng):
    return quartic_of_feet(rng, 4)


@worlds("even-steps")
def equal_angles(rng):
    """Where rays at equal angles meet a circle's chord."""
    b, u = rng.uniform(0.3, 1.2), rng.uniform(0.1, 0.9)
    start, stop = (np.array([np.sin(a), np.cos(a)]) for a in (-b, b))

    def step(u):
        ray = np.array([np.sin(b * (2 * u - 1)), np.cos(b * (2 * u - 1))])
        return {"u": u, "t": np.linalg.solve(np.column_stack([ray, start - stop]), start)[1]}

    return {"b": b, **step(u), "outside": [step(-0.1), step(1.1)]}


# ---- geodesics ------------------------------------------------------------------------------


@worlds("half-swing")
def swinging(rng):
    torus = some_torus(rng)
    narrow, wide = max(torus.r - torus.R, 0), torus.r + torus.R
    c = narrow + (wide - narrow) * rng.uniform(0.3, 0.9)

    def rho(x):  # from one turning point to the equator, no farther
        return 1 / np.hypot(np.cos(x) / c, np.sin(x) / wide) if 0 <= x <= np.pi / 2 else np.nan

    return {"r": torus.r, "R": torus.R, "c": c, "x": rng.uniform(1.45, 1.55), "rho": rho,
            "T": half_swing(torus, c)[0]}  # fmt: skip


@worlds("chord-law")
def beside_geodesic(rng):
    """On z = kappa x^2/2 + tau x y: a point dropped along its normal, and a geodesic's y''."""
    kappa, tau = signed(rng, 0.3, 2, 2)
    length = rng.uniform(0.2, 0.6)
    x, half = Polynomial([0, 1]), length / 2
    dropped = kappa * (half**2 - x**2) / 2 * (tau * x)
    bent = (-kappa * tau * x).integ(2)
    bent -= bent(half) / half * x  # odd, so that it vanishes at both ends
    gap = dropped - bent
    widest = max(abs(gap(place)) for place in gap.deriv().roots().real)
    longer = (gap.deriv() ** 2).integ()
    excess = (longer(half) - longer(-half)) / (2 * length)
    return {"kappa": kappa, "tau": tau, "l": length, "values": (widest, excess)}


@worlds("any-length-gap")
def swung_across(rng):
    """The push across the normals' great circle, the library's gap, and the oscillator solved."""
    p, q = rng.uniform((-0.9, -0.7), (0.7, 0.7), (2, 2))
    law = ChordLaw(p, q)
    first = Torus(1, 2).normal(*p)
    ahead = np.cross(law.pole, first)

    def push(s):
        normal = first * np.cos(s) + ahead * np.sin(s)
        return normal / np.hypot(normal[0], normal[2]) * [1, 0, 1] @ law.pole, normal[1]

    def rates(s, state):  # of two swings: driven from rest, and free
        return [state[1], push(s)[0] - state[0], state[3], -state[2]]

    share = rng.uniform(0.2, 0.8)
    s = share * law.angle
    at, end = solve_ivp(rates, (0, law.angle), [0, 0, 0, 1], t_eval=(s, law.angle),
                        method="DOP853", rtol=1e-12, atol=1e-14).y[[0, 2]].T  # fmt: skip
    psi, nu_y = push(s)
    return {"b_y": law.pole[1], "nu_y": nu_y, "psi": psi, "Theta": float(law.angle), "s": s,
            "delta": float(law.gap([share])[0]), "w": at[0] - end[0] / end[1] * at[1]}  # fmt: skip


# ---- the volume of a cut --------------------------------------------------------------------


@worlds("eq12")
def lens(rng):
    B = rng.uniform(0.5, 1.5)
    c = B * rng.uniform(0.2, 1)
    return {"B": B, "c": c, "V_D": float(half_lens(B, c))}


@worlds("groove-area")
def groove(rng):
    B, c = rng.uniform(0.5, 1.5), rng.uniform(0.1, 0.3)
    g = B * rng.uniform(0.1, 0.6)
    area = 2 * quad(lambda x: np.sqrt(B * B - x * x), B - g, B)[0]
    return {"B": B, "R": B, "c": c, "g": g, "A": area, "V": float(removed_volume(B, c, g)),
            "V_C": float(bowl(B, c)), "V_R": float(ring(B, c)), "tolerance": 1e-8}  # fmt: skip


@worlds("groove-round-wall")
def groove_in_a_round_wall(rng):
    B, c = rng.uniform(0.5, 1.5), rng.uniform(0.1, 0.3)
    g, W = B * rng.uniform(0.1, 0.6), B * rng.uniform(1.5, 3)
    return {"B": B, "c": c, "g": g, "W": W, "A": float(groove_area(B, g)),
            "V": float(removed_volume(B, c, g, wall=W))}  # fmt: skip


@worlds("groove-pitch")
def groove_beside_another(rng):
    B = rng.uniform(0.5, 1.5)
    g, p = B * rng.uniform(0.3, 0.6), B * rng.uniform(0.2, 0.5)
    area = quad(lambda x: np.sqrt(B * B - x * x) - (B - g), -p / 2, p / 2)[0]
    assert np.isclose(area, groove_area(B, g, pitch=p), rtol=1e-12)
    return {"B": B, "g": g, "p": p, "A": area}


# ---- the cone -------------------------------------------------------------------------------


@worlds("eq13")
def on_cone(rng):
    cone = Cone(rng.uniform(0.3, 1.2))
    point = cone.point(rng.uniform(1, 2), rng.uniform(0.3, 1.2))
    return {"k": cone.k, "alpha": cone.half_angle, **numbered("n", point)}


@worlds("eq14", "eq15", "eq16")
def foot_on_cone(rng):
    cone, m = Cone(rng.uniform(0.3, 1.2)), signed(rng, 0.5, 1.5, 3)
    foot = cone.feet(m)[rng.integers(2)]
    return {"k": cone.k, **numbered("m", m), **numbered("n", foot)}


def some_chord(rng):
    """Return a chord of a cone so flat that its development passes a right angle."""
    return ConeChord(rng.uniform(3, 4), rng.uniform(2, 3), rng.uniform(0.8, 1.5),
                     rng.uniform(0.38, 0.45))  # fmt: skip


def of_chord(chord):
    S, sigma = chord.ends
    return {"R": chord.R, "H": chord.H, "h": chord.h, "f": chord.f, "S": S, "sigma": sigma,
            "Phi_f": chord.turn * np.sin(chord.cone.half_angle)}  # fmt: skip


@worlds("eq17", "eq18")
def on_development(rng):
    chord, u = some_chord(rng), rng.uniform(0.85, 0.95)
    first, second = chord.geodesic(u)
    return {**of_chord(chord), "u": u, "n_d1": first, "d_d1": first, "n_d2": second,
            "phi.alt": chord.table(u)[1], "theta": float(chord.azimuth(u)),
            "Phi": 2 * np.pi * np.sin(chord.cone.half_angle)}  # fmt: skip


@worlds("eq18/case")
def on_narrow_development(rng):
    chord, u = ConeChord(*rng.uniform((1, 2, 0.5, 0.1), (2, 3, 1, 0.2))), rng.uniform(0.2, 0.9)
    return {**of_chord(chord), "u": u, "phi.alt": chord.table(u)[1],
            "theta": float(chord.azimuth(u))}  # fmt: skip


@worlds("eq19")
def line_and_plane(rng):
    """The line's point in the plane, as the mixture of its ends that the plane annuls."""
    p, q, plane = signed(rng, 0.5, 1.5, (3, 4))
    pairs = {f"m_{i}{j}": p[i] * q[j] - p[j] * q[i]
             for i, j in ((0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2))}  # fmt: skip
    pairs |= {f"m_{i}{i}": 0 * p[i] for i in range(4)}  # as the document prints them
    point = (q @ plane) * p - (p @ plane) * q
    return {**pairs, **numbered("m", point, 0), **numbered("M", plane, 0)}


@worlds("cone-point/case")
def on_quarter_turn(rng):
    return on_chord(rng, ConeChord(*rng.uniform((1, 2, 0.5), (2, 3, 1)), 0.25))


@worlds("cone-point")
def on_chord(rng, chord=None):
    chord = chord or some_chord(rng)
    theta = chord.turn * rng.uniform(0.2, 0.4)
    P, Q, M = chord.chord_point([0.0, chord.turn, theta])
    return {**of_chord(chord), "theta": theta, "Theta": chord.turn, "P": P, "Q": Q, "M": M,
            "rho_M": np.hypot(M[0], M[1]), "z_M": M[2],
            "LN": float(chord.tangent_sphere(theta))}  # fmt: skip


# ---- motion control -------------------------------------------------------------------------


@worlds("integer-line", count=60)
def counted_line(rng):
    J, D = int(rng.integers(5, 40)), int(rng.integers(-90, 90))
    start, j = int(rng.integers(-20, 20)), int(rng.integers(1, J))
    q, p = divmod(D, J)
    y = time_bresenham(start, start + D, J)[j]
    return {"y_j": int(y), "y_1": start, "j": j, "J": J, "q": q, "p": p}


@worlds("rounding-harmonics", count=8)
def harmonic(rng):
    J = int(rng.choice([7, 11, 13, 16, 25]))
    D = int(rng.choice([d for d in range(2, 60) if np.gcd(d, J) == 1 and d % J > 1]))
    error = time_bresenham(0, D, J)[:-1] - np.arange(J) * D / J
    k = int(rng.integers(1, J // 2 + 1))
    h = next(h for h in range(J) if (h * D - k) % J == 0)
    return {"e_k": np.fft.fft(error)[k] / J, "J": J, "p": D % J, "k": k, "h": h}


@worlds("ripple")
def staircase(rng):
    plant, gain = Resonance(0.5, rng.uniform(60, 120), 0.15), rng.uniform(5, 12)
    T, k = rng.uniform(0.02, 0.1), int(rng.integers(1, 4))
    A, B = plant.matrices()
    first = np.eye(len(B))[0]
    closed = A - gain * plant.command(1.0) * np.outer(B, first)

    def G(s):
        answer = np.linalg.solve(s * np.eye(len(B)) - closed, gain * plant.command(1.0) * B)
        return complex(first @ answer)

    return {"G": G, "k": k, "T": T, "values": (float(ripple(plant, gain, T, k)),)}


@worlds("unequal-areas")
def swings(rng):
    """Rates at which pressures stay: those of rest for small swings, their own in steady motion."""
    A, B, first, second = rng.uniform(0.5, 1.5, 4)  # displacements and volumes
    supply, load = 3.0, rng.uniform(-0.4, 0.4)
    lost = brentq(lambda p: A * (supply - p) - B * p - load, 0, supply, xtol=1e-15)
    flow = np.sqrt(lost)  # through either land, at an opening of 1
    torque_rate = lambda rate: A * (flow - A * rate) / first - B * (B * rate - flow) / second  # noqa: E731
    steady = lambda rate: A * (supply - (A * rate) ** 2) - B * (B * rate) ** 2 - load  # noqa: E731
    swing = brentq(torque_rate, 0, 99, xtol=1e-15) / brentq(steady, 0, 99, xtol=1e-15)
    theta, _ = reference_axes(REFERENCE_MACHINE)
    if rng.random() < 0.5:
        A, B = theta.linkage.displacements(-0.3)
        first, second = (v + theta.hose for v in theta.linkage.volumes(-0.3, theta.low, theta.high))
        swing = float(theta.swing(-0.3))
    return {"D_A": A, "D_B": B, "V_A": first, "V_B": second, "values": (swing,)}


# ---- the whole cut --------------------------------------------------------------------------


@cache
def reference_circuit():
    return cutting_circuit(REFERENCE_MACHINE, Egg(0.5))


def cusp(rho, B, tan, p):
    """Return the height of the cusp between balls that run two leaning turns of radius rho."""

    def missing(angle):
        beside = p / 2 - rho * angle * tan
        return rho + B - rho * np.cos(angle) - np.sqrt(
            B * B - beside**2 - (rho * np.sin(angle)) ** 2)  # fmt: skip

    return minimize_scalar(missing, (0, p), tol=1e-14).fun


@worlds("pitch")
def passes(rng):
    if rng.random() < 0.5:
        circuit, s, p = reference_circuit(), rng.uniform(0.05, 0.2), 0.04
        step = np.diff(circuit.in_tunnel(circuit.point([s - 1e-4, s + 1e-4])), axis=0)[0]
        tan, rho = step[0] / np.hypot(*step[1:]), 1 / circuit.profile.curvature(s)
        B, found = REFERENCE_MACHINE.cutter_radius, float(pass_distance(circuit, s, p))
    else:
        rho, B, tan, p = rng.uniform((0.5, 0.5, 0.4, 1), (1, 1, 0.9, 2))
        # To second order in the pitch, so its limit; h = p'^2 / (8 B) defines p'.
        a, b, c = (cusp(rho, B, tan, size) / size**2 for size in (0.08, 0.04, 0.02))
        first, second = (4 * b - a) / 3, (4 * c - b) / 3
        found = p * np.sqrt(8 * B * (16 * second - first) / 15)
    return {"p'": found, "p": p, "beta": np.arctan(tan), "rho": rho, "B": B, "tolerance": 1e-6}


# ---- a line against a cylinder --------------------------------------------------------------


def across(rng, v):
    """Return a unit vector at right angles to another."""
    e = np.cross(v, signed(rng, 0.5, 1, 3))
    return e / np.linalg.norm(e)


@worlds("rod-wall")
def on_wall(rng):
    v, r = signed(rng, 0.5, 1.5, 3), rng.uniform(0.3, 0.8)
    point = rng.uniform(0.2, 0.8) * v + r * across(rng, v)
    return {"bold v": v, "bold q": np.array([*point[:2], 0.0]), "z": point[2], "v_z": v[2], "r": r}


@worlds("rod-discs")
def on_discs(rng):
    v = signed(rng, 0.5, 1.5, 3)
    q = np.array([*signed(rng, 0.2, 0.8, 2), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    heights = [brentq(lambda z, end=end: (q + z * up - end) @ v, -99, 99, xtol=1e-15)
               for end in (np.zeros(3), v)]  # fmt: skip
    return {"bold v": v, "bold q": q, "v_z": v[2], "z_a": heights[0], "z_b": heights[1]}


@worlds("rod-miss", count=120)
def near_border(rng):
    v, r = np.append(rng.uniform(0.5, 1.5, 2), rng.uniform(0.5, 1.5)), rng.uniform(0.3, 0.8)
    d = np.hypot(v[0], v[1])
    e = v[2] / np.linalg.norm(v)
    s = r * rng.choice([-1, 1]) * rng.uniform(0.5, 1.1)
    k = e * np.sqrt(max(r * r - s * s, 0))
    # Beside the ends, the near one, the axis, or far away: a fair part on either side.
    m = rng.choice([-k, d + k, 0, d]) + rng.uniform(-0.4, 0.4) * r
    f = v[:2] / d
    q = m * f + s * np.array([-f[1], f[0]])
    enter, _ = Rod((0, 0, 0), tuple(v), r).meet_line((*q, 0), (0, 0, 1))
    return {"s": s, "m": m, "r": r, "k": k, "d": d, "e": e, "truth": bool(np.isinf(enter))}


# ---- envelopes of cones ---------------------------------------------------------------------


def wavy(x, y):
    return np.sin(2 * x) * np.cos(y) + 0.3 * x * y * y + np.exp(x - y)


def derivatives(jet):
    """Return a jet's derivatives by their letters, f_xxy."""
    orders = [(i, j) for i in range(5) for j in range(5 - i) if i + j]
    return {f"f_{'x' * i}{'y' * j}": float(jet.derivative(i, j)) for i, j in orders}


def with_term(jet, place, power, condition):
    """Return a jet with a multiple of x^power added for which a condition, linear, is zero."""
    bump = (jet_variables(*place)[0] - place[0]) ** power
    zero, one = condition(jet), condition(jet + bump)
    return jet - zero / (one - zero) * bump


@worlds("cones-eq06")
def plane(rng):
    n = across(rng, signed(rng, 0.5, 1, 3))
    h = rng.uniform(0.5, 2)
    return {**numbered("n", n), "h": h, "values": (plane_to_point(n, h),)}


@worlds("cones-eq07")
def sphere(rng):
    m, R = signed(rng, 0.5, 1.5, 3), rng.uniform(0.5, 1.5)
    x, y = signed(rng, 0.3, 1.2, 2)
    return {"x": x, "y": y, "z": float(sphere_point(m, R, x, y)), "R": R, **numbered("m", m)}


@worlds("cones-eq20")
def contact(rng):
    x, y = signed(rng, 0.3, 0.9, 2)
    jet = wavy(*jet_variables(x, y))
    return {"x": x, "y": y, "f": float(jet.value), **derivatives(jet),
            "bold r": surface_points(wavy, x, y)}  # fmt: skip


@worlds("cones-eq03", "cones-eq04")
def on_ruled_graph(rng):
    """A graph with lines through the third axis: over y = w x it's linear in x for each w."""
    x, y = rng.uniform(0.5, 1.5, 2)
    a, b = rng.uniform(0.5, 1.5, 2)
    X, Y = jet_variables(x, y)
    jet = np.sin(a * Y / X) + X * np.exp(b * Y / X)
    size = rng.uniform(0.5, 1.5)
    return {"u": size * x, "v": size * y, **derivatives(jet)}


@worlds("cones-eq09")
def circle_of_cone(rng):
    angle = rng.uniform(0.3, 1)
    centre, radius = top_circle(signed(rng, 0.4, 1, 3), angle)
    turn = rng.uniform(0.3, 1.2)
    x, y = centre + radius * np.array([np.cos(turn), np.sin(turn)])
    u, v = centre - [x, y]
    W = 1 + x * x + y * y + 2 * x * u + 2 * y * v
    return {"x": x, "y": y, "u": u, "v": v, "theta": angle, "W": W}


def over_circle(equation, jet, centre):
    """Return an equation's left side for a circle about a centre (u, v)."""
    return at(equation, jet, u=centre[0], v=centre[1])


def along_circle(jet, u, v, order):
    """Return the condition of contact of an order, by the graph's series along a circle."""
    value = [[jet.derivative(i, j) / mp.factorial(i) / mp.factorial(j) for j in range(5 - i)]
             for i in range(5)]  # fmt: skip

    def height(t):
        rise = 1 - mp.cos(t)
        dx, dy = v * mp.sin(t) + u * rise, v * rise - u * mp.sin(t)
        return sum(value[i][j] * dx**i * dy**j for i in range(5) for j in range(5 - i))

    with mp.workdps(30):
        c = mp.taylor(height, 0, 4)
        return float(6 * c[3] + c[1] if order == 3 else 24 * c[4] + 2 * c[2])


def contact_world(rng, order):
    place, (u, v) = signed(rng, 0.3, 0.9, 2), signed(rng, 0.4, 1, 2)
    printed = {3: EQ11, 4: EQ12}[order]
    jet = with_term(wavy(*jet_variables(*place)), place, order, lambda f: at(printed, f, u=u, v=v))
    assert abs(along_circle(jet, u, v, order)) < 1e-9
    return {"u": u, "v": v, **derivatives(jet)}


@worlds("cones-eq11", count=3)
def third_order(rng):
    return contact_world(rng, 3)


@worlds("cones-eq12", count=3)
def fourth_order(rng):
    return contact_world(rng, 4)


@worlds("adapted-orders")
def in_adapted_frame(rng):
    """Eqs 11 and 12 in the origin, for a circle about rho w; e is at right angles to w."""
    turn, rho = rng.uniform(0.3, 1.2), rng.uniform(0.4, 0.9)
    w, e = np.array([np.cos(turn), np.sin(turn)]), np.array([np.sin(turn), -np.cos(turn)])
    place = np.zeros(2)
    jet = with_term(wavy(*jet_variables(*place)), place, 3,
                    lambda jet: over_circle(EQ11, jet, rho * w))  # fmt: skip
    a, b = jet_variables(0.0, 0.0)
    X, Y = (e[i] * a + w[i] * b for i in (0, 1))
    turned = sum(jet.derivative(i, j) / float(mp.factorial(i) * mp.factorial(j)) * X**i * Y**j
                 for i in range(5) for j in range(5 - i))  # fmt: skip
    found = {name.translate(str.maketrans("xy", "ew")): value
             for name, value in derivatives(turned).items()}  # fmt: skip
    return {"rho": rho, **found, "R_12": over_circle(EQ12, jet, rho * w) / rho**2}


@worlds("multiple-field")
def along_a_double_root(rng):
    """The field of double roots of a surface that has them everywhere, in differences."""
    theta = rng.uniform(0.2, 0.9)
    tau = np.tan(theta)
    f = pseudo_envelope(theta)
    place = rng.uniform(0.3, 0.8) * np.tan(np.pi / 4 - theta / 2) * np.array([0.8, 0.6])

    def field(at):
        return np.arctan2(at[1], at[0]) + np.arcsin(double_root(theta, np.hypot(*at)))

    def centre(a, at):
        w = np.array([-np.sin(a), np.cos(a)])
        return w * (1 + at @ at) / 2 / (tau - at @ w)

    def q(a):
        rho = np.linalg.norm(centre(a, place))
        return p * over_circle(EQ11, f(*jet_variables(*place)), centre(a, place)) / rho**3

    a, p, h = field(place), 1 + place @ place, 1e-3
    e, rho = np.array([np.cos(a), np.sin(a)]), np.linalg.norm(centre(a, place))
    few = over_circle(EQ25, f(*jet_variables(*place)), centre(a, place)) / rho**2
    bend = (q(a + h) + q(a - h) - 2 * q(a)) / h**2
    bend = (4 * bend - (q(a + 2 * h) + q(a - 2 * h) - 2 * q(a)) / (4 * h**2)) / 3
    turn = (field(place + h * e) - field(place - h * e)) / (2 * h)
    turn = (4 * turn - (field(place + 2 * h * e) - field(place - 2 * h * e)) / (4 * h)) / 3
    return {"q_aa": bend, "kappa": 1 / rho, "a_e": turn, "tau": tau, "f_ew": few, "p": p,
            "tolerance": 1e-7}  # fmt: skip


@worlds("pseudo-envelope")
def bend_of_the_pseudo_envelope(rng):
    """Its y', (f_xx - f_yy)/r on the first axis, over what its factor is."""
    theta = rng.uniform(0.2, 0.9)
    end = np.tan(np.pi / 4 - theta / 2)

    def bend(r):
        jet = pseudo_envelope(theta)(*jet_variables(r, 0.0))
        return (jet.derivative(2, 0) - jet.derivative(0, 2)) / r

    r = rng.uniform(0.2, 0.9) * end
    # At the end W is 0 and c is sin(theta), which tells the factor.
    closest = end * (1 - 1e-14)
    known = (np.sin(theta) * np.cos(theta)) ** 1.5 * np.sin(theta) ** (-1.5 / np.cos(theta))
    factor = bend(closest) * end**2 / known
    c = np.cos(2 * np.arctan(r))
    return {"y'": bend(r) / factor, "r": r, "theta": theta, "c": c,
            "W": np.sqrt(c**2 - np.sin(theta) ** 2), "tolerance": 1e-5}  # fmt: skip


@worlds("cones-eq15")
def half_gradient(rng):
    x, y, u, v = signed(rng, 0.4, 1, 4)
    angle = rng.uniform(0.4, 1)

    def weight(u, v):
        return 1 + x * x + y * y + 2 * x * u + 2 * y * v

    def left(du, dv):
        square = (u + du) ** 2 + (v + dv) ** 2
        return weight(u + du, v + dv) ** 2 - 4 * np.tan(angle) ** 2 * square

    # A quadratic in u and in v: its difference is its derivative.
    return {"x": x, "y": y, "u": u, "v": v, "theta": angle,
            "W": weight(u, v),
            "tilde u": (left(1, 0) - left(-1, 0)) / 4,
            "tilde v": (left(0, 1) - left(0, -1)) / 4}  # fmt: skip


@worlds("third-line")
def generator(rng):
    """A circle through the origin: over it the graph of Example 31 holds a conic."""
    centre, turn = signed(rng, 0.4, 1, 2), rng.uniform(0.5, 2)
    x, y = centre + np.linalg.norm(centre) * np.array([np.cos(turn), np.sin(turn)])
    u, v = centre - [x, y]
    assert abs(at(EQ11, example(*jet_variables(x, y)), u=u, v=v)) < 1e-11
    return {"x": x, "y": y, "u": u, "v": v}
