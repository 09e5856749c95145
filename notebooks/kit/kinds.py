"""What arguments of this room may be, beside what `arguments` lists."""

from typing import Annotated

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from tunneller_lib.arguments import Rule, finite_array, one_whole, real, shown

LONGEST = 200  # characters of a line


def _line(name, value):
    """Return a text of one line, such as the name of a number or its unit."""
    if not isinstance(value, str) or not value.isprintable() or len(value) > LONGEST:
        raise ValueError(
            f"{name}: must be a text of one line, at most {LONGEST} characters; got {shown(value)}."
        )
    return value


def _lines(name, value):
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{name}: must be a list of texts; got {shown(value)}.")
    return [_line(f"{name}[{i}]", text) for i, text in enumerate(value)]


def _rows(name, value):
    """Return a table's rows as lists of cells, which are numbers or texts."""
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{name}: must be a list of rows; got {shown(value)}.")
    for i, row in enumerate(value):
        if not isinstance(row, (list, tuple)):
            raise ValueError(f"{name}[{i}]: must be a list of cells; got {shown(row)}.")
    return [list(row) for row in value]


def _decimals(name, value):
    """Return a number of decimals, None, or a tuple of them."""
    if isinstance(value, (list, tuple)):
        return tuple(_decimals(f"{name}[{i}]", one) for i, one in enumerate(value))
    return None if value is None else one_whole(name, value, 0, 15)


def _centimetres(name, value):
    number = real(name, value)
    if number.ndim or not 0.5 <= number <= 100:
        raise ValueError(f"{name}: must be one number from 0.5 to 100 cm; got {shown(value)}.")
    return float(number)


def _is_picture(value):
    return (
        isinstance(value, np.ndarray)
        and value.dtype == np.uint8
        and value.ndim == 3
        and value.shape[-1] == 3
        and value.size > 0
    )


def _pixels(name, value):
    if not _is_picture(value):
        raise ValueError(f"{name}: must be pixels (n, m, 3) uint8; got {shown(value)}.")
    return value


def _picture(name, value):
    if not isinstance(value, Figure) and not _is_picture(value):
        raise ValueError(
            f"{name}: must be a drawing or pixels (n, m, 3) uint8; got {shown(value)}."
        )
    return value


def sound_pictures(name, value):
    """Return a list or tuple of one or more pictures, each pixels (n, m, 3) uint8."""
    if not isinstance(value, (list, tuple)) or not value or not all(map(_is_picture, value)):
        raise ValueError(
            f"{name}: must be a list of pictures, each pixels (n, m, 3) uint8; got {shown(value)}."
        )
    return value


def _series(name, value):
    """Return a float array (n,) of two or more finite numbers."""
    array = finite_array(name, value)
    if array.ndim != 1 or len(array) < 2:
        raise ValueError(f"{name}: must be two or more numbers (n,); got {array.shape}.")
    return array


def _chart(name, value):
    """Return a float array (n, m) of finite numbers."""
    array = finite_array(name, value)
    if array.ndim != 2:
        raise ValueError(f"{name}: must be rows of numbers (n, m); got {array.shape}.")
    return array


def _grid(name, value):
    """Return a float array (n, m, 3); points that aren't finite are left out by those who draw."""
    array = real(name, value)
    if array.ndim != 3 or array.shape[-1] != 3:
        raise ValueError(f"{name}: must be a grid (n, m, 3); got {array.shape}.")
    return array


def _map(name, value):
    """Return a float array (n, m) of two or more finite numbers either way."""
    array = finite_array(name, value)
    if array.ndim != 2 or min(array.shape) < 2:
        raise ValueError(f"{name}: must be a map (n, m) of numbers; got {array.shape}.")
    return array


def check_same_shape(**maps):
    """Raise ValueError where maps (n, m) haven't all the same shape."""
    shapes = {one.shape for one in maps.values()}
    if len(shapes) > 1:
        names = ", ".join(maps)
        raise ValueError(f"{names}: must have one shape; got {sorted(shapes)}.")


def _flags(name, value):
    array = np.asarray(value) if isinstance(value, (np.ndarray, list, tuple)) else None
    if array is None or array.dtype != bool or array.ndim != 1:
        raise ValueError(f"{name}: must be True or False for each point (n,); got {shown(value)}.")
    return array


def _curve(name, value):
    array = real(name, value)
    if array.ndim != 2 or array.shape[-1] != 3 or len(array) < 2:
        raise ValueError(f"{name}: must be two or more points (n, 3); got {array.shape}.")
    return array


Line = Annotated[str, Rule("str", _line)]
Lines = Annotated[list, Rule("list of str", _lines)]
Rows = Annotated[list, Rule("list of list", _rows)]
Decimals = Annotated[object, Rule("int or sequence of int", _decimals)]
Centimetres = Annotated[float, Rule("float", _centimetres, "cm")]
Pixels = Annotated[np.ndarray, Rule("(n, m, 3) uint8", _pixels)]
Picture = Annotated[object, Rule("matplotlib.figure.Figure or (n, m, 3) uint8", _picture)]
Pictures = Annotated[list, Rule("list of (n, m, 3) uint8", sound_pictures)]
Series = Annotated[ArrayLike, Rule("(n,) float", _series)]
Chart = Annotated[ArrayLike, Rule("(n, m) float", _chart)]
Flags = Annotated[ArrayLike, Rule("(n,) bool", _flags)]
Grid = Annotated[ArrayLike, Rule("(n, m, 3) float", _grid)]
Map = Annotated[ArrayLike, Rule("(n, m) float", _map)]
Curve = Annotated[ArrayLike, Rule("(n, 3) float", _curve)]
