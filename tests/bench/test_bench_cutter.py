"""Cutters lowered onto a mesh: how fast, and where opencamlib's heights differ.

Both lower the same cutters at the same places onto the same triangles, each by one call for all
places, with one thread; opencamlib's tree of triangles is made beforehand.
"""

import numpy as np
import pytest

from tests.bench.conftest import best_times
from tunneller_lib.surfaces import Frustum, Rod, RoundedDisc, drop_cutter

RADIUS, LENGTH, CORNER, HALF_ANGLE = 3.0, 20.0, 1.0, 1.03  # mm and rad
HEIGHT = RADIUS / np.tan(HALF_ANGLE)
SIDE, PLACES = 100, 500
OURS = {
    "ball": [Rod((0, 0, RADIUS), (0, 0, LENGTH - RADIUS), RADIUS, ends="round")],
    "flat": [Rod((0, 0, 0), (0, 0, LENGTH), RADIUS)],
    "bull": [
        RoundedDisc((0, 0, CORNER), (0, 0, 1), RADIUS - CORNER, CORNER),
        Rod((0, 0, CORNER), (0, 0, LENGTH), RADIUS),
    ],
    "cone": [
        Frustum((0, 0, 0), (0, 0, HEIGHT), 0, RADIUS),
        Rod((0, 0, HEIGHT), (0, 0, LENGTH), RADIUS),
    ],
}


def ground():
    """Return corners and triangles of waves, and places."""
    along = np.linspace(-20, 20, SIDE)
    x, y = np.meshgrid(along, along, indexing="ij")
    points = np.stack([x, y, 2 * np.sin(x / 3) * np.cos(y / 4)], axis=-1).reshape(-1, 3)
    number = np.arange(SIDE**2).reshape(SIDE, SIDE)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = [np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))]
    return points, np.concatenate(faces), np.random.default_rng(0).uniform(-15, 15, (PLACES, 2))


@pytest.mark.parametrize("package", ["opencamlib"])
@pytest.mark.parametrize("name", OURS)
def test_cutters_against_opencamlib(installed, benchmark, say, name):
    points, faces, places = ground()
    peers = {
        "ball": installed.BallCutter(2 * RADIUS, LENGTH),
        "flat": installed.CylCutter(2 * RADIUS, LENGTH),
        "bull": installed.BullCutter(2 * RADIUS, CORNER, LENGTH),
        "cone": installed.ConeCutter(2 * RADIUS, HALF_ANGLE, LENGTH),
    }
    surface = installed.STLSurf()
    for face in faces:
        corners = [installed.Point(*map(float, points[i])) for i in face]
        surface.addTriangle(installed.Triangle(*corners))
    heights = []

    def theirs():
        run = installed.BatchDropCutter()
        run.setSTL(surface)
        run.setCutter(peers[name])
        run.setThreads(1)
        for x, y in places:
            run.appendPoint(installed.CLPoint(float(x), float(y), -100.0))
        run.run()
        heights[:] = [point.z for point in run.getCLPoints()]

    def ours():
        return drop_cutter(OURS[name], points, places, faces=faces)

    benchmark.pedantic(ours, rounds=1)
    time, other = best_times(ours, theirs, rounds=3)
    say(f"{name}, time over opencamlib's", time / other, "opencamlib")
    lower = ours() - heights
    say(f"{name}, opencamlib's heights lower by up to / mm", lower.max(), "opencamlib")
    say(f"{name}, opencamlib's heights higher by up to / mm", -lower.min(), "opencamlib")
    assert np.max(-lower) < 1e-9  # ours are never too low
    assert name == "cone" or np.max(lower) < 1e-9
