"""Scallops: what neighbouring strips of a coverage leave between them."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Whole, checked
from ..kernels.exact import dot, norm
from .chains import Chain
from .coverage import Coverage
from .patch import Patch
from .sweep import sweep_error
from .tools import BallMill, ConicalMill, CylinderMill

CLOSER = 12  # points between two of a line, between which strips meet
PAIRS = 2**20  # of contacts that are looked at together, to keep within memory


@dataclass(frozen=True, eq=False)
class Scallops:
    """What strips leave on lines from contacts of one to contacts of the next: a row a line.

    Parameters
    ----------
    chain, position : (k,) int
        Where the line begins, counted from 0.
    neighbour, opposite : (k,) int
        Where it ends: the chain, and the position on it.
    apart : (k,) float
        How long it is on the surface, in m.
    height : (k,) float
        The most that all strips together leave on it, in m.
    kink : (k,) float
        The angle, in rad, between what both strips leave, where the second begins to leave less
        than the first; NaN where it doesn't on this line.
    """

    chain: np.ndarray
    position: np.ndarray
    neighbour: np.ndarray
    opposite: np.ndarray
    apart: np.ndarray
    height: np.ndarray
    kink: np.ndarray

    def __len__(self):
        return len(self.height)


@checked
def find_scallops(
    patch: Patch,
    mill: ConicalMill | CylinderMill | BallMill | None,
    covered: Coverage,
    *,
    m: Whole(2, 500) = 60,
):
    """Return the scallops between the strips of a coverage.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill, CylinderMill or BallMill, optional
        That goes along all chains; None for the mills that the coverage has.
    covered : Coverage
        Chains with the positions of these mills.
    m : int
        Points at which a line is looked at.

    Returns
    -------
    scallops : Scallops
        From each contact, to either side, a line goes to the nearest contact of another chain that
        lies more across than along. It is straight in the patch's parameters. The first and the
        last two positions of a chain begin none, for there a chain cuts with less than its
        envelope, nor are they ends; each pair of contacts has one line.
    """
    mills = covered.mills if mill is None else [mill] * len(covered.chains)
    if len(mills) != len(covered.chains):
        raise ValueError(f"covered: must have a mill a chain; got {len(mills)} of them.")
    inner = [_inner(chain) for chain in covered.chains]
    ends = _pairs(inner) if any(len(part[0]) for part in inner) else ()
    if not len(ends):
        nothing = np.empty(0, dtype=int)
        return Scallops(nothing, nothing, nothing, nothing, *np.empty((3, 0)))
    chain, position, neighbour, opposite = ends.T
    s, t = (
        np.linspace(
            _take(inner, chain, position, k), _take(inner, neighbour, opposite, k), m, axis=1
        )
        for k in (2, 3)
    )

    def left(s, t):
        """Return what all strips leave (k, m) on lines, what both of theirs do, and their steps."""
        points = patch.points(s, t)
        least = np.full(s.shape, np.inf)
        pair = np.empty((2, *s.shape))
        # One strip at a time: of many chains all together would take too much memory.
        for number, (tool, one) in enumerate(zip(mills, covered.chains, strict=True)):
            alone = sweep_error(points, tool, one.tip, one.axis)
            least = np.minimum(least, alone)
            for own, whose in zip(pair, (chain, neighbour), strict=True):
                own[whose == number] = alone[whose == number]
        return least, pair, norm(np.diff(points, axis=1))

    least, pair, steps = left(s, t)
    row = np.arange(len(ends))
    meets, place = _crossing(*pair)
    s, t = (np.linspace(part[row, place], part[row, place + 1], CLOSER, axis=1) for part in (s, t))
    _, pair, short = left(s, t)
    _, place = _crossing(*pair)
    first, second = (
        np.arctan2(one[row, place + 1] - one[row, place], short[row, place]) for one in pair
    )
    kink = np.where(meets, first - second, np.nan)
    height = least.max(axis=1)
    return Scallops(chain, position + 2, neighbour, opposite + 2, steps.sum(axis=1), height, kink)


def _crossing(first, second):
    """Return whether rows (k, m) of heights cross so that the second gets lower, and where."""
    crosses = (first[:, :-1] <= second[:, :-1]) & (first[:, 1:] > second[:, 1:])
    return crosses.any(axis=1), crosses.argmax(axis=1)


def _inner(chain: Chain):
    """Return contacts, ways across, s and t of all but a chain's two first and last positions."""
    inner = slice(2, -2)
    return chain.contact[inner], chain.across[inner], chain.s[inner], chain.t[inner]


def _take(inner, chain, position, part):
    """Return one part of `_inner`, by numbers of chains and of positions (k,)."""
    return np.array([inner[c][part][p] for c, p in zip(chain, position, strict=True)])


def _pairs(inner):
    """Return rows (chain, position, neighbour, opposite) (k, 4), each pair of contacts once."""
    contacts = np.concatenate([part[0] for part in inner])
    count = [len(part[0]) for part in inner]
    owner = np.repeat(np.arange(len(inner)), count)
    place = np.concatenate([np.arange(n) for n in count])
    across = np.concatenate([part[1] for part in inner])
    found = set()
    step = max(PAIRS // len(contacts), 1)
    for first in range(0, len(contacts), step):
        some = slice(first, first + step)
        away = contacts - contacts[some, None]
        distance = norm(away)
        sideways = dot(away, across[some, None])
        of_others = owner != owner[some, None]
        for side in (1, -1):
            beside = of_others & (side * sideways > np.sqrt(0.5) * distance)
            nearest = np.where(beside, distance, np.inf).argmin(axis=1)
            for k in np.flatnonzero(beside.any(axis=1)):
                found.add(tuple(sorted((first + int(k), int(nearest[k])))))
    rows = [(owner[a], place[a], owner[b], place[b]) for a, b in sorted(found)]
    return np.array(rows, dtype=int).reshape(-1, 4)
