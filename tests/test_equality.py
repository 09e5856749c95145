"""What `==` and `hash` say of the library's objects: of values, or of objects that hold arrays."""

import copy
import dataclasses

import pytest

from tests.test_contract import INSTANCES, instance

# By the examples.
READS = []


@pytest.mark.parametrize(
    "kind", [*filter(dataclasses.is_dataclass, INSTANCES)], ids=lambda kind: kind.__name__
)
def test_object_can_be_compared_and_hashed(kind):
    one = instance(kind)
    assert one == one
    assert (one == copy.deepcopy(one)) in (True, False)
    assert one != 3
    # What is equal by the values of a dict has no hash, as a dict has none.
    if kind.__eq__ is object.__eq__ or not any(f.type is dict for f in dataclasses.fields(kind)):
        assert len({one, one}) == 1
