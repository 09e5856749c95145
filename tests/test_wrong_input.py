"""Wrong input to every public function: one sentence that names the argument and what came."""

from dataclasses import replace

import numpy as np
import pytest

from tests.calls import CALLS
from tunneller_lib.paths import ConeChord, cutting_circuit, project_chord
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Body, Cone, Egg, Torus

EGG = Egg(0.5)
NUMBERS = {
    "Torus r": ("r", lambda x: Torus(x, 1)),
    "Torus R": ("R", lambda x: Torus(1, x)),
    "Egg a": ("a", Egg),
    "Egg offset": ("d", EGG.offset),
    "Cone": ("half_angle", Cone),
    "ConeChord R": ("R", lambda x: ConeChord(x, 1, 1, 0.2)),
    "ConeChord H": ("H", lambda x: ConeChord(1, x, 1, 0.2)),
    "ConeChord h": ("h", lambda x: ConeChord(1, 1, x, 0.2)),
    "ConeChord f": ("f", lambda x: ConeChord(1, 1, 1, x)),
    "pitch": ("pitch", lambda x: cutting_circuit(REFERENCE_MACHINE, EGG, pitch=x)),
    "yaw": ("yaw", lambda x: cutting_circuit(REFERENCE_MACHINE, EGG, yaw=x)),
    "tolerance": ("tolerance", Circuit(REFERENCE_MACHINE, EGG).knots),
} | {
    f"{type(whole).__name__} {name}": (name, lambda x, whole=whole, name=name: replace(
        whole, **{name: x}
    ))
    for whole in (REFERENCE_MACHINE, Body(1.2, 0.3, -0.2, 0.1))
    for name in whole.__dataclass_fields__
    if name != "body"
}  # fmt: skip
SIZES = [k for k, (name, _) in NUMBERS.items() if name in ("r", "R", "a", "H", "h", "cutter_radius",
                                                           "tolerance")]  # fmt: skip


def check_sentence(error, name, came):
    """Assert that a message is one sentence with the argument's name and what came."""
    message = str(error.value)
    assert message.startswith(f"{name}: ") and message.endswith(".")
    assert "\n" not in message and f"got {came}" in message


@pytest.mark.parametrize("key", NUMBERS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, "1", None, 1j, [1, 2], [[1], [1, 2]]],
                         ids=repr)  # fmt: skip
def test_a_number_must_be_one_finite_number(key, value):
    name, call = NUMBERS[key]
    with pytest.raises(ValueError) as error:
        call(value)
    check_sentence(error, name, repr(value))


@pytest.mark.parametrize("key", SIZES)
@pytest.mark.parametrize("value", [0, 0.0, -0.0, -1, -1e-300])
def test_a_size_must_be_above_zero(key, value):
    name, call = NUMBERS[key]
    with pytest.raises(ValueError) as error:
        call(value)
    check_sentence(error, name, repr(value))


@pytest.mark.parametrize("value", ["x", None, [1j], ["1"], [[1], [1, 2]]], ids=repr)
@pytest.mark.parametrize("key", CALLS)
def test_arrays_must_hold_real_numbers(key, value):
    call = CALLS[key]
    for i, name in enumerate(call.names):
        arguments = [np.full(axis, 0.25) for axis in call.axes]
        arguments[i] = value
        with pytest.raises(ValueError) as error:
            call.function(*arguments)
        check_sentence(error, name, repr(value))


@pytest.mark.parametrize("shape", [(), (0,), (1,), (4,), (3, 4), (3, 1)], ids=str)
@pytest.mark.parametrize("key", [k for k, call in CALLS.items() if any(call.axes)])
def test_points_must_have_their_last_axis(key, shape):
    call = CALLS[key]
    for i, (name, axis) in enumerate(zip(call.names, call.axes, strict=True)):
        if axis:
            arguments = [np.full(axis, 0.25) for axis in call.axes]
            arguments[i] = np.zeros(shape)
            with pytest.raises(ValueError, match=r"the last axis must hold ") as error:
                call.function(*arguments)
            check_sentence(error, name, str(shape))


@pytest.mark.parametrize("make", [Torus(1, 2), Egg(1), Cone(0.5), ConeChord(1, 1, 1, 0.2),
                                  REFERENCE_MACHINE, Circuit(REFERENCE_MACHINE, EGG)])  # fmt: skip
def test_shapes_are_frozen_and_equal_by_value(make):
    assert make == replace(make) and hash(make) == hash(replace(make))
    with pytest.raises(AttributeError):
        setattr(make, next(iter(make.__dataclass_fields__)), 1.0)


def test_options_are_keyword_only():
    with pytest.raises(TypeError):
        project_chord(Torus(1, 2), (0, 0), (0, 1), 3, "arc")
    with pytest.raises(TypeError):
        cutting_circuit(REFERENCE_MACHINE, EGG, 0.1)
    with pytest.raises(TypeError):
        Torus(1, 2).meet_line((0, 0, 0), (1, 0, 0), "quartic")
