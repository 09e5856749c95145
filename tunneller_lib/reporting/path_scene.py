"""Paths on the torus in space, as meshes with their looks."""

import numpy as np

from ..paths import project_chord
from .scene import ball, curve, surface
from .style import COLOURS


def projected(torus, p, q, steps, limits, geodesic=None):
    """Return a chord, its projection onto the torus step by step, and the patch that it is on.

    Parameters
    ----------
    torus : Torus
        The surface, in m.
    p, q : (2,) float
        Joint positions (theta, phi) of the ends, in rad.
    steps : int
        Equal steps along the chord.
    limits : (2, 2) float
        The patch: least and greatest theta, least and greatest phi.
    geodesic : Geodesic, optional
        Drawn too.

    Returns
    -------
    parts : list of (mesh, dict)
        Each mesh with the arguments for ``Plotter.add_mesh``.
    """
    patch = torus.point(*np.meshgrid(*np.linspace(*np.transpose(limits), 80).T, indexing="ij"))
    fine = torus.point(*project_chord(torus, p, q, 200).T)
    dots = torus.point(*project_chord(torus, p, q, steps + 1).T)
    chord = dots[0] + np.linspace(0, 1, steps + 1)[:, None] * (dots[-1] - dots[0])
    blue, black = {"color": COLOURS["tangent sphere"]}, {"color": COLOURS["chord"]}
    sheet = {"color": COLOURS["torus"], "opacity": 0.45, "smooth_shading": True}
    parts = [(surface(patch), sheet), (curve(fine, 0.006), blue), (curve(chord, 0.004), black)]
    for m, n in zip(chord, dots, strict=True):
        parts += [(curve([m, n], 0.002), black), (ball(n, 0.013), blue)]
    if geodesic is not None:
        way = geodesic.points(200).point
        parts.append((curve(way, 0.006), {"color": COLOURS["geodesic"]}))
    return parts
