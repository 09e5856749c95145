"""The whole way of a mill over a surface: chains, and how it gets from one to the next."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Length, Length0, Whole, checked
from ..kernels.exact import norm
from .chains import Chains
from .five_axes import TiltingTable, cradle_depth
from .obstacles import Around
from .patch import Patch
from .positions import depths_of
from .tools import ConicalMill

STEP = 2e-3, np.radians(3)  # between places on the way at which gouging is looked at, in m and rad
CUT = "cut"
RETRACT = "retract"
TRAVERSE = "traverse"
APPROACH = "approach"


@dataclass(frozen=True, eq=False)
class Tour:
    """Where a mill stands one after the other: arrays with a row a place.

    Parameters
    ----------
    kind : (k,) str
        How it gets there: "approach", "cut", "retract" or "traverse".
    chain : (k,) int
        Which chain it follows, comes to or leaves, counted from 0; on a traverse, comes to.
    tip, axis : (k, 3) float
        The middle of the mill's lower end, in m, and the unit vector from there to the spindle.
    values : (k, 5) float
        Of the machine's axes: x, y, z in m, A and C in rad.
    """

    kind: np.ndarray
    chain: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    values: np.ndarray

    def __len__(self):
        return len(self.tip)


@checked
def plan_tour(
    patch: Patch,
    mill: ConicalMill,
    chains: Chains,
    machine: TiltingTable,
    *,
    clearance: Length,
    tolerance: Length0,
    others: Around | None = None,
    n: Whole(2, 500) = 121,
):
    """Return the way of a mill through chains, one after the other.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    chains : list of Chain
        Of this mill, four positions or more each.
    machine : TiltingTable
        In whose axes the ways between chains are straight.
    clearance : float
        How far the tip stays above the ball about the pivot that holds patch and other points, not
        the cradle, while the table moves, in m.
    tolerance, others, n
        As for `find_positions`.

    Returns
    -------
    tour : Tour
        From above the first chain, its first place, to above the last. Approach and retraction are
        along the mill's own axis: a cone that is drawn out of its place enters nothing that it
        didn't enter there.

    Raises
    ------
    ValueError
        If a position, or the height at which the table may move, is beyond the machine's axes, or
        if the mill enters something between the chains, or the machine's cradle anywhere.
    """
    pivot = np.array(machine.pivot)
    around = [patch.mesh(n).reshape(-1, 3)] + ([] if others is None else [others.points])
    safe = max(float(norm(part - pivot).max()) for part in around) + clearance
    if safe > machine.z[1]:
        raise ValueError(
            f"machine: z must reach {1e3 * safe:.4g} mm, where the table moves freely below the "
            f"tip; got at most {1e3 * machine.z[1]:g} mm."
        )
    parts = []
    for k, chain in enumerate(chains):
        values = machine.values(chain.tip, chain.axis, mill)
        wrong = machine.beyond(values)
        if wrong.any():
            place = int(np.flatnonzero(wrong)[0])
            raise ValueError(f"machine: {wrong[place][:-1]} at position {place} of chain {k}.")
        above = [_raised(values[end], safe) for end in (0, -1)]
        if parts:
            parts.append((TRAVERSE, k, _straight(parts[-1][2][-1], above[0])))
        else:
            parts.append((APPROACH, k, above[0][None]))
        parts.append((APPROACH, k, _straight(above[0], values[0])))
        parts.append((CUT, k, values))
        parts.append((RETRACT, k, _straight(values[-1], above[1])))
    kind = np.concatenate([[name] * len(rows) for name, _, rows in parts])
    chain = np.concatenate([[k] * len(rows) for _, k, rows in parts])
    values = np.concatenate([rows for _, _, rows in parts])
    tour = Tour(kind, chain, *machine.positions(values), values)
    _check_free(tour, patch, mill, tolerance, others, n)
    _check_place(tour, cradle_depth(machine, mill, values), "the machine's cradle")
    return tour


def _raised(values, safe):
    """Return values (5,) at which the tip is as high as `safe`, or where it is if that is more."""
    raised = values.copy()
    raised[2] = max(raised[2], safe)
    return raised


def _straight(start, stop):
    """Return values (k, 5) straight in the machine's axes, without the start."""
    way = np.abs(stop - start)
    count = max(1, *np.ceil(way[:3] / STEP[0]).astype(int), *np.ceil(way[3:] / STEP[1]).astype(int))
    return start + (stop - start) * np.arange(1, count + 1)[:, None] / count


def _check_free(tour, patch, mill, tolerance, others, n):
    """Raise ValueError where the mill enters something between chains."""
    between = np.flatnonzero(tour.kind != CUT)
    own, holder, other = depths_of(patch, mill, tour.tip[between], tour.axis[between], others, n)
    allowed = {
        "the surface": own - tolerance,
        "the surface with its holder": holder,
        "a neighbour": other,
    }
    for what, deep in allowed.items():
        every = np.zeros(len(tour))
        every[between] = deep
        _check_place(tour, every, what)


def _check_place(tour, deep, what):
    """Raise ValueError where the mill enters something: how deep (k,) at each place, in m."""
    if np.any(deep > 0):
        worst = int(deep.argmax())
        raise ValueError(
            f"chains: must be cut, left and reached freely; on the {tour.kind[worst]} of chain "
            f"{tour.chain[worst]} the mill would enter {what}, by {1e3 * deep.max():.3g} mm."
        )
