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
TINY = float(np.finfo(float).smallest_subnormal)
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
    range : tuple
        The least and the greatest number that passes, or none.
    """

    says: str
    check: Callable
    unit: str = ""
    range: tuple = ()

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
        With the same signature. The function itself is its attribute ``unchecked``, for proofs
        that call it with symbols.

    Notes
    -----
    The library's own code calls checked functions as everybody does. What that costs, some
    microseconds a call and two passes over an array, only a loop over single numbers would feel.
    Such a loop, and code whose numbers may be NaN, calls a plain function that the checked one
    calls, too, as `Torus.foot` does with `Torus._foot`. Nested calls don't skip their checks: a
    function that a user gave may be among the callers, and a list has to become an array.

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
        values[name] = sound = rule.check(name, value)
        if rule.own_axes is not None and sound is not None:
            shape = getattr(sound, "shape", ())  # a single number has none
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
            if isinstance(kind, type) and isinstance(value, kind) and not isinstance(value, type):
                return value
        if len(rules) > 1:
            wanted = " or ".join(rule.says for rule in rules)
            raise ValueError(f"{name}: must be of class {wanted}; got {shown(value)}.")
        return rules[0].check(name, value)

    says = " or ".join(rule.says for rule in rules)
    return Rule(says, check, rules[0].unit, rules[0].range)


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
    """A short form of values, made without a look at every element of long ones."""

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
    if type(value) is float:
        return np.array(value)
    array = as_array(value)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name}: must hold real numbers in a regular array; got {shown(value)}.")
    with np.errstate(over="ignore"):
        return np.asarray(array, dtype=float)


def as_array(value):
    """Return a value as an array, of objects where numpy has no type for it."""
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


def none_outside(array, low, high):
    """Tell whether none of the numbers is outside `low` to `high`: two passes that keep nothing."""
    if array.size <= FEW:
        return all([low <= number <= high for number in array.ravel().tolist()])
    return bool(array.min() >= low and array.max() <= high)


def _first(array, wrong):
    """Return the first of the wrong elements, as a message shows it."""
    return f"{array[wrong].flat[0]:g}"


def _span(low, high, or_zero):
    """Return the words for a range of numbers."""
    if low == -high:
        return f"of at most {high:g} in size"
    return f"{'zero or ' if or_zero else ''}from {low:g} to {high:g}"


def Number(low=-GREATEST, high=GREATEST, unit="", *, or_zero=False, why="", also=None):
    """Return the annotation of one finite number from `low` to `high`, which becomes a float.

    Parameters
    ----------
    low, high : float
        The range.
    unit : str, optional
        That docstrings give.
    or_zero : bool
        Whether zero passes, too, where the range begins above it.
    why : str, optional
        What the message says after the range.
    also : tuple of str and callable, optional
        What else the number must do, in words, and the function that tells whether it does.
    """
    least = TINY if low > 0 and not or_zero else 0.0 if low >= 0 else -GREATEST
    above = {TINY: " above zero", 0.0: ", not below zero"}.get(least, "")
    most = max(high, GREATEST)
    finite = "number" if most > GREATEST else "finite number"
    must, does = also or ("", None)

    def check(name, value):
        if type(value) is float and low <= value <= high and not does:
            return value  # as nearly always: the short way
        number = real(name, value)
        one = not number.ndim and -most <= number <= most
        if one and does and not does(number):
            raise ValueError(f"{name}: must {must}; got {float(number)!r}.")
        if not (one and least <= number):
            raise ValueError(f"{name}: must be one {finite}{above}; got {shown(value)}.")
        number = float(number)
        if not (low <= number <= high or (or_zero and number == 0)):
            span = _span(low, high, or_zero)
            raise ValueError(f"{name}: must be {span}{why}; got {shown(value)}.")
        return number

    return Annotated[float, Rule("float", check, unit, (low, high))]


def Array(
    says, unit="", *, low=-MOST, high=MOST, or_zero=False, why="", also=None, last="", loose=False
):
    """Return the annotation of an array of numbers from `low` to `high`.

    Parameters
    ----------
    says : str
        Its shape, as docstrings write it: "(..., 3) float" or "() or (n,) float". A name stands
        for any length, "n + 1" for one at least. Of "(3,) float" comes a tuple.
    unit, low, high, or_zero, why, also
        As of `Number`; `also` is asked of the whole array.
    last : str, optional
        What the last axis holds.
    loose : bool
        Whether its numbers may be of any size, infinite or NaN.
    """
    shaped, given = _shape_rule(says, last)
    must, does = also or ("", None)
    of = f" {unit}" if unit else ""

    def check(name, value):
        array = real(name, value)
        shaped(name, array)
        if not (loose or none_outside(array, low, high)):
            if not none_outside(array, -GREATEST, GREATEST):
                infinite = _first(array, ~np.isfinite(array))
                raise ValueError(f"{name}: must hold finite numbers; got {infinite}.")
            if low >= 0 and high == MOST and np.any(array < 0):
                raise ValueError(f"{name}: must not be below zero; got {array.min():g}{of}.")
            wrong = ~((low <= array) & (array <= high) | (or_zero & (array == 0)))
            if wrong.any():
                span = ("hold numbers " if low == -high else "be ") + _span(low, high, or_zero)
                raise ValueError(f"{name}: must {span}{why}; got {_first(array, wrong)}.")
        if does and not does(array):
            raise ValueError(f"{name}: must {must}; got {shown(value)}.")
        return tuple(array.tolist()) if given else array

    return Annotated[tuple if given else ArrayLike, Rule(says, check, unit, (low, high))]


def _shape_rule(says, last=""):
    """Return a function that refuses arrays of another shape than `says`, see `Array`.

    Return also whether it's one row of a given length, which functions get as a tuple.
    """
    shapes = says.rpartition(" ")[0]
    allowed = []
    for shape in shapes.split(" or "):
        lengths = [length.strip() for length in shape.strip("()").split(",") if length.strip()]
        leading = lengths[:1] == ["..."]
        ranges = [
            (int(length), int(length)) if length.isdigit() else (int("+ 1" in length), MOST)
            for length in lengths[leading:]
        ]
        allowed.append((leading, ranges))

    leading, ranges = allowed[0]
    axes = len(ranges)
    usual = tuple(low for low, high in ranges) if leading else None

    def check(name, array):
        if array.shape[array.ndim - axes :] == usual:  # as nearly always: the short way
            return
        for leading, ranges in allowed:
            own = array.shape[array.ndim - len(ranges) :] if leading else array.shape
            pairs = zip(own, ranges, strict=False)
            if len(own) == len(ranges) and all([low <= n <= high for n, (low, high) in pairs]):
                return
        must = "must have the shape"
        if last and array.shape[-1:] != (ranges[-1][0],):
            must = f"the last axis must hold {last}, so its shape must be"
        raise ValueError(f"{name}: {must} {shapes}; got {array.shape}.")

    return check, shapes.strip("(),").isdigit()


def Whole(low, high):
    """Return the annotation of one whole number from `low` to `high`."""
    return Annotated[int, Rule("int", lambda name, value: one_whole(name, value, low, high))]


def one_whole(name, value, low, high):
    """Return `value` as an int with low <= value <= high; the name is for the message."""
    array = as_array(value)
    if array.ndim or array.dtype.kind not in "iu" or not low <= array <= high:
        raise ValueError(
            f"{name}: must be one whole number from {low} to {high}; got {shown(value)}."
        )
    return int(array)


def Wholes(says, low, high):
    """Return the annotation of an array of whole numbers, `says` as of `Array`: "(k,) int"."""
    shaped, given = _shape_rule(says)

    def check(name, value):
        array = whole(name, value, low, high)
        shaped(name, array)
        return tuple(array.tolist()) if given else array

    return Annotated[tuple if given else ArrayLike, Rule(says, check)]


def whole(name, value, low, high):
    """Return `value` as an int64 array of any shape with low <= value <= high.

    The argument's name is for the message.
    """
    array = as_array(value)
    # Two passes that keep nothing are twice as fast as comparisons of every number.
    inside = array.dtype.kind in "iu" and (
        not array.size or (low <= array.min() and array.max() <= high)
    )
    if not inside:
        raise ValueError(
            f"{name}: must hold whole numbers from {low} to {high}; got {shown(value)}."
        )
    return array.astype(np.int64)


def Each(*kinds, some=False, or_one=False):
    """Return the annotation of a list or tuple of instances of `kinds`, some classes.

    It has one at least if `some` says so; with `or_one` an instance alone passes, too.
    """
    names = " or ".join(kind.__name__ for kind in kinds)
    wanted = f"a list of {names}{', one at least' if some else ''}"
    wanted = f"of class {names}, or a list" if or_one else wanted

    def check(name, value):
        if or_one and isinstance(value, kinds):
            return value
        if not isinstance(value, (list, tuple)) or (some and not value):
            raise ValueError(f"{name}: must be {wanted}; got {shown(value)}.")
        for i, one in enumerate(value):
            if not isinstance(one, kinds):
                raise ValueError(f"{name}[{i}]: must be of class {names}; got {shown(one)}.")
        return tuple(value)

    says = f"{names} or a list of them" if or_one else f"list of {names}"
    return Annotated[list, Rule(says, check)]


def directions(name, value):
    """Return `value` as vectors (..., 3), none of them zero, all with squares that are numbers."""
    array = _vectors(name, value)
    if array.size == 3:
        if none_outside(array, -MOST, MOST) and max(map(abs, array.ravel().tolist())) >= LEAST:
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
    _lengths(name, greatest)
    return array


def _direction(name, value):
    """Return `value` as a tuple of three floats: one vector, as of `directions`."""
    return rule_of(Point).check(name, directions(name, value))


def sizes(name, value):
    """Raise ValueError where a length (...), in size, is neither zero nor from 1e-100 to 1e100."""
    rule_of(Radii).check(name, np.abs(value))


_SQUARES = " in size, whose square is a number"

# What arguments may be. One number:
Finite = Number()
Positive = Number(LEAST, MOST)
NotNegative = Number(0.0, MOST)
Size = Number(LEAST, MOST, why=_SQUARES)
Length = Number(LEAST, MOST, "m", why=_SQUARES)
Length0 = Number(LEAST, MOST, "m", why=_SQUARES, or_zero=True)
Coordinate = Number(-MOST, MOST, "m")
Angle = Number(-MOST, MOST, "rad")
HalfAngle = Number(
    LEAST,
    np.pi / 2,
    "rad",
    also=("lie between 0 and pi/2, both left out", lambda angle: 0 < angle < np.pi / 2),
)
Duration = Number(LEAST, MOST, "s")
Sign = Annotated[int, Rule("{1, -1}", _sign)]
Point = Array("(3,) float", "m", last="x, y, z")
Direction = Annotated[tuple, Rule("(3,) float", _direction)]
# Many, that broadcast:
Corners = Array("(..., 2) float", "m", last="x, y")
Reals = Array("(...) float")
Angles = Array("(...) float", "rad")
Lengths = Array("(...) float", "m")
Radii = Array("(...) float", "m", low=LEAST, or_zero=True, why=_SQUARES)
Points = Array("(..., 3) float", "m", last="x, y, z")
Directions = Annotated[ArrayLike, Rule("(..., 3) float", directions)]
Positions = Array("(..., 2) float", "rad", last="theta, phi")
Rates = Array("(..., 2) float", "rad/s", last="theta, phi")

# The same for functions that look at a value themselves.
finite, positive = rule_of(Finite).check, rule_of(Positive).check
bounded_array = rule_of(Reals).check
finite_array = rule_of(Array("(...) float", low=-GREATEST, high=GREATEST)).check
positions = rule_of(Positions).check
_vectors = rule_of(Array("(..., 3) float", last="x, y, z", loose=True)).check
_lengths = rule_of(Array("(...) float", low=LEAST, why=_SQUARES)).check
