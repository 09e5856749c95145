"""What `==` and `hash` say of the library's objects: of values, or of objects that hold arrays."""

import copy
import dataclasses
import importlib
import inspect
import pkgutil
import types
import typing

import numpy as np
import pytest
from numpy.typing import ArrayLike

import tunneller_lib
from tests.test_contract import INSTANCES, instance

# By the examples.
READS = []


def every_dataclass():
    """Yield the dataclasses of all modules that can be imported here."""
    for module in pkgutil.walk_packages(tunneller_lib.__path__, "tunneller_lib."):
        try:
            room = importlib.import_module(module.name)
        except ImportError:  # the core's tests do without what pictures need
            continue
        for kind in vars(room).values():
            own = inspect.isclass(kind) and kind.__module__ == module.name
            if own and dataclasses.is_dataclass(kind):
                yield kind


KINDS = sorted(set(every_dataclass()), key=lambda kind: (kind.__module__, kind.__name__))


def may_be_an_array(annotation):
    """Tell whether what is annotated may be an array, or a list, that may have some."""
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return parts[0] is ArrayLike  # lists come as tuples
    if origin in (typing.Union, types.UnionType):
        return any(map(may_be_an_array, parts))
    return annotation in (np.ndarray, list)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_class_compares_by_identity_if_a_field_may_be_an_array(kind):
    fields = [field for field in dataclasses.fields(kind) if field.compare]
    bad = [field.name for field in fields if may_be_an_array(field.type)]
    if bad:
        assert kind.__eq__ is object.__eq__, f"{', '.join(bad)}: @dataclass(frozen=True, eq=False)"
        assert kind.__hash__ is object.__hash__


@pytest.mark.parametrize(
    "kind", [*filter(dataclasses.is_dataclass, INSTANCES)], ids=lambda kind: kind.__name__
)
def test_object_can_be_compared_and_hashed(kind):
    one = instance(kind)
    assert one == one
    assert (one == copy.copy(one)) in (True, False)
    assert one != 3
    # What is equal by the values of a dict has no hash, as a dict has none.
    if kind.__eq__ is object.__eq__ or not any(f.type is dict for f in dataclasses.fields(kind)):
        assert len({one, one}) == 1
