"""Chains of positions along which a conical mill goes, across its characteristic."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..arguments import Length, Length0, Rule, Whole, checked, shown
from ..envelopes import hyperosculating_cones
from ..envelopes.functions import as_jet
from ..envelopes.jet import jet_variables
from ..kernels.exact import dot, norm
from .five_axes import TiltingTable, cradle_depth, stretch
from .motion import moved
from .obstacles import Around
from .patch import Patch
from .positions import Positions, depths_of
from .tools import ConicalMill

MOST_TURN = np.cos(np.radians(15))  # of the axis from one position to the next
PATCH_ENDS = "the patch ends"
NO_CONE = "no cone continues"
NO_FIT = "the next one doesn't fit"
ON_THE_WAY = "the mill would gouge on its way"
NO_AXES = "the machine's axes end"
IN_CRADLE = "the cradle is in the way"
BETWEEN = 4  # places from one position to the next at which that is looked at


@dataclass(frozen=True, eq=False)
class Chain:
    """Positions one after the other: arrays with a row a position.

    Parameters
    ----------
    s, t : (k,) float
        Parameters of the contact.
    contact, normal : (k, 3) float
        Where the mill touches, or amid where it does twice, in m, and the unit normal that points
        to its side.
    tip, axis : (k, 3) float
        The middle of the mill's lower end, in m, and the unit vector from there to the spindle.
    across : (k, 3) float
        Unit tangent of the characteristic at the contact, which the chain crosses at a right
        angle.
    ends : tuple of two str
        Why it ends at its first and at its last position: "the patch ends", "no cone continues",
        "the next one doesn't fit", "the mill would gouge on its way", "the machine's axes end",
        "the cradle is in the way", "no pair of contacts fits" of cones that touch twice, or "long
        enough".
    """

    s: np.ndarray
    t: np.ndarray
    contact: np.ndarray
    normal: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    across: np.ndarray
    ends: tuple

    def __len__(self):
        return len(self.tip)


def _chains(name, value):
    """Return `value`, one or more chains of four positions or more."""
    if not isinstance(value, list) or not value:
        raise ValueError(f"{name}: must be a list of one Chain or more; got {shown(value)}.")
    for one in value:
        if not isinstance(one, Chain) or len(one) < 4:
            raise ValueError(f"{name}: must each be a Chain of four or more; got {shown(one)}.")
    return value


# What arguments may be, in this room and above it.
Chains = Annotated[list, Rule("list of Chain", _chains)]


@checked
def trace_chains(
    patch: Patch,
    mill: ConicalMill,
    starts: Positions,
    *,
    step: Length,
    tolerance: Length0,
    others: Around | None = None,
    machine: TiltingTable | None = None,
    most: Whole(2, 1000) = 100,
    n: Whole(2, 500) = 121,
):
    """Return the chain through each of some positions that fit.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    starts : Positions
        Those rows that fit are begun from, both ways.
    step : float
        From contact to contact, in m.
    tolerance, others
        As for `find_positions`: where a position doesn't fit the chain ends.
    machine : TiltingTable, optional
        A chain ends where an axis of the machine does, or would turn too far in a step, or the
        mill would enter the cradle; it may have no position then.
    most : int
        Positions to either side of the start.
    n : int
        As for `find_positions`.

    Returns
    -------
    chains : list of Chain
        One a row of `starts` that fits.

    Raises
    ------
    ValueError
        If a start is no position of this mill on this patch.

    Notes
    -----
    The characteristic of a moving cone that agrees with the surface to second order is conjugate to
    the ruling through the contact. Going at a right angle to it gives the widest strip (Envelopes,
    section 4). By the midpoint rule; at each point the cone is taken whose axis turns least, up to
    15 degrees.

    Examples
    --------
    >>> from tunneller_lib.milling import find_positions
    >>> patch = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
    >>> mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    >>> starts = find_positions(patch, mill, 0.005, 0.002, tolerance=1e-4)
    >>> chains = trace_chains(patch, mill, starts, step=1e-3, tolerance=1e-4)
    >>> len(chains)
    2
    """
    rows = np.flatnonzero(starts.fits)
    if not len(rows):
        return []
    # Both ways of all at once: most of a step's time is that of calls, not of places.
    begin = [np.tile(part[rows], 2) for part in (starts.s, starts.t)]
    steps = np.repeat([step, -step], len(rows))
    ways = _trace(patch, mill, *begin, np.tile(starts.axis[rows], (2, 1)), steps, most)
    chains = []
    for forth, back in zip(ways[: len(rows)], ways[len(rows) :], strict=True):
        rows_back, end_back = back
        rows_forth, end_forth = forth
        if not rows_forth:
            raise ValueError("starts: must be positions of this mill on this patch; got others.")
        parts = [np.array(column) for column in zip(*rows_back[:0:-1], *rows_forth, strict=True)]
        ends = end_back, end_forth
        about = tolerance, others, machine, n
        chains.append(fitting(patch, mill, parts, len(rows_back) - 1, ends, *about))
    return chains


def fitting(patch, mill, parts, start, ends, tolerance, others, machine, n):
    """Return the `Chain` of the positions next to each other, about the start, that fit.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    parts : list of (k, ..) float
        Fields of a `Chain` but its ends.
    start : int
        Which position it should hold.
    ends : tuple of two str
        Why it ends where all fit.
    tolerance, others, machine, n
        As for `find_positions`.
    """
    tip, axis = parts[4:6]
    own, holder, other = depths_of(patch, mill, tip, axis, others, n)
    wrong = np.flatnonzero((own > tolerance) | (holder > 0) | (other > 0))
    first = int(wrong[wrong < start].max(initial=-1)) + 1
    last = int(wrong[wrong > start].min(initial=len(tip)))
    ends = [NO_FIT if first else ends[0], NO_FIT if last < len(tip) else ends[1]]
    if machine is not None:
        here = stretch(machine, tip[first:last], axis[first:last], start - first)
        reached = first + here[0], first + here[1]
        ends = [
            NO_AXES if a != b else end
            for a, b, end in zip((first, last), reached, ends, strict=True)
        ]
        first, last = reached
    # Where the axis turns fast, as where two cones fall together, the way between two positions
    # that fit may gouge. What is cut off changes the smooth way through the rest: it's tried anew.
    while last - first >= 4:
        way = moved(tip[first:last], axis[first:last], between=BETWEEN)
        own, holder, other = depths_of(patch, mill, *way, others, n)
        blocked = np.zeros(len(own), dtype=bool)
        if machine is not None and machine.cradle is not None:
            blocked = cradle_depth(machine, mill, machine.values(*way, mill)) > 0
        bad = np.flatnonzero((own > tolerance) | (holder > 0) | (other > 0) | blocked)
        if not len(bad):
            break
        wrong = first + bad / BETWEEN
        why = np.where(blocked[bad], IN_CRADLE, ON_THE_WAY).tolist()
        before = np.flatnonzero(wrong <= start)
        after = np.flatnonzero(wrong > start)
        if len(before):
            first = int(np.floor(wrong[before[-1]])) + 1
            ends[0] = why[before[-1]]
        if len(after):
            last = int(np.ceil(wrong[after[0]]))
            ends[1] = why[after[0]]
    return Chain(*(part[first:last] for part in parts), tuple(ends))


def _trace(patch, mill, s, t, axis, step, most):
    """Return for each start the rows of a `Chain`, from there on, and why they end.

    The arrays (k,) and (k, 3) are written to; steps are in m, negative to go back.
    """
    found = [[] for _ in s]
    ends = np.full(len(s), "long enough", dtype="<U24")
    heading = np.full((len(s), 3), np.nan)
    active = np.arange(len(s))
    for _ in range(most + 1):
        at = s[active], t[active], axis[active], heading[active]
        here = _taken(patch, mill, *at, step[active])
        for row, k in zip(here.row, here.good, strict=True):
            found[active[k]].append(row)
        ends[active[~here.ok]] = NO_CONE
        active = active[here.ok]
        if not len(active):
            break
        middle = s[active] + here.rate[0] / 2, t[active] + here.rate[1] / 2
        inside = _within(patch, *middle)
        ends[active[~inside]] = PATCH_ENDS
        active = active[inside]
        between = _taken(
            patch,
            mill,
            middle[0][inside],
            middle[1][inside],
            here.axis[inside],
            here.heading[inside],
            step[active],
        )
        ends[active[~between.ok]] = NO_CONE
        active = active[between.ok]
        after = s[active] + between.rate[0], t[active] + between.rate[1]
        inside = _within(patch, *after)
        ends[active[~inside]] = PATCH_ENDS
        active = active[inside]
        s[active], t[active] = (part[inside] for part in after)
        axis[active] = between.axis[inside]
        heading[active] = between.heading[inside]
    return list(zip(found, ends.tolist(), strict=True))


@dataclass(eq=False)
class _Here:
    """Of points that are asked, whether one has a cone, and of those that do all that follows."""

    ok: np.ndarray
    good: np.ndarray
    row: list
    rate: np.ndarray
    axis: np.ndarray
    heading: np.ndarray


def _taken(patch, mill, s, t, axis, heading, step):
    """Return a `_Here` of points (k,), after axes and headings (k, 3), with steps (k,)."""
    cones = hyperosculating_cones.unchecked(
        patch.surface, s, t, half_angle=mill.half_angle, model="space"
    )
    near, far = mill.rulings
    usable = (cones.side == patch.side) & (cones.distance >= near) & (cones.distance <= far)
    turn = np.where(usable, dot(cones.axis, axis[cones.index]), -1.0)
    chosen = np.full(len(s), -1)
    order = np.argsort(turn)  # the best of each point is written last
    chosen[cones.index[order]] = order
    ok = (chosen >= 0) & (turn[chosen] >= MOST_TURN) if len(turn) else np.zeros(len(s), bool)
    good = np.flatnonzero(ok)
    k = chosen[good]
    contact = cones.contact[k]
    normal = patch.side * cones.normal[k]
    ruling = (contact - cones.vertex[k]) / cones.distance[k][:, None]
    way, inverse = conjugate_frame(patch, s[good], t[good], ruling)
    across = np.cross(normal, way)
    # The first heading's sign is free; afterwards it is that of the step before.
    ahead = np.where(np.isnan(heading[good, 0]), step[good], dot(way, np.nan_to_num(heading[good])))
    way = np.where(ahead < 0, -1.0, 1.0)[:, None] * way
    rate = np.abs(step[good]) * np.einsum("nij,nj->in", inverse, way)
    tip = cones.vertex[k] + mill.below * cones.axis[k]
    parts = s[good], t[good], contact, normal, tip, cones.axis[k], across
    return _Here(ok, good, list(zip(*parts, strict=True)), rate, cones.axis[k], way)


def conjugate_frame(patch, s, t, ruling):
    """Return the way across the characteristic, and the parameters' rates along tangents.

    Parameters
    ----------
    patch : Patch
        The surface.
    s, t : (k,) float
        Points.
    ruling : (k, 3) float
        Unit tangents there, along the rulings of cones.

    Returns
    -------
    way : (k, 3) float
        Unit tangents, at right angles to the directions that are conjugate to the rulings: the way
        in which the normal turns along them.
    inverse : (k, 2, 3) float
        By which a tangent vector, in m, is multiplied to give changes of s and t.
    """
    variables = jet_variables.unchecked(s, t)
    taylor = np.stack([as_jet(c, variables[0]).c for c in patch.surface(*variables)], axis=-1)
    by_s, by_t = taylor[1], taylor[2]
    first = _form(dot(by_s, by_s), dot(by_s, by_t), dot(by_t, by_t))
    second = (dot(c, np.cross(by_s, by_t)) for c in (2 * taylor[3], taylor[4], 2 * taylor[5]))
    inverse = np.linalg.pinv(first) @ np.stack([by_s, by_t], axis=1)
    turn = np.einsum("nij,njk,nk->ni", _form(*second), inverse, ruling)
    way = -np.einsum("nij,ni->nj", inverse, turn)
    return way / norm(way)[:, None], inverse


def _form(ss, st, tt):
    """Return a quadratic form's matrices (k, 2, 2)."""
    return np.stack([np.stack([ss, st], axis=-1), np.stack([st, tt], axis=-1)], axis=-1)


def _within(patch, s, t):
    """Tell whether parameters (k,) are within a patch."""
    return (s >= patch.s[0]) & (s <= patch.s[1]) & (t >= patch.t[0]) & (t <= patch.t[1])
