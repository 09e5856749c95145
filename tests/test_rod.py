"""Lines against rods: whole numbers as reference, hard lines by generator, properties."""

import numpy as np
import pytest

from exhibits.rod_cases import GENERATORS
from tests.audit.long import many
from tests.shapes import EPS
from tests.test_equations_rod import distance_outside
from tunneller_lib.surfaces import Rod
from tunneller_lib.surfaces.rod import meet_rods
from tunneller_lib.surfaces.rod_interval import frame

MANY = many(40_000, 400_000)  # lines a generator and kind of ends; the report says so: test_words
every_generator = pytest.mark.parametrize("lines_of", GENERATORS, ids=lambda g: g.__name__)
every_end = pytest.mark.parametrize("ends", ["flat", "round"])
TOUCHING = {"whole_rims", "far_rims", "tangents", "end_planes", "rim_tangents", "along_an_axis"}


def margin(a, b, radius, p, u):
    """Return by how much the docstring lets a rod's surface be off."""
    return 64 * EPS * (radius + frame(a.T, b.T, u.T).run)


@every_end
@every_generator
def test_meet_rods_of_many_hard_lines(lines_of, ends):
    # Each of these lines meets its rod, as whole numbers say, and its two ends are on the surface.
    lines = lines_of(np.random.default_rng(2), MANY)
    a, b, radius, p, u = lines
    enter, leave = meet_rods(*lines, ends=ends)
    hit = enter <= leave
    assert hit.all() or lines_of.__name__ not in TOUCHING
    assert np.all((enter == np.inf) & (leave == -np.inf) | hit)
    speed = np.linalg.norm(u, axis=-1)
    farther = np.where(hit, np.maximum(np.abs(enter), np.abs(leave)), 0)
    whole = radius + np.linalg.norm(b - a, axis=-1)
    slack = 16 * EPS * np.maximum(whole, farther * speed) + margin(*lines)
    for t in (enter, leave):
        off = distance_outside(a, b, radius, p + np.where(hit, t, 0)[:, None] * u, ends)
        # The point itself is rounded at the size of its coordinates.
        noise = 16 * EPS * (np.abs(p).max(axis=-1) + np.abs(np.where(hit, t, 0)) *
                            np.abs(u).max(axis=-1))  # fmt: skip
        assert np.all(np.abs(off[hit]) <= (slack + noise)[hit])


def test_meet_line_touches_the_rim_of_a_nearly_vertical_rod_where_it_is():
    axis = (-3.8534266197128644e-14, 3.084093971681962e-14, 16.978424326584722)
    rod = Rod((0, 0, 0), axis, 0.08605578297597163)
    point = (-0.07904269999452951, 0.03402718561959727, 16.978424326584722)
    enter, leave = rod.meet_line(point, (0, 0, 1.0))
    assert enter <= leave <= 1e-14


def test_meet_line_of_a_rod_shorter_than_its_rounding_keeps_to_its_disc():
    # A disc tilted by half a right angle: its shadow is as wide as 0.7071.
    rod = Rod((0, 0, 0), (1e-15, 0, 1e-15), 1.0)
    enter, leave = rod.meet_line((0.9, 0, 0), (0, 0, 1.0))
    assert leave < enter
    enter, leave = rod.meet_line((0.7, 0, 0), (0, 0, 1.0))
    assert enter == pytest.approx(-0.7) and leave == pytest.approx(-0.7)
