"""What a machine must meet to cut a section, against the positions that its circuit needs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.shapes import HIGH, LOW
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Machine

EGG = Egg(0.5)
FAILURES = {
    "bend": {"cutter_radius": 0.27},  # an offset of a/2 just so
    "width": {"phi_max": 0.3},
    "crown": {"theta_min": -0.85},
    "floor": {"theta_max": 0.3},
}

machines = st.builds(
    Machine,
    r=st.floats(0.01, 0.5),
    R=st.floats(0.3, 1.2),
    theta_min=st.floats(-1.5, -0.3),
    theta_max=st.floats(0.1, 1.5),
    phi_min=st.floats(-1.5, -0.2),
    phi_max=st.floats(0.2, 1.5),
    cutter_radius=st.just(0.2),
    depth=st.floats(0, 0.19),
    height=st.floats(-0.6, 0.1),
)


def reaches(machine, egg):
    """Return whether every sampled position of the circuit exists and is within the limits."""
    circuit = Circuit(machine, egg)
    extremes = np.cumsum([0, np.pi / 2 * circuit.profile.arcs[0].radius])
    s = [*np.linspace(0, circuit.profile.perimeter, 721), *extremes, *circuit.profile.blends[:-1]]
    try:
        position = circuit.position(s)
    except ValueError:
        return False
    return bool(np.all(machine.within_limits(position)))


def margin(requirement):
    return abs(requirement.left - requirement.right)


@settings(max_examples=400)
@given(machines, st.floats(0.3, 0.6))
def test_requirements_are_necessary_and_sufficient(machine, a):
    egg = Egg(a)
    needed = machine.requirements(egg)
    if min(map(margin, needed)) < 1e-4 * a or not needed[0].met:
        return
    assert all(need.met for need in needed) == reaches(machine, egg)


def test_requirements_of_the_reference_machine_hold():
    needed = REFERENCE_MACHINE.requirements(EGG)
    assert [str(need).split(",")[0] for need in needed] == ["bend", "width", "crown", "floor"]
    assert all(need.met and str(need).endswith("holds") for need in needed)
    assert REFERENCE_MACHINE.check(EGG) is None


@pytest.mark.parametrize("name", FAILURES)
def test_check_names_the_inequality_that_fails(name):
    machine = replace(REFERENCE_MACHINE, **FAILURES[name])
    failing = [need for need in machine.requirements(EGG) if not need.met]
    assert [need.what.split(",")[0] for need in failing] == [name]
    with pytest.raises(
        ValueError, match=rf"^machine: can't cut this section; {name}.* m fails by \S+ m[.]$"
    ):
        machine.check(EGG)
    with pytest.raises(ValueError, match=rf"^machine: can't cut this section; {name}"):
        cutting_circuit(machine, EGG)


def test_within_limits_includes_the_limits():
    assert REFERENCE_MACHINE.within_limits([(0, 0), LOW, HIGH]).all()
    beyond = [(HIGH[0] + 1e-12, 0), (0, LOW[1] - 1e-12)]
    assert not REFERENCE_MACHINE.within_limits(beyond).any()


def test_heights_are_where_crown_and_floor_are_just_reached():
    egg = Egg(0.5)
    for height, index in zip(REFERENCE_MACHINE.heights(egg), (2, 3), strict=True):
        requirement = replace(REFERENCE_MACHINE, height=height).requirements(egg)[index]
        assert abs(requirement.left - requirement.right) <= 1e-15


def test_requirements_of_a_joint_that_turns_past_a_right_angle():
    wide = replace(REFERENCE_MACHINE, phi_min=-3.0, phi_max=3.0, theta_min=-2.6)
    assert all(requirement.met for requirement in wide.requirements(Egg(0.5)))
