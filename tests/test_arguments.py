"""Right use of every public function: scalars, leading axes, empties, arguments left alone."""

import numpy as np
import pytest

from tests.calls import CALLS


def made(call, lead, seed=0):
    """Return valid arguments of a public call with leading axes."""
    rng = np.random.default_rng(seed)
    return [rng.uniform(0.1, 0.4, (*lead, *axis)) for axis in call.axes]


def as_tuple(answer):
    return answer if isinstance(answer, tuple) else (answer,)


ROWWISE = {name: call for name, call in CALLS.items() if not call.flat}
every_call = pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
every_rowwise_call = pytest.mark.parametrize("call", ROWWISE.values(), ids=ROWWISE)


@every_call
@pytest.mark.parametrize("lead", [(), (1,), (3,), (2, 3)])
def test_call_keeps_leading_axes(call, lead):
    if call.flat:
        lead = (6,)
    for answer, axis in zip(as_tuple(call.function(*made(call, lead))), call.answer, strict=True):
        assert np.shape(answer) == (*lead, *axis)


@every_rowwise_call
def test_call_of_an_array_is_that_of_its_rows(call):
    arguments = made(call, (5,))
    found = as_tuple(call.function(*arguments))
    rows = [as_tuple(call.function(*row)) for row in zip(*arguments, strict=True)]
    for answer, expected in zip(found, zip(*rows, strict=True), strict=True):
        np.testing.assert_allclose(answer, np.array(expected), rtol=1e-14, atol=1e-15)


@every_rowwise_call
def test_call_of_nothing_is_nothing(call):
    for lead in ((0,), (2, 0)):
        arguments = [np.empty((*lead, *axis)) for axis in call.axes]
        for answer, axis in zip(as_tuple(call.function(*arguments)), call.answer, strict=True):
            assert np.shape(answer) == (*lead, *axis)


@every_call
def test_call_leaves_its_arguments_alone(call):
    arguments = made(call, (6,))
    for argument in arguments:
        argument.flags.writeable = False
    before = [np.copy(argument) for argument in arguments]
    answers = as_tuple(call.function(*arguments))
    for argument, copy in zip(arguments, before, strict=True):
        np.testing.assert_array_equal(argument, copy)
        assert not any(np.may_share_memory(argument, answer) for answer in answers)


@every_rowwise_call
def test_call_takes_lists_and_whole_numbers(call):
    arguments = [np.full((2, *axis), i + 1) for i, axis in enumerate(call.axes)]
    whole, lists, real = (
        as_tuple(call.function(*map(take, arguments)))
        for take in (np.asarray, np.ndarray.tolist, lambda a: a.astype(float))
    )
    for a, b, c in zip(whole, lists, real, strict=True):
        np.testing.assert_array_equal(a, c)
        np.testing.assert_array_equal(b, c)


@every_call
@pytest.mark.parametrize("order", ["F", "strided"])
def test_call_takes_any_memory_layout(call, order):
    arguments = made(call, (6,))
    if order == "F":
        others = [np.asfortranarray(argument) for argument in arguments]
    else:
        others = [np.repeat(argument, 2, axis=0)[::2] for argument in arguments]
    for a, b in zip(
        as_tuple(call.function(*others)), as_tuple(call.function(*arguments)), strict=True
    ):
        np.testing.assert_allclose(a, b, rtol=1e-14, atol=1e-15)
