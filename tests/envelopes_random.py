"""Random surfaces of each class and near-misses of them, by a seed, for the recognisers.

A near-miss is a member with a bump of a ten-thousandth of its size or more, or with a tool that
grows as it moves, or a surface of another class.
"""

import numpy as np

from tunneller_lib.envelopes.adapted import adapted_frames
from tunneller_lib.envelopes.families import channel, moving_cone, ruled
from tunneller_lib.envelopes.jet import add, cross_product, times

KINDS = ("developable", "ruled", "cylinder", "channel", "pipe", "cone")


def curve(rng):
    """Return a random curve (point, first three derivatives), of frequencies below two."""
    waves = rng.uniform(0.4, 1.6, (3, 2))
    phases = rng.uniform(0, 2 * np.pi, (3, 2))
    sizes = rng.uniform(0.3, 1.0, (3, 2))
    drift = rng.normal(size=3)

    def derivative(s, k):
        parts = []
        for i in range(3):
            part = drift[i] * s if k == 0 else drift[i] * (k == 1) + 0 * s
            for wave, phase, size in zip(waves[i], phases[i], sizes[i], strict=True):
                part = part + size * wave**k * np.sin(wave * s + phase + k * np.pi / 2)
            parts.append(part)
        return parts

    return derivative


def frame(rng):
    """Return a random turning frame and its angular velocity, as `moving_cone` takes them."""
    lean = rng.uniform(0.3, 1.2)
    rate, tilt = rng.uniform(0.4, 1.0, 2)
    start = rng.uniform(0, 2 * np.pi, 2)

    def turning(v):
        # Two turns: about z by rate v + start, then about the turned first axis by tilt v.
        c, d = np.cos(rate * v + start[0]), np.sin(rate * v + start[0])
        g, h = np.cos(tilt * v + start[1]), np.sin(tilt * v + start[1])
        one = [c, d, 0 * v]
        three = [d * h, -c * h, g]
        mixed = add(times(np.cos(lean), three), times(np.sin(lean), one))
        across = add(times(-np.sin(lean), three), times(np.cos(lean), one))
        omega = add(times(tilt, one), [0 * v, 0 * v, rate + 0 * v])
        return (mixed, across, cross_product(mixed, across)), omega

    return turning


def member(kind, rng):
    """Return a random member of a class; more options make it a near-miss."""
    path = curve(rng)
    if kind == "developable":
        return lambda s, t: add(path(s, 0), times(1.5 + t, path(s, 1))), {}
    if kind in ("ruled", "cylinder"):
        other = curve(rng)
        offset = rng.uniform(0.1, 0.5) if kind == "cylinder" else 0.0

        def lines(s):
            return path(s, 0), path(s, 1), other(s, 1), other(s, 2)

        return ruled(lines, offset=offset), {"lines": lines}
    if kind in ("channel", "pipe"):
        radius = rng.uniform(0.1, 0.5)
        growth = rng.uniform(0.05, 0.15) if kind == "channel" else 0.0

        def spine(s):
            return path(s, 0), path(s, 1), path(s, 2)

        return channel(spine, radius, growth=growth), {"spine": spine, "radius": radius}
    turning = frame(rng)
    half_angle = rng.uniform(0.15, 0.9)

    def motion(v):
        axes, omega = turning(v)
        return path(v, 0), path(v, 1), axes, omega

    return moving_cone(motion, half_angle), {"motion": motion, "half_angle": half_angle}


def bumped(surface, size, rng):
    """Return a surface with a smooth bump along a fixed direction."""
    way = rng.normal(size=3)
    way = size * way / np.linalg.norm(way)
    a, b, c, d = rng.uniform(0.8, 2.0, 4)

    def moved(s, t):
        bump = np.sin(a * s + 1) * np.cos(b * t + c) + 0.5 * np.sin(d * t * s)
        return add(surface(s, t), [bump * k for k in way])

    return moved


def near_miss(kind, rng):
    """Return a surface that isn't of a class, and in which way."""
    surface, data = member(kind, rng)
    way = rng.choice(["bump", "small bump", "grown", "other"])
    if way == "grown" and kind == "cone":
        return moving_cone(data["motion"], data["half_angle"], rate=rng.uniform(0.05, 0.3)), way
    if way == "grown" and kind == "pipe":
        return channel(data["spine"], data["radius"], growth=rng.uniform(0.02, 0.1)), way
    if way == "other":
        # Of the next class: none that contains it (a pipe is a channel and enveloped by cylinders).
        others = {"developable": "ruled", "ruled": "cone", "cylinder": "cone", "channel": "cone",
                  "pipe": "cone", "cone": "cylinder"}  # fmt: skip
        return member(others[kind], rng)[0], way
    size = 10.0 ** rng.uniform(-2, -1) if way == "bump" else 10.0 ** rng.uniform(-4, -2)
    return bumped(surface, size, rng), "bump" if way == "bump" else "small bump"


def placed(surface, rng, scale):
    """Return a surface turned at random, moved and scaled."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = rng.normal(size=3)

    def moved(s, t):
        r = surface(s, t)
        return [scale * (sum(turn[i, k] * r[k] for k in range(3)) + shift[i]) for i in range(3)]

    return moved


def window(surface, rng, size):
    """Return 20 points in a window of the parameters where the surface keeps its side.

    Across its edge of regression an envelope turns back, and its normals jump.
    """
    while True:
        s0, t0 = rng.uniform(-0.5, 0.5, 2)
        s, t = s0 + size * rng.uniform(-0.5, 0.5, 20), t0 + size * rng.uniform(-0.5, 0.5, 20)
        n = adapted_frames(surface, s, t, "space").axes[:, 2]
        if np.min(n @ n.mean(axis=0)) > 0.1:
            return s, t
        size = size / 2
