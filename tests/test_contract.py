"""The contract of functions: an answer, or a ValueError of one sentence, and soon.

It holds for what a room's `__all__` lists: functions, classes with their methods, and modules with
theirs; and for whatever else of a room looks at its arguments, such as the methods of a class that
only comes as an answer. What each argument may be is read from the annotations, which
`arguments.checked` enforces.
"""

import ast
import doctest
import importlib
import importlib.util
import inspect
import math
import re
import reprlib
import struct
import time
import types
import warnings
from copy import deepcopy
from dataclasses import dataclass, fields, is_dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import islice
from pathlib import Path
from random import Random

import numpy as np
import pytest

from exhibits import atlas
from tests.audit.long import many
from tests.blocks import few_pairs
from tunneller_lib.arguments import rule_of

READS = []

EXAMPLES_AT = Path(__file__).parent / "examples"
ROOMS = sorted(path.stem for path in EXAMPLES_AT.glob("[a-z]*.py"))
SOON = 5.0  # seconds of processor time
EXAMPLES = {room: importlib.import_module(f"tests.examples.{room}") for room in ROOMS}
INSTANCES = {kind: one for room in EXAMPLES.values() for kind, one in room.INSTANCES.items()}

# Values that fit nearly every rule of a shape; numbers may be above zero alone.
USUAL = {
    "float": 0.5, "(...) float": 0.3, "(3,) float": (0.3, 0.2, 0.1),
    "(..., 2) float": (0.3, 0.2), "(..., 3) float": (0.0, 0.6, 0.8),
    "(..., n + 1) float": (1.0, -3.0, 2.0),
}  # fmt: skip


@cache
def instance(kind):
    """Return the examples' object of a class, made now if it takes time, or its docstring's."""
    one = INSTANCES[kind] if kind in INSTANCES else shown(kind)
    return one() if callable(one) and not isinstance(one, kind) else one


def shown(kind):
    """Return the object of a class that its docstring's examples make, or None."""
    for example in doctest.DocTestParser().get_examples(kind.__doc__ or ""):
        for node in ast.walk(ast.parse(example.source)):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == kind.__name__:
                return eval(ast.unparse(node), vars(inspect.getmodule(kind)))
    return None


@dataclass(frozen=True)
class Call:
    """A public function, method or class, and what its arguments may be."""

    room: str
    name: str
    function: object
    owner: type | None

    @cached_property
    def parameters(self):
        every = inspect.signature(self.function).parameters
        return {
            name: about
            for name, about in every.items()
            if name not in ("self", "cls") and about.kind is not about.VAR_KEYWORD
        }

    @property
    def checks(self):
        """Return whether it looks at its arguments, or has none and belongs to an answer."""
        looks = inspect.isclass(self.function) or hasattr(self.function, "unchecked")
        return looks or (self.owner in INSTANCES and not self.parameters)

    @cached_property
    def valid(self):
        """Return valid arguments: those of the examples, else what is usual for their rules."""
        given = EXAMPLES[self.room].CALLS.get(self.name, {})
        found = dict(given() if callable(given) else given)
        if not given and is_dataclass(self.function) and (one := instance(self.function)):
            found = {name: getattr(one, name) for name in self.parameters if hasattr(one, name)}
        for name, about in self.parameters.items():
            if name not in found and about.default is inspect.Parameter.empty:
                found[name] = usual(about.annotation)
        return found

    def __call__(self, given):
        """Call with arguments by name, and ask for the first answers of what yields many."""
        itself = () if self.owner is None else (instance(self.owner),)
        answer = self.function(*itself, **given)
        return list(islice(answer, 10_000)) if isinstance(answer, types.GeneratorType) else answer


def usual(annotation):
    """Return a value that an annotation allows."""
    if isinstance(annotation, type) and annotation in INSTANCES:
        return instance(annotation)
    rule = rule_of(annotation)
    for value in (USUAL.get(rule.says), True, "plus", 1, 2, 8):
        try:
            rule.check("it", value)
            return value
        except ValueError:
            continue
    raise LookupError(f"no example for {annotation!r}")


def calls(room):
    """Yield the calls of a room that the contract is for, those of a listed module by its name.

    Without those that its examples leave out, saying why.
    """
    package = importlib.import_module(f"tunneller_lib.{room}")
    left_out = getattr(EXAMPLES[room], "LEFT_OUT", set())
    for name in sorted(set(package.__all__) - left_out):
        thing = getattr(package, name, None)
        if thing is None:  # a module that is imported where it is asked for
            thing = importlib.import_module(f"{package.__name__}.{name}")
        yield from named(room, name, thing)
    if left_out:
        return
    for path in sorted(Path(package.__file__).parent.glob("[a-z]*.py")):
        if path.stem not in package.__all__:
            module = importlib.import_module(f"{package.__name__}.{path.stem}")
            for name, thing in own(module):
                if name not in package.__all__:
                    yield from (call for call in named(room, name, thing) if call.checks)


def own(module):
    """Yield what a module defines for others."""
    for name, thing in vars(module).items():
        if not name.startswith("_") and getattr(thing, "__module__", "") == module.__name__:
            yield name, thing


def named(room, name, thing):
    if inspect.ismodule(thing):
        for inner, one in own(thing):
            yield from named(room, f"{name}.{inner}", one)
    elif inspect.isclass(thing):
        if getattr(thing, "__post_init__", None) or hasattr(thing.__init__, "unchecked"):
            yield Call(room, name, thing, None)
        for inner, one in inspect.getmembers(thing):
            # What a class inherits is asked of the class that it is from.
            if not (inspect.isfunction(one) or inspect.ismethod(one)) or inner not in vars(thing):
                continue
            if not inner.startswith("_") or (inner == "__call__" and hasattr(one, "unchecked")):
                owner = thing if inspect.isfunction(one) else None  # a class method has its class
                yield Call(room, f"{name}.{inner}", one, owner)
    elif inspect.isfunction(thing):
        yield Call(room, name, thing, None)


@pytest.fixture(autouse=True, scope="module")
def _few_pairs():
    """Survey every hundredth pair of a block of the atlas."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(atlas, "pairs", few_pairs)
        yield


EVERY = {f"{room}.{call.name}": call for room in ROOMS for call in calls(room)}
every_call = pytest.mark.parametrize("call", EVERY.values(), ids=EVERY)


def test_every_argument_says_what_it_may_be():
    for call in EVERY.values():
        for name, about in call.parameters.items():
            said = f"{call.name}: {name}"
            assert about.annotation is not inspect.Parameter.empty, f"{said} says nothing"
            rule = rule_of(about.annotation)
            assert rule.says != "object", f"{said}: anything?"
            if about.default is not about.empty:  # which may be given by hand, too
                rule.check(said, about.default)
        looks = inspect.isclass(call.function) or hasattr(call.function, "unchecked")
        assert looks or not call.parameters, f"{call.name}: nobody looks at its arguments"


@every_call
def test_the_example_of_a_call_is_answered(call):
    call(call.valid)


class Hostile:
    """What numpy asks, it refuses; so it does to be shown."""

    def __array__(self, *given, **options):
        raise RuntimeError("no array")

    def __repr__(self):
        raise RuntimeError("no name")


ODD = [
    None, True, False, 0, 1, -1, 2, 3, 1.5, -0.0, 1e-5, 1e6, 10**9, 2**31, 2**63, 2**64, 10**400,
    np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 5e-324, 1e100, 1e-100, 1e15, 1j, "", "x", "up",
    "a\nb", "x" * 10**6, b"x", (), [], {}, {1: 2}, set(), [[]], [1], [1, 2], [1, 2, 3], (1,) * 4,
    [[1], [1, 2]], [None], ["1"], [np.nan, 0, 0], [[0, 0, 0]], np.zeros((0, 3)),
    np.zeros((2, 0, 3)), np.zeros((3, 2)), np.full((2, 3), 1e300), np.full((2, 2), 1e-300),
    np.ones((2, 2, 3)),
    np.ma.masked_array([1.0, 2.0, 3.0], [0, 1, 0]), np.ma.masked, np.float16(1), np.uint8(7),
    np.longdouble("1e4000"), np.array(3), np.array(True), np.array([1, 2], dtype=object),
    np.datetime64("2026-01-01"), np.array("x"), np.zeros(3, dtype=[("a", float)]), Fraction(1, 3),
    Decimal("0.5"), object(), int, len, lambda *given: None, Hostile(), range(3), iter([1, 2]),
    slice(1), Ellipsis, NotImplemented, np.random.default_rng(1), np.ones(1000), np.ones((500, 3)),
    np.ones((500, 2)), np.zeros((1, 1, 1, 1, 3)), list(range(5000)),
]  # fmt: skip


def odd_number(random):
    """Return a float of any bits, or one of a likely size."""
    if random.random() < 0.5:
        return struct.unpack("d", random.randbytes(8))[0]
    return random.choice([-1, 1]) * 10 ** random.uniform(-12, 12)


def odd_array(random):
    """Return an array of any shape up to (4, 4, 4), of odd or of likely numbers."""
    shape = [random.randint(0, 4) for _ in range(random.randint(0, 3))]
    kind = random.choice([np.float64, np.float32, np.int64])
    if kind is np.int64:
        draw = partial(random.randint, -(2**63), 2**63 - 1)
    else:
        draw = partial(odd_number, random)
    likely = random.choice([0.0, 1.0, 0.5])
    values = [draw() if random.random() < 0.5 else likely for _ in range(math.prod(shape))]
    with np.errstate(over="ignore", invalid="ignore"):  # for float32 some are too large
        return np.array(values, dtype=object).astype(kind).reshape(shape)


def odd(random):
    """Return what an argument hardly is meant to be."""
    return random.choice([
        lambda: random.choice(ODD),
        lambda: odd_number(random),
        lambda: random.randint(-(2 ** random.randint(0, 70)), 2 ** random.randint(0, 70)),
        lambda: instance(random.choice(list(INSTANCES))),
        lambda: odd_array(random),
    ])()  # fmt: skip


def level(random, value):
    """Return small whole numbers of a value's shape, or the value where it holds none.

    So points coincide and lie level, upright or in line, which odd numbers hardly ever do.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, RuntimeError):
        return value
    if array.dtype.kind not in "if" or array.size > 1000 or random.random() < 0.2:
        return value
    few = [0, 0, 1, 1, 2] if array.dtype.kind == "i" else [0, 0, 0, 1, 1, -1, 0.5, 2]
    drawn = np.array(random.choices(few, k=array.size), dtype=array.dtype).reshape(array.shape)
    return drawn if array.ndim else drawn.item()


def some_odd(call, random):
    names = sorted(call.parameters)
    chosen = random.sample(names, min(random.randint(1, 3), len(names)))
    return {name: odd(random) for name in chosen}


def all_level(call, random):
    return {name: level(random, value) for name, value in call.valid.items()}


def at_limits(call, random):
    """Return one or two arguments at an end of their ranges, or the float inside or outside it."""
    ranges = {name: rule_of(about.annotation).range for name, about in call.parameters.items()}
    names = sorted(name for name, range_ in ranges.items() if range_)
    chosen = random.sample(names, min(random.randint(1, 2), len(names)))
    given = {}
    for name in chosen:
        end = random.choice(ranges[name])
        value = random.choice([end, math.nextafter(end, math.inf), math.nextafter(end, -math.inf)])
        given[name] = np.full(np.shape(call.valid.get(name, 0.0)), value)[()]
    return given


WAYS = {"": (some_odd, many(8, 1000)), "level ": (all_level, many(4, 500)),
        "limit ": (at_limits, many(4, 300))}  # fmt: skip


@every_call
def test_arguments_are_answered_or_refused_in_a_sentence(call):
    """One to three odd ones, all of them small whole numbers, or some at the ends of ranges."""
    for way, (draw, count) in WAYS.items():
        for case in range(count if call.parameters else 0):
            tried(call, draw(call, Random(f"{call.room}.{call.name}, {way}{case}")), case)


def tried(call, given, case):
    """Call with valid arguments but for those given, and no warning; assert that it ends soon."""
    begun = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            call(call.valid | given)
    except ValueError as error:
        message = str(error)
        assert re.fullmatch(r"[^\n]{5,400}\.", message), f"no sentence: {message[:500]!r}"
        names = message.partition(":")[0]
        assert re.search(r"\w", names) and ":" in message, f"which argument? {message!r}"
    except Exception as error:
        error.add_note(f"Case {case}, with {reprlib.repr(given)}.")
        raise
    assert time.process_time() - begun < SOON


# Arrays: of leading axes that broadcast each row is answered as it is alone, and left alone.


def rows_of(call, lead):
    """Return valid arguments with leading axes where their rules allow such, or None."""
    rules = {name: rule_of(about.annotation) for name, about in call.parameters.items()}
    given = {}
    for name, value in call.valid.items():
        if rules[name].own_axes is not None:
            row = np.asarray(value)
            while row.ndim > rules[name].own_axes:
                row = row[0]
            given[name] = np.broadcast_to(row, (*lead, *row.shape)).copy()
    return given


def arrays_in(answer):
    """Yield the arrays of an answer: itself, its parts or its fields."""
    if isinstance(answer, np.ndarray | float | np.generic):
        yield np.asarray(answer)
    elif isinstance(answer, tuple):
        for part in answer:
            yield from arrays_in(part)


WHOLE = {
    "adapted_frames", "mean_frame", "fit_surface", "frames_along",
    "model_jet", "recognise", "GeodesicPoints.deviation", "DexelGrid",
}  # of points that belong together, or to what has rows of its own  # fmt: skip


@every_call
def test_rows_are_answered_as_they_are_alone_and_not_written_to(call):
    alone = rows_of(call, ())
    if not alone or call.name in WHOLE:
        return
    expected = list(arrays_in(call(call.valid | alone)))
    for lead in ((3,), (2, 3), (0,)):
        given = rows_of(call, lead)
        for row in given.values():
            row.flags.writeable = False
        found = list(arrays_in(call(call.valid | given)))
        assert len(found) == len(expected)
        for rows, one in zip(found, expected, strict=True):
            assert rows.shape == (*lead, *one.shape)
            np.testing.assert_allclose(
                rows, np.broadcast_to(one, rows.shape), rtol=1e-13, atol=1e-15
            )
            assert not any(np.may_share_memory(rows, row) for row in given.values())


# What `==` and `hash` say of objects: of values, or of objects that hold arrays.


@pytest.mark.parametrize("kind", [*filter(is_dataclass, INSTANCES)], ids=lambda kind: kind.__name__)
def test_object_can_be_compared_and_hashed(kind):
    one = instance(kind)
    assert one == one
    assert (one == deepcopy(one)) in (True, False)
    assert one != 3
    # What is equal by the values of a dict has no hash, as a dict has none.
    if kind.__eq__ is object.__eq__ or not any(f.type is dict for f in fields(kind)):
        assert len({one, one}) == 1
