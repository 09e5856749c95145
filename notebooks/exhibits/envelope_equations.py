"""The document's Eq. 4, term by term, as printed and as mended, and the noise of Example 32."""

import numpy as np

from tunneller_lib.envelopes.isotropic import normal, surface_points


def eq04_terms(f, *, printed=False):
    """Return the terms of Eq. 4 (13, ...), whose sum is 0 where a line lies in the graph of `f`.

    `f` is a jet. Nine terms are mended: as `printed` each of them has lost or changed an index of
    a third derivative.
    """
    a, b, c = (f.derivative(2 - i, i) for i in range(3))
    k, l, m, n = (f.derivative(3 - i, i) for i in range(4))  # noqa: E741
    l1, m1 = (b, b) if printed else (l, m)
    l2 = k if printed else l
    terms = [
        c**3 * k**2,
        6 * c * k * n * b * a,
        -6 * c**2 * k * m1 * a,
        -6 * n * m1 * a**2 * b,
        9 * c * m1**2 * a**2,
        -6 * b * c**2 * l1 * k,
        12 * b**2 * l1 * n * a,
        -18 * b * c * l1 * (n if printed else m) * a,
        12 * c * m1 * b**2 * k,
        -8 * n * b**3 * k,
        9 * a * c**2 * l1**2,
        -6 * c * l2 * n * a**2,
        n**2 * a**3,
    ]
    return np.stack(terms)


def tilted(n, turn, rng):
    """Return unit normals (..., 3), each turned in a random direction as Example 32 turns them.

    The `turn` is the document's r, the tangent of the angle.
    """
    # A normally distributed vector has no preferred direction, nor has its product about n.
    aside = np.cross(rng.normal(size=n.shape), n)
    n = n + turn * aside / np.linalg.norm(aside, axis=-1, keepdims=True)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def noisy_planes(f, place, rng, *, turn, count, reach):
    """Return contact points of a graph's planes about a place, and their normals with noise.

    Parameters
    ----------
    f : callable
        Of x and y, in m.
    place : (2,) float
        The middle of the disk of the model over which the planes lie.
    rng : numpy.random.Generator
        Draws places and turns.
    turn : float
        Of each normal, as for `tilted`.
    count : int
        How many planes.
    reach : float
        Radius of the disk.

    Returns
    -------
    contact : (count, 3) float
        Where the planes touch the surface before they turn, in m.
    n : (count, 3) float
        Unit normals.
    """
    angle = 2 * np.pi * rng.random(count)
    away = reach * np.sqrt(rng.random(count))
    x, y = np.array(place)[:, None] + away * np.array([np.cos(angle), np.sin(angle)])
    n = np.stack(normal(x, y), axis=-1)
    return surface_points(f, x, y), tilted(n, turn, rng)
