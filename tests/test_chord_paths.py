"""Paths that could stand in for a geodesic, and their lengths."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.audit.long import many
from tests.draws import log_uniform
from tests.foot_lengths import length_of_feet
from tests.shapes import joint_pairs
from tunneller_lib.paths import CHORD_PATHS, geodesic_inverse, path_length, project_chord
from tunneller_lib.paths.bounds import check_points
from tunneller_lib.paths.chord_paths import ChordPath
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

READS = ["README.md", "notebooks/*", "report/sections/geodesics.typ"]

ROOT = Path(__file__).resolve().parents[1]

MACHINE = REFERENCE_MACHINE
TORI = [MACHINE.torus, Torus(0.25, 1), Torus(3, 200), Torus(2e-4, 1e-3)]
every_torus = pytest.mark.parametrize("torus", TORI, ids=str)
every_path = pytest.mark.parametrize("path", CHORD_PATHS.values(), ids=CHORD_PATHS)
T = np.linspace(0, 1, 9)


def points(torus, joint):
    return torus.point(*np.moveaxis(joint, -1, 0))


@every_torus
@every_path
def test_path_begins_and_ends_at_its_ends(torus, path):
    p, q = joint_pairs(200)
    way = path(torus, p, q, np.array([0.0, 1.0]))
    np.testing.assert_allclose(way, np.stack([p, q], axis=1), atol=1e-13)


@every_torus
@every_path
def test_path_length_is_that_of_a_fine_polyline(torus, path):
    p, q = joint_pairs(many(15, 40), seed=1)
    fine = points(torus, path(torus, p, q, np.linspace(0, 1, 4001)))
    polyline = np.linalg.norm(np.diff(fine, axis=1), axis=-1).sum(axis=-1)
    np.testing.assert_allclose(path_length(torus, path, p, q), polyline, rtol=2e-7)


RING_HALF = np.arccos(1 / (1 + 0.2 * np.cos(0.09)))  # of a chord that meets the ring circle


def by_the_axis(gap):
    return MACHINE.torus, (0.1, 0.3), (np.pi + 0.1 - gap, -0.2)


def by_the_axis_of_a_ring(gap):
    return Torus(1, 0.5), (0, 0.2), (np.pi - gap / 4, 0.2)


def by_the_ring(gap):
    return Torus(1, 0.2), (gap - RING_HALF, 0.09), (RING_HALF, -0.09)


def from_a_node(gap):
    return MACHINE.torus, (0, 0), (1, np.arccos(-0.1) - gap)


@pytest.mark.parametrize("ends", [by_the_axis, by_the_axis_of_a_ring, by_the_ring, from_a_node])
@pytest.mark.parametrize("gap", [1e-2, 1e-4, 5e-6])
def test_path_length_close_by_a_jump_is_right(ends, gap):
    torus, p, q = ends(gap)
    expected = length_of_feet(torus, p, q)
    found = path_length(torus, CHORD_PATHS["projected chord"], p, q)
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("ends", [by_the_axis, by_the_ring])
@pytest.mark.parametrize("gap", [0, 1e-15, 1e-12, 1e-9])
def test_path_that_jumps_for_all_that_its_points_tell_is_refused(ends, gap):
    torus, p, q = ends(gap)
    sentence = r"^p, q: must be ends whose path doesn't jump.*or nea"
    with pytest.raises(ValueError, match=sentence):
        path_length(torus, CHORD_PATHS["projected chord"], p, q)
    with pytest.raises(ValueError, match=sentence):
        project_chord(torus, p, q, 5, spacing="arc")


@pytest.mark.parametrize("share", [1 / 2, 3 / 8, 1 / 3])
def test_path_of_ones_own_that_jumps_is_refused_wherever_it_jumps(share):
    def way(torus, p, q, t):
        return np.where((t < share)[:, None], p[..., None, :], q[..., None, :])

    mine = ChordPath("mine", way, "error", "-")
    with pytest.raises(ValueError, match=rf"^p, q: must be ends whose .* at {share:.3g}"):
        path_length(MACHINE.torus, mine, (0.1, 0.3), (0.2, 0.3))


def test_path_of_ones_own_with_corners_has_the_length_of_its_parts():
    """It goes to one side, back over its start, and on."""

    def way(torus, p, q, t):
        turned = np.interp(t, [0, 0.3, 1], [0, -0.5, 1])[:, None]
        return p[..., None, :] + turned * (q - p)[..., None, :]

    mine = ChordPath("mine", way, "error", "-")
    length = path_length(MACHINE.torus, mine, (0.1, 0), (0.5, 0))
    assert length == pytest.approx((MACHINE.r + MACHINE.R) * 0.4 * 2, rel=1e-9)


@pytest.mark.parametrize("p", [(3.0, 0.0), (-3.5, 0.0), (1e8, 0.0)])
def test_path_length_over_the_seam_of_the_angles_is_that_of_the_equator(p):
    q = (p[0] + 0.5, 0.0)
    for name, path in CHORD_PATHS.items():
        length = path_length(MACHINE.torus, path, p, q)
        own = 1e-6 if name == "joint space" and p[0] > 1e6 else 1e-12  # its angles' own rounding
        assert length == pytest.approx((MACHINE.r + MACHINE.R) * 0.5, rel=own)


@every_torus
def test_plane_section_lies_in_the_plane_and_is_where_lines_meet_the_torus(torus):
    p, q = joint_pairs(50, seed=4)
    way = points(torus, CHORD_PATHS["plane section"](torus, p, q, T[1:-1]))
    start, stop = points(torus, p), points(torus, q)
    middle = (start + stop) / 2
    normal = torus.normal(*torus.angles(middle))
    across = np.cross(stop - start, normal)
    off = np.einsum("nki,ni->nk", way - start[:, None], across)
    assert np.max(np.abs(off)) <= 1e-13 * torus.R**2
    chord = start[:, None] + T[1:-1, None] * (stop - start)[:, None]
    meets = torus.meet_line(chord, chord + torus.R * normal[:, None])
    t = np.einsum("nki,ni->nk", way - chord, normal) / torus.R
    assert np.max(np.nanmin(np.abs(meets - t[..., None]), axis=-1)) <= 1e-12


@every_torus
def test_radial_projection_lies_in_a_plane_through_the_centre(torus):
    p, q = joint_pairs(50, seed=5)
    way = points(torus, CHORD_PATHS["radial projection"](torus, p, q, T))
    across = np.cross(points(torus, p), points(torus, q))
    off = np.einsum("nki,ni->nk", way, across)
    assert np.max(np.abs(off)) <= 1e-13 * torus.R**3


@every_torus
def test_one_third_rule_is_the_geodesic_to_a_higher_order(torus):
    # Short oblique chords: the deviation falls by 16 where the projected chord's falls by 8.
    p, q = np.array([0.1, 0.2]), np.array([0.5, 0.45])
    ends = np.array([[p + s * (q - p), q - s * (q - p)] for s in (0.0, 0.25)])
    samples = geodesic_inverse(torus, ends[:, 0], ends[:, 1]).points(257)
    falls = {"projected chord": (7, 9), "plane section": (7, 9), "one-third rule": (13, 30)}
    for name, (least, most) in falls.items():
        way = CHORD_PATHS[name](torus, ends[:, 0], ends[:, 1], T)
        long, short = np.max(np.abs(samples.deviation(way)), axis=-1)
        assert least < long / short < most


@every_path
def test_path_refuses_ends_beyond_the_node(path):
    for name, ends in (("p", ((0, 3), (0, 0))), ("q", ((0, 0), (0, 3)))):
        for call in (lambda ends=ends: path(MACHINE.torus, *ends, T),
                     lambda ends=ends: path_length(MACHINE.torus, path, *ends)):  # fmt: skip
            with pytest.raises(ValueError, match=rf"^{name}: must lie on the working sheet"):
                call()


# Typst's and LaTeX's signs, and what they are in Python.
SIGNS = {r"\\": "\\", r"\,": "", r"\tfrac23": "2/3", r"\mathbf ": "", "bold(m)": "m",
         "bold(nu)": "n", "bold(n)": "n", "_0": "0", " (": "*(", "d(": "d*(",
         "3 d": "3*d"}  # fmt: skip


@pytest.mark.parametrize(
    ("file", "before"),
    [
        ("report/sections/geodesics.typ", r"it replaces \$bold\(m\)\$ by \$"),
        ("notebooks/10_law.ipynb", r"In code: put[^$]*\$"),
    ],
    ids=["report", "notebook"],
)
def test_recipe_of_the_third_rule_is_the_library_s(file, before):
    """As the text states it, with outward normals and the depth below the surface."""
    text = (ROOT / file).read_text(encoding="utf-8")
    [formula] = re.findall(before + r"([^$]+)\$", text)
    for sign, plain in SIGNS.items():
        formula = formula.replace(sign, plain)
    torus = MACHINE.torus
    p, q = joint_pairs(50)
    start, stop = (points(torus, joint)[:, None] for joint in (p, q))
    m = start + T[:, None] * (stop - start)
    foot = torus.foot(m)
    n, n0 = (torus.normal(*torus.angles(point)) for point in (m, (start + stop) / 2))
    assert np.all(np.sum(n * foot, axis=-1) > 0)  # outwards
    d = np.sum((foot - m) * n, axis=-1, keepdims=True)
    shifted = eval(formula, {"m": m, "d": d, "n": n, "n0": n0})
    way = CHORD_PATHS["one-third rule"](torus, p, q, T)
    np.testing.assert_allclose(np.stack(torus.angles(shifted), axis=-1), way, atol=1e-12)
    other = eval(formula.replace("-", "+", 1), {"m": m, "d": d, "n": n, "n0": n0})
    assert np.max(np.abs(np.stack(torus.angles(other), axis=-1) - way)) > 1e-3


@pytest.mark.parametrize("far", [2.0**26, 2.0**29, -(2.0**40), 2.0**53, 1e22])
def test_joint_space_length_is_the_same_however_far_the_angles_are(far):
    torus, path = Torus(0.08, 0.8), CHORD_PATHS["joint space"]
    assert path_length(torus, path, (far, 0.2), (far, -0.4)) == pytest.approx(0.48, rel=1e-12)
    turn = (far + 0.5) - far  # half a radian, or none where floats are farther apart
    near = path_length(torus, path, (0.0, 0.2), (turn, -0.4))
    there = path_length(torus, path, (far, 0.2), (far + 0.5, -0.4))
    assert there == pytest.approx(near, rel=1e-12)


def test_points_of_all_paths_together_have_a_bound():
    for n, shape in ((2, (2_500_000,)), (5, (1000, 1000)), (1_000_000, (5,)), (1_000_000, ())):
        check_points(n, shape)
    with pytest.raises(ValueError, match=r"^n: must ask for at most 5000000 .* 3 of each of 166"):
        check_points(3, (1_666_667,))  # one point too many


# ---- the projected chord: where it runs, and how its points are spaced --------------------------

SPINDLE = Torus(0.08, 0.8)
PROJECTED = CHORD_PATHS["projected chord"]
P, Q = (-0.9, -0.6), (0.5, 0.4)
SPACINGS = ("chord", "tangent", "arc")
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)

joints = st.tuples(st.floats(-1, 0.6), st.floats(-0.7, 0.7))
working = st.builds(lambda s, k: Torus(s, s * k), log_uniform(1e-3, 1e6), log_uniform(1, 1e4))


@every_spacing
@given(working, joints, joints)
def test_project_chord_runs_over_feet_of_the_chord(spacing, torus, p, q):
    start, stop = torus.point(*p), torus.point(*q)
    path = points(torus, project_chord(torus, p, q, 9, spacing=spacing))
    chord = stop - start
    length = np.linalg.norm(chord)
    if length < 1e-3 * torus.R:
        return
    # Normals meet the chord: ring point, path point and the chord's line lie in one plane.
    rho = np.hypot(path[:, 0], path[:, 2])[:, None]
    ring = torus.r * path * [1, 0, 1] / rho
    volume = np.einsum("ni,ni->n", np.cross(path - ring, chord), start - ring)
    assert np.max(np.abs(volume)) <= 1e-13 * length * torus.R * (torus.r + torus.R)


@pytest.mark.parametrize("spacing", ["tangent", "arc"])
def test_project_chord_on_a_sphere_is_an_even_great_circle(spacing):
    sphere = Torus(1e-12, 1)
    path = points(sphere, project_chord(sphere, P, Q, 11, spacing=spacing))
    plane = np.cross(path[0], path[-1])
    assert np.max(np.abs(path @ plane)) <= 1e-11
    turns = np.arccos(np.sum(path[1:] * path[:-1], axis=-1))
    np.testing.assert_allclose(turns, np.mean(turns), rtol=1e-10)
    total = np.arccos(path[0] @ path[-1])
    assert path_length(sphere, PROJECTED, P, Q) == pytest.approx(total, rel=1e-11)


@every_spacing
def test_project_chord_along_a_meridian_and_the_equator_stays_there(spacing):
    meridian = project_chord(SPINDLE, (0.2, -0.5), (0.2, 0.7), 9, spacing=spacing)
    np.testing.assert_allclose(meridian[:, 0], 0.2, atol=1e-14)
    equator = project_chord(SPINDLE, (-0.9, 0), (0.5, 0), 9, spacing=spacing)
    np.testing.assert_allclose(equator[:, 1], 0, atol=1e-14)


@pytest.mark.parametrize("spacing", ["chord", "tangent"])
@pytest.mark.parametrize("torus", [SPINDLE, Torus(2, 1)], ids=str)
def test_project_chord_through_the_axis_gives_finite_points(spacing, torus):
    path = project_chord(torus, (0, 0.3), (np.pi, -0.3), 5, spacing=spacing)
    assert np.all(np.isfinite(path))
    np.testing.assert_allclose(path[[0, -1]], [(0, 0.3), (np.pi, -0.3)], atol=1e-13)
