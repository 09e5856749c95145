"""A solid against a line grown to a box: the part two of Line and finite cylinder."""

import numpy as np

from ..arguments import Corners, checked
from .box import Box
from .facet import UP, meet_facets
from .frustum import Frustum
from .rod import Rod
from .rounded_disc import RoundedDisc


@checked
def meet_box(solid: Rod | Frustum | Box | RoundedDisc, low: Corners, high: Corners):
    """Return the lowest and highest points of a solid in boxes that are endless along z.

    Parameters
    ----------
    solid : Rod, Frustum, Box or RoundedDisc
        In any pose.
    low, high : (..., 2) float
        Opposite corners (x, y) of the boxes' sections, in m; low <= high.

    Returns
    -------
    bottom, top : (...) float
        Heights z between which a rectangular cutter over that section touches the solid, in m;
        ``inf`` and ``-inf`` where it doesn't.

    Raises
    ------
    ValueError
        If a corner isn't finite or low > high.

    Notes
    -----
    Line and finite cylinder announces this for a cylinder as its part two, and doesn't give it.
    The section is a facet that moves along z. A `Box` in any pose that moves in any direction
    touches with its faces: take the least `enter` and the greatest `leave` of `meet_facets` of
    ``box.faces``. So each solid meets lines by its `meet_line`, and boxes by this, with one guard.

    Examples
    --------
    >>> bottom, top = meet_box(Rod((0, 0, 0), (0, 8, 0), 2), (1, 1), (3, 9))
    >>> float(top.round(6)), float(bottom.round(6))
    (1.732051, -1.732051)
    """
    low, high = np.broadcast_arrays(low, high)
    if not np.all(low <= high):
        raise ValueError("low: must not be above high on either axis; got a corner that is.")
    corners = [(low, low), (high, low), (high, high), (low, high)]
    section = np.stack(
        [np.stack([x[..., 0], y[..., 1], np.zeros_like(x[..., 0])], axis=-1) for x, y in corners],
        axis=-2,
    )
    return meet_facets(solid, section, UP)
