"""Grids of intervals (dexels): what is left of a block or of a tunnel's wall after cuts."""

import os
from functools import partial

import numpy as np

from ..arguments import Array, Coordinate, Length, Lengths, Point, Wholes, checked
from ..kernels import compiled
from ..kernels.elementwise import NUMBERS
from ..surfaces.solid import Solid
from .grid import Lines, ball_about, fan, meet_moves, parallel, swept

GROUP = 8  # moves of a path that are cut together
MOVE = 4e-4  # s, about what one move takes with whole arrays
LEAN = 1e-2  # the least cosine that is taken between a line and the ball's normal
TOGETHER = 0.5  # of the radius: moves are cut together whose ends are so near to their middle

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
        if len(centres) == 1:
            return self._take(self._met_by(centres.repeat(2, axis=0), radius))
        removed = 0.0
        for here in range(0, len(centres) - 1, GROUP):
            way = centres[here : here + GROUP + 1]
            # Long moves go one after the other: most lines about all of them are met by none.
            if ball_about(way)[1] > TOGETHER * radius:
                for k in range(len(way) - 1):
                    removed += self._take(self._met_by(way[k : k + 2], radius))
            else:
                removed += self._take(self._met_by(way, radius))
        return removed

    @checked
    def front(self, centres: Centres, radius: Length):
        """Return what a ball would remove along a path, where, and how to have it removed.

        Parameters
        ----------
        centres : (n, 3) float
            Its centres, in m, at least two, joined by short straight moves.
        radius : float
            In m.

        Returns
        -------
        volume : float
            What `cut_path` would remove, in m^3.
        area : (3,) float
            The sum of the ball's surface over all places where it would cut, each along the
            outward normal, in m^2: a further short move d removes the dot product area . d more,
            as long as it goes on cutting there.
        cut : function
            Called without arguments it removes what is still there of this and returns the volume,
            in m^3.
        """
        if len(centres) < 2:
            raise ValueError(f"centres: must be at least two; got {len(centres)}.")
        volume = 0.0
        area = np.zeros(3)
        cuts = list(self._met_by(centres, radius))
        for i, j, enters, leaves in cuts:
            # Moves that follow each other take one interval of a line together.
            for found in self._met(enters.min(axis=0), leaves.max(axis=0), i, j):
                volume += self._shared(*found)[0]
                area += self._facing(*found, centres[-1], radius)
        return volume, area, partial(self._take, cuts)

    def _facing(self, slot, place, enter, leave, centre, radius):
        """Return the area vector (3,), in m^2, of the part of a ball that cuts.

        That is where cuts `enter` and `leave` within the material of a `slot`, on the ball about a
        `centre`; a cut that ends outside the material has no face there.
        """
        lines = self.lines
        i, j = place
        cos = lines.cos[j]
        sin = lines.sin[j]
        area = np.zeros(3)
        for t, sign, within in (
            (leave, 1.0, leave < self.high[slot][place]),
            (enter, -1.0, enter > self.low[slot][place]),
        ):
            if not within.any():  # nearly always where cuts enter, from the hollow of the tunnel
                continue
            ends = np.stack([lines.x[i], lines.aside[j] * sin, -lines.aside[j] * cos], axis=-1)
            ends += t[:, None] * np.stack([0 * cos, cos, sin], axis=-1)
            out = ends - centre
            # The surface is as much larger than the cell as its normal leans away from the line.
            along = np.maximum(sign * (out[:, 1] * cos + out[:, 2] * sin), LEAN * radius)
            cells = within * lines.cell * (t if lines.rays else 1.0)
            area += np.sum(out * (cells / along)[:, None], axis=0)
        return area

    def _take(self, cuts):
        """Remove cuts as `_met_by` yields them, and return the volume, in m^3."""
        removed = 0.0
        for i, j, enters, leaves in cuts:
            for enter, leave in zip(enters, leaves, strict=True):
                removed += self._taken(enter, leave, i, j)
        return removed

    def _met_by(self, centres, radius):
        """Yield the lines i, j whose material a ball may reach on its way, and its cuts.

        The ball, of this radius, in m, moves from centre to centre (k + 1, 3). Cuts are where it
        enters and leaves these lines: one row for all moves together, or one for each.
        """
        # Most lines of the window were cut as far as this by earlier moves. One ball about all
        # these moves, larger by more than its rounding, tells which lines have material in reach,
        # and only those are compared with the moves one by one.
        middle, away = ball_about(centres)
        about = (radius + away) * (1 + 1e-9)
        compiled.expect(MOVE * (len(centres) - 1), "grid")
        met = self._moves_one_by_one if compiled.ready("grid") else self._moves_at_once
        for window in self.lines.blocks(self.lines.window(centres, radius, self._nearest)):
            yield met(centres[:-1], centres[1:], radius, middle, about, *window)

    def _moves_at_once(self, a, b, radius, middle, about, rows, columns):
        """Return what `_met_by` yields of one window, by whole arrays.

        A ball about the `middle` of the radius `about` holds all moves, in m.
        """
        enter, leave = self.lines.meet_ball(middle, about, rows, columns)
        low = self.low[:, rows, columns]
        high = self.high[:, rows, columns]
        i, j = np.nonzero(np.any((enter < high) & (leave > low) & (low < high), axis=0))
        i = i + rows.start
        j = j + columns.start
        seen = self.lines.seen(a, b, j[:, None])
        enter, leave = swept(self.lines.x[i, None], self.lines.aside[j[:, None]], radius, seen)
        enter = enter[..., 0]
        leave = leave[..., 0]
        # What a move takes from a line nearly always overlaps with what the moves before it
        # took, as they share a ball. While that holds on every line the moves together take
        # one interval, which goes at once; one gap anywhere, and the moves go one by one.
        first = np.minimum.accumulate(enter)
        last = np.maximum.accumulate(leave)
        met = (enter[1:] < leave[1:]) & (first[:-1] < last[:-1])
        apart = (enter[1:] > last[:-1]) | (leave[1:] < first[:-1])
        if np.any(met & apart):
            return i, j, enter, leave
        return i, j, first[-1:], last[-1:]

    def _moves_one_by_one(self, a, b, radius, middle, about, rows, columns):
        """Return what `_moves_at_once` does, with the same bits, by a compiled loop."""
        size = (rows.stop - rows.start) * (columns.stop - columns.start)
        i, j = np.empty((2, size), dtype=int)
        enter, leave = np.empty((2, 1 + len(a), size))
        x, cos, sin, aside, _, _ = self.lines
        found, apart = compiled.call(
            meet_moves,
            self.low,
            self.high,
            (x, cos, sin, aside),
            (rows.start, rows.stop, columns.start, columns.stop),
            (*middle.tolist(), float(about)),
            radius,
            self.lines.seen(a, b, columns),
            i,
            j,
            enter,
            leave,
            **NUMBERS,
        )
        cuts = slice(1, None) if apart else slice(1)
        return i[:found], j[:found], enter[cuts, :found], leave[cuts, :found]

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
            _refuse(self.low.shape[1:], len(self.low) + 1)
            empty = np.zeros((1, *self.low.shape[1:]))
            self.low = np.concatenate([self.low, empty])
            self.high = np.concatenate([self.high, empty])
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
