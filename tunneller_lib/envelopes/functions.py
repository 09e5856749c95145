"""What callers may give for a function or for its variables, and what such functions must answer.

An exception that a caller's own function raises passes through as it is: the fault is to be seen
where it lies. What the function answers is looked at once a call, never within the arithmetic.
"""

import inspect
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType, MethodType
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
        if not callable(value) or not _takes(value, count):
            raise ValueError(f"{name}: must be a function of {wanted}; got {shown(value)}.")
        return value

    return Annotated[Callable, Rule("callable", check)]


def _takes(function, count):
    # Classes make no numbers, and what is built into Python, as those of `math`, takes no jets.
    if isinstance(function, type) or inspect.isbuiltin(function):
        return False
    if isinstance(function, MethodType) and isinstance(function.__func__, FunctionType):
        # A shape's method is asked for at every point; the functions of classes aren't many.
        return _method_binds(function.__func__, count + 1)
    return _binds(function, count)


def _binds(function, count):
    try:
        inspect.signature(function).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # one of numpy's, without a signature to ask
        return True
    return True


_method_binds = lru_cache(32)(_binds)


def _varying(name, value):
    return value if isinstance(value, Jet) else bounded_array(name, value)


class _Three(list):
    """Three coordinates, with the shape of the points that they are of."""

    @property
    def shape(self):
        return np.broadcast_shapes(*map(np.shape, self))


def _three(name, value):
    try:
        x, y, z = value
    except (TypeError, ValueError):
        raise ValueError(f"{name}: must hold three coordinates; got {shown(value)}.") from None
    three = _Three(_varying(f"{name}[{i}]", part) for i, part in enumerate((x, y, z)))
    shapes = [np.shape(part) for part in three]
    try:
        np.broadcast_shapes(*shapes)
    except ValueError:
        came = ", ".join(map(str, shapes))
        raise ValueError(f"{name}: the coordinates must broadcast; got {came}.") from None
    return three


def _normals(name, value):
    three = _three(name, value)
    x, y, z = (part.value if isinstance(part, Jet) else part for part in three)
    length = np.sqrt(x * x + y * y + z * z)
    if not np.all(np.abs(length - 1) <= _UNIT):
        raise ValueError(f"{name}: must have the length 1; got one that hasn't.")
    if not np.all(z + 1 > 0):
        raise ValueError(f"{name}: must not be (0, 0, -1), which has no point; got one that is.")
    return three


def _are_units(array):
    return np.all(np.abs(norm(array) - 1) <= _UNIT)


Centre = Array("(2,) float", last="x, y")
Three = Annotated[list, Rule("(...) float or Jet, three of them", _three)]
UnitThree = Annotated[list, Rule("(...) float or Jet, three of them", _normals)]
UnitVectors = Array("(..., 3) float", last="x, y, z", also=("have the length 1", _are_units))
Varying = Annotated[ArrayLike | Jet, Rule("(...) float or Jet", _varying)]


def coordinates(name, value, like):
    """Return the three coordinates that the caller's function `name` answered.

    Each must be a number, an array or a jet that goes with the points of `like`, its argument.
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
    """Return the `count` vectors of the answer `value` of the caller's function `name`.

    Each is of three coordinates that go with the points of `like`, as those of `coordinates`.
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
    """Return the number, array or jet that the caller's function `name` answered to `like`."""
    if not _is_number(value, like):
        raise ValueError(f"{name}: must return one value f(x, y) a point; got {shown(value)}.")
    return value


def as_jet(value, like):
    """Return what a function answered to the jet `like` as a jet: a constant is one, too."""
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
