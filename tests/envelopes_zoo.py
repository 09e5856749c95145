"""Surfaces that are known envelopes, six and more of each class, and negative controls.

All are functions of two variables in ordinary arithmetic, as `recognise` takes them.
"""

import numpy as np

from tunneller_lib.envelopes import families
from tunneller_lib.envelopes.families import channel, cubic, helicoid, helix, saddle, turning
from tunneller_lib.envelopes.jet import add, cross_product, times


def parabola(s):
    return [s, s * s / 2, 0 * s], [1 + 0 * s, s, 0 * s], [0 * s, 1 + 0 * s, 0 * s]


def ellipse(s):
    c, d = np.cos(s), np.sin(s)
    return [3 * c, 2 * d, 0 * s], [-3 * d, 2 * c, 0 * s], [-3 * c, -2 * d, 0 * s]


def wave(s):
    return [s, np.sin(s), 0 * s], [1 + 0 * s, np.cos(s), 0 * s], [0 * s, -np.sin(s), 0 * s]


def knot(s):
    c, d = np.cos(s), np.sin(s)
    return (
        [2 * c, d, np.sin(2 * s) / 2], [-2 * d, c, np.cos(2 * s)], [-2 * c, -d, -2 * np.sin(2 * s)],
    )  # fmt: skip


CURVES = {
    "helix": helix, "parabola": parabola, "ellipse": ellipse, "cubic": cubic, "wave": wave,
    "knot": knot,
}  # fmt: skip


def tangents(curve):
    """Return the tangent developable of a curve."""
    return lambda s, t: add(curve(s)[0], times(1 + t, curve(s)[1]))


def pipe(curve, radius, growth=0.0):
    """Return a channel surface on a curve, of radius + growth * s."""
    return channel(curve, radius, growth=growth)


def ruled(name, offset=0.0):
    """Return a skew ruled surface, or one at a constant distance along its normal."""
    return families.ruled(RULED[name], offset=offset)


def _hyperboloid(s):
    c, d = np.cos(s), np.sin(s)
    return [2 * c, d, 0 * s], [-2 * d, c, 0 * s], [-2 * d, c, 1.2 + 0 * s], [-2 * c, -d, 0 * s]


def _conoid(s):
    c, d = np.cos(s), np.sin(s)
    return [0 * s, 0 * s, 3 * np.sin(s)], [0 * s, 0 * s, 3 * np.cos(s)], [c, d, 0 * s], [
        -d, c, 0 * s]  # fmt: skip


def _binormals(s):
    c, v, a = cubic(s)
    return c, v, cross_product(v, a), cross_product(v, [0 * s, 0 * s, 1 + 0 * s])


def _strip(s):
    c, d, p, q = np.cos(s), np.sin(s), np.cos(s / 2), np.sin(s / 2)
    return [2 * c, 2 * d, 0 * s], [-2 * d, 2 * c, 0 * s], [p * c, p * d, q], [
        -q * c / 2 - p * d, -q * d / 2 + p * c, p / 2]  # fmt: skip


RULED = {
    "hyperboloid": _hyperboloid, "saddle": saddle, "helicoid": helicoid, "conoid": _conoid,
    "binormals": _binormals, "strip": _strip,
}  # fmt: skip


RATE = -0.25  # rad, by which a half-angle that varies grows with the time
MOTIONS = {
    "rotation": turning(lambda v: [2 * np.cos(v), 2 * np.sin(v), 0 * v],
                        lambda v: [-2 * np.sin(v), 2 * np.cos(v), 0 * v], 1.0),
    "screw": turning(lambda v: [2 * np.cos(v), 2 * np.sin(v), 0.7 * v],
                     lambda v: [-2 * np.sin(v), 2 * np.cos(v), 0.7 + 0 * v], 0.8),
    "straight": turning(lambda v: [0 * v, 3 * v, 0 * v],
                        lambda v: [0 * v, 3 + 0 * v, 0 * v], 1.2),
    "parabola": turning(lambda v: [v, v * v, 1 + 0 * v],
                        lambda v: [1 + 0 * v, 2 * v, 0 * v], 0.7, start=0.5),
    "cubic": turning(lambda v: [v, v * v / 2, v**3 / 3],
                     lambda v: [1 + 0 * v, v, v * v], 1.1, start=-0.7),
    "wave": turning(lambda v: [np.sin(v), 2 * v, np.cos(v)],
                    lambda v: [np.cos(v), 2 + 0 * v, -np.sin(v)], 0.9, start=1.5),
}  # fmt: skip


DEVELOPABLE = {
    **{f"tangents of the {name}": tangents(CURVES[name]) for name in ("helix", "cubic", "knot")},
    "cylinder": lambda s, t: [2 * np.cos(s), 2 * np.sin(s), t],
    "wavy cylinder": lambda s, t: [s, np.sin(s) + 0.5 * t, t + s],
    "cone": lambda s, t: [(2 + t) * np.cos(s), (2 + t) * np.sin(s), 1.5 * t],
    "skew cone": lambda s, t: [(2 + t) * s, (2 + t) * (s * s + 1), (2 + t) * np.sin(s)],
    "plane": lambda s, t: [s + t, s - t + 1, 2 * t],
}
GENERAL = {
    "quartic graph": lambda s, t: [s, t, s**2 - t**2 + 0.3 * s**3 * t + 0.2 * t**4],
    "sine graph": lambda s, t: [s, t, np.sin(s) * np.cos(2 * t) + 0.3 * s * t],
    "ellipsoid": lambda s, t: [3 * np.cos(s) * np.cos(t), 2 * np.sin(s) * np.cos(t), np.sin(t)],
}
GRID = tuple(a.ravel() for a in np.meshgrid(np.linspace(0.15, 0.75, 5), np.linspace(0.1, 0.6, 4)))
