"""What arguments may be: said once, in the annotations, which `checked` and the tests read.

A function of the library says ``def foot(self, m: Points)`` and is `checked`: it gets a sound
array, or its caller a ValueError of one sentence, with the name, the rule and what came.
"""

import functools
import inspect
import reprlib
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

LEAST, MOST = 1e-100, 1e100  # lengths whose squares, and products of three, are sound floats
GREATEST = float(np.finfo(float).max)
FEW = 3  # numbers, as of one point, that Python looks at one by one before numpy begins
MOST_AXES = 3  # of an array whose numbers a message shows


@dataclass(frozen=True)
class Rule:
    """What an annotation says of an argument.

    Parameters
    ----------
    says : str
        Shape and type as docstrings write them; arguments whose shape begins with ``...``
        broadcast with each other.
    check : callable
        Of the argument's name and value: returns it as the function wants it, or raises ValueError.
    unit : str
        That docstrings give, or "" where it differs from use to use.
    """

    says: str
    check: Callable
    unit: str = ""

    @functools.cached_property
    def own_axes(self):
        """Return how many axes follow the leading ones, or None where none are leading."""
        if not self.says.startswith("(..."):
            return None
        return self.says.partition(")")[0].count(",")


def checked(made):
    """Return a function, or a class of fields, that checks arguments by their annotations.

    Parameters
    ----------
    made : callable or class
        Each of its arguments has an annotation of this module's, a class, a `Literal` of words,
        or one of these and None. Beneath `dataclass` it checks the fields, before
        `__post_init__` sees them.

    Returns
    -------
    checked : callable or class
        With the same signature. For inner loops, whose arguments are sound, the function itself
        stays at hand as its attribute ``unchecked``.

    Examples
    --------
    >>> @checked
    ... def twice(x: Reals, *, sign: Literal["plus", "minus"] = "plus"):
    ...     return 2 * x
    >>> twice([1, 2])
    array([2., 4.])
    >>> twice(1, sign="times")
    Traceback (most recent call last):
        ...
    ValueError: sign: must be "plus" or "minus"; got 'times'.
    """
    if isinstance(made, type):
        return _with_checked_fields(made)

    @functools.cache
    def contract():
        # At the first call: hundreds of signatures would take a tenth of an import's time.
        signature = inspect.signature(made)
        parameters = signature.parameters.items()
        rules = {
            name: rule_of(about.annotation)
            for name, about in parameters
            if name not in ("self", "cls")
        }
        by_place = [
            name
            for name, about in parameters
            if about.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
        ]
        return signature, rules, by_place

    @functools.wraps(made)
    def call(*given, **options):
        signature, rules, by_place = contract()
        # As `signature.bind` would, but in a fraction of the time that a small call takes.
        values = dict(zip(by_place, given, strict=False), **options)
        if len(values) < len(given) + len(options):  # too many, or one of them twice
            signature.bind(*given, **options)  # raises TypeError
        _check(values, rules)
        return made(**values)

    call.unchecked = made
    return call


def _with_checked_fields(made):
    rules = {name: rule_of(about) for name, about in made.__annotations__.items()}
    own = getattr(made, "__post_init__", None)

    def __post_init__(self):
        fields = {name: getattr(self, name) for name in rules}
        _check(fields, rules)
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        if own:
            own(self)

    made.__post_init__ = __post_init__
    return made


def _check(values, rules):
    """Replace values by what their rules make of them; their leading axes must broadcast."""
    leading = {}
    for name, value in values.items():
        rule = rules.get(name)
        if rule is None:
            continue
        values[name] = rule.check(name, value)
        if rule.own_axes is not None and values[name] is not None:
            shape = np.shape(values[name])
            leading[name] = shape[: len(shape) - rule.own_axes]
    if len(set(leading.values())) > 1:
        try:
            np.broadcast_shapes(*leading.values())
        except ValueError:
            came = ", ".join(map(str, leading.values()))
            raise ValueError(
                f"{', '.join(leading)}: their leading axes must broadcast; got {came}."
            ) from None


def rule_of(annotation):
    """Return the `Rule` of an annotation.

    That is one of this module's types, a class, a `Literal` of words, `bool`, ``Callable`` or
    ``Callable[[str, ..], object]`` by the number of its arguments, or one of these with None.
    """
    if get_origin(annotation) is Annotated:
        return annotation.__metadata__[0]
    if get_origin(annotation) is Literal:
        return _one_of(get_args(annotation))
    if get_origin(annotation) in (Union, types.UnionType):
        return _any_of(get_args(annotation))
    if annotation is bool:
        return Rule("bool", _truth)
    if annotation is Callable:
        return Rule("callable", _callable)
    if get_origin(annotation) is Callable:
        return _taking(len(get_args(annotation)[0]))
    if isinstance(annotation, type):
        return Rule(annotation.__name__, lambda name, value: instance(name, value, annotation))
    raise TypeError(f"{annotation!r} is no annotation that arguments are checked by")


def _one_of(words):
    quoted = [f'"{word}"' for word in words]
    rule = " or ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)

    def check(name, value):
        if not isinstance(value, str) or value not in words:
            raise ValueError(f"{name}: must be {rule}; got {shown(value)}.")
        return value

    return Rule("{" + ", ".join(quoted) + "}", check)


def _any_of(kinds):
    """Return the rule of the first kind, or of classes one of which will do; None may pass."""
    optional = type(None) in kinds
    rules = [rule_of(kind) for kind in kinds if kind is not type(None)]

    def check(name, value):
        if value is None and optional:
            return None
        for kind in kinds:
            if isinstance(kind, type) and kind is not Callable and isinstance(value, kind):
                return value
        if len(rules) > 1:
            wanted = " or ".join(rule.says for rule in rules)
            raise ValueError(f"{name}: must be of class {wanted}; got {shown(value)}.")
        return rules[0].check(name, value)

    says = " or ".join(rule.says for rule in rules)
    return Rule(says, check, rules[0].unit)


def _sign(name, value):
    if isinstance(value, (bool, np.bool_)) or not np.isscalar(value) or value not in (1, -1):
        raise ValueError(f"{name}: must be 1 or -1; got {shown(value)}.")
    return int(value)


def _truth(name, value):
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name}: must be True or False; got {shown(value)}.")
    return bool(value)


def _callable(name, value):
    if not callable(value) or isinstance(value, type):
        raise ValueError(f"{name}: must be a function; got {shown(value)}.")
    return value


def _taking(count):
    """Return the rule of a function that can be called with so many arguments."""

    def check(name, value):
        _callable(name, value)
        try:
            signature = inspect.signature(value)
        except (TypeError, ValueError):  # one written in C may not tell
            return value
        try:
            signature.bind(*range(count))
        except TypeError:
            plural = "" if count == 1 else "s"
            raise ValueError(
                f"{name}: must be a function of {count} argument{plural}; got {shown(value)}."
            ) from None
        return value

    return Rule("callable", check)


def instance(name, value, kind):
    """Return `value`, which must be an instance of the class `kind`; the name is for messages."""
    if not isinstance(value, kind):
        raise ValueError(f"{name}: must be of class {kind.__name__}; got {shown(value)}.")
    return value


class _Briefly(reprlib.Repr):
    """It doesn't look at every element of what is long."""

    def repr_ndarray(self, array, level):
        # numpy would write some of each axis' rows: of many axes more than anybody reads.
        if array.ndim > MOST_AXES:
            return f"an array of shape {array.shape}"
        with np.printoptions(threshold=30):
            return repr(array)


_BRIEFLY = _Briefly()
_BRIEFLY.maxstring = _BRIEFLY.maxother = 200


def shown(value):
    """Return a value for a message: in one line of at most a hundred characters."""
    try:
        text = _BRIEFLY.repr(value)
    except Exception:  # whatever somebody's class does when it is asked what it is
        text = f"an object of class {type(value).__name__}"
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= 100 else f"{text[:97]}..."


def real(name, value):
    """Return `value` as a float array of any shape, or say why it can't be one.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : array_like
        Whole or floating-point numbers; NaN and infinity pass.

    Returns
    -------
    array : (...) float
        A new array, or `value` itself where it is one already; nobody writes to it.

    Raises
    ------
    ValueError
        If `value` isn't an array of real numbers, or one of them is masked or missing.

    Examples
    --------
    >>> real("theta", [1, 2])
    array([1., 2.])
    """
    if type(value) is np.ndarray and value.dtype == float:
        return value
    array = as_array(value)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name}: must hold real numbers in a regular array; got {shown(value)}.")
    with np.errstate(over="ignore"):
        return np.asarray(array, dtype=float)


def as_array(value):
    """Return a value as an array, of objects where it is none that numpy knows."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        return np.asarray(None)  # what a mask hides must not be taken for a number
    try:
        array = np.asarray(value)
        if array.dtype == object and all(map(_is_number, array.flat)):
            # A column of pandas that allows for missing numbers, and has none.
            array = np.asarray(array.tolist()).reshape(array.shape)
        return array
    except Exception:  # ragged lists, whole numbers of hundreds of digits, somebody's class
        return np.asarray(None)


def _is_number(value):
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def finite_array(name, value):
    """Return `value` as a float array (...) of finite numbers."""
    array = real(name, value)
    if not none_beyond(array, GREATEST):
        raise ValueError(
            f"{name}: must hold finite numbers; got {_first(array, ~np.isfinite(array))}."
        )
    return array


def none_beyond(array, most):
    """Tell whether no number is above `most` in size: two passes that keep nothing."""
    if array.size <= FEW:
        return all([abs(number) <= most for number in array.ravel().tolist()])
    return not array.size or bool(array.min() >= -most and array.max() <= most)


def _first(array, wrong):
    """Return the first of the wrong elements, as a message shows it."""
    return f"{array[wrong].flat[0]:g}"


def bounded_array(name, value):
    """Return `value` as a float array (...) of numbers not above 1e100 in size."""
    array = real(name, value)
    if not none_beyond(array, MOST):
        finite_array(name, array)
        far = np.abs(array) > MOST
        raise ValueError(
            f"{name}: must hold numbers of at most {MOST:g} in size; got {_first(array, far)}."
        )
    return array


def positive(name, value):
    """Return `value` as a float, which must be one finite number above zero."""
    number = real(name, value)
    if number.ndim or not (np.isfinite(number) and number > 0):
        raise ValueError(f"{name}: must be one finite number above zero; got {shown(value)}.")
    return float(number)


def finite(name, value):
    """Return `value` as a float, which must be one finite number."""
    number = real(name, value)
    if number.ndim or not np.isfinite(number):
        raise ValueError(f"{name}: must be one finite number; got {shown(value)}.")
    return float(number)


def not_negative(name, value):
    """Return `value` as a float, which must be one finite number, zero or above."""
    number = real(name, value)
    if number.ndim or not (np.isfinite(number) and number >= 0):
        raise ValueError(f"{name}: must be one finite number, not below zero; got {shown(value)}.")
    return float(number)


def coordinate(name, value):
    """Return `value` as a float, which must be one number of at most 1e100 in size."""
    return float(bounded_array(name, finite(name, value)))


def size(name, value):
    """Return `value` as a float, which must be one number from 1e-100 to 1e100."""
    return _sized(name, positive(name, value), "from")


def size_or_zero(name, value):
    """Return `value` as a float, which must be zero or one number from 1e-100 to 1e100."""
    number = not_negative(name, value)
    sizes(name, number)
    return number


def _half_angle(name, value):
    """Return `value` as a float, half the opening of a cone that is no line and no plane."""
    number = finite(name, value)
    if not 0 < number < np.pi / 2:
        raise ValueError(f"{name}: must lie between 0 and pi/2, both left out; got {number!r}.")
    if number < LEAST:
        raise ValueError(f"{name}: must be at least {LEAST:g} rad; got {number!r}.")
    return number


def whole(name, value, low, high):
    """Return `value` as an int64 array of any shape with low <= value <= high.

    The argument's name is for the message.
    """
    array = as_array(value)
    # Two passes that keep nothing are twice as fast as comparisons of every number.
    within = array.dtype.kind in "iu" and (
        not array.size or (low <= array.min() and array.max() <= high)
    )
    if not within:
        raise ValueError(
            f"{name}: must hold whole numbers from {low} to {high}; got {shown(value)}."
        )
    return array.astype(np.int64)


def one_whole(name, value, low, high):
    """Return `value` as an int with low <= value <= high; the name is for the message."""
    array = as_array(value)
    if array.ndim or array.dtype.kind not in "iu" or not low <= array <= high:
        raise ValueError(
            f"{name}: must be one whole number from {low} to {high}; got {shown(value)}."
        )
    return int(array)


def points(name, value):
    """Return `value` as a float array (..., 3) of points."""
    return _last_axis(name, value, 3, "x, y, z")


def finite_points(name, value):
    """Return `value` as a float array (..., 3) of points, none of them NaN or infinite."""
    return finite_array(name, points(name, value))


def near_points(name, value):
    """Return `value` as `finite_points`, none further than 1e100 along any axis."""
    return bounded_array(name, points(name, value))


def sizes(name, value):
    """Return `value`, an array (...) of lengths, each zero or from 1e-100 to 1e100 in size."""
    return _sized(name, value, "zero or from")


def _sized(name, value, rule):
    array = np.abs(value)
    # The extremes tell of nearly all that come.
    if array.size and array.min() >= LEAST and array.max() <= MOST:
        return value
    wrong = ~((array == 0) | (array >= LEAST) & (array <= MOST))
    if wrong.any():
        raise ValueError(
            f"{name}: must be {rule} {LEAST:g} to {MOST:g} in size, whose square is a number; "
            f"got {_first(np.asarray(array), wrong)}."
        )
    return value


def directions(name, value):
    """Return `value` as vectors (..., 3) of `sizes` that have squares, none of them zero."""
    array = points(name, value)
    if array.ndim == 1:
        finite_array(name, array)
        greatest = max(map(abs, array.tolist()))
        if LEAST <= greatest <= MOST:
            return array
    elif array.size:
        # The extremes of the squares tell of nearly all that come: one pass over the vectors.
        squares = np.einsum("...i,...i->...", array, array)
        if squares.min() >= 3 * LEAST**2 and squares.max() <= MOST**2:
            return array
    finite_array(name, array)
    greatest = np.abs(array).max(axis=-1)
    if not greatest.all():
        raise ValueError(f"{name}: must not be zero; got (0, 0, 0).")
    _sized(name, greatest, "from")
    return array


def point(name, value):
    """Return `value` as a tuple of three floats: one point, as `near_points`."""
    array = near_points(name, value)
    if array.ndim != 1:
        raise ValueError(f"{name}: must be one point (3,); got {array.shape}.")
    return tuple(array.tolist())


def positions(name, value):
    """Return `value` as a float array (..., 2) of joint positions."""
    return bounded_array(name, _last_axis(name, value, 2, "theta, phi"))


def corners(name, value):
    """Return `value` as a float array (..., 2) of points (x, y)."""
    return bounded_array(name, _last_axis(name, value, 2, "x, y"))


def polynomials(name, value):
    """Return `value` as a float array (..., n + 1) of coefficients, which need not be finite."""
    array = real(name, value)
    if array.ndim == 0 or not array.shape[-1]:
        raise ValueError(f"{name}: must have a last axis of coefficients; got {array.shape}.")
    return array


def _last_axis(name, value, count, axes):
    array = real(name, value)
    if array.ndim == 0 or array.shape[-1] != count:
        raise ValueError(
            f"{name}: the last axis must hold {axes}, so its shape must be (..., {count}); "
            f"got {array.shape}."
        )
    return array


# What arguments may be. One number:
Finite = Annotated[float, Rule("float", finite)]
Positive = Annotated[float, Rule("float", positive)]
NotNegative = Annotated[float, Rule("float", not_negative)]
Length = Annotated[float, Rule("float", size, "m")]
Length0 = Annotated[float, Rule("float", size_or_zero, "m")]
Coordinate = Annotated[float, Rule("float", coordinate, "m")]
Angle = Annotated[float, Rule("float", coordinate, "rad")]
HalfAngle = Annotated[float, Rule("float", _half_angle, "rad")]
Duration = Annotated[float, Rule("float", positive, "s")]
Sign = Annotated[int, Rule("{1, -1}", _sign)]
Point = Annotated[tuple[float, float, float], Rule("(3,) float", point, "m")]
# Many, that broadcast:
Corners = Annotated[ArrayLike, Rule("(..., 2) float", corners, "m")]
Polynomials = Annotated[ArrayLike, Rule("(..., n + 1) float", polynomials)]
Rates = Annotated[ArrayLike, Rule("(..., 2) float", positions, "rad/s")]
Reals = Annotated[ArrayLike, Rule("(...) float", bounded_array)]
Angles = Annotated[ArrayLike, Rule("(...) float", bounded_array, "rad")]
Lengths = Annotated[ArrayLike, Rule("(...) float", bounded_array, "m")]
Points = Annotated[ArrayLike, Rule("(..., 3) float", near_points, "m")]
Directions = Annotated[ArrayLike, Rule("(..., 3) float", directions)]
Positions = Annotated[ArrayLike, Rule("(..., 2) float", positions, "rad")]


def Whole(low, high):
    """Return the annotation of one whole number from `low` to `high`."""
    return Annotated[int, Rule("int", lambda name, value: one_whole(name, value, low, high))]


def Wholes(says, low, high):
    """Return the annotation of an array of whole numbers from `low` to `high`.

    Its shape is what docstrings say of it: "(k,) int".
    """
    return Annotated[ArrayLike, Rule(says, lambda name, value: whole(name, value, low, high))]


def Each(*kinds):
    """Return the annotation of a list or tuple of instances of one of some classes."""
    says = " or ".join(kind.__name__ for kind in kinds)

    def check(name, value):
        if not isinstance(value, (list, tuple)):
            raise ValueError(f"{name}: must be a list of {says}; got {shown(value)}.")
        for i, one in enumerate(value):
            if not isinstance(one, kinds):
                raise ValueError(f"{name}[{i}]: must be of class {says}; got {shown(one)}.")
        return tuple(value)

    return Annotated[list, Rule(f"list of {says}", check)]
