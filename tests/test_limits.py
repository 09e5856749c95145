"""Limits that docstrings allow, drawn on purpose: at each, each pair of them, and next to them.

Each test asks what a docstring promises there, in numbers.
"""

import math

import numpy as np
import pytest
from mpmath import mp, mpf

from tests.foot_lengths import length_of_feet
from tests.shapes import ends_at_limits
from tunneller_lib.paths import CHORD_PATHS, geodesic_inverse, path_length, project_chord
from tunneller_lib.surfaces import Rod, Torus

# Geodesics: every pair of ends at the limits of the sheet and of their turn, on every torus.

RATIOS = 1e-100, 1e-15, 1e-4, 0.1, 0.5, 0.99999, 1 - 1e-12, 1, 1 + 1e-12, 1.0001, 1.5, 3, 1e4, 1e100


@pytest.mark.parametrize("ratio", RATIOS)
def test_geodesic_inverse_answers_all_ends_and_no_simple_way_is_shorter(ratio):
    torus = Torus(ratio, 1)
    p, q = ends_at_limits(torus)
    found = geodesic_inverse(torus, p, q)
    assert found.certified.all()
    a, b, turn = p[:, 1], q[:, 1], q[:, 0]
    near = np.minimum(np.cos(a), np.cos(b)) + ratio
    straight = np.abs(a - b)
    most = straight + near * turn  # along the meridian and the shorter parallel
    if ratio < 1:  # over the nearer node
        most = np.minimum(most, 2 * math.acos(-ratio) - np.abs(a + b))
        least = straight
    else:  # round the tube, on a horn through its node
        round_tube = 2 * np.pi - straight
        over = round_tube + (near if ratio > 1 else np.where(a * b < 0, 0, near)) * turn
        most, least = np.minimum(most, over), np.minimum(straight, round_tube)
    slack = 1e-12 * np.maximum(found.length, 1)
    assert np.all((least - slack <= found.length) & (found.length <= most + slack))
    back = geodesic_inverse(torus, q, p)
    np.testing.assert_allclose(back.length, found.length, rtol=3e-14, atol=2e-13)


@pytest.mark.parametrize("ratio", [ratio for ratio in RATIOS if ratio < 1])
def test_points_of_a_geodesic_end_where_it_does(ratio):
    torus = Torus(ratio, 1)
    p, q = ends_at_limits(torus)
    found = geodesic_inverse(torus, p, q)
    end = found.points(5).point[:, -1]
    np.testing.assert_allclose(end, torus.point(*q.T), rtol=0, atol=2e-12)


@pytest.mark.parametrize("far", [1e3, -1e8, 1e16, 3e22, 1e100])
def test_far_angles_of_geodesics_are_reduced_exactly(far):
    torus = Torus(0.1, 1)
    with mp.workdps(130):
        turn = float((mpf(far) - mpf(0.2) + mp.pi) % (2 * mp.pi) - mp.pi)
    expected = geodesic_inverse(torus, (0, 0.3), (turn, -0.4)).length
    found = geodesic_inverse(torus, [(0.2, 0.3), (far, 0.3)], [(far, -0.4), (0.2, -0.4)]).length
    np.testing.assert_allclose(found, expected, rtol=1e-14)


# Paths of chords: corners of the sheet, close by the axis, the ring circle or a node.

CORNERS = [
    (0.1, (0, 65), (150, -65)), (0.1, (0, 85), (170, -85)), (0.1, (0, -85), (170, -80)),
    (0.25, (0, 40), (95, -40)), (1 / 1.4, (0, 129), (28, -129)), (1, (0, 85), (95, -85)),
    (5, (-33.3, 5.2), (33.5, -5.2)), (0.1, (0, 17), (179.4, -11)), (0.1, (0, 0), (57, 95.7)),
]  # fmt: skip


@pytest.mark.parametrize("case", CORNERS)
def test_length_of_the_projected_chord_is_right_to_1e_9_and_its_arcs_are_equal(case):
    ratio, *ends = case
    torus, (p, q) = Torus(ratio, 1), np.radians(ends)
    expected = length_of_feet(torus, p, q)
    assert path_length(torus, CHORD_PATHS["projected chord"], p, q) == pytest.approx(
        expected, rel=1e-9
    )
    way = project_chord(torus, p, q, 4001, spacing="arc")
    steps = np.linalg.norm(np.diff(torus.point(*way.T), axis=0), axis=-1)
    assert np.median(steps) == pytest.approx(expected / 4000, rel=1e-5)


# Lines and solids without thickness, of needles, and with one direction for all.


@pytest.mark.parametrize("length", [1e3, 1e9, 1e15])
def test_needle_seen_end_on_is_met_to_16_eps_of_its_length(length):
    """Along the axis the ends are known: lines through the cap's inside, in whole numbers."""
    rod = Rod((0, 0, 0), (0, 3 * length, 4 * length), 5)
    p = np.array([[k, 4.0 * j, -3.0 * j] for k in (-2, 0, 3) for j in (-0.5, 0, 0.5)])
    enter, leave = rod.meet_line(p, (0, 3, 4))
    np.testing.assert_allclose(enter, 0, atol=16 * np.finfo(float).eps * length)
    np.testing.assert_allclose(leave, length, rtol=16 * np.finfo(float).eps)
