"""Chains that cover a patch, one after the other, and what they leave together."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Length, Length0, NotNegative, Whole, checked
from ..exact import norm
from .chains import trace_chains
from .five_axes import TiltingTable
from .patch import Cloud, Patch
from .positions import Positions
from .sweep import sweep_error
from .tools import ConicalMill

FEWEST = 6  # positions of a chain that is kept


@dataclass(frozen=True)
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
    """

    chains: list
    error: np.ndarray
    area: np.ndarray

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
    others: Cloud | None = None,
    machine: TiltingTable | None = None,
    most: Whole(1, 100) = 12,
    n: Whole(2, 500) = 121,
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
        Chains at most, 1 to 100.
    n : int
        The patch is looked at on a mesh n by n.
    say : callable, optional
        Is given a sentence a chain.

    Returns
    -------
    covered : Coverage
        A chain begins at the position whose contact is farthest from what those before it leave,
        and needs six positions; one whose contact is left within the tolerance begins none.
    """
    mesh = patch.mesh(n)
    error = np.full(mesh.shape[:2], np.inf)
    left = np.full(len(found), np.inf)
    left[~found.fits] = -np.inf
    chains = []
    while len(chains) < most and np.any(left > tolerance):
        row = int(np.argmax(left))
        alone = np.where(np.arange(len(found)) == row, found.reason, "")
        options = {
            "step": step,
            "tolerance": tolerance,
            "others": others,
            "machine": machine,
            "n": n,
        }
        [chain] = trace_chains(patch, mill, replace(found, reason=alone), **options)
        left[row] = -np.inf
        if len(chain) < FEWEST:
            continue
        chains.append(chain)
        error = np.minimum(error, sweep_error(mesh, mill, chain.tip, chain.axis))
        at = sweep_error(found.contact, mill, chain.tip, chain.axis)
        left = np.minimum(left, np.abs(at))
        if say:
            say(f"chain {len(chains)}: {len(chain)} positions; {chain.ends[0]}, {chain.ends[1]}")
    return Coverage(chains, error, areas(mesh))


def areas(mesh):
    """Return what each point of a mesh (n, m, 3) stands for, in m^2 (n, m)."""
    by_s = np.gradient(mesh, axis=0)
    by_t = np.gradient(mesh, axis=1)
    area = norm(np.cross(by_s, by_t))
    # A point of the border stands for half a cell, one of the corners for a quarter.
    area[[0, -1]] /= 2
    area[:, [0, -1]] /= 2
    return area
