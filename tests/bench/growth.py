"""Draw growth.svg, by the tables geodesic_growth.csv and times.csv: what many at once cost.

python -m tests.bench.growth

`make bench` does so, too.
"""

import csv
from pathlib import Path

from kit import COLOURS, figure
from kit.record import drawing_svg
from tests.bench import times

GEODESICS = Path(__file__).with_name("geodesic_growth.csv")
PICTURE = Path(__file__).with_name("growth.svg")
LIMIT = 64.0  # bytes for a pair
# Works of times.csv by their labels, with the label's shift in points; geodesics on the sheet have
# a table of their own.
WORKS = {
    "any lines against a rod, compiled": ("lines, rod", (4, -3)),
    "ball swept through 400 x 720 rays, compiled": ("swept balls", (-40, 7)),
    "hyperosculating cones of a blade, in space": ("cones", (-96, -34)),
}
COLOURED = ["corrected", "tangent sphere", "correct"]


def growth():
    """Return numbers of pairs, seconds, and bytes beside the arguments, three lists of float."""
    with GEODESICS.open(encoding="utf-8", newline="") as file:
        _, *rows = csv.reader(file)
    return [[float(row[column]) for row in rows] for column in range(3)]


def of_works():
    """Return numbers at once and seconds for all of them, by the name of each of `WORKS`."""
    found = {}
    for row in times.read():
        if row["work"] in WORKS:
            counts, seconds = found.setdefault(row["work"], ([], []))
            counts.append(int(row["n"]))
            seconds.append(int(row["n"]) * float(row["here_s"]))
    return found


def draw():
    """Return the figure: time on the left, memory on the right."""
    drawing, (left, right) = figure(1, 2, height=7, gridspec_kw={"width_ratios": [3, 2]})
    pairs, seconds, memory = growth()
    for (work, line), colour in zip(of_works().items(), COLOURED, strict=True):
        label, shift = WORKS[work]
        left.loglog(*line, "s--", color=COLOURS[colour], ms=3)
        _name(left, label, line, colour, shift)
    left.loglog(pairs, seconds, "o-", color=COLOURS["geodesic"], ms=4)
    _name(left, "geodesics, sheet", (pairs, seconds), "geodesic", (-84, -8))
    left.set(xlabel="at once", ylabel="processor time / s", xlim=(0.7, 3e8))
    left.set_xticks([1, 1e2, 1e4, 1e6])
    held = [(n, size) for n, size in zip(pairs, memory, strict=True) if size]
    counts, sizes = zip(*held, strict=True)
    right.loglog(counts, sizes, "o-", color=COLOURS["geodesic"], ms=4)
    _name(right, "geodesics, sheet", (counts, sizes), "geodesic", (-56, -80))
    limit = counts, [LIMIT * n for n in counts]
    right.loglog(*limit, ":", color=COLOURS["chord"])
    _name(right, f"{LIMIT:.0f} B for each", limit, "chord", (-80, -4))
    right.set(xlabel="pairs at once", ylabel="memory beside the arguments / B")
    for ax in (left, right):
        ax.grid(True)
    return drawing


def _name(ax, text, line, colour, shift):
    end = line[0][-1], line[1][-1]
    look = {"fontsize": 8, "color": COLOURS[colour]}
    ax.annotate(text, end, shift, textcoords="offset points", **look)


def write():
    PICTURE.write_bytes(drawing_svg(draw()))


if __name__ == "__main__":
    write()
