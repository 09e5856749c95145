"""The patch of a surface through measured points with normals, or through a mesh of triangles."""

import numpy as np

from ..envelopes import fit_surface
from ..kernels.exact import dot, norm
from ..milling import Patch
from .csv_reading import read_csv
from .mesh import read_stl, vertex_normals
from .tables import said_of

COLUMNS = "x_m", "y_m", "z_m", "nx", "ny", "nz"
MOST_ROWS = 200_000
NEIGHBOURS = 8  # of a measured point, whose normals must be like its own
HOLE = 5.0  # times the points' usual distance, a place of the patch that is farther from any
INNER = 0.08  # share of measured points that may lie beyond the patch on each of its four sides


def patch_through(content, errors, side):
    """Return the patch through measured points, and its `Fit`.

    Parameters
    ----------
    content : str or bytes
        A table of points and unit normals, or a mesh of triangles as STL in mm, whose corners are
        the points.
    errors : dict
        ``contact_error`` in m and ``normal_error`` in rad, standard errors.
    side : {1, -1}
        As of `Patch`.

    Returns
    -------
    patch : Patch
        Over a rectangle amid the points.
    fit : Fit
        The polynomial behind it.

    Raises
    ------
    ValueError
        If the points are none, have a hole or normals to both sides, or no polynomial passes all of
        them within their errors.
    """
    contact, normal = _table(content) if isinstance(content, str) else _corners(content)
    _check_normals(contact, normal)
    with said_of("surface"):
        fit = fit_surface(contact, normal, **errors)
    if not fit.fits or len(fit.place) < len(contact):
        raise ValueError(
            "points: no polynomial passes all of them within their errors; give a smaller patch "
            f"or the errors that they have; {len(fit.place)} of {len(contact)} were tried last."
        )
    low, high = np.quantile(fit.place, [INNER, 1 - INNER], axis=0)
    _check_holes(fit.place, low, high)
    # The fit's third axis is the mean normal, so that x and y go round it as the patch's s and t.
    return Patch(fit.surface, (low[0], high[0]), (low[1], high[1]), side), fit


def _corners(content):
    """Return corners (n, 3), in m, of a mesh in STL, and unit normals amid their triangles."""
    mesh = read_stl(content)
    return mesh.points, vertex_normals(mesh)


def _table(text):
    """Return points (n, 3), in m, and unit normals that a table holds, or raise ValueError."""
    _, columns = read_csv(text, most=MOST_ROWS)
    if set(COLUMNS) - set(columns):
        raise ValueError(
            f"text: must have the columns {', '.join(COLUMNS)}; got {', '.join(columns)}."
        )
    try:
        table = np.stack([columns[name].astype(float) for name in COLUMNS], axis=-1)
    except ValueError:
        raise ValueError("text: must hold numbers alone.") from None
    if not np.all(np.isfinite(table)):
        raise ValueError("text: points must be finite; got one that isn't.")
    contact, normal = table[:, :3], table[:, 3:]
    length = norm(normal)
    if not np.all(np.abs(length - 1) < 0.01):
        raise ValueError("text: nx, ny, nz must be unit normals; got one that isn't.")
    return contact, normal / length[:, None]


def _check_normals(contact, normal):
    """Raise ValueError where normals point to the other side than those beside them."""
    from scipy.spatial import cKDTree

    if len(contact) <= NEIGHBOURS:
        raise ValueError(f"points: must be more than {NEIGHBOURS}; got {len(contact)}.")
    _, beside = cKDTree(contact).query(contact, k=NEIGHBOURS + 1)
    against = np.any(dot(normal[beside[:, 1:]], normal[:, None]) < 0, axis=1)
    if np.any(against):
        flipped = np.count_nonzero(dot(normal, normal.mean(axis=0)) < 0) or np.sum(against)
        raise ValueError(
            "points: normals must point to one side, and turn by less than 90 degrees between "
            f"neighbours; {flipped} of {len(normal)} don't."
        )


def _check_holes(place, low, high):
    """Raise ValueError where a place of a rectangle is far from any measured point."""
    from scipy.spatial import cKDTree

    tree = cKDTree(place)
    x, y = (np.linspace(a, b, 60) for a, b in zip(low, high, strict=True))
    asked = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    away, _ = tree.query(asked)
    usual = np.sqrt(np.prod(np.ptp(place, axis=0)) / len(place))
    if away.max() > HOLE * usual:
        raise ValueError(
            f"points: must leave no hole; got one that is {2e3 * away.max():.3g} mm wide, where "
            f"points are {1e3 * usual:.2g} mm apart."
        )
