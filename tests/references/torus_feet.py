"""Write torus_feet.csv: tangent-sphere feet of hard points, by mpmath at 50 digits.

    python -m tests.references.torus_feet

Each foot is checked here against Eq. 2 and against the parallelism of MN and the gradient, so the
table doesn't rest on the construction alone.
"""

import random
from pathlib import Path

from mpmath import mp, mpf

from tests.references import tables

TABLE = Path(__file__).with_suffix(".csv")
COLUMNS = ["family", "r", "R", "m1", "m2", "m3"]
COLUMNS += [f"{foot}{i}" for foot in ("pp", "pm", "mp", "mm") for i in (1, 2, 3)]


def feet(r, R, m):
    """Return the four feet (+,+), (+,-), (-,+), (-,-) in mpmath's numbers.

    The normals of a torus pass through its ring, so a foot is at the distance R on the line from M
    through one of the two ring points in M's meridian plane.
    """
    r, R, x, y, z = map(mpf, (r, R, *m))
    turn = r / mp.sqrt(x * x + z * z)
    found = []
    for ring in (turn, -turn):
        cx, cz = ring * x, ring * z
        dx, dz = x - cx, z - cz
        scale = R / mp.sqrt(dx * dx + y * y + dz * dz)
        dx, dy, dz = dx * scale, y * scale, dz * scale
        found += [(cx + dx, dy, cz + dz), (cx - dx, -dy, cz - dz)]
    return found


def residual(r, R, m, n):
    """Return by how much, relatively, N is off Eq. 2 and MN off the gradient of Eq. 2 there."""
    r, R = mpf(r), mpf(R)
    sphere = sum(c * c for c in n) - r * r - R * R
    off = sphere**2 - 4 * r**2 * (R**2 - n[1] ** 2)
    gradient = (sphere * n[0], (sphere + 2 * r * r) * n[1], sphere * n[2])
    mn = [a - mpf(b) for a, b in zip(n, m, strict=True)]
    pairs = [(0, 1), (1, 2), (2, 0)]
    skew = max(abs(mn[i] * gradient[j] - mn[j] * gradient[i]) for i, j in pairs)
    size, far = r + R, mp.sqrt(sum(mpf(c) ** 2 for c in m)) + r + R
    return max(abs(off) / size**4, skew / (size**3 * far))


def cases(rng, count=40):
    """Yield family, r, R, m: hard places of all proportions and scales."""

    def log(low, high):
        return 10 ** rng.uniform(low, high)

    def direction():
        v = [rng.gauss(0, 1) for _ in range(3)]
        return [c / sum(c * c for c in v) ** 0.5 for c in v]

    def on_ring(r, offset):
        turn, v = rng.uniform(-mp.pi, mp.pi), direction()
        ring = (r * mp.cos(turn), 0, -r * mp.sin(turn))
        return [float(a + offset * b) for a, b in zip(ring, v, strict=True)]

    for _ in range(count):
        r, R = log(-1, 0), log(-1, 1)
        m = [rng.uniform(-2, 2) for _ in range(3)]
        yield "random", r, R, m
        yield "thin tube", 1.0, log(-4, -1), on_ring(1.0, log(-4, 0))
        yield "fat spindle", 1.0, log(2, 4), [log(2, 4) * c for c in direction()]
        yield "horn", 1.0, 1.0, m
        scale = log(-3, 6)
        yield "scales", r * scale, R * scale, [c * scale for c in m]
        yield "far point", r, R, [R * log(1, 6) * c for c in direction()]
        yield "near ring circle", r, R, on_ring(r, r * log(-9, -2))
        tilt, height = log(-12, -3), rng.uniform(-3, 3)
        yield "near axis", r, R, [tilt * rng.gauss(0, 1), height, tilt * rng.gauss(0, 1)]
        R = r * (1 + log(-2, 2))
        node, gap = (R * R - r * r) ** 0.5, log(-12, -2)
        m = [gap * c for c in direction()]
        yield "near node", r, R, [m[0], m[1] + rng.choice([-1, 1]) * node, m[2]]
        yield "near centre", r, log(-1, 1), [log(-12, -3) * c for c in direction()]


def rows():
    """Yield the rows of the table."""
    mp.dps = 50
    for family, r, R, m in cases(random.Random(20)):
        found = feet(r, R, m)
        worst = max(residual(r, R, m, n) for n in found)
        if worst > mpf("1e-40"):
            raise ArithmeticError(f"{family}: feet are off by {mp.nstr(worst, 3)}.")
        yield [family, *map(repr, (r, R, *m)), *(mp.nstr(c, 20) for n in found for c in n)]


if __name__ == "__main__":
    tables.write(TABLE, COLUMNS, rows())
