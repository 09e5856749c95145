"""Grids of intervals, dexels: what is left of a block or of a tunnel's wall after cuts."""

import os

import numpy as np

from ..arguments import finite_points, instance, positive, real
from ..surfaces import Rod
from . import lines as grids

GROUP = 6  # moves of a path that are cut at once, as long as
GREATER = 2  # the lines that some may meet are no more than so many times those of the greatest


class DexelGrid:
    """Material as intervals on a grid of lines, made by `cartesian` or `radial`; cuts change it.

    Parameters
    ----------
    lines : Lines
        The grid.
    low, high : (n, m) float
        Where the material begins and ends on each line, in m; nothing where low >= high.
    memory : float, optional
        Bytes that its intervals may take while they grow; half of the computer's unless told.

    Attributes
    ----------
    low, high : (k, n, m) float
        Up to k intervals a line, in no order, in m.

    Notes
    -----
    A convex cut splits at most one interval of a line; room for one more is made only when no
    line's slot is free. What is removed and what is left add up to rounding, and the order of cuts
    doesn't matter. Over shifts of the grid the error of a ball's volume falls with power 2 of the
    spacing, that of a capsule with 3/2 to 2: its chords begin as a root along straight sides, and
    where such a side runs along the grid the errors of its cells don't average out.
    """

    def __init__(self, lines, low, high, *, memory=None):
        shape = (len(lines.x), len(lines.cos))
        self.memory = _allowed(memory)
        _refuse(shape, 1, self.memory)
        self.lines = lines
        low, high = np.broadcast_to(low, shape), np.broadcast_to(high, shape)
        self.low, self.high = low.copy()[None], high.copy()[None]
        self._nearest = np.where(low < high, low, np.inf).min(axis=0, initial=np.inf)

    @classmethod
    def cartesian(cls, low, high, shape, *, memory=None):
        """Return a block of material on lines along z.

        Parameters
        ----------
        low, high : (3,) float
            Opposite corners, in m.
        shape : (int, int)
            Number of lines along x and along y, each in the middle of its cell.
        memory : float, optional
            Bytes that it may take; half of the computer's unless told.

        Returns
        -------
        grid : DexelGrid
            The block.

        Examples
        --------
        >>> grid = DexelGrid.cartesian((-1, -1, 0), (1, 1, 1), (200, 200))
        >>> removed = grid.cut(Rod((0, 0, 1), (0, 0, 1), 0.5, ends="round"))
        >>> round(removed / (2 / 3 * np.pi * 0.5**3), 3)
        1.0
        """
        low, high = (finite_points(n, p) for n, p in (("low", low), ("high", high)))
        if low.shape != (3,) or high.shape != (3,) or not np.all(low < high):
            raise ValueError(f"low: must be below high (3,) on each axis; got {low}, {high}.")
        shape = _shape(shape)
        _refuse(shape, 1, _allowed(memory))
        return cls(grids.parallel(low[:2], high[:2], shape), low[2], high[2], memory=memory)

    @classmethod
    def radial(cls, start, stop, inner, outer, shape, *, memory=None):
        """Return the wall of a tunnel along x on rays from its axis y = z = 0.

        Parameters
        ----------
        start, stop : float
            Its ends, in m.
        inner, outer : float or (m,) float
            Distances from the axis between which there is material, in m, one for each ray;
            inner <= outer, both finite, and nothing is there where they are equal.
        shape : (int, int)
            n places along x times m angles from y (left) over z (up), each in its cell's middle.
        memory : float, optional
            Bytes that it may take; half of the computer's unless told.

        Returns
        -------
        grid : DexelGrid
            The wall.

        Examples
        --------
        >>> grid = DexelGrid.radial(0, 1, 0.5, 0.6, (10, 90))
        >>> bool(np.isclose(grid.volume, np.pi * (0.6**2 - 0.5**2)))
        True
        """
        shape = _shape(shape)
        _refuse(shape, 1, _allowed(memory))
        inner, outer, ends = (
            real("inner", inner),
            real("outer", outer),
            real("start", [start, stop]),
        )
        if not (np.all(np.isfinite(ends)) and ends[0] < ends[1]):
            raise ValueError(f"start: must be below stop, both finite; got {start} and {stop}.")
        for name, radius in (("inner", inner), ("outer", outer)):
            sound = np.isfinite(radius) & (radius >= 0)
            if radius.shape not in ((), (shape[1],)) or not sound.all():
                raise ValueError(
                    f"{name}: must be one finite distance or one a ray, none below zero."
                )
        if np.any(inner > outer):
            raise ValueError("inner: must not be above outer on any ray.")
        return cls(grids.fan(*ends, shape), inner, outer, memory=memory)

    @property
    def volume(self):
        """Return the volume of what is left, in m^3."""
        total = 0.0
        _, n, m = self.low.shape
        for block in self.lines.blocks((0, n, 0, m)):
            low, high = (side[(slice(None), *block)] for side in (self.low, self.high))
            filled = high > low
            total += float(np.sum(self.lines.measure(low[filled], high[filled])))
        return total

    @property
    def splits(self):
        """Return how many intervals there are beyond one on a line."""
        filled = self.high > self.low
        return int(np.count_nonzero(filled) - np.count_nonzero(filled.any(axis=0)))

    def copy(self):
        """Return a grid of its own with the same material."""
        other = object.__new__(DexelGrid)
        other.__dict__.update(self.__dict__, low=self.low.copy(), high=self.high.copy())
        return other

    def cut(self, rod):
        """Remove a rod, or a ball as a round rod without length, and return the volume, in m^3."""
        return sum(self._subtract(*touched) for touched in self._touched_by(rod))

    def overlap(self, rod):
        """Return the volume, in m^3, that a rod shares with the material: 0 without a collision."""
        return sum(self._shared(*touched)[0] for touched in self._touched_by(rod))

    def cut_path(self, centres, radius):
        """Remove what a ball sweeps along a path.

        Parameters
        ----------
        centres : (n, 3) float
            Its centres, in m, joined by straight moves.
        radius : float
            In m.

        Returns
        -------
        removed : float
            The volume, in m^3.
        """
        centres, radius = finite_points("centres", centres), positive("radius", radius)
        if centres.ndim != 2:
            raise ValueError(f"centres: must have the shape (n, 3); got {centres.shape}.")
        a, b = centres[:-1], centres[1:]
        if len(centres) == 1:
            a = b = centres
        windows = self.lines.windows(a, b, radius, self._nearest)
        removed = 0.0
        for here in range(0, len(a), GROUP):
            moves = slice(here, here + GROUP)
            window = self.lines.around(windows[moves])
            if _lines(window) <= GREATER * _lines(windows[moves].T).max(initial=0):
                removed += self._sweep(a[moves], b[moves], radius, window)
            else:  # long moves, side by side: most lines of the window are met by none
                for start, end, one in zip(a[moves], b[moves], windows[moves], strict=True):
                    removed += self._sweep(start[None], end[None], radius, one)
        return removed

    def _sweep(self, a, b, radius, window):
        """Remove what a ball sweeps in consecutive moves from a to b (k, 3); return the volume."""
        # Most lines were cut as far as this before: a ball about all the moves leaves them out.
        middle = (a[0] + b[-1]) / 2
        away = np.linalg.norm(np.concatenate([a, b]) - middle, axis=-1).max()
        about = (radius + away) * (1 + 1e-9)
        removed = 0.0
        for rows, columns in self.lines.blocks(window):
            enter, leave = self.lines.meet_ball(middle, about, rows, columns)
            low, high = self.low[:, rows, columns], self.high[:, rows, columns]
            i, j = np.nonzero(np.any((enter < high) & (leave > low) & (low < high), axis=0))
            i, j = i + rows.start, j + columns.start
            enter, leave = self.lines.meet(a, b, radius, True, i, j[:, None])
            enter, leave = enter[..., 0], leave[..., 0]
            # What all moves so far take from a line; where that's one interval it goes at once.
            first, last = np.minimum.accumulate(enter), np.maximum.accumulate(leave)
            met = (enter[1:] < leave[1:]) & (first[:-1] < last[:-1])
            if np.any(met & ((enter[1:] > last[:-1]) | (leave[1:] < first[:-1]))):
                cuts = zip(enter, leave, strict=True)
            else:
                cuts = [(first[-1], last[-1])]
            for cut in cuts:
                for touched in self._met(*cut, i, j):
                    removed += self._subtract(*touched)
        return removed

    def _touched_by(self, rod):
        """Return `_touched` for one rod of any length."""
        instance("rod", rod, Rod)
        ends = np.array([[rod.a], [rod.b]])
        reach = rod.radius
        if self.lines.rays:  # whose window is that of a ball
            reach += rod.length / 2
            ends[:] = ends.mean(axis=0)
        window = self.lines.windows(*ends, reach, self._nearest)[0]
        a, b = np.array([rod.a, rod.b])
        return self._touched(a, b, rod.radius, rod.ends == "round", window)

    def _touched(self, a, b, radius, round_ends, window):
        """Yield what `_met` does of the lines of a window against one rod."""
        for rows, columns in self.lines.blocks(window):
            enter, leave = self.lines.meet(a, b, radius, round_ends, rows, columns)
            hit = enter < leave
            i, j = np.nonzero(hit)
            yield from self._met(enter[hit], leave[hit], i + rows.start, j + columns.start)

    def _met(self, enter, leave, i, j):
        """Yield slot, places, and where a cut enters and leaves, of the intervals that it meets."""
        for slot in range(len(self.low)):
            low, high = self.low[slot, i, j], self.high[slot, i, j]
            met = (leave > low) & (enter < high) & (enter < leave) & (low < high)
            if np.any(met):
                yield slot, (i[met], j[met]), enter[met], leave[met]

    def _shared(self, slot, place, enter, leave):
        """Return the volume that intervals share with a rod, and the intervals."""
        low, high = self.low[slot][place], self.high[slot][place]
        shared = self.lines.measure(np.maximum(low, enter), np.minimum(high, leave))
        return float(np.sum(shared)), low, high

    def _subtract(self, slot, place, enter, leave):
        """Take a rod from intervals of one slot, and return the volume."""
        removed, low, high = self._shared(slot, place, enter, leave)
        below, above = enter > low, leave < high
        self.high[slot][place] = np.where(below, enter, high)
        self.low[slot][place] = np.where(below, low, np.where(above, leave, high))
        both = below & above
        if np.any(both):
            self._add(tuple(index[both] for index in place), leave[both], high[both])
        return removed

    def _add(self, place, low, high):
        """Put intervals into the first slots that are free at their places."""
        free = self.high[(slice(None), *place)] <= self.low[(slice(None), *place)]
        if not np.all(free.any(axis=0)):
            _refuse(self.low.shape[1:], len(self.low) + 1, self.memory)
            empty = np.zeros((1, *self.low.shape[1:]))
            self.low, self.high = (np.concatenate([side, empty]) for side in (self.low, self.high))
            free = np.concatenate([free, np.ones_like(free[:1])])
        slot = np.argmax(free, axis=0)
        self.low[(slot, *place)], self.high[(slot, *place)] = low, high


def _lines(window):
    """Return how many lines there are in windows (4, ...)."""
    first, last, start, stop = window
    return np.maximum(last - first, 0) * np.maximum(stop - start, 0)


def _shape(shape):
    sizes = np.asarray(shape)
    if sizes.shape != (2,) or sizes.dtype.kind not in "iu" or not np.all(sizes > 0):
        raise ValueError(f"shape: must be two whole numbers above zero; got {shape!r}.")
    return tuple(int(size) for size in sizes)


def _allowed(memory):
    """Return the bytes that a grid may take."""
    if memory is not None:
        return positive("memory", memory)
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2
    return 2.0**32


def _refuse(shape, slots, memory):
    """Raise ValueError if intervals in so many slots, and as much for work, don't fit."""
    need = 32.0 * slots * shape[0] * shape[1]
    if need > memory:
        share = np.sqrt(memory / need)
        n, m = (max(int(size * share), 1) for size in shape)
        raise ValueError(f"shape: {shape[0]} x {shape[1]} lines in {slots} slots need "
                         f"{need / 1e9:.3g} GB of the {memory / 1e9:.3g} GB allowed; "
                         f"{n} x {m} would fit.")  # fmt: skip
