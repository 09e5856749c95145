"""Patches of surfaces that cones envelop on random motions, with mills that fit them."""

from dataclasses import replace

import numpy as np

from ..arguments import Angle, checked
from ..envelopes.families import moving_cone, turning
from ..kernels.exact import dot
from .patch import Patch
from .tools import ConicalMill

TRIED = 1000  # motions, of which about one in seventy gives such a patch
LOOKED = 7  # points of a patch each way
PATH = np.array([[0.020], [0.010], [0.005]])  # m, spread of a vertex' way by v, v^2 and v^3
ALONG = 0.005, 0.120  # m, from the vertices to the patch along the axes


@checked
def random_envelope(rng: np.random.Generator, *, opening: Angle = 0.0):
    """Return a patch that a cone envelops on a random motion, everywhere a saddle, and a mill.

    Parameters
    ----------
    rng : numpy.random.Generator
        Which draws the motion and the cone.
    opening : float
        By how much the cone's half-angle grows on its way, in rad. Then no mill envelops the patch.

    Returns
    -------
    patch : Patch
        With the cone on one side of it, from which the mill comes.
    mill : ConicalMill
        Of the cone's half-angle at first, longer than the patch is wide.

    Raises
    ------
    ValueError
        If none of many motions gives such a patch, as where the cone opens too far.

    Examples
    --------
    >>> patch, mill = random_envelope(np.random.default_rng(0))
    >>> bool(patch.saddle(*patch.parameters(5)).all())
    True
    """
    for _ in range(TRIED):
        path = rng.normal(size=(3, 3)) * PATH
        half_angle = rng.uniform(*np.radians((6, 20)))
        rate, start = rng.uniform(0.3, 1.0), rng.uniform(0.5, 1.5)
        u = rng.uniform(0, 2 * np.pi)
        motion = turning(*_way(path), 1.0, rate=rate, start=start)
        patch = Patch(moving_cone(motion, half_angle, rate=opening), (u, u + 1.2), (0, 1))
        found = _seen(patch, motion)
        if found:
            side, low, high = found
            width = np.tan(half_angle)
            mill = ConicalMill(half_angle, low * width, high - low, high * width, 0.030)
            return replace(patch, side=side), mill
    raise ValueError(f"opening: must leave saddles on one side of a cone; got {opening:g} rad.")


def _way(path):
    """Return functions of v that give a cubic way, by its coefficients (3, 3), and its velocity."""
    powers = range(1, 4)

    def vertex(v):
        return [sum(a * v**k for a, k in zip(column, powers, strict=True)) for column in path.T]

    def velocity(v):
        return [
            sum(k * a * v ** (k - 1) for a, k in zip(column, powers, strict=True))
            for column in path.T
        ]

    return vertex, velocity


def _seen(patch, motion):
    """Return the side of a patch on which its cones are and where a mill begins and ends, or None.

    These are heights above a cone's vertex, in m.
    """
    s, t = patch.parameters(LOOKED)
    mesh = patch.mesh(LOOKED)
    vertex, _, (axis, *_), _ = motion(t)
    vertex, axis = (np.stack(np.broadcast_arrays(*part), axis=-1) for part in (vertex, axis))
    along = dot(mesh - vertex, axis)
    if not ALONG[0] < along.min() <= along.max() < ALONG[1]:
        return None
    normal = np.cross(*np.gradient(mesh, axis=(0, 1)))
    sides = np.sign(dot(normal, vertex + along[..., None] * axis - mesh))
    if abs(sides.sum()) < sides.size or not patch.saddle(s, t).all():
        return None
    return int(sides.flat[0]), 0.7 * along.min(), 1.2 * along.max()
