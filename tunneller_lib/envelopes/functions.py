"""What callers may give for a function or for its variables, and what such functions must return.

An exception that a caller's own function raises passes through as it is, so that the fault is seen
where it lies. What the function returns is checked once a call, never within the arithmetic.
"""

import inspect
from collections.abc import Callable
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Rule, bounded_array, real, shown
from ..kernels.exact import norm
from .jet import Jet

_UNIT = 1e-6  # by how much the length of what is said to be a unit vector may be off


def Function(count):
    """Return the annotation of a function that takes `count` arguments, numbers or jets."""
    wanted = "one argument" if count == 1 else f"{count} arguments"

    def check(name, value):
        # Classes make no numbers, and what is built into Python, as `math.sin`, takes no jets.
        no_function = isinstance(value, type) or inspect.isbuiltin(value) or not callable(value)
        if no_function or not _takes(value, count):
            raise ValueError(f"{name}: must be a function of {wanted}; got {shown(value)}.")
        return value

    return Annotated[Callable, Rule("callable", check)]


def _takes(function, count):
    try:
        inspect.signature(function).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # one of numpy's, which has no signature to ask
        return True
    return True


def _varying(name, value):
    """Return a jet as it is, its numbers unchecked, and anything else as a checked array."""
    return value if isinstance(value, Jet) else bounded_array(name, value)


def _are_units(array):
    """Return whether vectors (..., 3) all have the length 1, but for a millionth.

    Examples
    --------
    >>> bool(_are_units(np.array([0.6, 0.0, 0.8]))), bool(_are_units(np.array([0.0, 0.0, 2.0])))
    (True, False)
    """
    return np.all(np.abs(norm(array) - 1) <= _UNIT)


Centre = Array("(2,) float", last="x, y")
UnitVectors = Array("(..., 3) float", last="x, y, z", also=("have the length 1", _are_units))
Varying = Annotated[ArrayLike | Jet, Rule("(...) float or Jet", _varying)]


def coordinates(name, value, like):
    """Return the three coordinates that the caller's function `name` returned for `like`.

    Each must be a number, an array or a jet that broadcasts to the points of `like`.
    """
    try:
        x, y, z = value
    except (TypeError, ValueError):
        raise ValueError(f"{name}: must return three coordinates; got {shown(value)}.") from None
    for part in (x, y, z):
        if not _is_number(part, like):
            raise ValueError(
                f"{name}: must return three coordinates, each one real number a point; "
                f"got {shown(part)}."
            )
    return [x, y, z]


def vectors(name, value, count, like):
    """Return the `count` vectors in the `value` that the caller's function `name` returned.

    Each holds three coordinates that broadcast to the points of `like`, as for `coordinates`.
    """
    try:
        every = list(value)
    except TypeError:
        every = []
    if len(every) != count:
        raise ValueError(
            f"{name}: must return {count} vectors of three coordinates; got {shown(value)}."
        )
    return [coordinates(name, one, like) for one in every]


def one_number(name, value, like):
    """Return the number, array or jet that the caller's function `name` returned for `like`."""
    if not _is_number(value, like):
        raise ValueError(f"{name}: must return one value f(x, y) a point; got {shown(value)}.")
    return value


def as_jet(value, like):
    """Return what a function returned for the jet `like` as a jet; a number has no slopes."""
    return value if isinstance(value, Jet) else like * 0.0 + real("value", value)


def _is_number(part, like):
    """Tell whether `part` is one real number for each point of `like`."""
    if type(part) in (int, float):
        return True
    points = np.shape(like)
    if isinstance(part, Jet):
        return part.shape == points and part.c.dtype == float
    try:
        shape = real("", part).shape
        return np.broadcast_shapes(shape, points) == points
    except ValueError:
        return False
