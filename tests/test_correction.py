"""The corrected chord, and the rules that are good on short chords."""

import csv

import numpy as np
import pytest

from tests.audit.long import many
from tests.references import short_chords
from tests.shapes import HIGH, LOW, joint_pairs
from tunneller_lib.paths import (
    CHORD_PATHS,
    SHORT_CHORD_PATHS,
    corrected_chord,
    geodesic_direct,
    geodesic_inverse,
    path_length,
    project_chord,
)
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

READS = ["tests/references/*"]

MACHINE = REFERENCE_MACHINE
CORRECTED = CHORD_PATHS["corrected chord"]
SOME = many(300, 1000)
EVERY_PATH = CHORD_PATHS | SHORT_CHORD_PATHS


def pairs(n=SOME, seed=0):
    """Return random pairs of positions, and those of a grid with the joint limits' corners."""
    p, q = joint_pairs(n, seed)
    grid = np.stack(np.meshgrid(*np.linspace(LOW, HIGH, 5).T, indexing="ij"), -1).reshape(-1, 2)
    first, second = np.triu_indices(len(grid), 1)
    return np.concatenate([p, grid[first]]), np.concatenate([q, grid[second]])


def excess(torus, path, p, q):
    return path_length(torus, path, p, q) / geodesic_inverse(torus, p, q).length - 1


def steps(torus, way):
    points = torus.point(*np.moveaxis(way, -1, 0))
    return np.linalg.norm(np.diff(points, axis=-2), axis=-1)


def test_corrected_chord_is_within_a_millionth_of_the_geodesic():
    p, q = pairs(many(1000, 5000), seed=11)
    found = excess(MACHINE.torus, CORRECTED, p, q)
    assert 0.93e-6 < found.max() <= 1e-6
    assert np.median(found[:-300]) <= 2e-10


def test_corrected_chord_leaves_the_geodesic_by_half_a_millimetre():
    p, q = pairs()
    way = corrected_chord(MACHINE.torus, p, q, 33)
    off = geodesic_inverse(MACHINE.torus, p, q).points(65).deviation(way)
    assert 0.55e-3 < np.max(np.abs(off)) <= 0.6e-3


def test_waypoints_are_even():
    p, q = pairs()
    lengths = steps(MACHINE.torus, corrected_chord(MACHINE.torus, p, q, 33))
    ratio = lengths.max(axis=-1) / lengths.min(axis=-1)
    assert 1.03 < ratio.max() <= 1.04
    assert np.median(ratio[:-300]) < 1.0005


def test_excess_falls_with_the_fourth_power_of_the_ratio():
    p, q = pairs()
    ratios = np.array([4, 10, 20, 50, 100])
    worst = [excess(Torus(1 / ratio, 1), CORRECTED, p, q).max() for ratio in ratios]
    assert worst[0] == pytest.approx(29.2e-6, rel=2e-3)
    power = np.diff(np.log(worst)) / np.diff(np.log(ratios))
    assert np.all((-4.05 < power) & (power < -3.6))
    assert -4.05 < power[-1] < -3.95


@pytest.mark.parametrize(
    ("ratio", "gain"), [(0.01, 3), (0.1, 3), (0.25, 3), (0.5, 3), (1.0, 3), (1.5, 2.2)]
)
def test_no_pair_is_worse_corrected_and_the_worst_is_better(ratio, gain):
    p, q = pairs()
    torus = Torus(ratio, 1)
    plain = excess(torus, CHORD_PATHS["projected chord"], p, q)
    corrected = excess(torus, CORRECTED, p, q)
    assert np.all(corrected <= plain + 1e-12)
    assert corrected.max() < plain.max() / gain


@pytest.mark.parametrize("torus", [MACHINE.torus, Torus(1, 2), Torus(2, 1)], ids=str)
@pytest.mark.parametrize("azimuth", [0.7, np.pi / 2, 2.5])
def test_excess_falls_with_the_sixth_power_of_the_length(torus, azimuth):
    lengths = torus.R * np.array([0.5, 0.25])
    ends = [geodesic_direct(torus, (0, 0.35), [azimuth + np.pi, azimuth], size / 2).position[:, -1]
            for size in lengths]  # fmt: skip
    p, q = np.moveaxis(ends, 1, 0)
    long, short = path_length(torus, CORRECTED, p, q) / lengths - 1
    assert 2**5.7 < long / short < 2**6.3


@pytest.fixture(scope="module")
def short():
    with short_chords.TABLE.open(newline="") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def test_paths_have_the_excess_of_the_table(short):
    for row in short:
        if row["length"] < 0.1:  # nearly all of the rest is below rounding
            continue
        torus = Torus(row["r"], row["R"])
        azimuths = [row["azimuth"] + np.pi, row["azimuth"]]
        length = row["length"] * row["R"]
        ends = geodesic_direct(torus, (0, row["phi"]), azimuths, length / 2).position[:, -1]
        for name in short_chords.PATHS:
            found = path_length(torus, EVERY_PATH[name], *ends) / length - 1
            assert found == pytest.approx(row[name], rel=1e-4, abs=2e-14), name


def test_constants_of_the_rules(short):
    """A = kappa tau', B = kappa' tau in the middle, from the exact derivatives on a torus."""
    for row in short[7::16]:  # the shortest oblique chord of each torus
        a, b = rates(row)
        size = (row["length"] * row["R"]) ** 6 / 544320
        assert row["Simpson rule"] == pytest.approx(46 * b**2 * size, rel=2e-4)
        third = 9 * a**2 + 30 * a * b + 46 * b**2
        assert row["one-third rule"] == pytest.approx(third * size, rel=2e-4)
    for row in short[15::16]:  # and along a parallel, where the torsion vanishes
        a, _ = rates(row)
        size = (row["length"] * row["R"]) ** 6
        assert row["projected chord"] == pytest.approx(a**2 * size / 8064, rel=2e-4)
        assert row["one-third rule"] == pytest.approx(a**2 * size / 60480, rel=2e-4)


def rates(row):
    """Return kappa tau' and kappa' tau along a geodesic, by central differences."""
    torus, step = Torus(row["r"], row["R"]), 1e-4 * row["R"]
    way = geodesic_direct(torus, (0, row["phi"]), row["azimuth"], [-step, 0, step])
    q, along = way.position[:, -1], way.tangent[:, -1]
    bend, twist = torus.normal_curvature(q, along), torus.geodesic_torsion(q, along)
    return bend[1] * (twist[2] - twist[0]) / (2 * step), (bend[2] - bend[0]) / (2 * step) * twist[1]


def test_corrected_chord_is_its_path():
    p, q = pairs(100)
    way = corrected_chord(MACHINE.torus, p, q, 7)
    np.testing.assert_array_equal(way, CORRECTED(MACHINE.torus, p, q, np.linspace(0, 1, 7)))
    np.testing.assert_allclose(way[:, 0], p, atol=1e-14)
    np.testing.assert_allclose(way[:, -1], q, atol=1e-14)


@pytest.mark.parametrize(("p", "q"), [
    ((0.2, -0.5), (0.2, 0.7)), ((0.3, 0.2), (0.3, 0.2)), ((0.3, 0.2), (0.3 + 1e-6, 0.2 - 1e-6)),
    ((0.0, 1.55), (0.1, 1.59)), ((0.0, 1.6), (0.3, 1.6)),
], ids=["meridian", "point", "near", "across 90 deg", "beyond 90 deg"])  # fmt: skip
def test_nothing_is_corrected(p, q):
    torus = Torus(1, 1)
    plain = project_chord(torus, p, q, 5, spacing="tangent")
    np.testing.assert_allclose(corrected_chord(torus, p, q, 5), plain, atol=1e-14)
