"""Four ways of meeting rods with lines, that of the library among them: Line and finite cylinder.

Each of `METHODS` takes rods with flat ends and a line each, and answers as `meet_rods` does. The
three that the document weighs against its own solve the printed quadratic, whose
leading coefficient vz^2 - vsq cancels for lines along the axis. Its discriminant is of the sixth
order in lengths and leaves the range of floats for rods below 1e-50 m or above 1e50 m.
"""

import numpy as np

from tunneller_lib.kernels.exact import dot, norm
from tunneller_lib.surfaces.rod import meet_rods

EPSILON = 0.00001  # as printed; once a share of the length, once a length


def crossings(a, b, radius, point, direction, *, epsilon=0.0):
    """Return where lines cross the three surfaces, each on its own, and which crossings count.

    Parameters
    ----------
    a, b : (..., 3) float
        Ends of the axes, in m.
    radius : (...) float
        Of the rods, whose ends are flat, in m.
    point, direction : (..., 3) float
        One point of each line, in m, and its direction.
    epsilon : float
        By how much the three surfaces are extended.

    Returns
    -------
    t : (4, ...) float
        Wall, wall, disc at a, disc at b; in lengths of the direction.
    accepted : (4, ...) bool
        Whether the surface reaches that far.
    """
    q, v, vsq, vz, vq, along, shift, speed = _setting(a, b, point, direction)
    wide = radius + epsilon
    with np.errstate(all="ignore"):
        low, high, _ = _wall(q, vsq, vz, vq, radius)
        za = -vq / vz
        zb = (vsq - vq) / vz
        shares = [(vq + vz * z) / vsq for z in (low, high)]  # of the axis, m in the document
        accepted = [(-epsilon <= share) & (share <= 1 + epsilon) for share in shares]
        for z, centre in ((za, 0.0), (zb, v)):
            off = q + z[..., None] * along - centre
            accepted.append(wide * wide >= dot(off, off))
        t = (np.stack(np.broadcast_arrays(low, high, za, zb)) - shift) / speed
    return t, np.stack(np.broadcast_arrays(*accepted))


def three_surfaces(a, b, radius, point, direction, *, epsilon=0.0):
    """Return `enter` and `leave`, the least and the greatest of the `crossings` that count.

    "The cylinder considered as independent surfaces", with the parentheses that its zb lacks;
    arguments a, b, radius, point, direction and epsilon as of `crossings`.
    """
    t, accepted = crossings(a, b, radius, point, direction, epsilon=epsilon)
    enter = np.min(np.where(accepted, t, np.inf), axis=0)
    return enter[()], np.max(np.where(accepted, t, -np.inf), axis=0)[()]


def epsilon_fix(a, b, radius, point, direction):
    """Return `enter` and `leave` with the document's "epsilon fix" of `three_surfaces`.

    Arguments a, b, radius, point and direction as there.
    """
    return three_surfaces(a, b, radius, point, direction, epsilon=EPSILON)


def slab(a, b, radius, point, direction):
    """Return `enter` and `leave` as the interval of the endless cylinder within the two planes.

    "The finite cylinder expressed as an intersection of two volumes"; arguments a, b, radius,
    point and direction as of `three_surfaces`.
    """
    q, _, vsq, vz, vq, _, shift, speed = _setting(a, b, point, direction)
    with np.errstate(all="ignore"):
        low, high, inside = _wall(q, vsq, vz, vq, radius)
        low = np.where(inside, -np.inf, low)
        high = np.where(inside, np.inf, high)
        za = -vq / vz
        zb = (vsq - vq) / vz
        # A line that is level with the planes is between them everywhere or nowhere.
        level = (vz == 0) & (0 <= vq) & (vq <= vsq)
        first = np.where(level, -np.inf, np.minimum(za, zb))
        last = np.where(level, np.inf, np.maximum(za, zb))
        enter = np.maximum(low, first)
        leave = np.minimum(high, last)
        hit = (enter <= leave) & (vsq > 0)  # a rod of no length is empty
    enter = np.where(hit, (enter - shift) / speed, np.inf)
    return enter[()], np.where(hit, (leave - shift) / speed, -np.inf)[()]


METHODS = {
    "exact": meet_rods,
    "slab": slab,
    "three-surfaces": three_surfaces,
    "epsilon": epsilon_fix,
}


def _setting(a, b, point, direction):
    """Return q across the line, v, vsq, vz, vq, the unit direction, its way to p, and its speed.

    The letters are the document's.
    """
    direction = np.asarray(direction, dtype=float)
    speed = norm(direction)
    along = direction / speed[..., None]
    q = np.subtract(point, a)
    shift = dot(q, along)
    q = q - shift[..., None] * along
    v = np.subtract(b, a)
    return q, v, dot(v, v), dot(along, v), dot(q, v), along, shift, speed


def _wall(q, vsq, vz, vq, radius):
    """Return both roots of the printed quadratic, and whether it has none but holds everywhere."""
    A = vz * vz - vsq  # as printed: it cancels along the axis, the fault that is shown here
    B = vq * vz
    C = vq * vq + radius * radius * vsq - dot(q, q) * vsq
    root = np.sqrt(B * B - A * C)
    return (-B + root) / A, (-B - root) / A, (A == 0) & (C >= 0)
