"""What a ball takes and where a rod is met: by slices, sums and searches."""

import numpy as np

from tests.independent.section import BALL, DEPTH, HALF, INSIDE

READS = ["report/numbers/*.json"]

ADVANCE = 0.01  # m, along the path
V = "$V$ / cm³"


def groove(wall=np.inf, pitch=None, count=200_001):
    """Return the ground, m^3, that a metre of the path takes behind a wall bent about its radius.

    In slices across the way, each a ring between the wall, or what an earlier pass left, and
    the circle in which the ball is cut.
    """
    x = np.linspace(-BALL, BALL, count)
    reach = np.sqrt(np.maximum(BALL**2 - x**2, 0))
    earlier = np.sqrt(np.maximum(BALL**2 - (x - pitch) ** 2, 0)) if pitch else 0 * x
    near = np.maximum(BALL - DEPTH, earlier)
    thick = np.maximum(reach - near, 0)
    middle = (near + reach) / 2
    path = wall - (BALL - DEPTH)  # radius of the centre's way
    return np.sum(thick * (1 + middle / path)) * (x[1] - x[0])


def test_volumes_of_the_groove(printed):
    rows = {
        "plane wall": {},
        "roof, $W = a$": {"wall": HALF},
        "wall, $W = 3a$": {"wall": 3 * HALF},
        "invert, $W = a\\/2$": {"wall": HALF / 2},
        "roof, passes 50 mm apart": {"wall": HALF, "pitch": 0.05},
        "roof, passes 20 mm apart": {"wall": HALF, "pitch": 0.02},
    }
    for row, how in rows.items():
        assert 1e6 * ADVANCE * groove(**how) == printed("32_volume", "volumes", row, V)


def test_printed_volume_over_the_grooves(printed):
    """The document's cylinder about two balls, times the sector's angle, beside the slices."""
    angle = 2 * np.arccos((BALL - DEPTH) / BALL)
    cylinder = np.pi * BALL**2 * ADVANCE
    taken = ADVANCE * groove()
    assert 1e6 * angle * cylinder == printed("32_volume", "volumes", "as printed", V)
    assert angle * cylinder / taken == printed("32_volume", "printed over exact")
    assert angle * BALL**2 / 2 / groove() == printed("32_volume", "sector over exact")


def test_advance_that_takes_the_wanted_volume(printed):
    assert 1e3 * 20e-6 / groove() == printed("32_volume", "advance for the wanted volume")


def test_closed_form_of_a_lap_in_whole_ground(printed):
    """The groove of each arc's bend times the way of the centre along it."""
    bends = {HALF: np.pi, 3 * HALF: 2 * np.arctan2(1.5, 2), HALF / 2: 2 * np.arctan2(2, 1.5)}
    litres = sum(1e3 * turn * (wall - INSIDE) * groove(wall) for wall, turn in bends.items())
    assert litres == printed("32_volume", "closed form")


def test_what_decides_how_far_a_box_is_lowered_onto_a_leaning_rod(printed):
    """The highest place of a rod under each of many boxes: over a corner, its own, or on a side.

    The axis leans by 3 in 4. Over a place (x, y) the rod is between two lines along its side, w
    away from the axis, and between the planes of its ends.
    """
    radius, long, ax, az = 25.0, 150.0, 0.6, 0.8

    def between(x, y):
        w = np.sqrt(np.maximum(radius**2 - y**2, 0))
        top = np.minimum((x * az + w) / ax, (long - x * ax) / az)
        bottom = np.maximum((x * az - w) / ax, -x * ax / az)
        return np.where((bottom <= top) & (np.abs(y) <= radius), top, -np.inf)

    x, y = np.meshgrid(np.arange(-50, 141, 0.5) + 0.123, np.arange(-45, 46, 0.5) + 0.123)
    # Nearest to the axis it is highest, and along it where side and end meet.
    aside = np.clip(0, y - 10, y + 10)
    ridge = long * ax - az * np.sqrt(np.maximum(radius**2 - aside**2, 0))
    top = between(np.clip(ridge, x - 15, x + 15), aside)
    corners = np.max([between(x + i, y + j) for i in (-15, 15) for j in (-10, 10)], axis=0)
    met = np.isfinite(top)
    own = met & (top >= between(90 - radius * az, 0) - 1e-9)
    corner = met & ~own & (top <= corners + 1e-9)
    for name, found in (("own", own), ("corner", corner), ("side", met & ~own & ~corner)):
        share = 100 * found.sum() / met.sum()
        assert share == printed("31_rod", f"decides, {name}")
