"""Ways on the torus as they lie in space."""

import numpy as np

from kit import scene
from tunneller_lib.paths import geodesic_inverse, project_chord

GAUGE = 0.007  # m, radius of what is drawn of a curve
FROM_THE_SIDE = 0.7, -1.6, 0.5  # towards the camera


def three_ways_in_space(torus, p, q, *, exaggeration):
    """Return a picture of the chord, the geodesic and the projected chord between two corners.

    Parameters
    ----------
    torus : Torus
        The surface, in m; the patch between the corners is drawn.
    p, q : (2,) float
        The corners: theta and phi in rad.
    exaggeration : float
        How many times too far beside the geodesic the projected chord is drawn.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    curve = geodesic_inverse(torus, p, q).points(201)
    beside = curve.deviation(project_chord(torus, p, q, 201))
    normal = torus.normal(*np.moveaxis(curve.position, -1, 0))
    across = np.cross(normal, curve.tangent)
    wide = torus.foot(curve.point + exaggeration * beside[:, None] * across)
    chord = torus.point(*np.transpose([p, q]))
    plotter = scene.empty()
    angles = [np.linspace(a, b, n) for a, b, n in zip(p, q, (80, 60), strict=True)]
    patch = scene.surface(torus.point(*np.meshgrid(*angles, indexing="ij")))
    scene.put(plotter, patch, "torus", opacity=0.5)
    ways = {"geodesic": curve.point, "tangent sphere": wide, "chord": chord}
    for colour, points in ways.items():
        scene.put(plotter, scene.curve(points, GAUGE), colour)
    letters = {
        "$P$": (chord[0], (-0.7, 0.3)),
        "$Q$": (chord[-1], (0.5, -0.7)),
        "chord": (chord.mean(axis=0), (-1.8, -0.5)),
        "geodesic": (curve.point[60], (1.0, 0.9)),
        f"projected, aside × {exaggeration:g}": (wide[80], (-2.5, -2.0)),
    }
    direction = (1.4, -1.0, -0.5)
    return scene.shoot(plotter, direction=direction, zoom=1.0, letters=letters, width=7.4)


def projected_chord(torus, p, q, *, low, high, steps, geodesic=False):
    """Return a scene of a chord, its projection step by step, and the patch that it is on.

    Parameters
    ----------
    torus : Torus
        The surface, in m.
    p, q : (2,) float
        Ends of the chord: theta and phi in rad.
    low, high : (2,) float
        Corners of the patch, in rad.
    steps : int
        Of equal length along the chord.
    geodesic : bool
        Whether the geodesic is drawn, too.

    Returns
    -------
    plotter : pyvista.Plotter
        The scene, its camera set.
    """
    plotter = scene.empty()
    angles = [np.linspace(a, b, 80) for a, b in zip(low, high, strict=True)]
    patch = scene.surface(torus.point(*np.meshgrid(*angles, indexing="ij")))
    scene.put(plotter, patch, "torus", opacity=0.45, smooth_shading=True)
    path = torus.point(*project_chord(torus, p, q, 200).T)
    scene.put(plotter, scene.curve(path, 0.006), "tangent sphere")
    dots = torus.point(*project_chord(torus, p, q, steps + 1).T)
    chord = dots[0] + np.linspace(0, 1, steps + 1)[:, None] * (dots[-1] - dots[0])
    scene.put(plotter, scene.curve(chord, 0.004), "chord")
    for m, n in zip(chord, dots, strict=True):
        scene.put(plotter, scene.curve([m, n], 0.002), "chord")
        scene.put(plotter, scene.ball(n, 0.013), "tangent sphere")
    if geodesic:
        way = geodesic_inverse(torus, p, q).points(200).point
        scene.put(plotter, scene.curve(way, 0.006), "geodesic")
    return scene.look(plotter, FROM_THE_SIDE)


def projected_chord_picture(torus, p, q, *, low, high, steps):
    """Return a picture of that scene with letters at its ends and at the fifth of its points.

    Parameters
    ----------
    torus, p, q, low, high, steps
        As of `projected_chord`.

    Returns
    -------
    picture : (n, m, 3) uint8
    """
    plotter = projected_chord(torus, p, q, low=low, high=high, steps=steps)
    start, stop = torus.point(*np.transpose([p, q]))
    n = torus.point(*project_chord(torus, p, q, steps + 1)[4])
    m = start + 4 / steps * (stop - start)
    letters = {
        "$P$": (start, (0, 0.8)),
        "$Q$": (stop, (0.2, -0.8)),
        "$M$": (m, (-0.9, -0.3)),
        "$N$": (n, (0.4, 0.9)),
    }
    return scene.shoot(plotter, direction=FROM_THE_SIDE, letters=letters, width=6.4)
