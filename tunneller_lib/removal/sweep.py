"""What a ball takes from a grid of intervals on a straight move, line by line.

The loops serve `compiled.call`. In flat rows line j of plane i has the place i m + j, and its
interval in slot s the place s n m + i m + j. Plain Python has whole arrays in the place of the
loops, by the same formulas in the same order, so that the bits are the same.

A ball takes an interval of a line: the balls' chords along a straight move make up the line's chord
through a capsule, which is convex. Where a chord ends, as the ball moves by a share t, is a concave
function of t. If it still grows at the end of the move, the ball that stands there gives the end of
the whole interval; this is so all over the front of a cutter. Other lines ask for the capsule.
"""

import math
from typing import NamedTuple

import numpy as np

from ..kernels.elementwise import NUMBERS, larger, smaller, square_root, where
from ..surfaces.rod_interval import ball_sweep

ROOM = 1 + 1e-9  # times the radius of a ball about a whole move, by more than its rounding
ENDLESS = math.inf


class Grid(NamedTuple):
    """A grid of lines, as of `Lines`: n planes of m, each line with some slots for intervals.

    `low` and `high` are flat rows of all slots; on the rays of each angle the material began at
    first at `nearest` (m,).
    """

    slots: int
    n: int
    m: int
    cell: float
    rays: bool
    low: np.ndarray
    high: np.ndarray
    x: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    aside: np.ndarray
    nearest: np.ndarray


class Found(NamedTuple):
    """Room for what `sweep` finds: the lines that lose something, and what each loses.

    `work` (6 m,) has numbers of the m lines of a plane.
    """

    line: np.ndarray
    enter: np.ndarray
    leave: np.ndarray
    work: np.ndarray


def room_on(grid, lines):
    """Return the `Found` with room for so many lines of a grid, or for those of a plane."""
    size = max(min(lines, grid.n * grid.m), grid.m)
    return Found(np.empty(size, dtype=int), np.empty(size), np.empty(size), np.empty(6 * grid.m))


def first_from(values, count, bound):
    """Return how many of ascending `values` (count,) are below a bound."""
    low = 0
    high = count
    while low < high:
        middle = (low + high) // 2
        if values[middle] < bound:
            low = middle + 1
        else:
            high = middle
    return low


def window(grid, a, b, radius):
    """Return the lines that a ball may meet on its way from a to b, (x, y, z) in m.

    They are from and to in x, and from and to among the lines, which on rays may go round: below 0,
    or past the last one. Rounding here only adds lines that are met by nothing.
    """
    if not grid.rays:
        low = min(a[0], b[0]) - radius
        high = max(a[0], b[0]) + radius
        left = first_from(grid.aside, grid.m, min(a[1], b[1]) - radius)
        right = first_from(grid.aside, grid.m, max(a[1], b[1]) + radius)
        return first_from(grid.x, grid.n, low), first_from(grid.x, grid.n, high), left, right
    # One ball stands for all on the way.
    reach = ROOM * (radius + way_between(a, b) / 2)
    middle = (a[0] + b[0]) / 2
    y = (a[1] + b[1]) / 2
    z = (a[2] + b[2]) / 2
    off = math.sqrt(y * y + z * z)
    angle = math.atan2(z, y)
    # Rays touch a ball beside the axis at angles of -+ half; all rays meet one that holds it.
    half = math.pi
    if off > reach:
        half = math.atan2(reach, math.sqrt((off - reach) * (off + reach)))
    # Nearer to the axis than the nearest material on these rays there is nothing to cut, so only
    # the part of the ball beyond counts.
    step = 2 * math.pi / grid.m
    start, stop = turned_to(grid, angle / step, half / step)
    inner = ENDLESS
    for k in range(stop - start):
        inner = min(inner, grid.nearest[(start + k) % grid.m])
    beyond = inner - off
    if beyond > reach:
        return 0, 0, 0, 0
    # That part ends at the angles where the ball's surface is as far from the axis as the material,
    # by the law of cosines. If the material begins nearer than the places where the rays touch the
    # ball, those places are in that part, and the touching rays bound it.
    if off > 0 and inner > 0 and inner * inner > (off - reach) * (off + reach):
        cosine = (inner * inner + off * off - reach * reach) / (2 * off * inner)
        cosine = min(max(cosine, -1.0), 1.0)
        half = math.atan2(math.sqrt((1 - cosine) * (1 + cosine)), cosine)
        start, stop = turned_to(grid, angle / step, half / step)
    # That part is also narrower along x than the ball.
    width = math.sqrt(max(reach * reach - max(beyond, 0.0) * max(beyond, 0.0), 0.0))
    first = first_from(grid.x, grid.n, middle - width)
    return first, first_from(grid.x, grid.n, middle + width), start, stop


def turned_to(grid, angle, half):
    """Return the first and past-the-last rays within angle -+ half, both counted in rays' steps.

    They are never more than once round.
    """
    # The rays are in the middles of their cells, and rounding must lose none at the ends.
    start = -math.floor(half - angle + 0.5 + 1e-9)
    stop = math.floor(angle + half - 0.5 + 1e-9) + 1
    return start, max(min(stop, start + grid.m), start)


def way_between(a, b):
    """Return the length of a straight move from a to b, (x, y, z)."""
    dx = b[0] - a[0]
    dy = b[1] - a[1]
    dz = b[2] - a[2]
    return math.sqrt(dx * dx + dy * dy + dz * dz)


def seen(cos, sin, a, b):
    """Return a move from a to b, (x, y, z), in the coordinates of lines along (0, cos, sin).

    Numbers or arrays.

    Returns
    -------
    x, side, fx, fy, run, rise, length, start
        Of the end that a line passes first: its x and its way to the right, in m; the unit vector
        of the move in the plane across the line; how far the move goes in that plane and along the
        line, its length, and where along the line it starts, in m.
    """
    ax, ay, az = a
    bx, by, bz = b
    # The move starts at the end that a line passes first, so that it rises along the line.
    back = cos * (by - ay) + sin * (bz - az) < 0
    sx = where(back, bx, ax)
    sy = where(back, by, ay)
    sz = where(back, bz, az)
    vx = where(back, ax - bx, bx - ax)
    vy = where(back, ay - by, by - ay)
    vz = where(back, az - bz, bz - az)
    # The plane across a line has the coordinates x and, to its right, sin y - cos z.
    aside = sin * vy - cos * vz
    run = square_root(vx * vx + aside * aside)
    # A move along the line has no direction in that plane: any will do.
    pace = where(run > 0, run, 1.0)
    fx = where(run > 0, vx / pace, 1.0)
    length = square_root(vx * vx + vy * vy + vz * vz)
    start = cos * sy + sin * sz
    return sx, sin * sy - cos * sz, fx, aside / pace, run, cos * vy + sin * vz, length, start


def across(x, aside, move):
    """Return where lines lie across and along moves, in m, in the plane across the lines.

    Numbers or arrays: the lines' planes x and ways `aside`, in m, and the moves as `seen`.
    """
    sx, side, fx, fy, _, _, _, _ = move
    qx = x - sx
    qy = aside - side
    return qx * fy - fx * qy, qx * fx + qy * fy


def capsule(x, aside, radius, move):
    """Return where lines enter and leave what a ball of a radius sweeps on a move, in m.

    Numbers or arrays: x and `aside` of the lines, in m, and the move as `seen` by them. A line that
    misses gets inf and -inf.
    """
    _, _, _, _, run, rise, length, start = move
    s, m = across(x, aside, move)
    size = where(length > 0, length, 1.0)  # a ball: its rise is zero, over any length
    enter, leave, room = ball_sweep(run, rise, size, radius, s, m)
    return where(room > 0, enter + start, ENDLESS), where(room > 0, leave + start, -ENDLESS)


def share(grid, low, high, enter, leave):
    """Return the volume that an interval of a line shares with a cut that meets it, in m^3."""
    near = larger(low, enter)
    far = smaller(high, leave)
    volume = grid.cell * (far - near)
    return volume * ((far + near) / 2) if grid.rays else volume


def sweep(grid, a, b, radius, start, found):
    """Find what a ball takes on a straight move.

    Parameters
    ----------
    grid : Grid
        The lines.
    a, b : (float, float, float)
        Where the move begins and ends, x, y, z in m.
    radius : float
        Of the ball, in m.
    start : int
        The plane to begin with.
    found : Found
        Filled with the lines that lose something, in order, and the ends of what each loses.

    Returns
    -------
    volume : float
        In m^3.
    count : int
        How many lines lose something.
    split : bool
        Whether a line must be split that has no free slot.
    last : int
        The plane to go on with where `found` has no room for more; the number of planes at the end.
    """
    first, last, left, right = window(grid, a, b, radius)
    m = grid.m
    low = grid.low
    high = grid.high
    x = grid.x
    cos = grid.cos
    sin = grid.sin
    aside = grid.aside
    line = found.line
    enter = found.enter
    leave = found.leave
    work = found.work
    total = 0.0
    count = 0
    split = False
    if first < start:
        first = start
    end = planes_at_once(first, last, right - left, len(line))
    ax, ay, az = a
    bx, by, bz = b
    dx = bx - ax
    about = ROOM * (radius + way_between(a, b) / 2)
    mx = (ax + bx) / 2
    # Of each line: along it and beside it, one ball about the whole move, then the last ball, and
    # the move itself.
    for k in range(right - left):
        j = (left + k) % m
        work[k] = cos[j] * ((ay + by) / 2) + sin[j] * ((az + bz) / 2)
        beside = aside[j] - (sin[j] * ((ay + by) / 2) - cos[j] * ((az + bz) / 2))
        work[m + k] = beside * beside
        work[2 * m + k] = cos[j] * by + sin[j] * bz
        work[3 * m + k] = aside[j] - (sin[j] * by - cos[j] * bz)
        work[4 * m + k] = cos[j] * (by - ay) + sin[j] * (bz - az)
        work[5 * m + k] = cos[j] * (bz - az) - sin[j] * (by - ay)
    for r in range(end - first):
        i = first + r
        off = x[i] - mx
        square = about * about - off * off
        if square <= 0:
            continue
        off = x[i] - bx
        disc = radius * radius - off * off
        for k in range(right - left):
            # Most lines were cut as far as this by earlier moves.
            room = square - work[m + k]
            if room <= 0:
                continue
            j = (left + k) % m
            at = i * m + j
            gap = low[at] - work[k]
            if grid.slots == 1 and gap > 0 and gap * gap >= room:
                continue
            # The last ball, by which the line is left unless the ball recedes from it.
            beside = work[3 * m + k]
            room = disc - beside * beside
            half = math.sqrt(room) if room > 0 else 0.0
            begins = work[2 * m + k] - half
            ends = work[2 * m + k] + half
            growing = work[4 * m + k] * half + (off * dx - beside * work[5 * m + k]) >= 0
            if not (room > 0 and growing and grid.slots == 1 and begins <= low[at]):
                begins, ends = capsule(
                    x[i], aside[j], radius, seen(cos[j], sin[j], (ax, ay, az), (bx, by, bz))
                )
            if not begins < ends:
                continue
            taken = False
            free = False
            parted = 0
            for s in range(grid.slots):
                near = low[s * grid.n * m + at]
                far = high[s * grid.n * m + at]
                if far <= near:
                    free = True
                elif ends > near and begins < far:
                    total += share(grid, near, far, begins, ends)
                    taken = True
                    if begins > near and ends < far:
                        parted += 1
            if taken:
                line[count] = at
                enter[count] = begins
                leave[count] = ends
                count += 1
                if parted > 0 and not free:
                    split = True
    return total, count, split, end if end < last else grid.n


def planes_at_once(first, last, width, room):
    """Return the end of as many planes of so many lines as surely fit, at least one."""
    if (last - first) * width > room:
        return first + max(room // width, 1)
    return last


def take(grid, found, count):
    """Take what `sweep` has found from the lines, which must have the slots that they need."""
    low = grid.low
    high = grid.high
    line = found.line
    enter = found.enter
    leave = found.leave
    size = grid.n * grid.m
    for c in range(count):
        for s in range(grid.slots):
            at = s * size + line[c]
            near = low[at]
            far = high[at]
            if far > near and leave[c] > near and enter[c] < far:
                # The slot keeps what is before the cut, else what is behind it, else nothing.
                if enter[c] > near and leave[c] < far:
                    free = line[c]
                    while high[free] > low[free]:
                        free += size
                    low[free] = leave[c]
                    high[free] = far
                if enter[c] > near:
                    high[at] = enter[c]
                elif leave[c] < far:
                    low[at] = leave[c]
                else:
                    high[at] = near


def cut_moves(grid, centres, radius, begin, volumes, found):
    """Take what a ball takes on moves from centre to centre (k + 1, 3), in m, from `begin` on.

    `volumes` (k,) are increased by what each takes, in m^3; `grid`, `radius` and `found` are as of
    `sweep`. Return the number of moves that are done: fewer than k if a line must be split that has
    no free slot.
    """
    for c in range(len(volumes) - begin):
        k = begin + c
        a = (centres[k][0], centres[k][1], centres[k][2])
        b = (centres[k + 1][0], centres[k + 1][1], centres[k + 1][2])
        plane = 0
        while plane < grid.n:
            volume, count, split, plane = sweep(grid, a, b, radius, plane, found)
            if split:
                return k
            take(grid, found, count)
            volumes[k] += volume
    return len(volumes)


# ---- the same with whole arrays, for plain Python ----------------------------------------------


def sweep_arrays(grid, a, b, radius, start, found):
    """Do what `sweep` does."""
    _, _, _, _, _, low, high, x, cos, sin, aside, _ = grid
    line, enter, leave, _ = found
    first, last, left, right = window(grid, a, b, radius)
    first = max(first, start)
    end = planes_at_once(first, last, right - left, len(line))
    go_on = end if end < last else grid.n
    ax, ay, az = a
    bx, by, bz = b
    about = ROOM * (radius + way_between(a, b) / 2)
    j = np.arange(left, right) % grid.m
    c = cos[j]
    s = sin[j]
    along = c * ((ay + by) / 2) + s * ((az + bz) / 2)
    beside = aside[j] - (s * ((ay + by) / 2) - c * ((az + bz) / 2))
    off = x[first:end] - (ax + bx) / 2
    room = (about * about - off * off)[:, None] - beside * beside
    met = room > 0
    if grid.slots == 1:
        gap = low.reshape(grid.n, grid.m)[first:end, j] - along
        met &= (gap <= 0) | (gap * gap < room)
    row, k = np.nonzero(met)
    if not len(row):
        return 0.0, 0, False, go_on
    i = first + row
    j = j[k]
    at = i * grid.m + j
    off = x[i] - bx
    beside = aside[j] - (sin[j] * by - cos[j] * bz)
    room = (radius * radius - off * off) - beside * beside
    half = np.sqrt(np.maximum(room, 0.0))
    middle = cos[j] * by + sin[j] * bz
    begins = middle - half
    ends = middle + half
    growing = (cos[j] * (by - ay) + sin[j] * (bz - az)) * half + (
        off * (bx - ax) - beside * (cos[j] * (bz - az) - sin[j] * (by - ay))
    ) >= 0
    quick = (room > 0) & growing & (grid.slots == 1)
    if grid.slots == 1:
        quick &= begins <= low[at]
    if not quick.all():
        hard = ~quick
        h = j[hard]
        begins[hard], ends[hard] = capsule(x[i[hard]], aside[h], radius, seen(cos[h], sin[h], a, b))
    places = at + grid.n * grid.m * np.arange(grid.slots)[:, None]
    near = low[places]
    far = high[places]
    filled = far > near
    hit = filled & (ends > near) & (begins < far) & (begins < ends)
    taken = hit.any(axis=0)
    count = int(np.count_nonzero(taken))
    volume = np.zeros(hit.shape)
    both = (np.broadcast_to(one, hit.shape)[hit] for one in (near, far, begins, ends))
    volume[hit] = share(grid, *both)
    # One after the other, as the loop adds them.
    total = float(np.cumsum(volume.T.ravel())[-1])
    split = hit & (begins > near) & (ends < far)
    lacking = bool(np.any(split.any(axis=0) & filled.all(axis=0)))
    line[:count] = at[taken]
    enter[:count] = begins[taken]
    leave[:count] = ends[taken]
    return total, count, lacking, go_on


def take_arrays(grid, found, count):
    """Do what `take` does."""
    low = grid.low
    high = grid.high
    size = grid.n * grid.m
    lines, begins, ends = (rows[:count] for rows in found[:3])
    for s in range(grid.slots):
        at = s * size + lines
        near = low[at]
        far = high[at]
        hit = (far > near) & (ends > near) & (begins < far)
        before = hit & (begins > near)
        behind = hit & (ends < far)
        # Where an interval is split its second piece goes into the first free slot.
        for c in np.flatnonzero(before & behind):
            free = lines[c]
            while high[free] > low[free]:
                free += size
            low[free] = ends[c]
            high[free] = far[c]
        high[at] = np.where(before, begins, np.where(hit & ~behind, near, far))
        low[at] = np.where(behind & ~before, ends, near)


# What `compiled.call` puts in the place of the formulas' functions, and of the loops.
LOOPS = NUMBERS
ARRAYS = {"sweep": sweep_arrays, "take": take_arrays}
