"""Both joints as one machine in ground that pushes back."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.controllers import job_with
from tests.test_ground_coupling import ARM, AXES, CIRCUIT, LOOP, OILY, SIZES, planned
from tunneller_lib.job import read_job
from tunneller_lib.motion import Compressible, Push, follow, reference_axes
from tunneller_lib.motion.arm import couplings
from tunneller_lib.motion.both_joints import machine_of as joints_of
from tunneller_lib.motion.both_joints import machine_slopes
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Case, Limits, loads, plan, simulate
from tunneller_lib.ream.front import engaged_areas
from tunneller_lib.ream.margins import capability, used
from tunneller_lib.removal import Ground
from tunneller_lib.removal.volume import removed_volume
from tunneller_lib.surfaces import REFERENCE_MACHINE, Arc, Egg, closed_profile

READS = ["notebooks/reference.toml"]

REFERENCE = Path(__file__).resolve().parents[1] / "notebooks" / "reference.toml"

CONCRETE = Ground(20e6, 2.0, normal=0.5, ripple=0.3, ripple_frequency=12.0)
MORTAR = replace(CONCRETE, energy=5e6)
SOFT = replace(CONCRETE, energy=3e6)
RAMP = np.stack([0.1 * (1 - np.cos(np.linspace(0, 3, 400))), np.linspace(0.3, 0.1, 400)], axis=-1)
SLOPES = np.diff(RAMP, axis=0) / 5e-3


def machine_of(scale):
    """Return the reference machine, all of whose lengths are so many times as great."""
    sizes = ("r", "R", "cutter_radius", "depth", "height")
    grown = {size: scale * getattr(REFERENCE_MACHINE, size) for size in sizes}
    return replace(REFERENCE_MACHINE, **grown)


# The arm


@pytest.mark.parametrize("motion", [(0.3, 0.5, 0.7, -0.4), (-0.9, -0.6, -0.2, 0.5), (0, 0, 1, 1)])
def test_arm_moves_as_points_along_it_do(motion):
    """By Lagrange's equations and differences of energies: a thousand points, and the head."""
    theta, phi, lifting, swinging = motion
    s = ARM.R * np.append((np.arange(1000) + 0.5) / 1000, 1.0)
    mass = np.append(np.full(1000, ARM.beam / 1000), ARM.head)

    def inertia(phi):
        return mass @ (ARM.r + s * np.cos(phi)) ** 2

    def held(theta, phi):
        return -9.81 * np.sin(theta) * (mass @ (ARM.r + s * np.cos(phi)))

    h = 1e-5
    change = (inertia(phi + h) - inertia(phi - h)) / (2 * h)
    by_theta, by_phi = ((held(theta + a, phi + b) - held(theta - a, phi - b)) / (2 * h)
                        for a, b in ((h, 0), (0, h)))  # fmt: skip
    assert ARM.inertias(phi) == pytest.approx((inertia(phi), mass @ s**2), rel=1e-6)
    assert ARM.weight((theta, phi)) == pytest.approx((by_theta, by_phi), rel=1e-5, abs=1e-5)
    wanted = change * lifting * swinging, -change * lifting**2 / 2
    assert couplings(ARM.moments, phi, lifting, swinging) == pytest.approx(wanted, rel=1e-5)


# Both joints as one machine


def test_joints_that_share_nothing_are_the_two_axes_alone():
    plants = [Compressible(axis) for axis in reference_axes(REFERENCE_MACHINE)]
    alone = follow(plants, LOOP, RAMP, slopes=SLOPES)
    together = follow(plants, LOOP, RAMP, slopes=SLOPES, push=Push())
    assert together.position == pytest.approx(alone.position, abs=1e-9)
    assert alone.energies is None and together.energies.shape == (400, 5)


def test_energy_that_the_pump_gives_is_found_again():
    push = Push(damper=4000.0, lever=(0.88, 0.80), across=(0.3, -0.2), torque=(50.0, 0.0))
    track = follow(OILY, LOOP, RAMP, slopes=SLOPES, arm=ARM, push=push)
    rates = np.stack([states[:, 1] for states in track.states], axis=-1)
    theta, phi = track.position.T
    reach = (ARM.head + ARM.beam) * ARM.r + (ARM.head + ARM.beam / 2) * ARM.R * np.cos(phi)
    kinetic = np.sum(np.stack(ARM.inertias(phi), axis=-1) * rates**2, axis=-1) / 2
    held = kinetic - 9.81 * np.sin(theta) * reach
    supplied, *spent = track.energies.T
    missing = supplied - sum(spent) - (held - held[0])
    assert np.abs(missing).max() < 1e-6 * supplied[-1]
    assert spent[3][-1] > 0.05 * supplied[-1]  # the ground takes a part that isn't rounding
    later = track.between(100, 300).energies
    np.testing.assert_array_equal(later, track.energies[100:301] - track.energies[100])


@pytest.mark.parametrize("rates", [(0.2, -0.1), (-0.3, 0.2)])
@pytest.mark.parametrize("drift", [(0.0, 0.0, 0.0), (0.05, -0.1, 0.2)])
def test_push_resists_each_joint_by_its_parts(rates, drift):
    push = Push(torque=(5.0, -8.0), damper=900.0, lever=(0.9, 0.8), across=(0.3, -0.2),
                drift=drift)  # fmt: skip
    (theta, phi), rates = (AXES, np.array(rates))
    state = *((0.1, rate, 5e6, 6e6, 0.2) for rate in rates), (0.0,) * 5
    free, pushed = (
        machine_slopes(joints_of(AXES, None), state, (0.1, 0.3), tuple(one.rows[0]))
        for one in (Push(), push)
    )
    along = push.lever * rates + drift[:2]
    speed = np.linalg.norm([*along, drift[2]])
    force = 900.0 * speed
    resisted = push.torque + force * (push.lever * along / speed + push.across)
    for joint, axis in enumerate((theta, phi)):
        lost = axis.inertia * (free[joint][1] - pushed[joint][1])
        assert lost == pytest.approx(resisted[joint], rel=1e-9)
    assert pushed[2][4] == pytest.approx(resisted @ rates, rel=1e-9)


# The ground


def test_feed_keeps_the_power_of_the_head_and_the_oil_of_the_valves():
    made = planned(CONCRETE)
    power = CONCRETE.power(engaged_areas(CIRCUIT, made.places) * np.gradient(made.reached, 5e-3))
    assert power.max() == pytest.approx(3000, rel=1e-3)
    assert planned(replace(CONCRETE, energy=40e6)).lap_time == pytest.approx(
        2 * made.lap_time, rel=0.03
    )
    # With all the power that one likes the axes' oil decides.
    strong = plan(CIRCUIT, replace(made.limits, power=np.inf), tolerance=1e-3)
    free = plan(CIRCUIT, replace(made.limits, power=np.inf, valve=np.inf), tolerance=1e-3)
    assert free.lap_time < strong.lap_time < made.lap_time


def test_loaded_axis_goes_as_fast_as_its_pressure_allows():
    axis = AXES[0]
    assert axis.loaded(0.1, 0.2, 0.0, 1.0) == pytest.approx(axis.rate(0.1, 1.0) / 0.2)
    assert axis.loaded(0.1, -0.2, 0.0, 0.5) == pytest.approx(-axis.rate(0.1, -0.5) / 0.2)
    # At rest the pressure alone holds the torque.
    (D, rho, load), _ = axis.sides(0.1)
    stall = D * (axis.supply - rho * axis.tank) - load
    assert axis.loaded(0.1, 0.0, 100.0, 1.0) == pytest.approx(stall / 100)
    assert axis.loaded(0.1, 0.0, 0.0, 1.0) == np.inf
    # A torque that uses up nine tenths of the pressure leaves the root of a tenth of the speed.
    slow = axis.loaded(0.1, 1e-6, 0.9 * stall, 1.0)
    assert slow == pytest.approx(1 / 0.9, rel=1e-3)


@pytest.fixture(scope="module")
def even_cut():
    """Return a plan in soft mortar whose even picks let no speed swing, and its cut."""
    even = replace(SOFT, ripple=0.0)
    short = plan(CIRCUIT, replace(planned(even).limits, feed=0.12), tolerance=5e-3, rest=0.2)
    return short, simulate(short, OILY, LOOP, shape=(40, 90), arm=ARM, ground=even)


def test_wall_pushes_back_with_the_power_of_the_ground_that_is_removed(even_cut):
    short, pushed = even_cut
    free = simulate(short, OILY, LOOP, shape=(40, 90), arm=ARM)
    assert free.force is None
    # The force times the picks' speed is the power of the ground that is removed.
    cut_power = pushed.force * SOFT.pick_speed * short.tick
    assert cut_power.sum() == pytest.approx(SOFT.power(pushed.removed.sum()), rel=1e-3)
    assert (free.deviation - pushed.deviation).max() > 1e-3


def test_cut_says_what_it_used_of_power_valves_and_oil(even_cut):
    short, done = even_cut
    found = {margin.what: margin for margin in used(short, OILY, done, SIZES)}
    assert list(found) == ["power in a second", "valve of theta", "valve of phi", "oil in a tick"]
    # The force is that of the same ground: its mean over a second, in whole chunks of those whose
    # volume is noted, times the picks' speed.
    ticks = 5 * 48
    evened = np.convolve(done.force * MORTAR.pick_speed, np.ones(ticks) / ticks, mode="valid")
    assert found["power in a second"].needs == pytest.approx(evened[::48].max(), rel=0.03)
    assert found["power in a second"].has == 3000
    for name, command in zip(("theta", "phi"), done.track.command.T, strict=True):
        opened = found[f"valve of {name}"]
        assert opened.needs == np.abs(command).max() and opened.has == 1
    # What flows in is by how much the chambers grow.
    chambers = [axis.linkage.volumes(q, axis.low, axis.high)
                for axis, q in zip(AXES, done.track.position.T, strict=True)]  # fmt: skip
    drawn = np.maximum(np.diff(np.concatenate(chambers)), 0).sum(axis=0) / short.tick
    assert found["oil in a tick"].needs == pytest.approx(drawn.max(), rel=1e-3)
    assert found["oil in a tick"].has == SIZES.pump > drawn.max()
    free = replace(short, limits=replace(short.limits, power=np.inf))
    assert "power in a second" not in {one.what for one in used(free, OILY, done, SIZES)}


def test_cutter_that_leaves_the_modelled_ground_is_refused(monkeypatch, even_cut):
    monkeypatch.setattr("tunneller_lib.ream.face.BESIDE", -0.02)  # m: less than the cutter reaches
    short = even_cut[0]
    with pytest.raises(ValueError, match=r"^ground: must hold the cutter back by less than 0\."):
        simulate(short, OILY, LOOP, shape=(40, 90), arm=ARM, ground=SOFT)


CIRCLE = closed_profile([Arc(0.0, 0.0, 0.55, 0.0, 2 * np.pi)])
OTHERS = [(0.5, None, {}), (1.0, CIRCLE, {"height": -0.1})]
SOURCES = "both joints", "ground, mean", "ground, picks"


def loaded(scale, section, sizes):
    """Return the case of a machine of another size in mortar, the smaller the faster."""
    machine = replace(machine_of(scale), **sizes)
    circuit = cutting_circuit(machine, section or Egg(0.5 * scale))
    parts = usual_sizes(machine)
    axes = axes_of(machine, parts)
    ground = replace(MORTAR, ripple_frequency=12.0 / scale)
    limits = Limits(feed=0.1 / scale, acceleration=0.5, power=3000 * scale**2, valve=0.8, axes=axes,
                    ground=ground)  # fmt: skip
    made = plan(circuit, limits, tolerance=2e-3 * scale, rest=0.2)
    loop = replace(LOOP, gain=10.0 / max(scale, 1.0))
    plants = [Compressible(axis) for axis in axes]
    return Case(made, plants, loop, arm=arm_of(machine, parts), ground=ground)


@pytest.mark.parametrize(("scale", "section", "sizes"), OTHERS)
def test_loads_leave_what_their_closed_forms_say(monkeypatch, scale, section, sizes):
    runs = []
    run = follow
    monkeypatch.setattr(loads, "follow", lambda *a, **b: runs.append(b) or run(*a, **b))
    case = loaded(scale, section, sizes)
    faults = [case.fault(source) for source in SOURCES]
    for fault in faults:
        assert 1 / 1.25 < fault.ratio < 1.25, fault.source
    assert len(runs) == 4  # of six that they compare two are those of another source
    _, mean, picks = faults
    assert 0 < picks.measured < mean.measured and abs(picks.ratio - 1) < 0.045
    if scale == 1.0:
        return
    still = replace(case, ground=replace(case.ground, ripple=0.0)).fault("ground, picks")
    assert still.measured == 0 == still.closed
    # Most of it is a mean that the ripple leaves, not a swing.
    period = round(1 / 24 / case.plan.tick)
    evened = np.convolve(picks.deviation, np.ones(5 * period) / (5 * period), mode="valid")
    assert np.abs(evened).max() > 0.5 * picks.measured


def test_ground_holds_back_by_the_groove_that_is_really_cut():
    made = planned(CONCRETE, tolerance=5e-3, rest=0.2)
    off = loads.held_back(made, OILY, [LOOP] * 2, CONCRETE)
    depth = REFERENCE_MACHINE.depth
    left = removed_volume(0.2, 1.0, depth + off) / removed_volume(0.2, 1.0, depth)
    torque = loads.ground_torques(made, CONCRETE) * left[:, None]
    found = loads.pushed_off(made, OILY, [LOOP] * 2, torque)
    assert off.min() < -0.05 * depth
    np.testing.assert_allclose(found, off, atol=0.01 * np.abs(off).max())


# Sizes


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_usual_sizes_grow_as_similar_machines_do(scale):
    grown, sizes = usual_sizes(machine_of(scale)), usual_sizes(REFERENCE_MACHINE)
    powers = {"head": 3, "beam": 3, "hose": 3, "lift_friction": 3, "swing_friction": 3,
              "rated_flow": 2, "pump": 2, "valve_leak": 2, "valve_lag": 1, "piston_leak": 1,
              "supply": 0, "tank": 0, "bulk": 0}  # fmt: skip
    for name, power in powers.items():
        assert getattr(grown, name) == pytest.approx(getattr(sizes, name) * scale**power)
    assert (sizes.head, sizes.beam, sizes.supply, sizes.bulk) == (30.0, 60.0, 160e5, 1e9)


def test_capability_says_what_is_lacking_and_what_would_do():
    made = planned(CONCRETE)
    found = {margin.what: margin for margin in capability(made, OILY, LOOP, SIZES)}
    assert all(margin.enough for margin in found.values()) and len(found) == 9
    assert found["torque of theta"].has > 1.05 * found["torque of theta"].needs
    weak = {
        margin.what: margin
        for margin in capability(made, OILY, replace(LOOP, gain=40.0), replace(SIZES, pump=1e-6))
    }
    assert not weak["pump"].enough and not weak["gain of theta"].enough
    assert str(weak["pump"]).endswith("a greater pump in [hydraulics], would do.")
    assert weak["gain of theta"].has == found["gain of theta"].has


# The job


def test_table_of_hydraulics_changes_the_axes():
    own = job_with(read_job(REFERENCE), hydraulics={"head": 40, "lift_bore": 0.06})
    assert own.sizes.head == 40 and own.sizes.lift.bore == 0.06 and own.arm.head == 40
    assert own.cylinders[0].linkage.bore == 0.06 and own.sizes.swing == SIZES.swing


REFUSED = [
    ({"hydraulics": {"supply": 4e5}},
     r"^\[hydraulics\] supply: must move the weight.*; the usual 1.6e\+07 Pa would do\.$"),
    ({"hydraulics": {"lift_dead_length": 0.4}},
     r"^\[hydraulics\] lift_dead_length: stroke: .*; the usual 0.2 m would do\.$"),
    ({"ground": {"ripple": 1.0}}, r"^\[ground\] ripple: must be from 0 to below 1; got 1"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), REFUSED)
def test_machine_that_cannot_is_refused_with_its_table_and_what_would_do(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        job_with(read_job(REFERENCE), **changes).planned  # noqa: B018
