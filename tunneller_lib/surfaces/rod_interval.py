"""A rod as lines of one direction see it, two ellipses and a rectangle."""

from typing import NamedTuple

import numpy as np

from ..exact import cross, dot, norm, two_product, two_sum

# Bound of the rounding here, in parts of the rod's size as the line sees it: s and m are sums of
# three products of numbers that carry at most six roundings each.
GUARD = 16 * np.finfo(float).eps


class Frame(NamedTuple):
    """An axis as lines of one direction see it, as arrays (...) and unit vectors (..., 3).

    `start` is the end that the lines pass first and the origin; `flat`, `across` and `along`
    are f, its perpendicular and z of the document, which has d for `run` and vz for `rise`.
    """

    start: np.ndarray
    flat: np.ndarray
    across: np.ndarray
    along: np.ndarray
    run: np.ndarray
    rise: np.ndarray
    length: np.ndarray
    speed: np.ndarray


def frame(a, b, direction):
    """Return the `Frame` of axes from a to b (..., 3) for directions (..., 3), none zero."""
    u, exponent = near_one(direction)
    turn = dot(b - a, u)[..., None] < 0
    start, end = np.where(turn, b, a), np.where(turn, a, b)
    v, v_low = two_sum(end, -start)
    size, length = norm(u), norm(v)
    # Nearly parallel vectors: their product to its last digits, with what b - a has rounded off.
    normal = cross(u, v) + np.cross(u, v_low)
    area = norm(normal)
    along = u / size[..., None]
    across = normal / np.where(area > 0, area, 1)[..., None]
    return Frame(
        start, np.cross(across, along), across, along, area / size, np.abs(dot(along, v)), length,
        np.ldexp(size, exponent),
    )  # fmt: skip


def near_one(v):
    """Return vectors (..., 3) over powers of two that bring them near 1, and their exponents.

    No digit changes, and the squares are in range.
    """
    exponent = np.frexp(np.max(np.abs(v), axis=-1))[1]
    return np.ldexp(v, -exponent[..., None]), exponent


def nearest_offset(start, along, speed, p, direction):
    """Return from `start` to lines' nearest points (..., 3), in m, and these points' parameters.

    Parameters: start and the lines' points p (..., 3), in m, unit vectors along them, their
    speeds, and their directions.
    """
    q, low = two_sum(p, -start)
    total = np.zeros(np.broadcast_shapes(q.shape[:-1], along.shape[:-1]))
    # The way back from a point 1e16 sizes away is off by a size: once more, from nearby.
    for _ in range(2):
        shift = -dot(q, along) / speed
        step, step_low = two_product(shift[..., None], direction)
        q, q_low = two_sum(q, step)
        q, low = two_sum(q, q_low + (step_low + low))
        total = total + shift
    return q, total


def nearest_point(axis, p, direction):
    """Return lines' points next to `axis.start` as s, m, z in its `Frame`, and their parameter.

    Parameters: axis, the points p (..., 3) and the direction of each line, in m.
    """
    q, shift = nearest_offset(axis.start, axis.along, axis.speed, p, direction)
    # Without a run the axis has no plane of its own: any length across will do.
    s = np.where(axis.run > 0, dot(q, axis.across), norm(q))
    return s, dot(q, axis.flat), dot(q, axis.along), shift


def flat_interval(run, rise, length, radius, s, m):
    """Return where lines are inside flat rods, along the lines from the plane through the start.

    Parameters
    ----------
    run, rise, length : (...) float
        Of the axes, in m, as in `Frame`.
    radius : (...) float
        Of the rods, in m.
    s, m : (...) float
        Where the lines lie across and along the axes, in m, counted from the start.

    Returns
    -------
    hit : (...) bool
        Whether the line meets the rod, decided in the plane across it.
    enter, leave : (...) float
        In m; meaningless where the line misses.
    """
    empty, across = length == 0, s
    guard, length, parallel, s = _sizes(run, length, radius, s, m)
    # A short rod is a disc, which such a run may tilt by any angle.
    parallel = parallel & (run * radius <= guard * length)
    s = np.where(parallel, s, np.abs(across))
    # A tilt too small to tell: on the end's disc it comes to less than the guard.
    level = ~parallel & (rise * radius <= guard * length)
    # The shadow is a rectangle, |s| <= r and 0 <= m <= run, with an ellipse about either end: a
    # disc seen at a slant, whose half width at s is k = rise/length sqrt(r^2 - s^2).
    wide = radius + guard
    k = rise / length * np.sqrt(np.maximum((wide - s) * (wide + s), 0))
    hit = (s <= wide) & (parallel | ((m >= -k - guard) & (m <= run + k + guard))) & ~empty
    # What the guard let in beyond the shadow is moved to its edge, where the formulas hold.
    m = np.where(parallel, m, np.clip(m, -k, run + k))
    # The product keeps the digits that r^2 - s^2 would lose near a tangent.
    w = np.sqrt(np.maximum((radius - s) * (radius + s), 0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # The endless wall is entered and left at middle -+ half. A line along the axis never
        # meets it: there the discs alone bound the interval.
        middle, half = m * rise / run, w * length / run
        first = np.where(parallel, -np.inf, middle - half)
        last = np.where(parallel, np.inf, middle + half)
        # The rod is inside the wall and between the discs' planes, where the way along the axis,
        # (run m + rise z) / length, is 0 and length. A level line stays between them.
        enter = np.where(level, first, np.maximum(first, -run * m / rise))
        leave = np.where(level, last, np.minimum(last, rise + run * (run - m) / rise))
    # A touch: disc and wall ought to agree, and rounding moves the one less than the other.
    disc = (run / length) ** 2 * w <= rise / length * radius
    touch = np.where((enter > first) == disc, enter, leave)
    crossed = leave < enter
    return hit, np.where(crossed, touch, enter), np.where(crossed, touch, leave)


def round_interval(run, rise, length, radius, s, m):
    """Return the same for capsules; parameters and returns as of `flat_interval`.

    Parameters: run, rise, length, radius, s, m.
    """
    guard, length, parallel, s = _sizes(run, length, radius, s, m)
    wide = radius + guard
    k = np.sqrt(np.maximum((wide - s) * (wide + s), 0)) + guard
    hit = (s <= wide) & (parallel | ((m >= -k) & (m <= run + k)))
    m, run = np.where(parallel, 0.0, m), np.where(parallel, 0.0, run)
    enter, leave, _ = ball_sweep(run, rise, length, radius, s, m)
    return hit, enter, np.maximum(enter, leave)


def ball_sweep(run, rise, length, radius, s, m):
    """Return where lines enter and leave the sweep of a ball: of those balls that they meet so.

    Parameters as of `flat_interval`: run, rise, length (above zero), radius, s, m. The third
    answer is negative where a line misses, and tells it without a guard.
    """
    room = (radius - s) * (radius + s)
    k = rise / length * np.sqrt(np.maximum(room, 0))
    still = run == 0
    pace = np.where(still, 1.0, run)
    # How far along the axis those balls are: the ends' beyond the wall's own two crossings.
    first = np.where(still, 0.0, np.clip((m - k) / pace, 0, 1))
    last = np.where(still, 1.0, np.clip((m + k) / pace, 0, 1))
    before, after = room - (m - first * run) ** 2, room - (m - last * run) ** 2
    enter = first * rise - np.sqrt(np.maximum(before, 0))
    return enter, last * rise + np.sqrt(np.maximum(after, 0)), before


def _sizes(run, length, radius, s, m):
    """Return the guard, lengths without zeros, which axes lie along the line, and |s| of those."""
    guard = GUARD * (radius + run)
    # So small a run moves the surface over the whole rod by less than the guard.
    parallel = run <= guard
    return guard, np.where(length > 0, length, 1), parallel, \
        np.where(parallel, np.hypot(s, m), np.abs(s))  # fmt: skip
