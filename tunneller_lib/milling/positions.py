"""Positions of a conical mill in third-order contact with a patch, and why some don't fit."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Length0, Reals, Whole, checked
from ..envelopes import hyperosculating_cones
from .faces import Patch
from .tools import ConicalMill, seen_from

BLOCK = 200_000  # pairs of a position and a point that are handled together, to save memory
CLOSER = 3  # nested windows in which the deepest point is looked for between those of the mesh
AROUND = 7  # points each way in a window, of which the first is two cells wide
ROUNDS = 20  # of such a search, at most
Cloud = Array("(n, 3) float", "m", last="x, y, z")


@dataclass(frozen=True, eq=False)
class Positions:
    """Positions of a conical mill: arrays with a row a position.

    Parameters
    ----------
    index : (k,) int
        Which of the points, counted through the flattened arrays.
    s, t : (k,) float
        Parameters of the contact.
    contact, normal : (k, 3) float
        Where the mill touches, in m, and the unit normal that points to its side.
    tip, axis : (k, 3) float
        The middle of the mill's lower end, in m, and the unit vector from there to the spindle.
    distance : (k,) float
        From the cone's vertex to the contact, in m.
    enters, holder_enters : (k,) float
        How deep mill and holder enter the patch, in m; infinite for a position on the other side
        or off the cutting part, where that isn't asked.
    others_enter : (k,) float
        How deep the deepest of the other points lies in mill or holder, in m, likewise.
    reason : (k,) str
        "fits", or the first reason why not: "on the other side", "off the cutting part",
        "gouges at its contact", "enters the surface elsewhere", "holder enters the surface",
        "enters a neighbour".
    """

    index: np.ndarray
    s: np.ndarray
    t: np.ndarray
    contact: np.ndarray
    normal: np.ndarray
    tip: np.ndarray
    axis: np.ndarray
    distance: np.ndarray
    enters: np.ndarray
    holder_enters: np.ndarray
    others_enter: np.ndarray
    reason: np.ndarray

    def __len__(self):
        return len(self.tip)

    @property
    def fits(self):
        """Return which rows (k,) fit."""
        return self.reason == "fits"


@checked
def find_positions(
    patch: Patch,
    mill: ConicalMill,
    s: Reals,
    t: Reals,
    *,
    tolerance: Length0,
    others: Cloud | None = None,
    n: Whole(2, 500) = 121,
):
    """Return all positions of a conical mill in third-order contact with a patch at points.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill
        Its size is fixed: a cone fits only if its contact lies on the cutting part.
    s, t : (...) float
        Parameters of the points.
    tolerance : float
        How deep the mill may enter the patch, in m. The holder may not.
    others : (n, 3) float, optional
        Points of neighbouring blades or a hub that mill and holder must stay off, in m. What is
        between them isn't looked at, so they must lie close together.
    n : int
        The patch is looked at on a mesh n by n, and between the mesh's points near the deepest.

    Returns
    -------
    positions : Positions
        Those that fit and those that don't, with the reasons.

    Notes
    -----
    Envelopes of cones, section 6. The verdict at the contact is that of `hyperosculating_cones`. A
    position that gouges there by less than the tolerance fits all the same: along an envelope that
    is known to an error only, the sign of the fourth-order term is noise.

    Examples
    --------
    >>> patch = Patch(lambda s, t: [s, t, 30 * s * t], (-0.01, 0.01), (-0.01, 0.01))
    >>> mill = ConicalMill(0.2, 0.01, 0.2, 0.03, 0.05)
    >>> found = find_positions(patch, mill, 0.001, [0.0, 0.002], tolerance=1e-5)
    >>> len(found), int(found.fits.sum())
    (8, 4)

    A ridge that is thinner than the mesh's cells may pass between them unseen:

    >>> high = lambda t: 0.001 * np.exp(-(((t + 0.003360996) / 1e-5) ** 2))
    >>> ridge = Patch(lambda s, t: [s, t, 30 * s * t + high(t)], (-0.01, 0.01), (-0.01, 0.01))
    >>> int(find_positions(ridge, mill, 0.001, [0.0, 0.002], tolerance=1e-5).fits.sum())
    4
    >>> int(find_positions(ridge, mill, 0.001, [0.0, 0.002], tolerance=1e-5, n=242).fits.sum())
    0
    """
    s, t = np.broadcast_arrays(s, t)
    cones = hyperosculating_cones(patch.surface, s, t, half_angle=mill.half_angle, model="space")
    near, far = mill.rulings
    side = cones.side == patch.side
    on = (cones.distance >= near) & (cones.distance <= far)
    asked = np.flatnonzero(side & on)
    tip = cones.vertex + mill.below * cones.axis
    depths = np.full((3, len(cones)), np.inf)
    depths[:, asked] = depths_of(patch, mill, tip[asked], cones.axis[asked], others, n)
    own, holder, other = depths
    # From the last reason to the first.
    reason = np.full(len(cones), "fits", dtype="<U28")
    reason[other > 0] = "enters a neighbour"
    reason[holder > 0] = "holder enters the surface"
    reason[own > tolerance] = "enters the surface elsewhere"
    reason[(own > tolerance) & cones.gouges] = "gouges at its contact"
    reason[~on] = "off the cutting part"
    reason[~side] = "on the other side"
    at = cones.index
    normal = patch.side * cones.normal
    contact = s.ravel()[at], t.ravel()[at], cones.contact, normal
    return Positions(at, *contact, tip, cones.axis, cones.distance, own, holder, other, reason)


def depths_of(patch, mill, tip, axis, others, n):
    """Return how deep mills and their holders enter a patch, and other points lie in either.

    Parameters
    ----------
    patch : Patch
        The surface.
    mill : ConicalMill
        The same for all.
    tip, axis : (k, 3) float
        Of the positions.
    others : (n, 3) float or None
        Points beside it.
    n : int
        Of the patch's mesh.

    Returns
    -------
    depths : (3, k) float
        In m; 0 where they don't enter.
    """
    depths = np.zeros((3, len(tip)))
    s, t = (part.ravel() for part in patch.parameters(n))
    mesh = patch.points(s, t)
    # On the patch the deepest point is looked for between those of the mesh; what lies between
    # the other points isn't known.
    beside = np.empty((0, 3)) if others is None else others
    parts = mill.cutting, mill.holder
    size = max(1, BLOCK // (len(mesh) + len(beside)))
    for first in range(0, len(tip), size):
        rows = slice(first, first + size)
        at = tip[rows], axis[rows]
        seen = seen_from(mesh, *at)
        for part, function in enumerate(parts):
            distance = function(*seen)
            nearest = distance.argmin(axis=1)
            least = _between(patch, function, *at, s[nearest], t[nearest], n)
            depths[part, rows] = -np.minimum(least, distance.min(axis=1))
        if len(beside):
            seen = seen_from(beside, *at)
            depths[2, rows] = -np.min([function(*seen).min(axis=1) for function in parts], axis=0)
    return np.maximum(depths, 0.0)


def _between(patch, distance, tip, axis, s, t, n):
    """Return the least distance (k,) near parameters of a mesh (k,), between its points.

    A window is searched about the best place so far. It moves on where the next best is at its
    border, as along a rim of the mill, and gets smaller where it isn't.

    Examples
    --------
    A place is found to 1/54 of a cell, so that a ball's distance, 0.5 m, is off by 0.1 mm:

    >>> flat = Patch(lambda s, t: [s, t, 0 * s], (0, 1), (0, 1))
    >>> tip, up, corner = np.array([[0.4, 0.4, 0.5]]), np.array([[0.0, 0.0, 1.0]]), np.zeros(1)
    >>> ball = lambda height, radius: np.hypot(height - 0.25, radius) - 0.25
    >>> _between(flat, ball, tip, up, corner, corner.copy(), 2).round(6)
    array([0.500073])
    """
    cell = [(high - low) / (n - 1) for low, high in (patch.s, patch.t)]
    offsets = np.linspace(-1, 1, AROUND)
    across, along = (part.ravel() for part in np.meshgrid(offsets, offsets))
    least = np.full(len(s), np.inf)
    shrunk = np.zeros(len(s), dtype=int)
    row = np.arange(len(s))
    for _ in range(ROUNDS):
        size = (2 / (AROUND - 1)) ** shrunk[row][:, None]
        tried_s = np.clip(s[row][:, None] + size * cell[0] * across, *patch.s)
        tried_t = np.clip(t[row][:, None] + size * cell[1] * along, *patch.t)
        every = distance(*seen_from(patch.points(tried_s, tried_t), tip[row], axis[row]))
        best = np.arange(len(row)), every.argmin(axis=1)
        least[row] = np.minimum(least[row], every[best])
        way = np.maximum(
            np.abs(tried_s[best] - s[row]) / cell[0], np.abs(tried_t[best] - t[row]) / cell[1]
        )
        s[row], t[row] = tried_s[best], tried_t[best]
        shrunk[row] += way < 0.99 * size[:, 0]
        row = row[shrunk[row] < CLOSER]
        if not len(row):
            break
    return least
