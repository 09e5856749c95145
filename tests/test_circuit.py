"""The cutting circuit: on both surfaces, within the limits, its knots."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tunneller_lib.paths import cutting_circuit, project_chord
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

EGG = Egg(0.5)
POSES = {"aligned": (0, 0), "pitched": (0.03, 0), "yawed": (0, -0.04), "both": (-0.02, 0.05)}
WIDE = replace(REFERENCE_MACHINE, theta_min=-1.4, theta_max=1.2, phi_min=-1.2, phi_max=1.2)
pose = pytest.mark.parametrize("pitch, yaw", POSES.values(), ids=POSES)


def of(machine, pitch=0.0, yaw=0.0, egg=EGG):
    return cutting_circuit(machine, egg, pitch=pitch, yaw=yaw)


def along(circuit, n=721):
    """Return arc lengths evenly round a circuit, and its blends."""
    return np.sort([*np.linspace(0, circuit.profile.perimeter, n), *circuit.profile.blends])


@pose
@pytest.mark.parametrize("scale", [1e-3, 1, 1e3])
def test_circuit_lies_on_both_surfaces(pitch, yaw, scale):
    sizes = {name: getattr(WIDE, name) * scale for name in ("r", "R", "cutter_radius", "depth",
                                                          "height")}  # fmt: skip
    machine = replace(WIDE, **sizes)
    circuit = of(machine, pitch, yaw, Egg(0.5 * scale))
    s = along(circuit, 121)
    points, wanted = circuit.point(s), circuit.profile.point(s)
    steep = 8 * machine.r * machine.R * np.hypot(points[:, 0], points[:, 2])  # of Eq. 2, on it
    assert np.max(np.abs(machine.torus.implicit(points)) / steep) <= 1e-12 * scale
    turned = Rotation.from_euler("yz", [pitch, yaw]).apply(points)[:, 1:]
    np.testing.assert_allclose(turned, wanted - [0, machine.height], rtol=0, atol=1e-12 * scale)


def test_circuits_pitched_by_next_to_nothing_are_the_aligned_ones_closed_form():
    machine = replace(WIDE, height=0.0)  # the lowest ruling all but passes the torus by
    aligned, pitched = (Circuit(machine, EGG, pitch=pitch) for pitch in (0.0, 1e-9))
    s = along(aligned)
    np.testing.assert_allclose(pitched.position(s), aligned.position(s), atol=1e-8)


def test_extremes_of_the_reference_circuit():
    circuit = of(REFERENCE_MACHINE)
    blends, roof = circuit.profile.blends, np.pi / 2 * 0.32
    crown, invert = circuit.position([roof, (blends[2] + blends[3]) / 2])
    height, reach = REFERENCE_MACHINE.height, 0.88
    np.testing.assert_allclose(crown, [-np.arcsin((0.32 - height) / reach), 0], atol=1e-14)
    np.testing.assert_allclose(invert, [np.arcsin((0.82 + height) / reach), 0], atol=1e-14)
    left, right = circuit.position([0, blends[1]])
    np.testing.assert_allclose([left[1], -right[1]], np.arcsin(0.32 / 0.8), atol=1e-15)
    every = circuit.position(along(circuit, 4001))
    np.testing.assert_allclose(every.min(axis=0), [crown[0], right[1]], atol=1e-6)
    np.testing.assert_allclose(every.max(axis=0), [invert[0], left[1]], atol=1e-6)


def test_positive_pitch_lowers_the_nose_and_positive_yaw_turns_it_left():
    assert Circuit(WIDE, EGG, pitch=0.1).in_tunnel((1, 0, 0))[2] < WIDE.height
    assert Circuit(WIDE, EGG, yaw=0.1).in_tunnel((1, 0, 0))[1] > 0


def test_overbreak_is_positive_in_the_ground():
    circuit = of(REFERENCE_MACHINE)
    crown = circuit.position(np.pi / 2 * 0.32)
    for lift in (-0.01, 0.01):
        raised = circuit.overbreak(crown - [lift, 0])
        z = circuit.in_tunnel(REFERENCE_MACHINE.torus.point(*(crown - [lift, 0])))[2]
        assert raised == pytest.approx(z - 0.32, abs=1e-14) and np.sign(raised) == np.sign(lift)


@pose
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5])
def test_knots_keep_the_tolerance_between_them(pitch, yaw, tolerance):
    circuit = of(WIDE, pitch, yaw)
    s = circuit.knots(tolerance)
    assert s[0] == 0 and np.all(np.diff(s) > 0) and s[-1] < circuit.profile.perimeter
    assert np.all(np.isin(circuit.profile.blends[:-1], s))
    knots = circuit.position(s)
    path = project_chord(WIDE.torus, knots, np.roll(knots, -1, axis=0), 101)
    assert np.max(np.abs(circuit.overbreak(path))) <= tolerance * (1 + 1e-3)


@pose
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_knots_are_no_more_than_the_sagitta_asks_for(pitch, yaw, tolerance):
    circuit = of(WIDE, pitch, yaw)
    arcs = circuit.profile.arcs
    sagitta = sum(arc.radius * arc.sweep / np.sqrt(8 * arc.radius * tolerance) for arc in arcs)
    assert len(circuit.knots(tolerance)) <= 1.5 * sagitta + 2 * len(arcs)


def test_corrected_chords_need_the_same_knots_and_leave_the_same_sagitta():
    circuit = of(REFERENCE_MACHINE)
    plain, corrected = (circuit.knots(1e-3, path=path)
                        for path in ("projected chord", "corrected chord"))  # fmt: skip
    np.testing.assert_array_equal(plain, corrected)
    apart = circuit.path_overbreak(plain) - circuit.path_overbreak(plain, path="corrected chord")
    assert 2e-6 < np.max(np.abs(apart)) < 4e-6
    with pytest.raises(ValueError, match=r'^path: must be "projected chord" or "corrected chord"'):
        circuit.path_overbreak(plain, path="geodesic")


@pytest.mark.parametrize("tolerance", [1e-9, 1e-15, 1e-100])
def test_knots_are_not_more_than_any_machine_wants(tolerance):
    sentence = rf"^tolerance: must be such that 20000 knots keep it; got {tolerance:g} m\.$"
    with pytest.raises(ValueError, match=sentence):
        of(REFERENCE_MACHINE).knots(tolerance)


OFFSET_TOO_GREAT = replace(REFERENCE_MACHINE, cutter_radius=0.27)


@pytest.mark.parametrize("machine, egg, pitch, message", [
    (OFFSET_TOO_GREAT, EGG, 0, "bend, offset < least radius: 0.25 m < 0.25 m fails"),
    (replace(REFERENCE_MACHINE, cutter_radius=0.7), EGG, 0, "0.68 m < 0.25 m fails"),
    (REFERENCE_MACHINE, Egg(0.3), 0, "bend, offset < least radius"),
    (REFERENCE_MACHINE, Egg(0.9), 0, "width"),
    (replace(REFERENCE_MACHINE, R=0.3), EGG, 0, "width.*crown.*floor"),
    (REFERENCE_MACHINE, EGG, 0.3, "it needs theta from .* deg, beyond its limits"),
    (replace(REFERENCE_MACHINE, R=0.3), EGG, 0.01, "m along the circuit misses the torus"),
])  # fmt: skip
def test_cutting_circuit_refuses_in_one_sentence(machine, egg, pitch, message):
    with pytest.raises(ValueError, match=message) as error:
        cutting_circuit(machine, egg, pitch=pitch)
    assert str(error.value).endswith(".") and "\n" not in str(error.value)


def test_joint_limit_between_samples_is_kept():
    low, high = of(WIDE, pitch=0.03, yaw=0.02).reach()
    fine = of(WIDE, pitch=0.03, yaw=0.02)
    position = fine.position(np.linspace(0, fine.profile.perimeter, 50_001))
    assert np.all(low <= position.min(axis=0)) and np.all(high >= position.max(axis=0))
    barely = replace(WIDE, theta_max=high[0] - 1e-9)
    with pytest.raises(ValueError, match="beyond its limits"):
        cutting_circuit(barely, EGG, pitch=0.03, yaw=0.02)
