"""The ground that the front of a moving ball takes."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.audit.long import many
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, plan
from tunneller_lib.ream.front import engaged_areas, facing_areas, front_areas, groove_areas
from tunneller_lib.ream.wall import intact_wall
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
INVERT = float(CIRCUIT.profile.blends[2])  # where the tight bend begins
ADVANCES = pytest.mark.parametrize("advance", [0.0, 0.04, 0.17, 0.5])
SPACING = 1e-3  # m of points, across the way
STEP = 5e-3  # m of the section, over which ground is counted


def counted(s, advance):
    """Return the ground that a step along the offset section at s takes, by counting points."""
    machine = CIRCUIT.machine
    radius = machine.cutter_radius
    profile = CIRCUIT.profile
    half = np.sqrt(machine.depth * (2 * radius - machine.depth))
    x = np.arange(-half, half, 2 * SPACING) + SPACING
    ways = np.linspace(s - 0.15, s - STEP / 2, 100), np.linspace(s - STEP / 2, s + STEP / 2, 20)
    low, high = profile.point(s) - radius - STEP, profile.point(s) + radius + STEP
    grid = [np.arange(a, b, SPACING) + SPACING / 2 for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 2)
    beyond = -profile.depth(*points.T)
    near = (beyond > machine.offset) & (beyond < radius)
    before, during = (cKDTree(profile.point(way)).query(points[near])[0] for way in ways)
    square = (radius**2 - x**2)[:, None]
    earlier = np.maximum(radius**2 - (x - advance) ** 2, 0.0)[:, None] if advance else 0.0
    new = (during**2 < square) & (before**2 > square) & (beyond[near] ** 2 > earlier)
    return np.count_nonzero(new) * 2 * SPACING**3 / STEP


@ADVANCES
def test_front_on_one_arc_takes_the_groove_of_a_circle(advance):
    s = np.linspace(0.05, 0.85, 9)
    exact = groove_areas(CIRCUIT, s, advance)
    assert front_areas(CIRCUIT, s, advance) == pytest.approx(exact, rel=1e-4)


@ADVANCES
def test_areas_change_evenly_where_the_bend_jumps(advance):
    s = np.linspace(0.9, CIRCUIT.profile.perimeter - 0.1, 4000)
    jumps = np.abs(np.diff(groove_areas(CIRCUIT, s, advance))).max()
    assert np.abs(np.diff(engaged_areas(CIRCUIT, s, advance))).max() < 0.05 * jumps


@pytest.mark.parametrize("advance", [0.0, 0.04])
@pytest.mark.parametrize("before", [0.05, 0.03, 0.015, 0.0, -0.05, -0.11, -0.125])
def test_front_meets_a_bend_before_its_centre_does(before, advance):
    s = INVERT - before
    found = front_areas(CIRCUIT, np.array([s]), advance)[0]
    assert found == pytest.approx(counted(s, advance), rel=0.04)  # of points 1 mm apart


@pytest.mark.parametrize(("advance", "close"), [(0.0, 0.01), (0.08, 0.06), (0.04, 0.06)])
@pytest.mark.parametrize("s", [0.2, 0.6, 0.8, 1.5, 1.75, 2.0, 2.3][:: many(2, 1)])
def test_front_takes_what_a_wall_that_is_cut_would_lose(s, advance, close):
    """Where it leans by up to 24 degrees, and bends are far; what faces the wall, too."""
    way = np.linspace(s - 0.12, s + 0.2, 401)
    centres = CIRCUIT.in_tunnel(CIRCUIT.point(way))
    radius = CIRCUIT.machine.cutter_radius
    ends = centres[:, 0].min() - radius, centres[:, 0].max() + radius + advance
    wall = intact_wall(CIRCUIT, *ends, (400, 1080))
    if advance:
        wall.cut_path(centres + np.array([advance, 0.0, 0.0]), radius)
    here = int(np.searchsorted(way, s))
    wall.cut_path(centres[: here + 1], radius)
    ahead = centres[here + 1] - centres[here]
    ahead /= np.linalg.norm(ahead)
    out = np.array([0.0, *CIRCUIT.profile.normal(way[here])])
    area, facing = (
        wall.copy().cut_path(centres[here] + [0 * one, 1e-9 * one], radius) / 1e-9
        for one in (ahead, out)
    )
    place = way[here : here + 1]
    assert engaged_areas(CIRCUIT, place, advance)[0] == pytest.approx(area, rel=close)
    if not advance:
        # Half a ray's spacing, by which the flat side of the half ellipse may be off, is 2 % of it.
        assert facing_areas(CIRCUIT, place)[0] == pytest.approx(facing, rel=0.02)


@pytest.mark.parametrize("advance", [0.04, 0.08])
def test_planned_feed_keeps_the_ground_of_the_front_within_its_limit(advance):
    limits = Limits(feed=0.1, acceleration=0.5, volume=1.5e-4)
    made = plan(CIRCUIT, limits, tolerance=1e-3, laps=2, advance=advance)
    rate = engaged_areas(CIRCUIT, made.places, advance) * np.gradient(made.reached, made.tick)
    assert rate.max() <= 1.03 * limits.volume
    assert rate.max() > 0.97 * limits.volume
    # By the bend at the centre alone the feed would be full up to where the invert begins.
    assert np.interp(INVERT - 0.01, made.s, made.feed) < 0.9 * limits.feed
