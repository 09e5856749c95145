"""Formulas in running text: each is read where the reader knows its signs, equations are evaluated.

What says something of the library's is true at values that it gives, as a display is
(typeset_check.py): by the values of a display's letters, or by some of its own. Other equations
and conditions, given sizes and definitions among them, stand in formulas.csv, one a line, for
somebody to look at.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import bisect, brentq

from report.tests.prose import sources
from report.tests.typeset_check import Check
from report.tests.typeset_worlds import WORLDS, numbered, signed, some_torus
from tests.shapes import half_swing
from tests.symbols_envelopes import example
from tunneller_lib.envelopes.isotropic import normal as plane_normal
from tunneller_lib.envelopes.isotropic import surface_points
from tunneller_lib.envelopes.pseudo import double_root
from tunneller_lib.motion import Integrator, Loop, Resonance
from tunneller_lib.motion.stability import continuous_limit, eigenvalue_limit, is_stable
from tunneller_lib.paths import ConeChord, geodesic_direct
from tunneller_lib.ream.wall import scallop_height
from tunneller_lib.removal.volume import bowl, ring
from tunneller_lib.surfaces import Egg, Rod
from tunneller_lib.surfaces.rod_interval import frame

READS = ["report/*.typ", "report/sections/*", "report/tests/formulas.csv"]


def formulas(path):
    """Return the formulas of a source's running text."""
    text = re.sub(r"\\\$|`[^`]*`|//[^\n]*", "", path.read_text("utf-8"))
    return [" ".join(formula.split()) for formula in re.findall(r"\$([^$]*)\$", text)]


FORMULAS = list(dict.fromkeys(formula for path in sources() for formula in formulas(path)))
LIST = Path(__file__).with_name("formulas.csv")

# Equations of letters that a display has, too.
OF_DISPLAYS = {
    r"S = sqrt(H^2 + R^2)": "eq17",
    r"sigma = h S \/ H": "eq17",
    r"P = (R, 0, -H)": "cone-point",
    r"rho = r + R cos phi": "eq01",
    r"m_1 n_3 = m_3 n_1": "eq08",
    r"d_sigma = sqrt((rho - sigma r)^2 + m_2^2)": "feet",
    r"s = m_1^2 + m_3^2": "eq11",
    r"rho = sqrt(m_1^2 + m_3^2)": "feet",
    r"sin phi = y\/R": "circuit",
    r"rho = r + sqrt(R^2 - y^2)": "circuit",
    r"V_R = pi c^3 \/ 12": "groove-area",
}
OWN = {}


def world(*sources):
    """Register a function of a generator as what gives the letters of formulas their values."""

    def register(make):
        for source in sources:
            OWN[source] = make
        return make

    return register


@world(r"tan alpha = R\/H", r"Theta_f \/ Phi_f = S\/R")
def chord_of_a_cone(rng):
    chord = ConeChord(*rng.uniform(0.5, 2, 2), 0.3, rng.uniform(0.1, 0.4))
    u = np.linspace(0, 1, 3)
    developed = np.arctan2(*chord.geodesic(u)[-1, ::-1])
    return {"R": chord.R, "H": chord.H, "alpha": chord.cone.half_angle,
            "Theta_f": float(chord.azimuth(1.0)), "Phi_f": float(developed),
            "S": float(chord.table(0.0)[2])}  # fmt: skip


@world("c = rho sin alpha")
def along_a_geodesic(rng):
    torus = some_torus(rng)
    start, alpha = rng.uniform(-0.6, 0.6, 2), rng.uniform(0.3, 2.5)
    way = geodesic_direct(torus, start, alpha, 0.4)
    far, near = (np.hypot(*torus.point(*way.position[i])[[0, 2]]) for i in (-1, 0))
    return {"c": far * np.sin(way.azimuth[-1]), "rho": near, "alpha": alpha}


@world('theta = "atan2"(-m_3, m_1)', 'phi = "atan2"(m_2, rho - r)')
def angles_of_a_foot(rng):
    torus, m = some_torus(rng), signed(rng, 0.4, 1.2, 3)
    theta, phi = torus.angles(torus.foot(m))
    return {"theta": float(theta), "phi": float(phi), "r": torus.r, "rho": np.hypot(m[0], m[2]),
            **numbered("m", m)}  # fmt: skip


@world(r"bold(q) = bold(a) + t (bold(b) - bold(a))",
       "T_4 t^4 + T_3 t^3 + T_2 t^2 + T_1 t + T_0 = 0",
       "t_4 = |bold(b) - bold(a)|^2", "t_3 = bold(a) dot (bold(b) - bold(a))",
       "t_2 = |bold(a)|^2 - r^2 - R^2")  # fmt: skip
def line_through_a_torus(rng):
    torus, theta, phi = some_torus(rng), *rng.uniform(-0.5, 0.5, 2)
    q, along = torus.point(theta, phi), signed(rng, 0.5, 1.5, 3)
    a = q - 0.3 * along
    values = WORLDS["eq05"](0)[0] | {"bold a": a, "bold b": a + along, "bold q": q, "t": 0.3}
    # The product of the distances to both meridian circles, as a polynomial in t.
    t = np.linspace(-1, 1, 5)
    quartic = np.polynomial.Polynomial.fit(t, torus.implicit(a + t[:, None] * along), 4).convert()
    return values | {"r": torus.r, "R": torus.R, "t_4": along @ along, "t_3": a @ along,
                     "t_2": a @ a - np.hypot(torus.r, torus.R) ** 2,
                     **numbered("T", quartic.coef, 0)}  # fmt: skip


@world("V_C + V_R = V_L = pi B^2 c")
def bowl_and_ring(rng):
    B, c = rng.uniform(0.5, 1.5), rng.uniform(0.1, 0.3)
    cylinder = Rod((0, 0, 0), (0, 0, c), B)
    x, y = np.meshgrid(*[(np.arange(400) + 0.5) * B / 200 - B] * 2)
    lines = np.stack([x, y, 0 * x], axis=-1)
    enter, leave = cylinder.meet_line(lines, (0, 0, 1))
    volume = np.sum(np.where(enter < leave, leave - enter, 0)) * (B / 200) ** 2
    return {"B": B, "c": c, "V_C": float(bowl(B, c)), "V_R": float(ring(B, c)),
            "V_L": float(volume), "tolerance": 1e-4}  # fmt: skip


@world(r"K_v T < 2 sin(pi\/(2(2m+1)))")
def below_the_limit_with_a_delay(rng):
    m, T = int(rng.integers(5)), rng.uniform(1e-3, 0.1)
    limit = eigenvalue_limit(Integrator(0.5), Loop(0.1 / T, T, delay=m))
    return {
        "K_v": 0.999 * limit,
        "T": T,
        "m": m,
        "outside": [{"K_v": 1.001 * limit}, {"T": 1.01 * T}, {"m": m + 1}],
    }


@world(r"K_i T < K_v < (4 + K_i T^2)\/(2T)")
def between_the_limits_with_an_integral(rng):
    T = rng.uniform(1e-3, 0.1)
    K_i = (rng.uniform(0.2, 1) / T) ** 2
    loop = Loop(1.5 / T, T, integral=K_i)
    high = eigenvalue_limit(Integrator(0.5), loop)
    low = bisect(
        lambda g: is_stable(Integrator(0.5), replace(loop, gain=g)) - 0.5, 1e-3 / T, 1.5 / T
    )
    near_low = rng.random() < 0.5
    return {"K_v": 1.001 * low if near_low else 0.999 * high, "K_i": K_i, "T": T,
            "outside": [{"K_v": 0.999 * low}, {"K_v": 1.001 * high}, {"T": 1.05 * T},
                        {"K_i": (1.05 if near_low else 0.5) * K_i}]}  # fmt: skip


@world("K_v < 2 zeta omega_h")
def below_the_limit_of_a_resonance(rng):
    omega, zeta = rng.uniform(30, 200), rng.uniform(0.05, 0.3)
    limit = continuous_limit(Resonance(0.5, omega, zeta))
    outside = [{"K_v": 1.001 * limit}, {"zeta": 0.99 * zeta}, {"omega_h": 0.99 * omega}]
    return {"K_v": 0.999 * limit, "zeta": zeta, "omega_h": omega, "outside": outside}


@world(r"h = B - sqrt(B^2 - p^2 \/ 4)")
def cusp_between_passes(rng):
    B, p = rng.uniform(0.1, 0.3), rng.uniform(0.02, 0.1)
    return {"h": float(scallop_height(B, p)), "B": B, "p": p}


@world("h = |(v_x, v_y)|", r"e = v_z \/ |bold(v)|", "w = sqrt((r - s)(r + s))", "k = e w")
def rod_seen_along_a_line(rng):
    v = np.append(signed(rng, 0.5, 1.5, 2), rng.uniform(0.5, 1.5))
    seen = frame(np.zeros(3), v, np.array([0.0, 0, 1]))
    # A point of the end's rim: s aside, w from the middle in the disc, k as the line sees that.
    r, angle = rng.uniform(0.4, 0.8), rng.uniform(-1, 1)
    within = np.cross(v / seen.length, seen.across)
    w = r * np.cos(angle)
    return {"v_x": v[0], "v_y": v[1], "v_z": v[2], "bold v": v, "h": float(seen.run), "w": w,
            "e": float(seen.rise / seen.length), "r": r, "s": r * np.sin(angle),
            "k": abs(w * float(within @ seen.flat))}  # fmt: skip


@world("z (x^2 + y^2 + z^2) + 2 (x^2 + z^2) = 0")
def point_of_the_cyclide(rng):
    return dict(zip("xyz", surface_points(example, *signed(rng, 0.3, 1, 2)).tolist(), strict=True))


@world(r"d = a\/2")
def offset_that_uses_the_invert_up(rng):
    a = rng.uniform(0.3, 2)
    return {"d": float(Egg(a).least_radius), "a": a}


@world(r"T(R + r) = pi\/sqrt(1 + r\/R)")
def half_swing_along_the_outer_equator(rng):
    torus = some_torus(rng)

    def T(c):  # just below the limit, at which nothing swings any more
        within = 0 < c <= torus.r + torus.R
        return half_swing(torus, (1 - 1e-10) * c)[0] if within else np.nan

    return {"r": torus.r, "R": torus.R, "tolerance": 1e-6, "T": T}


@world("R^2 sin^2 phi = (R + r - rho)(R - r + rho)")
def on_a_meridian(rng):
    torus, phi = some_torus(rng), rng.uniform(0.3, 1.2)
    return {"r": torus.r, "R": torus.R, "phi": phi, "rho": torus.point(0.0, phi)[0]}


def node(torus):
    """Return the angle phi at which a meridian meets the axis of a torus that crosses itself."""
    return brentq(lambda phi: torus.point(0.0, phi)[0], 1.6, 3.1)


@world("(0, plus.minus sqrt(R^2 - r^2), 0)")
def nodes(rng):
    torus, side = some_torus(rng), int(rng.choice([-1, 1]))
    place = np.round(torus.point(rng.uniform(-1, 1), side * node(torus)), 14)  # zeros exactly
    return {"r": torus.r, "R": torus.R, "epsilon": side, "values": (place,), "tolerance": 1e-8}


@world("R (2 phi_n - a - b)")
def through_a_node(rng):
    torus, (a, b) = some_torus(rng), rng.uniform(0.1, 1, 2)
    arcs = [np.linspace(start, node(torus), 20_001) for start in (a, b)]
    steps = [np.linalg.norm(np.diff(torus.point(0.0, arc), axis=0), axis=1) for arc in arcs]
    return {"R": torus.R, "a": a, "b": b, "phi_n": node(torus), "values": (np.sum(steps),),
            "tolerance": 1e-8}  # fmt: skip


@world(r"kappa = 1\/rho = 2 (tau - bold(x) dot bold(w))\/p", "p = 1 + |bold(x)|^2",
       "tau = tan theta", "(u, v) = rho bold(w)", "bold(x) = (x, y)")  # fmt: skip
def top_circle_of_a_cone(rng):
    """The circle through a place, in a direction, that Eq. 9 knows as a cone's."""
    angle, turn, (x, y) = rng.uniform(0.3, 1), rng.uniform(0.3, 1.2), signed(rng, 0.1, 0.4, 2)
    w = np.array([-np.sin(turn), np.cos(turn)])

    def eq09(size):
        u, v = size * w
        weight = 1 + x * x + y * y + 2 * x * u + 2 * y * v
        return weight**2 - 4 * np.tan(angle) ** 2 * size**2

    rho = brentq(eq09, 1e-3, 1 / np.tan(angle))
    u, v = rho * w
    p = 2 / (1 + plane_normal(x, y)[2])
    return {"kappa": 1 / rho, "rho": rho, "tau": np.tan(angle), "theta": angle, "bold w": w,
            "x": x, "y": y, "bold x": np.array([x, y]), "u": u, "v": v, "p": p}  # fmt: skip


@world(r"sin a + 1\/sin a = (1\/r - r)\/tau")
def double_cone(rng):
    theta = rng.uniform(0.2, 0.9)
    r = rng.uniform(0.2, 0.9) * np.tan(np.pi / 4 - theta / 2)
    return {"a": float(np.arcsin(double_root(theta, r))), "r": r, "tau": np.tan(theta)}


@world(r"0 < r < tan(pi\/4 - theta\/2)")
def where_double_cones_are(rng):
    theta = rng.uniform(0.2, 0.9)
    with np.errstate(invalid="ignore"):
        places = np.linspace(1e-6, 1, 1_000_001)
        last = places[np.isfinite(double_root(theta, places))][-1]
    return {"r": last, "theta": theta, "outside": [{"r": last + 2e-6}, {"theta": theta + 1e-4}]}


@world(r"f = y^2\/(x^2 + y^2)")
def graph_of_the_example(rng):
    x, y = signed(rng, 0.3, 1, 2)
    return {"x": x, "y": y, "f": example(x, y)}


@pytest.mark.parametrize("formula", [*OF_DISPLAYS, *OWN])
def test_equation_in_running_text_is_right_and_every_letter_matters(formula):
    assert formula in FORMULAS
    make = OWN.get(formula)
    found = [make(np.random.default_rng((5, i))) for i in range(4)] if make else None
    source = formula.replace("plus.minus", "epsilon")
    check = Check(source, found or WORLDS[OF_DISPLAYS[formula]](5))
    assert check.right()
    changed = {letter for change in check.worlds[0].get("outside", ()) for letter in change}
    assert set(check.blind()) <= changed  # of a condition, those that make it false when changed


def not_evaluated():
    """Return a line for each equation, condition or place of the text that nothing evaluates."""
    lines = ["section,formula"]
    for path in sources():
        for formula in dict.fromkeys(formulas(path)):
            says = re.search(r"[=<>]|plus\.minus|equiv", formula) and re.search("[a-z]", formula)
            if says and "#" not in formula and formula not in OF_DISPLAYS | OWN:
                lines.append(f'{path.stem},"{formula.replace(chr(34), chr(34) * 2)}"')
    return "\n".join(lines) + "\n"


def test_list_of_what_is_not_evaluated_is_that_of_the_text():
    if LIST.read_text("utf-8") != not_evaluated():
        pytest.fail("The list is stale: `python -m report.tests.test_inline` renews it; look at "
                    "each new line, or give it values with @world.", pytrace=False)  # fmt: skip


if __name__ == "__main__":
    LIST.write_text(not_evaluated(), "utf-8")
