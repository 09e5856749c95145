"""Cones that touch a patch twice, near those in third-order contact, and make wider strips."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Length0, Rule, Whole, bounded_array, checked, shown
from ..envelopes.functions import Function
from ..envelopes.jet import jet_variables
from ..kernels.exact import dot, norm
from .chains import Chain, conjugate_frame, fitting
from .five_axes import TiltingTable
from .obstacles import Around
from .patch import Patch
from .positions import depths_of
from .sweep import strip_across
from .tools import ConicalMill

SHARE = 0.93  # of a strip's width, between contacts: amid them 0.93^4 of the tolerance stays
LOOKS = 60  # points to either side at which a strip is looked at for its width
NO_PAIR = "no pair of contacts fits"
FIRST = 0.1  # of a patch's size, a distance of contacts to begin with
ROUNDS = 12  # of Newton's method, which doubles the digits in each
SMALL = 1e-11  # a residual, over the distance of the contacts, that is rounding
_H = 1e-30  # of a complex step, which makes derivatives to the last digit


def _apart(name, value):
    """Return `value`, one length or a row of them, all above zero."""
    array = bounded_array(name, value)
    if array.ndim > 1 or not np.all(array > 0):
        raise ValueError(
            f"{name}: must be above zero, one length or one a position; got {shown(value)}."
        )
    return array


# What arguments may be, in this room and above it.
Apart = Annotated[ArrayLike, Rule("float or (k,) float", _apart, "m")]


@dataclass(frozen=True, eq=False)
class TwoContacts:
    """Positions of a conical mill that touches a patch twice: arrays with a row a position.

    Parameters
    ----------
    found : (k,) bool
        Whether there is one; where not, the row is that of the chain.
    s, t : (k, 2) float
        Parameters of the contacts.
    contact : (k, 2, 3) float
        Where the mill touches, in m.
    tip, axis : (k, 3) float
        The middle of the mill's lower end, in m, and the unit vector from there to the spindle.
    enters, holder_enters, others_enter : (k,) float
        As of `Positions`.
    """

    found: np.ndarray
    s: np.ndarray
    t: np.ndarray
    contact: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    enters: np.ndarray
    holder_enters: np.ndarray
    others_enter: np.ndarray

    def __len__(self):
        return len(self.tip)


@checked
def touch_twice(
    patch: Patch,
    mill: ConicalMill,
    chain: Chain,
    *,
    apart: Apart,
    others: Around | None = None,
    n: Whole(2, 500) = 121,
):
    """Return positions that touch a patch twice, on lines across a chain.

    Parameters
    ----------
    patch, mill, chain
        A chain of this mill on this patch, in third-order contact.
    apart : float or (k,) float
        Between the two contacts, in m, measured in the tangent plane amid them: the same at all
        positions, or at each its own.
    others, n
        As for `find_positions`.

    Returns
    -------
    twice : TwoContacts
        A row a position of the chain. There is none where a contact would be beyond the patch.

    Raises
    ------
    ValueError
        If the distances aren't above zero, or not as many as the positions.

    Notes
    -----
    Envelopes of cones, section 4, says that there are such cones near those in third-order contact.
    The middle of the contacts is the chain's. Six equations, that distance and both slopes vanish
    at either contact, for six unknowns: the vertex, two turns of the axis, and the direction from
    one contact to the other. As the contacts fall together the six become those of third-order
    contact. By Newton's method.

    To fourth order the distance along that direction is c x^4 for the cone in third-order contact
    and c (x^2 - a^2)^2 for one that touches at a and -a. If c > 0, neither enters the surface, and
    within the same tolerance the second is wider by the root of two at best, at c a^4 = tolerance.

    Examples
    --------
    >>> from tunneller_lib.milling import find_positions, trace_chains
    >>> patch = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
    >>> mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    >>> starts = find_positions(patch, mill, 0.001, 0.0, tolerance=1e-4)
    >>> chain = trace_chains(patch, mill, starts, step=1e-3, tolerance=1e-4)[0]
    >>> bool(touch_twice(patch, mill, chain, apart=2e-3).found.any())
    True
    """
    vertex = chain.tip - mill.below * chain.axis
    ruling = chain.contact - vertex
    way, inverse = conjugate_frame(patch, chain.s, chain.t, ruling / norm(ruling)[:, None])
    if np.size(apart) not in (1, len(chain)):
        raise ValueError(f"apart: must be one length or {len(chain)}; got {np.size(apart)}.")
    apart = np.broadcast_to(apart, len(chain))[:, None]
    lines = _Lines(patch, chain, way, inverse, apart / 2)
    axis = chain.axis.copy()
    turn = np.zeros(len(chain))
    with np.errstate(all="ignore"):  # a row that runs away is answered by `found`
        for _ in range(ROUNDS):
            values, slopes = _equations(lines, mill.half_angle, vertex, axis, turn)
            step = _solved(slopes, values)
            vertex = vertex - apart * step[:, :3]
            axis = axis - np.einsum("ni,nij->nj", step[:, 3:5], _beside(axis))
            axis = axis / norm(axis)[:, None]
            turn = turn - step[:, 5]
        values, _ = _equations(lines, mill.half_angle, vertex, axis, turn)
        found = np.abs(values).max(axis=1) < SMALL
        found &= (dot(axis, chain.axis) > 0) & lines.within(turn)
    s, t = lines.places(np.where(found, turn, 0.0))
    tip = np.where(found[:, None], vertex + mill.below * axis, chain.tip)
    axis = np.where(found[:, None], axis, chain.axis)
    depths = depths_of(patch, mill, tip, axis, others, n)
    return TwoContacts(found, s, t, patch.points(s, t), tip, axis, *depths)


@checked
def touch_seam(
    patch: Patch,
    mill: ConicalMill,
    chain: Chain,
    seam: Function(2),
    *,
    tolerance: Length0,
    others: Around | None = None,
    machine: TiltingTable | None = None,
    n: Whole(2, 500) = 121,
):
    """Return the `Chain` of cones that touch twice, one of the contacts on a curve, the seam.

    Two strips that touch along one seam join there with a common tangent.

    Parameters
    ----------
    patch, mill, chain
        As for `touch_twice`; of six positions or more.
    seam : callable
        Of parameters s and t: zero on the seam, with a sign to either side, and smooth. What it
        raises itself passes through.
    tolerance, others, machine, n
        As for `find_positions`.

    Returns
    -------
    joined : Chain or None
        The longest row of such positions next to each other that fit, if there is one.

    Notes
    -----
    By the rule of false position on the distance of the contacts, with which the seam's function
    falls nearly evenly.
    """
    before = seam(chain.s, chain.t)
    size = np.ptp(patch.mesh(9).reshape(-1, 3), axis=0).max()
    apart = np.full(len(chain), FIRST * size)
    for _ in range(ROUNDS):
        two = touch_twice.unchecked(patch, mill, chain, apart=apart, n=2)
        left = seam(two.s, two.t)
        left = left[:, np.abs(left).sum(axis=0).argmin()]
        with np.errstate(all="ignore"):
            nearer = apart * before / (before - left)
        apart = np.where(two.found & (nearer > 0) & np.isfinite(nearer), nearer, apart)
    return touch_along(patch, mill, chain, tolerance, others, machine, n, apart)


def touch_along(patch, mill, chain, tolerance, others, machine, n, apart=None):
    """Return the `Chain` of cones that touch twice, near another chain, as far as they fit.

    Parameters
    ----------
    patch, mill, chain
        As for `touch_twice`; of six positions or more.
    tolerance, others, machine, n
        As for `find_positions`.
    apart
        As for `touch_twice`; None for nearly the width of the chain's strip within the tolerance.

    Returns
    -------
    twice : Chain or None
        The longest row of such positions next to each other, if there is one. Its contacts are
        those of the given chain, amid the two.
    """
    if apart is None:
        size = np.ptp(patch.mesh(9).reshape(-1, 3), axis=0).max()
        strip = strip_across(patch, mill, chain, chain.tip, chain.axis, reach=size / 2, m=LOOKS)
        apart = SHARE * np.median(strip.widths(tolerance)) if tolerance else 0.0
        if not apart:
            return None
    two = touch_twice.unchecked(patch, mill, chain, apart=apart, others=others, n=n)
    fits = two.found & (two.enters <= tolerance)
    fits &= (two.holder_enters == 0) & (two.others_enter == 0)
    if not fits.any():
        return None
    runs = np.split(np.arange(len(chain)), np.flatnonzero(np.diff(fits)) + 1)
    run = max(runs, key=lambda rows: np.sum(fits[rows]))
    ends = [
        end if place in run else NO_PAIR
        for end, place in zip(chain.ends, (0, len(chain) - 1), strict=True)
    ]
    same = chain.s, chain.t, chain.contact, chain.normal
    parts = [part[run] for part in (*same, two.tip, two.axis, chain.across)]
    return fitting(patch, mill, parts, len(run) // 2, ends, tolerance, others, machine, n)


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines through the contacts of a chain, in its tangent planes, and places to either side."""

    patch: Patch
    chain: Chain
    way: np.ndarray
    inverse: np.ndarray
    half: np.ndarray  # (k, 1), the distance from the middle to either contact, in m

    def rates(self, turn):
        """Return changes (k, 2, 2) of s and t from the middle to both contacts, and by the turn."""
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        across = self.chain.across
        way = self.way
        ends = np.stack([self.half, -self.half], axis=1)
        return [
            ends * np.einsum("nij,nj->ni", self.inverse, direction)[:, None]
            for direction in (c * across + s * way, c * way - s * across)
        ]

    def asked(self, turn):
        """Return parameters (k, 2) of both contacts, be they beyond the patch."""
        rates = self.rates(turn)[0]
        return self.chain.s[:, None] + rates[..., 0], self.chain.t[:, None] + rates[..., 1]

    def places(self, turn):
        """Return parameters (k, 2) of both contacts, of the patch's border where it ends."""
        s, t = self.asked(turn)
        return np.clip(s, *self.patch.s), np.clip(t, *self.patch.t)

    def within(self, turn):
        """Return whether both contacts (k,) are within the patch."""
        pairs = zip(self.asked(turn), self.places(turn), strict=True)
        return np.logical_and.reduce([np.all(asked == there, axis=1) for asked, there in pairs])


def _equations(lines, half_angle, vertex, axis, turn):
    """Return the six equations (k, 6), and their slopes (k, 6, 6), of cones at two contacts.

    The unknowns are shifts of the vertex, over the distance of the contacts, turns of the axis, and
    the turn of the line through both.
    """
    turn = np.where(np.isfinite(turn), turn, 0.0)
    jets = lines.patch.surface(*jet_variables(*lines.places(turn)))
    r, rs, rt, rss, rst, rtt = (
        np.stack([factor * part.c[place] for part in jets], axis=-1)
        for place, factor in ((0, 1), (1, 1), (2, 1), (3, 2), (4, 1), (5, 2))
    )
    ds, dt = (lines.rates(turn)[1][..., k, None] for k in (0, 1))
    apart = 2 * lines.half

    def values(vertex, axis, r, rs, rt):
        """Return distances over that of the contacts, and slopes, one after the other (k, 6)."""
        away = r - vertex[:, None]
        height = np.sum(away * axis[:, None], axis=-1)[..., None]
        off = away - height * axis[:, None]
        radius = np.sqrt(np.sum(off * off, axis=-1))[..., None]
        cosine, sine = np.cos(half_angle), np.sin(half_angle)
        n = cosine * off / radius - sine * axis[:, None]
        distance = (cosine * radius - sine * height)[..., 0] / apart
        slopes = [np.sum(n * part, axis=-1) / norm(part.real) for part in (rs, rt)]
        return np.concatenate([distance, *slopes], axis=1)

    i = 1j * _H
    beside = _beside(axis)
    moved = [(vertex + i * apart * e, axis, r, rs, rt) for e in np.eye(3)]
    moved += [(vertex, axis + i * beside[:, k], r, rs, rt) for k in (0, 1)]
    along = (
        r + i * (rs * ds + rt * dt),
        rs + i * (rss * ds + rst * dt),
        rt + i * (rst * ds + rtt * dt),
    )
    moved.append((vertex, axis, *along))
    slopes = np.stack([values(*one).imag / _H for one in moved], axis=-1)
    return values(vertex, axis, r, rs, rt), slopes


def _beside(axis):
    """Return two unit vectors (k, 2, 3) at right angles to axes (k, 3) and to each other."""
    least = np.eye(3)[np.abs(axis).argmin(axis=1)]
    first = np.cross(axis, least)
    first = first / norm(first)[:, None]
    return np.stack([first, np.cross(axis, first)], axis=1)


def _solved(slopes, values):
    """Return the solutions (k, 6) of linear equations, NaN where these aren't finite."""
    sound = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(values).all(axis=1)
    found = np.full_like(values, np.nan)
    found[sound] = (np.linalg.pinv(slopes[sound]) @ values[sound][..., None])[..., 0]
    return found
