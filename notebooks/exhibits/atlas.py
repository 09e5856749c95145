"""The atlas: how far each stand-in for a geodesic is off, over tori and all pairs of positions.

The tube's radius is the unit of length. A symmetry of the torus carries any pair of positions
into one from (0, phi1) to (turn, phi2) with phi1 >= |phi2|, so only those are tried.
"""

import numpy as np

from tunneller_lib.paths.chord_paths import CHORD_PATHS, path_length
from tunneller_lib.paths.inverse_problem import geodesic_inverse
from tunneller_lib.surfaces import REFERENCE_MACHINE, Torus

RATIOS = np.geomspace(4, 100, 13)  # R / r
STRIPES = 9  # of turns, a block each
COLUMNS = ["R / r", "turn", "phi1", "phi2", "length", "converged", "certified"]
COLUMNS += [f"{what} of {name}" for what in ("excess", "aside") for name in CHORD_PATHS]

_TURNS = np.linspace(0, REFERENCE_MACHINE.theta_max - REFERENCE_MACHINE.theta_min, 82)[1:]
_HEIGHTS = np.linspace(-REFERENCE_MACHINE.phi_max, REFERENCE_MACHINE.phi_max, 63)
_ON_GEODESIC = 65  # points of a geodesic from which the deviation of
_ON_PATH = 17  # points of a path is measured


def blocks():
    """Return the (ratio, stripe) indices of all blocks, each about 9,000 pairs."""
    return [(i, k) for i in range(RATIOS.size) for k in range(STRIPES)]


def pairs(stripe):
    """Return the turns, phi1 and phi2 (n,), in rad, of the pairs of a stripe, for any ratio."""
    turns = np.split(_TURNS, STRIPES)[stripe]
    turn, phi1, phi2 = np.meshgrid(turns, _HEIGHTS, _HEIGHTS, indexing="ij")
    kept = phi1 >= np.abs(phi2)
    return turn[kept], phi1[kept], phi2[kept]


def survey(block):
    """Return a block of the atlas.

    Parameters
    ----------
    block : (2,) int
        One of `blocks`.

    Returns
    -------
    table : (n, 19) float
        `COLUMNS`: angles in rad, lengths and deviations in tube radii, excess as a share of the
        geodesic's length.
    """
    ratio, stripe = block
    turn, phi1, phi2 = pairs(stripe)
    torus = Torus(1 / RATIOS[ratio], 1)
    p = np.stack([np.zeros_like(turn), phi1], axis=-1)
    q = np.stack([turn, phi2], axis=-1)
    geodesic = geodesic_inverse(torus, p, q)
    excess = [path_length(torus, path, p, q) / geodesic.length - 1 for path in CHORD_PATHS.values()]
    # All paths in one array: the geodesics are then integrated and looked at once.
    t = np.linspace(0, 1, _ON_PATH)[1:-1]
    ways = np.concatenate([path(torus, p, q, t) for path in CHORD_PATHS.values()], axis=-2)
    deviation = np.abs(geodesic.points(_ON_GEODESIC).deviation(ways))
    aside = np.max(deviation.reshape(turn.size, len(CHORD_PATHS), -1), axis=-1)
    found = (geodesic.length, geodesic.converged, geodesic.certified)
    which = np.full_like(turn, RATIOS[ratio])
    return np.column_stack([which, turn, phi1, phi2, *found, *excess, aside])


def summary(tables):
    """Return the worst and the middle of blocks, a dict for each block and path.

    Parameters
    ----------
    tables : iterable of (n, 19) float
        Results of `survey`, which may be read one after the other: each is let go before the next.

    Returns
    -------
    rows : list of dict
        What a row is about, and the median and the worst of its pairs; "at turn", "at phi1" and
        "at phi2" say where the excess is worst.
    """
    return [_row(table, k, name) for table in tables for k, name in enumerate(CHORD_PATHS)]


def _row(table, k, name):
    excess = table[:, 7 + k]
    aside = table[:, 7 + len(CHORD_PATHS) + k]
    worst = np.argmax(excess)
    return {
        "R / r": table[0, 0], "turn from": table[0, 1], "turn to": table[-1, 1], "path": name,
        "pairs": len(table), "certified": int(table[:, 6].sum()),
        "median excess": np.median(excess), "worst excess": excess[worst],
        "median aside": np.median(aside), "worst aside": np.max(aside),
        "at turn": table[worst, 1], "at phi1": table[worst, 2], "at phi2": table[worst, 3],
    }  # fmt: skip
