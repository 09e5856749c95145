"""Rules for what may be asked of a path: how many points, at which shares, between which ends."""

import math
from typing import Literal

import numpy as np

from ..arguments import Array, Whole

MOST_POINTS = 5_000_000  # of all paths of a call together: a few seconds, some hundred megabytes
MOST_RATIO = 1e100  # of r and R, either way

Count = Whole(2, 1_000_000)
# The `CHORD_PATHS` by which a machine may go from knot to knot.
Way = Literal["projected chord", "corrected chord"]
Row = Array("(n,) float")


def check_points(n, shape):
    """Raise ValueError where n points are too many for each of the paths of an array of `shape`."""
    paths = math.prod(shape)
    if n * paths > MOST_POINTS:
        raise ValueError(
            f"n: must ask for at most {MOST_POINTS} points of all paths together; "
            f"got {n} of each of {paths}."
        )


def check_on_sheet(torus, p, q):
    """Raise ValueError where an end of a path (..., 2), in rad, isn't on the working sheet.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Torus
    >>> check_on_sheet(Torus(1, 2), np.array([0, 0]), np.array([0, 3]))
    Traceback (most recent call last):
    ValueError: q: must lie on the working sheet, r + R cos(phi) >= 0; got phi = 3 rad.
    """
    for name, end in (("p", p), ("q", q)):
        inner = torus.r + torus.R * np.cos(end[..., 1]) < 0
        if np.any(inner):
            raise ValueError(
                f"{name}: must lie on the working sheet, r + R cos(phi) >= 0; "
                f"got phi = {end[..., 1][inner].flat[0]:g} rad."
            )


def check_ratio(torus):
    """Raise ValueError where one radius of a torus is over 1e100 times the other.

    Examples
    --------
    >>> from tunneller_lib.surfaces import Torus
    >>> check_ratio(Torus(1e100, 1))
    >>> check_ratio(Torus(1e60, 1e-60))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: torus: r / R must be from 1e-100 to 1e+100, ...
    """
    if not 1 / MOST_RATIO <= torus.r / torus.R <= MOST_RATIO:
        raise ValueError(
            f"torus: r / R must be from {1 / MOST_RATIO:g} to {MOST_RATIO:g}, so that nothing "
            f"overflows; got {torus.r / torus.R:g}."
        )
