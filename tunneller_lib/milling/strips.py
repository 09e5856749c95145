"""What a mill that moves along chains leaves: its error, widths of strips, coverage, scallops."""

from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Each, Length, Length0, NotNegative, Points, Sign, Whole, checked
from ..envelopes import adapted_frames
from ..envelopes.adapted import tangent_graph
from ..envelopes.jet import derivative
from ..kernels.exact import dot, norm
from .chains import Chain, motion_through, trace_chain
from .faces import Patch
from .positions import Cloud, Positions
from .tools import BallMill, ConicalMill, CylinderMill, seen_from

BLOCK = 200_000  # pairs of a place of the mill and a point that are handled together
BETWEEN = 8  # places from one position to the next; a search begins at the nearest of them
CLOSER = 12  # halvings of the step between places: the least distance is off by its square
FEWEST = 6  # positions of a chain that is kept
LEAST = 0.01  # of the patch's area, that a chain must add
TRIED = 6  # starts in a round; the one whose strip adds most is taken

Mill = ConicalMill | CylinderMill | BallMill
Chains = Each(Chain, some=True)


@checked
def sweep_error(points: Points, mill: Mill, chain: Chain):
    """Return how far points are from the space that a mill sweeps along a chain.

    Parameters
    ----------
    points : (..., 3) float
        Such as points of the wanted surface, in m.
    mill : ConicalMill, CylinderMill or BallMill
        Only its cutting part counts.
    chain : Chain
        Of four positions of the mill or more, through which it goes smoothly.

    Returns
    -------
    error : (...) float
        In m: what stays on the surface if positive, how deep it is cut if negative.

    Examples
    --------
    >>> tip = np.stack([np.linspace(0, 0.05, 6), np.zeros(6), np.zeros(6)], axis=-1)
    >>> up = np.tile((0.0, 0.0, 1.0), (6, 1))
    >>> chain = Chain(*tip.T[:2], tip, up, tip, up, up)
    >>> sweep_error([0.025, 0.006, 0.01], CylinderMill(0.005, 0.02), chain).round(6)
    np.float64(0.001)
    """
    motion = motion_through(chain.tip, chain.axis)
    last = len(chain) - 1
    places = np.linspace(0, last, BETWEEN * last + 1)
    tips, axes = motion(places)
    flat = points.reshape(-1, 3)
    error = np.empty(len(flat))
    size = max(1, BLOCK // len(places))
    for first in range(0, len(flat), size):
        part = slice(first, first + size)
        nearest = places[mill.cutting(*seen_from(flat[part], tips, axes)).argmin(axis=0)]
        error[part] = _closer(flat[part], mill, motion, nearest, 1 / BETWEEN, last)
    return error.reshape(points.shape[:-1])[()]


def _closer(points, mill, motion, where, step, last):
    """Return the least distances (n,) of points from a moving mill, near places (n,) of its way.

    The step to either side is halved: a parabola through three distances would be off where the
    nearest part of the mill changes, as at its edges.

    Examples
    --------
    After 12 halvings the nearest place of a ball is known to 1/65536 of the way between positions:

    >>> along, no, up = np.arange(6.0), np.zeros(6), np.tile([0.0, 0.0, 1.0], (6, 1))
    >>> motion = motion_through(np.stack([along, no, no], axis=-1), up)
    >>> point = np.array([[2.5 + 2**-16, 0.101, 0.1]])  # a millimetre beside the ball
    >>> left = _closer(point, BallMill(0.1), motion, np.array([2.5]), 1 / BETWEEN, 5)
    >>> ((left - 0.001) * 1e9).round(2)  # in nm
    array([1.15])
    """

    def distance(where):
        tip, axis = motion(where)
        return mill.cutting(*seen_from(points[:, None], tip, axis))[:, 0]

    least = distance(where)
    for _ in range(CLOSER):
        step /= 2
        for sign in (-1, 1):
            tried = np.clip(where + sign * step, 0, last)
            there = distance(tried)
            where = np.where(there < least, tried, where)
            least = np.minimum(there, least)
    return least


@dataclass(frozen=True, eq=False)
class Strip:
    """What a mill leaves across its way, at each position of a chain.

    Parameters
    ----------
    along : (k, m) float
        Way on the surface from the contact, across the chain, in m.
    error : (k, m) float
        As of `sweep_error`, in m; infinite beyond the patch.
    """

    along: np.ndarray
    error: np.ndarray

    @checked
    def widths(self, tolerance: Length):
        """Return how wide (k,), in m, the error about each contact stays within a tolerance."""
        middle = self.along.shape[1] // 2
        good = np.abs(self.error) <= tolerance
        right = np.logical_and.accumulate(good[:, middle:], axis=1).sum(axis=1) - 1
        left = np.logical_and.accumulate(good[:, middle::-1], axis=1).sum(axis=1) - 1
        row = np.arange(len(good))
        width = self.along[row, middle + right] - self.along[row, middle - left]
        return np.where(good[:, middle], width, 0.0)


@checked
def strip_across(patch: Patch, mill: Mill, chain: Chain, *, reach: Length, m: Whole(1, 500) = 100):
    """Return what a mill leaves along lines across a chain, but for its first and last two places.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill, CylinderMill or BallMill
        That moves.
    chain : Chain
        Of six positions of this mill or more; the lines run along its characteristics' tangents.
    reach : float
        To either side, in m.
    m : int
        Points to either side.

    Returns
    -------
    strip : Strip
        Of k - 4 lines; near its ends a chain cuts with less than its envelope.
    """
    if len(chain) < 6:
        raise ValueError(f"chain: must have 6 positions or more; got {len(chain)}.")
    inner = slice(2, -2)
    s, t = (part[inner] for part in (chain.s, chain.t))
    frames = adapted_frames(patch.surface, s, t, "space")
    # The tangents by s and t, in the frames; their pseudoinverse turns a direction on the surface
    # into rates of s and t.
    first = np.stack([np.stack(c.c[1:3], axis=-1) for c in frames.r], axis=1)
    rate = (np.linalg.pinv(first) @ (frames.axes @ chain.across[inner, :, None]))[..., 0]
    away = np.linspace(-reach, reach, 2 * m + 1)
    at_s = s[:, None] + rate[:, :1] * away
    at_t = t[:, None] + rate[:, 1:] * away
    beyond = (at_s < patch.s[0]) | (at_s > patch.s[1]) | (at_t < patch.t[0]) | (at_t > patch.t[1])
    points = patch.points(np.clip(at_s, *patch.s), np.clip(at_t, *patch.t))
    steps = norm(np.diff(points, axis=1))
    along = np.concatenate([np.zeros((len(s), 1)), np.cumsum(steps, axis=1)], axis=1)
    error = sweep_error(points, mill, chain)
    return Strip(along - along[:, m : m + 1], np.where(beyond, np.inf, error))


@checked
def ball_chain(chain: Chain, mill: BallMill):
    """Return a chain with a ball in place of its mill, which touches where the mill does.

    It isn't in the document and serves to compare. The axis stays that of the mill.
    """
    return replace(chain, tip=chain.contact + mill.radius * (chain.normal - chain.axis))


@checked
def cylinder_chain(patch: Patch, chain: Chain, mill: CylinderMill, *, which: Sign = 1):
    """Return a chain with a cylinder in place of its mill, whose flank touches where the mill does.

    It isn't in the document and serves to compare. The axis lies in the tangent plane so that the
    gap to the surface vanishes to second order in one direction, and is nowhere negative to that
    order; there are two such axes. The contact is at the middle of the cylinder's length.

    Parameters
    ----------
    patch : Patch
        The surface.
    chain : Chain
        Whose contacts are taken.
    mill : CylinderMill
        The cylinder.
    which : {1, -1}
        Which of the two axes, on either side of a principal direction.

    Returns
    -------
    chain : Chain
        With the cylinder's tips and axes.

    Raises
    ------
    ValueError
        If the cylinder is too thick: it gouges at a contact whatever its axis.
    """
    frames = adapted_frames(patch.surface, chain.s, chain.t, "space")
    g = tangent_graph(frames, slice(None))
    # Second derivatives of the height, positive where the surface bends towards the mill.
    xx, xy, yy = (patch.side * derivative(g, i, 2 - i) for i in (2, 1, 0))
    determinant = xx * yy - xy * xy
    # With the unit vector n across the axis: det(S - n n'/R) = 0 is n' adj(S) n = R det(S).
    mean = (xx + yy) / 2
    size = np.hypot((yy - xx) / 2, xy)
    cosine = (mill.radius * determinant - mean) / size
    if np.any(np.abs(cosine) > 1):
        raise ValueError(
            f"mill: must be thin enough to touch without gouging; got the radius {mill.radius:g} m."
        )
    middle = np.arctan2(-xy, (yy - xx) / 2)
    angle = ((middle + which * np.arccos(cosine)) / 2 + np.pi / 2)[:, None]
    axis = np.cos(angle) * frames.axes[:, 0] + np.sin(angle) * frames.axes[:, 1]
    # The line has no direction yet: the first axis takes that of the chain's, and no axis turns
    # back against the one before.
    turns = dot(axis[1:], axis[:-1])
    first = np.where(dot(axis[0], chain.axis[0]) < 0, -1.0, 1.0)
    signs = first * np.cumprod(np.append(1.0, np.where(turns < 0, -1.0, 1.0)))
    axis = signs[:, None] * axis
    tip = chain.contact + mill.radius * chain.normal - mill.length / 2 * axis
    return replace(chain, tip=tip, axis=axis)


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
    """

    chains: list
    error: np.ndarray
    area: np.ndarray

    @checked
    def share(self, tolerance: NotNegative):
        """Return the share of the patch's area where the error is within a tolerance, in m."""
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
    most: Whole(1, 100) = 12,
    n: Whole(2, 500) = 121,
):
    """Return chains along which a mill covers a patch, as far as positions allow.

    Parameters
    ----------
    patch, mill
        As for `find_positions`.
    found : Positions
        Chains begin at those that fit.
    step, tolerance, others
        As for `trace_chain`.
    most : int
        Chains at most, 1 to 100.
    n : int
        The patch is looked at on a mesh n by n.

    Returns
    -------
    covered : Coverage
        In each round chains are traced from six positions that lie far from each other, of those
        whose contact isn't within the tolerance yet. The chain that brings most area within the
        tolerance is kept, if it has six positions and adds a hundredth of the patch.
    """
    about = {"step": step, "tolerance": tolerance, "others": others, "n": n}
    mesh = patch.mesh(n)
    area = _areas(mesh)
    error = np.full(area.shape, np.inf)
    chains = []
    left = np.where(found.fits, np.inf, -np.inf)
    strips = {}  # by the row of the start: the chain from there, and what it leaves alone
    while len(chains) < most and np.any(left > tolerance):
        tried = _spread(found.contact, np.flatnonzero(left > tolerance))
        for row in tried:
            if row not in strips:
                chain = trace_chain(patch, mill, found, row, **about)
                short = len(chain) < FEWEST
                strips[row] = chain, np.inf if short else sweep_error(mesh, mill, chain)
        gains = {row: _gain(error, strips[row][1], area, tolerance) for row in tried}
        best = max(gains, key=gains.get)
        if gains[best] < LEAST * area.sum():
            left[tried] = -np.inf
            continue
        chain, alone = strips[best]
        chains.append(chain)
        error = np.minimum(error, alone)
        left[best] = -np.inf
        left = np.minimum(left, np.abs(sweep_error(found.contact, mill, chain)))
    return Coverage(chains, error, area)


@checked
def coverage_of(patch: Patch, mill: Mill, chains: Chains, *, n: Whole(2, 500) = 121):
    """Return what a mill leaves of a patch when it goes along chains.

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
    >>> plane = Patch(lambda s, t: [s, t, 0 * s], (0, 0.02), (0, 0.02))
    >>> contact = np.stack([np.linspace(0, 0.02, 6), np.full(6, 0.01), np.zeros(6)], axis=-1)
    >>> up = np.tile([0.0, 0.0, 1.0], (6, 1))
    >>> chain = Chain(*contact[:, :2].T, contact, up, contact, up, up[:, [0, 2, 1]])
    >>> round(coverage_of(plane, BallMill(0.005), [chain], n=21).share(1e-3), 2)
    0.35
    """
    mesh = patch.mesh(n)
    error = np.min([sweep_error(mesh, mill, one) for one in chains], axis=0)
    return Coverage(list(chains), error, _areas(mesh))


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
    """Return the area that one more strip brings within a tolerance; `alone` is what it leaves."""
    return float(area[(np.abs(error) > tolerance) & (np.abs(alone) <= tolerance)].sum())


def _areas(mesh):
    """Return what each point of a mesh (n, m, 3) stands for, in m^2 (n, m)."""
    by_s = np.gradient(mesh, axis=0)
    by_t = np.gradient(mesh, axis=1)
    area = norm(np.cross(by_s, by_t))
    # A point of the border stands for half a cell, one of the corners for a quarter.
    area[[0, -1]] /= 2
    area[:, [0, -1]] /= 2
    return area


@checked
def find_scallops(patch: Patch, mill: Mill, chains: Chains, *, m: Whole(2, 500) = 60):
    """Return the scallops between the strips of a mill.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill, CylinderMill or BallMill
        That goes along the chains.
    chains : list of Chain
        Of positions of this mill.
    m : int
        Points of each line at which the height is looked for.

    Returns
    -------
    lines : (k, 4) int
        Where each line begins, a chain and a position on it, and where it ends, counted from 0.
    height : (k,) float
        The most that all strips together leave on it, in m.

    Notes
    -----
    From each contact, to either side, a line goes to the nearest contact of another chain that
    lies more across than along. It is straight in the patch's parameters. The first and the last
    two positions of a chain begin none, for there a chain cuts with less than its envelope, nor
    are they ends; each pair of contacts has one line.

    Examples
    --------
    Two ways of a ball, 4 mm apart, leave a ridge 417 um high; points beside its crest are lower:

    >>> plane = Patch(lambda s, t: [s, t, 0 * s], (0, 0.02), (0, 0.02))
    >>> up = np.tile([0.0, 0.0, 1.0], (6, 1))
    >>> s, across = np.linspace(0, 0.02, 6), up[:, [0, 2, 1]]
    >>> ways = [np.stack([s, 0 * s + t, 0 * s], axis=-1) for t in (0.008, 0.012)]
    >>> chains = [Chain(*tip[:, :2].T, tip, up, tip, up, across) for tip in ways]
    >>> lines, height = find_scallops(plane, BallMill(0.005), chains)
    >>> lines.tolist(), (1e6 * height).round(1)
    ([[0, 2, 1, 2], [0, 3, 1, 3]], array([372.7, 372.7]))
    """
    inner = [(c, p) for c, one in enumerate(chains) for p in range(2, len(one) - 2)]
    contact, across, s, t = (
        np.array([getattr(chains[c], name)[p] for c, p in inner])
        for name in ("contact", "across", "s", "t")
    )
    owner = np.array([c for c, _ in inner])
    pairs = set()  # of contacts on two chains, each pair once
    for k in range(len(inner)):
        away = contact - contact[k]
        distance = norm(away)
        sideways = dot(away, across[k])
        for side in (1, -1):
            beside = (owner != owner[k]) & (side * sideways > np.sqrt(0.5) * distance)
            if beside.any():
                nearest = int(np.where(beside, distance, np.inf).argmin())
                pairs.add((min(k, nearest), max(k, nearest)))
    ends = np.array(sorted(pairs), dtype=int).reshape(-1, 2)
    lines = np.array(inner, dtype=int).reshape(-1, 2)[ends].reshape(-1, 4)
    if not len(lines):
        return lines, np.empty(0)
    first, last = ends.T
    points = patch.points(*(np.linspace(x[first], x[last], m, axis=1) for x in (s, t)))
    # One strip at a time: of many chains all together would take too much memory.
    left = np.min([sweep_error(points, mill, one) for one in chains], axis=0)
    return lines, left.max(axis=1)
