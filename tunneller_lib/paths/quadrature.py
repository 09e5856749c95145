"""Gauss and Legendre's quadrature, and the lengths of paths by it, panel by panel."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ..kernels.exact import in_blocks, norm

ORDER = 48  # nodes on a panel
BLOCK = 1024  # paths measured at once, whose nodes fit the cache
RESOLVED = 1e-10  # of the straight way: the error that a panel may have
ROUNDING = 1e-14  # of r + R, for each rad of the angles: the error of a length by their roundings
GAPS = 10  # times a panel's error: what the gaps between all panels of a path may come to
HALVINGS = 30  # of a panel, after which a path counts as one that jumps


@cache
def gauss_rule(count):
    """Return so many nodes (count,), from -1 to 1, and their weights; neither may be written to.

    They are kept, for they come from an eigenvalue problem, which takes longer than most sums.
    """
    rule = legendre.leggauss(count)
    for row in rule:
        row.flags.writeable = False
    return rule


class Panel(NamedTuple):
    """Some paths between two shares of their way.

    Parameters
    ----------
    rows : (k,) int
        Which of the paths.
    low, high : float
        The shares, from 0 to 1.
    series : (ORDER, k) float
        The Legendre series of the speed in x, from -1 to 1. Its first term is the mean speed, and
        half the length.
    ends : (2, k, 3) float
        The first and the last point, in m, by the polynomials through the nodes.
    """

    rows: np.ndarray
    low: float
    high: float
    series: np.ndarray
    ends: np.ndarray

    def pick(self, kept):
        """Return the panel of those paths only that are `kept`, (k,) bool."""
        return Panel(self.rows[kept], *self[1:3], self.series[:, kept], self.ends[:, kept])


def panels(torus, way, p, q):
    """Return panels that make up paths on a torus, for each path from p to q in order.

    Parameters
    ----------
    torus : Torus
        The surface.
    way : callable
        Returns the joint positions (k, n, 2) for p, q and shares t (n,) of the way.
    p, q : (k, 2) float
        Joint positions of the ends, in rad.

    Returns
    -------
    panels : list of Panel
        Together they give each length to 1e-9 of itself, or to what the roundings of angles make of
        it: 1e-13 (r + R) for angles up to a turn.

    Raises
    ------
    ValueError
        If by its points a path jumps, or doesn't lead from p to q.

    Notes
    -----
    On a panel the angles are polynomials through ORDER nodes. These can't miss anything: a swing
    between two nodes leaves a step of the angles, while a spike of the speed alone could fall
    between two nodes. A panel is good enough where the last terms of the speed's series are small,
    or where its halves together are as long as it is, as also happens where rounding spoils the
    terms. Other panels are halved. A path that jumps just where two panels meet, as where a chord
    crosses the axis there, is found by the gap between them.
    """
    first, last = (torus.point(*np.moveaxis(end, -1, 0)) for end in (p, q))
    turned = np.maximum(1, np.abs(way(p, q, np.array([0.0, 1.0]))).max(axis=(1, 2)))
    within = RESOLVED * norm(last - first) + ROUNDING * (torus.r + torus.R) * turned

    def measured(rows, low, high):
        t, _, _, _, _ = _rules()
        joint = way(p[rows], q[rows], low + (high - low) * t)
        return Panel(rows, low, high, *_speed_and_ends(torus, joint))

    def off_ends(panel):
        """Return by how much a panel misses p or q, where it begins or ends there."""
        before = norm(panel.ends[0] - first[panel.rows]) if panel.low == 0 else 0.0
        return before + (norm(panel.ends[1] - last[panel.rows]) if panel.high == 1 else 0.0)

    def settled(panel, halvings):
        """Yield the panel, or what it is halved into, until all parts are good enough."""
        # The ends count, too: a path may begin or end elsewhere than at p and q.
        tail = np.max(np.abs(panel.series[-4:]), axis=0)
        enough = tail + off_ends(panel) <= within[panel.rows]
        yield panel if enough.all() else panel.pick(enough)
        panel = panel.pick(~enough)
        if not panel.rows.size:
            return
        if halvings == 0:
            raise _jump(p, q, panel.rows[0], panel.low)
        # Where both halves together have the length of the whole, nothing was missed.
        middle = (panel.low + panel.high) / 2
        halves = measured(panel.rows, panel.low, middle), measured(panel.rows, middle, panel.high)
        change = np.abs(halves[0].series[0] + halves[1].series[0] - panel.series[0])
        gap = norm(halves[1].ends[0] - halves[0].ends[1])
        enough = change + gap + sum(map(off_ends, halves)) <= within[panel.rows]
        for half in halves:
            yield half.pick(enough)
            yield from settled(half.pick(~enough), halvings - 1)

    every = settled(measured(np.arange(len(p)), 0.0, 1.0), HALVINGS)
    found = [panel for panel in every if panel.rows.size]
    # The gaps between the panels of a path, and at its ends, count together.
    reached, gaps = first.copy(), np.zeros(len(p))
    for rows, low, _, _, (start, stop) in found:
        gaps[rows] += norm(start - reached[rows])
        _check_joined(p, q, rows, low, gaps[rows] / within[rows])
        reached[rows] = stop
    _check_joined(p, q, np.arange(len(p)), 1.0, (gaps + norm(last - reached)) / within)
    return found


def path_lengths(torus, way, p, q):
    """Return the lengths (...), in m, of paths on a torus from p to q (..., 2), by their way.

    They are as exact as `panels` says, and it refuses the same paths.

    Examples
    --------
    All of these run along an outer equator of radius 2 m. One comes back over the seam of its
    angles, another has been round many times, and a short one goes to the wrong side first.

    >>> from tunneller_lib.surfaces import Torus
    >>> torus = Torus(1, 1)
    >>> def straight(p, q, t):
    ...     return p[:, None] + t[:, None] * (q - p)[:, None]
    >>> def reduced(p, q, t):
    ...     return np.mod(straight(p, q, t) + np.pi, 2 * np.pi) - np.pi
    >>> def turning(p, q, t):
    ...     return straight(p, q, np.interp(t, [0, 0.3, 1], [0, -0.5, 1]))
    >>> float(path_lengths(torus, reduced, (3, 0), (3.5, 0)).round(9))
    1.0
    >>> float(path_lengths(torus, straight, (1e8, 0), (1e8 + 0.5, 0)).round(5))
    1.0
    >>> float(path_lengths(torus, turning, (0.1, 0), (0.1001, 0)).round(12))
    0.0004
    """

    def of_block(ends):
        p, q = np.split(ends, 2, axis=-1)
        total = np.zeros((len(ends), 1))
        for panel in panels(torus, way, p, q):
            total[panel.rows, 0] += 2 * panel.series[0]
        return total

    ends = np.concatenate(np.broadcast_arrays(p, q), axis=-1)
    return in_blocks(of_block, ends, 1, BLOCK)[..., 0]


def _check_joined(p, q, rows, t, gaps):
    """Raise ValueError where the gaps (k,) of paths up to t, in errors of a panel, make a jump."""
    if np.any(gaps > GAPS):
        raise _jump(p, q, rows[np.argmax(gaps)], t)


def _jump(p, q, row, t):
    """Return the ValueError that says that the path of a `row` of p and q jumps at t."""
    ends = " to ".join(f"({theta:g}, {phi:g})" for theta, phi in (p[row], q[row]))
    return ValueError(
        "p, q: must be ends whose path doesn't jump, as the foot of a chord does where it crosses "
        f"the axis or the ring circle; got {ends} rad, which at {t:g} of the way does, or nearly."
    )


def _speed_and_ends(torus, joint):
    """Return the speed's series (ORDER, k) and the ends (2, k, 3) of paths on a panel.

    `joint` are the joint positions (k, ORDER, 2) at its nodes.
    """
    _, weights, slope, basis, ends = _rules()
    # An angle that comes reduced to one turn, as from -pi to pi, jumps where the path doesn't.
    span = np.ptp(joint, axis=1, keepdims=True)
    wrapped = (np.pi < span) & (span <= 2 * np.pi)
    if np.any(wrapped):
        joint = np.where(wrapped, np.unwrap(joint, axis=1), joint)
    theta, phi = np.moveaxis(joint, -1, 0)
    # By the metric of the torus, ds^2 = rho^2 dtheta^2 + R^2 dphi^2.
    rho = torus.r + torus.R * np.cos(phi)
    speed = np.hypot(rho * (theta @ slope.T), torus.R * (phi @ slope.T))
    series = np.moveaxis((speed * weights) @ basis, -1, 0)
    return series, torus.point((theta @ ends.T).T, (phi @ ends.T).T)


@cache
def _rules():
    """Return what a panel needs: nodes from 0 to 1, weights, and three matrices.

    The first takes values at the nodes to derivatives there, the second speeds times weights to
    the speed's series, the third values to those at both ends of the panel.
    """
    x, weights = gauss_rule(ORDER)
    # A value at the nodes is `values` times a series of Legendre's polynomials. So what takes
    # series to slopes, or to the ends, has to be divided by `values`.
    values = legendre.legvander(x, ORDER - 1)
    slopes = np.stack([legendre.legval(x, legendre.legder(row)) for row in np.eye(ORDER)], axis=1)
    slope = np.linalg.solve(values.T, slopes.T).T
    ends = np.linalg.solve(values.T, legendre.legvander(np.array([-1.0, 1.0]), ORDER - 1).T).T
    return (1 + x) / 2, weights, slope, values * (np.arange(ORDER) + 0.5), ends
