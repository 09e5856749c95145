"""Problems 15 and 30 once more, by who doubts the proofs: random solutions of the equations.

Graphs that solve the document's equations are made from random data as power series, with no use of
the proofs, and seen in space: one counterexample would do.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.audit.long import many
from tests.series_open import Equations, series, solved
from tunneller_lib.envelopes.isotropic import contact_point, normal

ARC = np.linspace(-0.02, 0.02, 9)  # along an integral curve, in the model
SEEDS = range(many(2, 150))


def channel(equations):
    return equations.mixed(), equations.third()  # (26)


def pipe(equations):
    return equations.radius(), equations.mixed()  # (24) and (25)


def cylinders(equations):
    return equations.radius(), equations.hyperosculates(0.0)  # (24), and (11) with (23)


def along_the_field(equations):
    """Return points (9, 3) over an integral curve of the field, in space, and the normals there."""

    def way(_, place):
        angle = equations.angle(*place)
        return np.cos(angle), np.sin(angle)

    exact = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    back, forth = (solve_ivp(way, (0, half[-1]), (0.0, 0.0), t_eval=half, **exact).y
                    for half in (ARC[4::-1], ARC[4:]))  # fmt: skip
    h, k = np.concatenate([back[:, :0:-1], forth], axis=1)
    x, y = h + equations.place[0], k + equations.place[1]
    slopes = equations.at(h, k), equations.at(h, k, 1, 0), equations.at(h, k, 0, 1)
    return np.stack(contact_point(x, y, *slopes), -1), np.stack(normal(x, y), -1)


def sphere(points, n):
    """Return centre and radius of the sphere whose normals n point inwards, and how it misses."""
    rows = np.concatenate([np.tile(np.eye(3), (len(n), 1)), -n.reshape(-1, 1)], axis=1)
    found = np.linalg.lstsq(rows, points.ravel(), rcond=None)[0]
    centre, radius = found[:3], found[3]
    return centre, radius, np.abs(points + radius * n - centre).max()


def out_of_plane(vectors):
    """Return how far vectors are from lying in one plane through the origin."""
    return np.linalg.svd(vectors, compute_uv=False)[2]


def is_tame(found):
    """Tell whether the field's series doesn't grow so fast that its end hides the rest."""
    return np.abs(found.m).max() < 1e3


def found_for(asked, free, changed, *seed, suits=is_tame):
    """Return a random solution that suits, whose graph's series doesn't grow too fast either."""
    rng = np.random.default_rng(seed)
    while True:
        try:
            found = solved(asked, free, changed, rng)
        except np.linalg.LinAlgError:  # the line is a characteristic of the equations there
            continue
        if np.abs(found.f).max() < 1e3 and suits(found):
            return found


@pytest.mark.parametrize("seed", SEEDS)
def test_what_solves_eq26_has_a_sphere_along_a_circle(seed):
    found = found_for(channel, 3, [(3, 0), (1, 1)], 28, seed)
    points, n = along_the_field(found)
    _, radius, missed = sphere(points, n)
    assert missed < 1e-10 and abs(radius) > 1e-6
    assert out_of_plane(n - n[0]) < 1e-10


@pytest.mark.parametrize("seed", SEEDS)
def test_what_solves_eqs_24_and_25_has_a_sphere_along_a_great_circle(seed):
    found = found_for(pipe, 2, [(2, 0), (1, 1)], 29, seed).offset(0.7)
    points, n = along_the_field(found)
    _, radius, missed = sphere(points, n)
    assert missed < 1e-10 and radius == pytest.approx(0.7, abs=1e-10)
    assert out_of_plane(n) < 1e-10


@pytest.mark.parametrize("seed", SEEDS)
def test_what_solves_eqs_11_23_and_24_has_a_cylinder_along_a_curve(seed):
    found = found_for(cylinders, 3, [(3, 0), (2, 0)], 25, seed).offset(0.7)
    points, n = along_the_field(found)
    axis = points + 0.7 * n
    values, ways = np.linalg.svd(axis - axis.mean(axis=0))[1:]
    assert values[1] < 1e-10 < values[0]  # a line
    assert np.abs(n @ ways[0]).max() < 1e-10 / values[0]  # across the normals


# ---- multiple conics ------------------------------------------------------------------------


def across(found, tangent):
    """Return the direction w at a graph's place, and the rho of (9) there."""
    angle = found.angle(0.0, 0.0)
    w = np.array([-np.sin(angle), np.cos(angle)])
    return w, (1 + found.place @ found.place) / 2 / (tangent - w @ found.place)


def gap_coefficients(found, tangent):
    """Return the first six Taylor coefficients of osculating conic less graph, and the conic's rho.

    They are a contour integral of the gap itself; nothing is differentiated but for Eq. 10.
    """
    w, rho = across(found, tangent)
    u, v = rho * w
    orders = (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)
    fx, fy, fxx, fxy, fyy = (found.at(0.0, 0.0, *order) for order in orders)
    a = fx * v - fy * u
    b = fx * u + fy * v + fxx * v * v - 2 * fxy * u * v + fyy * u * u
    reach = 0.05 / max(1.0, abs(rho))
    t = reach * np.exp(2j * np.pi * np.arange(32) / 32)
    sine, rise = np.sin(t), 1 - np.cos(t)
    height = found.at(0.0, 0.0) + a * sine + b * rise
    left = height - found.at(v * sine + u * rise, v * rise - u * sine)
    return (np.fft.fft(left) / 32)[:6].real / reach ** np.arange(6), rho


def bend_of_q(found, tangent, step=1e-3):
    """Return the second derivative of q by the angle, by differences."""
    at = found.angle(0.0, 0.0)

    def q(angle):
        turned = Equations(found.f, series(np.tan(angle)), found.place)
        return turned.hyperosculates(tangent)[0, 0] * np.cos(angle) ** 3

    weights = {-2: -1, -1: 16, 0: -30, 1: 16, 2: -1}
    return sum(weight * q(at + k * step) for k, weight in weights.items()) / 12 / step**2


@pytest.mark.parametrize("seed", SEEDS)
def test_double_conics_of_random_graphs_have_contact_of_order_4_and_no_more(seed):
    """Only (9), (11) and (14) are put in. (12) holds by itself, and f_ew says what follows."""
    tangent = np.exp(np.random.default_rng(seed).uniform(-1.5, 1.0))
    found = found_for(
        lambda e: (e.hyperosculates(tangent), e.hyperosculates_twice(tangent)),
        3,
        [(3, 0), (2, 1)],
        15,
        seed,
        # The gap is divided by powers of the conic's size: in a large one rounding hides the rest.
        suits=lambda found: abs(across(found, tangent)[1]) < 20,
    )
    gap, rho = gap_coefficients(found, tangent)
    scale = max(1.0, abs(rho)) ** np.arange(6)
    assert np.abs(gap[:5] / scale[:5]).max() < 1e-9
    m = found.m[0, 0]
    mixed = found.mixed()[0, 0] / (1 + m * m)
    size = 1 + found.place @ found.place
    qaa = bend_of_q(found, tangent)
    fifth = -24 / 5 * rho**5 * (1 + tangent**2) ** 2 * mixed**2 / size**3 / qaa
    assert gap[5] == pytest.approx(fifth, rel=1e-4, abs=1e-9 * scale[5])
    # (I): how the field turns against the conic's circle.
    turn = (found.m[1, 0] + m * found.m[0, 1]) / (1 + m * m) ** 1.5
    assert qaa * (1 / rho - turn) == pytest.approx(24 * (1 + tangent**2) * mixed / size, rel=1e-5)
