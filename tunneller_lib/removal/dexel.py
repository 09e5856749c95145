"""Grids of intervals (dexels): what is left of a block or of a tunnel's wall after cuts."""

import os

import numpy as np

from ..arguments import Array, Coordinate, Length, Lengths, Point, Wholes, checked
from ..kernels import compiled
from ..surfaces.solid import Solid
from .grid import BLOCK, Lines, fan, parallel
from .sweep import ARRAYS, LOOPS, Grid, cut_moves, room_on

MOVE = 2e-4  # s, about what one move takes with whole arrays

# What arguments may be, in this room and in those above it.
Shape = Wholes("(2,) int", 1, 2**53)
Centres = Array("(n, 3) float", "m", last="x, y, z")
Distances = Array("() or (m,) float", "m", low=0.0)


class DexelGrid:
    """Material as intervals on a grid of lines, made by `cartesian` or `radial`.

    Parameters
    ----------
    lines : Lines
        The grid: n planes of m lines, as of another `DexelGrid`.
    low, high : (...) float
        Where the material begins and ends on each line, in m; nothing where low >= high. They
        broadcast to (n, m).

    Attributes
    ----------
    low, high : (k, n, m) float
        Up to k intervals a line, in no order, in m; an empty slot has low >= high.

    Raises
    ------
    ValueError
        If the ends don't fit the grid, or a grid would take more than half of the computer's
        memory; cuts raise it, too, when the intervals that they split don't fit any more.

    Notes
    -----
    A convex cut splits at most one interval of a line; room for one more is made only when no
    line's slot is free. What is removed and what is left add up to rounding, and the order of cuts
    doesn't matter. Over shifts of the grid the error of a ball's volume falls with power 2 of the
    spacing, that of a capsule with 3/2 to 2: its chords begin as a root along straight sides, and
    where such a side runs along the grid the errors of its cells don't average out.
    """

    @checked
    def __init__(self, lines: Lines, low: Lengths, high: Lengths):
        shape = (len(lines.x), len(lines.cos))
        self.lines = lines
        low = _on_lines("low", low, shape)
        high = _on_lines("high", high, shape)
        self.low = low.copy()[None]
        self.high = high.copy()[None]
        # Where the material began at first on the rays of each angle: cuts only move it outwards.
        self._nearest = np.where(low < high, low, np.inf).min(axis=0, initial=np.inf)

    @classmethod
    @checked
    def cartesian(cls, low: Point, high: Point, shape: Shape):
        """Return a block of material on lines along z.

        Parameters
        ----------
        low, high : (3,) float
            Opposite corners, in m.
        shape : (2,) int
            Number of lines along x and along y, each in the middle of its cell.

        Returns
        -------
        grid : DexelGrid
            The block.

        Examples
        --------
        >>> from tunneller_lib.surfaces import Rod
        >>> grid = DexelGrid.cartesian((-1, -1, 0), (1, 1, 1), (200, 200))
        >>> removed = grid.cut(Rod((0, 0, 1), (0, 0, 1), 0.5, ends="round"))
        >>> round(removed / (2 / 3 * np.pi * 0.5**3), 3)
        1.0
        """
        if not np.all(np.less(low, high)):
            raise ValueError(f"low: must be below high on each axis; got {low} and {high}.")
        _refuse(shape, 1)
        return cls(parallel(low[:2], high[:2], shape), low[2], high[2])

    @classmethod
    @checked
    def radial(
        cls, start: Coordinate, stop: Coordinate, inner: Distances, outer: Distances, shape: Shape
    ):
        """Return the wall of a tunnel along x on rays from its axis y = z = 0.

        Parameters
        ----------
        start, stop : float
            Its ends, in m.
        inner, outer : () or (m,) float
            Distances from the axis between which there is material, in m, one for each ray;
            inner <= outer, and nothing is there where they are equal.
        shape : (2,) int
            n places along x times m angles from y (left) over z (up), each in its cell's middle.

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
        _refuse(shape, 1)
        if not start < stop:
            raise ValueError(f"start: must be below stop; got {start:g} and {stop:g} m.")
        for name, distances in (("inner", inner), ("outer", outer)):
            if distances.shape not in ((), (shape[1],)):
                raise ValueError(
                    f"{name}: must be one distance or one for each of {shape[1]} rays; "
                    f"got {distances.size}."
                )
        if np.any(inner > outer):
            raise ValueError("inner: must not be above outer on any ray.")
        return cls(fan(start, stop, shape), inner, outer)

    @property
    def volume(self):
        """Return the volume of what is left, in m^3."""
        total = 0.0
        _, n, m = self.low.shape
        for block in self.lines.blocks((0, n, 0, m)):
            low = self.low[(slice(None), *block)]
            high = self.high[(slice(None), *block)]
            filled = high > low
            total += float(np.sum(self.lines.measure(low[filled], high[filled])))
        return total

    def copy(self):
        """Return a grid of its own with the same material."""
        other = object.__new__(DexelGrid)
        other.__dict__.update(self.__dict__, low=self.low.copy(), high=self.high.copy())
        return other

    @checked
    def cut(self, solid: Solid):
        """Remove a solid and return the volume, in m^3; a ball is a round rod without length."""
        a, b, radius = solid.capsule
        window = self.lines.window(np.stack([a, b]), radius, self._nearest)
        removed = 0.0
        for rows, columns in self.lines.blocks(window):
            enter, leave = self.lines.meet_solid(solid, rows, columns)
            hit = enter < leave
            i, j = np.nonzero(hit)
            removed += self._taken(enter[hit], leave[hit], i + rows.start, j + columns.start)
        return removed

    @checked
    def cut_path(self, centres: Centres, radius: Length):
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
        return float(np.cumsum(np.append(0.0, self.cut_moves(centres, radius)))[-1])

    @checked
    def cut_moves(self, centres: Centres, radius: Length):
        """Remove what a ball sweeps along a path, and return what each of its moves removes.

        Parameters
        ----------
        centres : (n, 3) float
            Its centres, in m, joined by straight moves.
        radius : float
            In m.

        Returns
        -------
        removed : (n - 1,) float
            Volumes, in m^3; a single centre is a move from it to itself.
        """
        if len(centres) == 1:
            centres = centres.repeat(2, axis=0)
        moves = max(len(centres) - 1, 0)
        removed = np.zeros(moves)
        centres = np.array(centres, order="C")
        compiled.expect(MOVE * moves, "grid")
        found = room_on(self.rows, BLOCK)
        done = 0
        while True:
            given = self.rows, centres, radius, done, removed, found
            done = compiled.call(cut_moves, *given, kind="grid", arrays=ARRAYS, **LOOPS)
            if done == moves:
                return removed
            self.add_slot()

    @property
    def rows(self):
        """Return the grid as the loops of the module `sweep` take it, a `Grid`."""
        x, cos, sin, aside, cell, rays = self.lines
        flat = self.low.reshape(-1), self.high.reshape(-1)
        return Grid(*self.low.shape, cell, rays, *flat, x, cos, sin, aside, self._nearest)

    def add_slot(self):
        """Give each line room for one more interval."""
        _refuse(self.low.shape[1:], len(self.low) + 1)
        empty = np.zeros((1, *self.low.shape[1:]))
        self.low = np.concatenate([self.low, empty])
        self.high = np.concatenate([self.high, empty])

    def _met(self, enter, leave, i, j):
        """Yield the intervals that a cut meets: their slot and lines, where it enters and leaves.

        A piece that is split off meanwhile, into a later slot, isn't met again: it begins where
        the cut leaves.
        """
        for slot in range(len(self.low)):
            low = self.low[slot, i, j]
            high = self.high[slot, i, j]
            met = (leave > low) & (enter < high) & (enter < leave) & (low < high)
            if np.any(met):
                yield slot, (i[met], j[met]), enter[met], leave[met]

    def _shared(self, slot, place, enter, leave):
        """Return the volume that intervals share with a cut, and the ends of the intervals."""
        low = self.low[slot][place]
        high = self.high[slot][place]
        shared = self.lines.measure(np.maximum(low, enter), np.minimum(high, leave))
        return float(np.sum(shared)), low, high

    def _taken(self, enter, leave, i, j):
        """Take a cut from the lines i, j and return the volume."""
        removed = 0.0
        for slot, place, first, last in self._met(enter, leave, i, j):
            volume, low, high = self._shared(slot, place, first, last)
            removed += volume
            below = first > low  # something stays on the line before the cut
            above = last < high  # and behind it
            # The slot keeps what is before the cut, else what is behind it, else nothing.
            self.high[slot][place] = np.where(below, first, high)
            self.low[slot][place] = np.where(below, low, np.where(above, last, high))
            # Where an interval is split its second piece needs a slot of its own.
            both = below & above
            if np.any(both):
                self._add(tuple(index[both] for index in place), last[both], high[both])
        return removed

    def _add(self, place, low, high):
        """Put intervals into the first free slots of their lines."""
        free = self.high[(slice(None), *place)] <= self.low[(slice(None), *place)]
        if not np.all(free.any(axis=0)):
            self.add_slot()
            free = np.concatenate([free, np.ones_like(free[:1])])
        slot = np.argmax(free, axis=0)
        self.low[(slot, *place)] = low
        self.high[(slot, *place)] = high


def _on_lines(name, sides, shape):
    """Return ends of intervals, in m, broadcast to the lines of a grid of this shape (n, m)."""
    try:
        return np.broadcast_to(sides, shape)
    except ValueError:
        raise ValueError(
            f"{name}: must broadcast to {shape[0]} x {shape[1]} lines; got shape {sides.shape}."
        ) from None


def allowed_memory():
    """Return how many bytes may be taken: half of the computer's memory."""
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2
    return 2.0**32


def check_fits(shape, each, memory, what):
    """Raise ValueError if a `shape` of `what`, `each` of so many bytes, exceeds the `memory`."""
    need = each * shape[0] * shape[1]
    if need > memory:
        share = np.sqrt(memory / need)
        n, m = (max(int(size * share), 1) for size in shape)
        raise ValueError(
            f"shape: {shape[0]} x {shape[1]} {what} need {need / 1e9:.3g} GB, and "
            f"{memory / 1e9:.3g} GB are allowed; {n} x {m} would fit."
        )


def _refuse(shape, slots):
    """Raise ValueError if intervals in so many slots, and as much for work, don't fit."""
    room = f"{slots} interval{'' if slots == 1 else 's'}"
    check_fits(shape, 32.0 * slots, allowed_memory(), f"lines with room for {room} each")
