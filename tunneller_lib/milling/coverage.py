"""Chains that cover a patch, one after the other, and what they leave together."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Length, Length0, NotNegative, Whole, checked
from ..kernels.exact import norm
from .chains import Chains, trace_chains
from .five_axes import TiltingTable
from .obstacles import Around
from .patch import Patch
from .positions import Positions
from .sweep import sweep_error
from .tangency import touch_along
from .tools import BallMill, ConicalMill, CylinderMill

FEWEST = 6  # positions of a chain that is kept
LEAST = 0.01  # of the patch's area, that a chain must add
TRIED = 6  # starts a round, of which the one is taken whose strip adds most


@dataclass(frozen=True, eq=False)
class Coverage:
    """Chains, and what a mill leaves of a patch that goes along all of them.

    Parameters
    ----------
    chains : list of Chain
        In the order in which they were found.
    error : (n, n) float
        As of `sweep_error`, on the patch's mesh, in m; infinite without a chain.
    area : (n, n) float
        What each point of the mesh stands for, in m^2.
    mills : tuple of ConicalMill
        The mill of each chain.
    """

    chains: list
    error: np.ndarray
    area: np.ndarray
    mills: tuple = ()

    @checked
    def share(self, tolerance: NotNegative):
        """Return which share of the patch's area is left within a tolerance, in m."""
        return float(self.area[np.abs(self.error) <= tolerance].sum() / self.area.sum())


@checked
def cover(
    patch: Patch,
    mill: ConicalMill,
    found: Positions,
    *,
    step: Length,
    tolerance: Length0,
    others: Around | None = None,
    machine: TiltingTable | None = None,
    most: Whole(1, 100) = 12,
    n: Whole(2, 500) = 121,
    twice: bool = False,
    begun: Coverage | None = None,
    say: Callable[[str], object] | None = None,
):
    """Return chains that cover a patch, as far as its positions allow.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    found : Positions
        Chains begin at those that fit.
    step, tolerance, others, machine
        As for `trace_chains`.
    most : int
        Chains at most, 1 to 100, with those begun.
    n : int
        The patch is looked at on a mesh n by n.
    twice : bool
        Whether each chain is also tried with cones that touch twice, as of `touch_twice`, the
        contacts nearly as far apart as the chain's strip is wide within the tolerance.
    begun : Coverage, optional
        Of the same patch and mesh by other mills, which go first: its chains stay.
    say : callable, optional
        Is given a sentence a chain.

    Returns
    -------
    covered : Coverage
        With what is begun first. In each round six positions that are far from each other begin a
        chain, of those whose contact isn't left within the tolerance yet. The chain is kept that
        brings most area within the tolerance; it needs six positions, and a hundredth of the patch.
    """
    mesh = patch.mesh(n)
    area = areas(mesh)
    if begun is None:
        begun = Coverage([], np.full(mesh.shape[:2], np.inf), area)
    if begun.error.shape != mesh.shape[:2] or len(begun.mills) != len(begun.chains):
        raise ValueError(
            f"begun: must be of this patch's mesh {mesh.shape[:2]}, with a mill a chain; "
            f"got {begun.error.shape} and {len(begun.mills)} mills."
        )
    about = {"tolerance": tolerance, "others": others, "machine": machine, "n": n}
    error = begun.error
    chains = list(begun.chains)
    left = np.where(found.fits, np.inf, -np.inf)
    for chain, other in zip(chains, begun.mills, strict=True):
        left = np.minimum(left, np.abs(sweep_error(found.contact, other, chain.tip, chain.axis)))
    strips = {}  # by the row of the start: chains from there, and what each leaves alone
    while len(chains) < most and np.any(left > tolerance):
        tried = _spread(found.contact, np.flatnonzero(left > tolerance))
        new = sorted(row for row in tried if row not in strips)
        if new:
            reason = np.where(np.isin(np.arange(len(found)), new), found.reason, "")
            starts = replace(found, reason=reason)
            traced = trace_chains(patch, mill, starts, step=step, **about)
            for row, chain in zip(new, traced, strict=True):
                ways = [chain] if len(chain) >= FEWEST else []
                if twice and ways:
                    twin = touch_along(patch, mill, chain, **about)
                    ways += [twin] if twin and len(twin) >= FEWEST else []
                strips[row] = [(way, sweep_error(mesh, mill, way.tip, way.axis)) for way in ways]
        gains = {
            (row, k): _gain(error, alone, area, tolerance)
            for row in tried
            for k, (_, alone) in enumerate(strips[row])
        }
        best = max(gains, key=gains.get, default=None)
        if best is None or gains[best] < LEAST * area.sum():
            left[tried] = -np.inf
            continue
        row, k = best
        chain, alone = strips[row][k]
        chains.append(chain)
        error = np.minimum(error, alone)
        left[row] = -np.inf
        at = sweep_error(found.contact, mill, chain.tip, chain.axis)
        left = np.minimum(left, np.abs(at))
        if say:
            say(f"chain {len(chains)}: {len(chain)} positions; {chain.ends[0]}, {chain.ends[1]}")
    mills = (*begun.mills, *[mill] * (len(chains) - len(begun.chains)))
    return Coverage(chains, error, area, mills)


@checked
def coverage_of(
    patch: Patch,
    mill: ConicalMill | CylinderMill | BallMill,
    chains: Chains,
    *,
    n: Whole(2, 500) = 121,
):
    """Return what a mill leaves of a patch that goes along chains.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill, CylinderMill or BallMill
        Only its cutting part counts.
    chains : list of Chain
        Whose tips and axes are positions of this mill.
    n : int
        The patch is looked at on a mesh n by n.

    Returns
    -------
    covered : Coverage
        With these chains.

    Examples
    --------
    >>> from tunneller_lib.milling.chains import Chain
    >>> plane = Patch(lambda s, t: [s, t, 0 * s], (0, 0.02), (0, 0.02))
    >>> contact = np.stack([np.linspace(0, 0.02, 6), np.full(6, 0.01), np.zeros(6)], axis=-1)
    >>> up = np.tile([0.0, 0.0, 1.0], (6, 1))
    >>> chain = Chain(*contact[:, :2].T, contact, up, contact, up, up[:, [0, 2, 1]], ("", ""))
    >>> round(coverage_of(plane, BallMill(0.005), [chain], n=21).share(1e-3), 2)
    0.35
    """
    mesh = patch.mesh(n)
    error = np.min([sweep_error(mesh, mill, one.tip, one.axis) for one in chains], axis=0)
    return Coverage(list(chains), error, areas(mesh), (mill,) * len(chains))


def _spread(contact, rows):
    """Return some of these rows whose contacts (n, 3) are far from each other."""
    away = norm(contact[rows] - contact[rows].mean(axis=0))
    taken = [int(np.argmin(away))]
    away = norm(contact[rows] - contact[rows[taken[0]]])
    away[taken] = -1.0
    while len(taken) < min(TRIED, len(rows)):
        taken.append(int(np.argmax(away)))
        away = np.minimum(away, norm(contact[rows] - contact[rows[taken[-1]]]))
        away[taken] = -1.0
    return rows[taken].tolist()


def _gain(error, alone, area, tolerance):
    """Return the area that one more strip, what it leaves alone, brings within a tolerance."""
    return float(area[(np.abs(error) > tolerance) & (np.abs(alone) <= tolerance)].sum())


def areas(mesh):
    """Return what each point of a mesh (n, m, 3) stands for, in m^2 (n, m)."""
    by_s = np.gradient(mesh, axis=0)
    by_t = np.gradient(mesh, axis=1)
    area = norm(np.cross(by_s, by_t))
    # A point of the border stands for half a cell, one of the corners for a quarter.
    area[[0, -1]] /= 2
    area[:, [0, -1]] /= 2
    return area
