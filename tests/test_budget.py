"""The error budget: each fault alone against its closed form, what halves it, and their sum."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import expm

from tunneller_lib.motion import (
    Compressible,
    Integrator,
    Lag,
    Loop,
    Resonance,
    Rigid,
    follow,
    reference_axes,
)
from tunneller_lib.motion.plant import LinearPlant, NoLinearForm, Plant, ValveResonance
from tunneller_lib.motion.stability import gain_limit
from tunneller_lib.motion.tasks import Task
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, Pose, budget, plan, starved, trailing
from tunneller_lib.ream.faults import (
    corner_fault,
    count_fault,
    encoder_fault,
    following_fault,
    knot_fault,
    pose_fault,
    ripple_fault,
    setpoint_fault,
    tangent_sphere_fault,
)
from tunneller_lib.ream.sensitivity import geodesic_bend, gradient, joint_bend, rounding_passed
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Torus

CIRCUIT = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
TILTED = cutting_circuit(REFERENCE_MACHINE, Egg(0.5), pitch=0.03, yaw=-0.04)
AXES = reference_axes(REFERENCE_MACHINE)
BITS16 = 2 * np.pi / 2**16
POSE = Pose(y=3e-3, z=-2e-3, roll=3e-3, pitch=2e-3, yaw=-4e-3)
P, FED = {"feedforward": 0.0}, {"feedforward": 1.0}


def job(circuit=CIRCUIT, *, feed=0.06, **options):
    limits = Limits(feed=feed, acceleration=0.5)
    return plan(circuit, limits, **({"tolerance": 1e-3, "rest": 0.5} | options))


LAP = job()


def pair(gains=(10.0, 10.0), **options):
    return [Loop(gain, 0.005, **({"delay": 1, "count": BITS16} | options)) for gain in gains]


CIRCUITS = pytest.mark.parametrize("circuit", [CIRCUIT, TILTED], ids=["aligned", "tilted"])
TOLERANCES = pytest.mark.parametrize("tolerance", [3e-3, 1e-3, 2e-4])


@CIRCUITS
@TOLERANCES
def test_knots_alone_leave_the_sagitta(circuit, tolerance):
    fault = knot_fault(job(circuit, tolerance=tolerance))
    assert fault.measured == pytest.approx(fault.closed, rel=0.01)
    assert fault.under > fault.over  # chords keep inside


@CIRCUITS
@TOLERANCES
def test_corrected_chords_leave_hardly_anything(circuit, tolerance):
    plain, corrected = (tangent_sphere_fault(job(circuit, tolerance=tolerance, path=path))
                        for path in ("projected chord", "corrected chord"))  # fmt: skip
    assert plain.source == "projected chord" and corrected.source == "corrected chord"
    assert corrected.measured < plain.measured / 100
    assert plain.ratio == pytest.approx(1, rel=0.03)
    assert corrected.closed is None and corrected.ratio is None


@CIRCUITS
@TOLERANCES
def test_tangent_spheres_alone_leave_the_law_of_the_third_power(circuit, tolerance):
    fault = tangent_sphere_fault(job(circuit, tolerance=tolerance))
    assert fault.measured == pytest.approx(
        fault.closed, rel=0.025
    )  # of short chords: 0.3 % at 0.2 mm


@CIRCUITS
def test_setpoints_alone_leave_the_sagitta_of_joint_lines(circuit):
    for step in (2e-2, 5e-3):
        fault = setpoint_fault(job(circuit, step=step))
        assert fault.measured == pytest.approx(fault.closed, rel=1e-3)


@CIRCUITS
@pytest.mark.parametrize("bits", [13, 16])
def test_counts_alone_leave_their_rounding(circuit, bits):
    count = 2 * np.pi / 2**bits
    fault = count_fault(job(circuit, count=count))
    assert fault.measured == pytest.approx(fault.closed, rel=0.025)  # a mean over one lap
    # Half a count of either set-value is met, and one count of both together isn't passed.
    at = CIRCUIT.position(LAP.places)
    off = np.abs(count * np.rint(at / count) - at).max()
    assert off == pytest.approx(count / 2, rel=0.05)
    steepest = np.abs(gradient(CIRCUIT, LAP.places, at)).sum(axis=-1).max()
    assert max(fault.over, fault.under) <= count * steepest


@CIRCUITS
@TOLERANCES
def test_corners_alone_miss_their_knots_by_the_blend(circuit, tolerance):
    fault = corner_fault(job(circuit, tolerance=tolerance))
    assert fault.measured == pytest.approx(fault.closed, rel=0.006)
    assert fault.closed <= tolerance / 2 * 1.01


@CIRCUITS
@pytest.mark.parametrize("acceleration", [0.5, 0.1])
def test_feed_ripple_alone_is_the_sagitta_in_time(circuit, acceleration):
    lap = plan(circuit, Limits(feed=0.06, acceleration=acceleration), tolerance=1e-3)
    fault = ripple_fault(lap)
    # Over the worst move the acceleration changes, so that its mean isn't that of the middle.
    assert fault.along and fault.measured == pytest.approx(fault.closed, rel=0.2)
    # A move of N ticks has at most 1/N of the acceleration.
    assert fault.closed <= acceleration / 8 * 0.005**2 * lap.ticks[:-1].max()


PLANTS = {"T0": Integrator(0.5), "T1": Lag(0.5, 0.02), "T2": [Rigid(a) for a in AXES]}


@pytest.mark.parametrize("tier", PLANTS)
@pytest.mark.parametrize("gains", [(10.0, 10.0), (10.0, 8.0), (8.0, 12.0)])
@pytest.mark.parametrize("options", [P, FED])
def test_following_alone_leaves_its_series_in_the_lag(tier, gains, options):
    plants = PLANTS[tier] if tier == "T2" else [PLANTS[tier]] * 2
    fault = following_fault(LAP, plants, pair(gains, **options))
    # Equal gains lag along the path. Others lag across it, of which the series lacks the third
    # order, and where the bend jumps they overshoot by micrometres.
    missed = 0.003 if gains[0] == gains[1] else 0.055
    assert fault.measured == pytest.approx(fault.closed, rel=missed)


@pytest.mark.parametrize("tier", ["T0", "T1"])
def test_following_is_off_its_series_by_the_third_order_in_the_lag(tier):
    plants = [PLANTS[tier]] * 2
    slow, fast = (following_fault(LAP, plants, pair(gains)) for gains in [(8, 12), (16, 24)])
    missed = [abs(fault.measured / fault.closed - 1) for fault in (slow, fast)]
    assert 0.03 < missed[0] < 0.055 and missed[1] < missed[0] / 4


def test_following_error_of_a_steady_rate_is_the_rate_over_the_gain():
    at = CIRCUIT.position(LAP.places)
    rate = np.diff(at, axis=0) / 0.005
    track = follow(Integrator(0.5), pair(**P, count=0.0), at, slopes=rate)
    for error, speed in zip(track.error.T, rate.T, strict=True):
        slow = np.convolve(speed, np.full(40, 1 / 40), "same")  # setpoints on whole ticks jitter
        assert np.abs(error).max() == pytest.approx(np.abs(slow).max() / 10, rel=0.05)


def test_following_of_compressible_oil_is_worse_where_the_pressures_change_sides():
    plants = [Compressible(a) for a in AXES]
    fault = following_fault(LAP, plants, pair(**FED))
    slow = following_fault(LAP, PLANTS["T2"], pair(**FED))
    assert slow.measured < 1.06 * slow.closed < 1.06 * fault.closed  # the oil is late, too
    assert fault.measured > 3 * fault.closed
    rate = np.gradient(CIRCUIT.position(LAP.places)[:, 0])
    worst = np.argmax(np.abs(fault.deviation))
    turns = np.flatnonzero(np.diff(np.sign(rate[:-200])) != 0)
    assert 0 < np.min(np.abs(worst - turns)) < 250  # just after theta turns back


@pytest.mark.parametrize("feedforward", [0.0, 1.0])
def test_encoder_in_slow_motion_is_half_a_count(feedforward):
    count, gain, tick = 1e-3, 10.0, 0.01
    slow = 1e-4 * count * gain  # rad/s: the axis settles long before the next count
    wanted = slow * tick * np.arange(300_000)
    loop = Loop(gain, tick, count=count, feedforward=feedforward)
    track = follow(Integrator(0.5), loop, wanted, slopes=np.full(len(wanted) - 1, slow))
    assert track.largest_error == pytest.approx(count / 2, rel=0.05)
    # Each tick at the edge of a count is a step of Kv T counts, forth and back.
    step = gain * tick
    square = count**2 / 12 * ((1 - step) ** 2 + step**2)
    assert track.rms_error == pytest.approx(np.sqrt(square), rel=0.05)
    passed = rounding_passed(Integrator(0.5), loop, np.array([slow]), np.zeros(1))
    assert passed[0] == pytest.approx(1 / 12, rel=0.02)  # the linear theory lacks those steps


@pytest.mark.parametrize("tier", PLANTS)
def test_encoder_alone_in_motion_is_what_the_linear_loop_passes_on(tier):
    plants = PLANTS[tier] if tier == "T2" else [PLANTS[tier]] * 2
    fault = encoder_fault(LAP, plants, pair(**FED))
    assert 0.75 < fault.measured / fault.closed < 1.35  # the axis answers to the rounding
    half = BITS16 / 2 * np.abs(gradient(CIRCUIT, LAP.s, CIRCUIT.position(LAP.s))).sum(-1).max()
    assert max(fault.over, fault.under) <= 1.2 * half


# The extremes of all feeds, resolutions and tiers tried, and some between.
@pytest.mark.parametrize(
    ("tier", "feed", "bits", "ratio"),
    [("T0", 0.03, 16, 1.43), ("T0", 0.06, 12, 1.42), ("T1", 0.03, 14, 1.23), ("T1", 0.06, 14, 1.09),
     ("T1", 0.06, 16, 0.89), ("T1", 0.1, 15, 0.85), ("T1", 0.2, 13, 0.65), ("T1", 0.2, 15, 1.07)],
)  # fmt: skip
def test_encoder_is_off_the_linear_theory_by_half_at_most(tier, feed, bits, ratio):
    count = 2 * np.pi / 2**bits
    fault = encoder_fault(job(feed=feed, count=count), [PLANTS[tier]] * 2, pair(count=count, **FED))
    found = fault.measured / fault.closed
    assert 0.6 < found < 1.5
    assert found == pytest.approx(ratio, abs=0.06)  # which rounding leads where is a chance


@CIRCUITS
@pytest.mark.parametrize("name", ["y", "z", "roll", "pitch", "yaw"])
def test_pose_alone_leaves_the_normal_part_of_a_small_rigid_motion(circuit, name):
    fault = pose_fault(job(circuit), Pose(**{name: 2e-3}))
    assert fault.measured == pytest.approx(fault.closed, rel=1e-3)


@CIRCUITS
@pytest.mark.parametrize("turn", [-2e-3, 2e-3])
@pytest.mark.parametrize(("shift", "axis"), [("z", "pitch"), ("y", "yaw"), ("y", "roll")])
def test_shift_and_turn_of_a_pose_add_up_with_their_signs(circuit, shift, axis, turn):
    """A turn the other way round would leave as much alone, and less or more beside a shift."""
    fault = pose_fault(job(circuit), Pose(**{shift: 2e-3, axis: turn}))
    assert fault.measured == pytest.approx(fault.closed, rel=3e-3)


def of_remedy(fault):
    """Return what a fault's first remedy changes, and by which factor."""
    return fault.remedies[0]


@pytest.mark.parametrize("fault", [knot_fault, tangent_sphere_fault, corner_fault, setpoint_fault,
                                   count_fault])  # fmt: skip
def test_faults_of_the_plan_are_halved_by_their_first_remedy(fault):
    usual = {"tolerance": 1e-3, "step": 5e-3, "count": BITS16}
    before = fault(LAP)
    what, factor = of_remedy(before)
    after = fault(job(**{what: factor * usual[what]}))
    assert after.measured == pytest.approx(before.measured / 2, rel=0.25)  # whole numbers of knots
    assert after.closed == pytest.approx(before.closed / 2, rel=0.25)


@pytest.mark.parametrize(
    "gains, options", [((10.0, 10.0), P), ((10.0, 8.0), P), ((10.0, 9.0), FED)]
)
def test_following_without_delay_is_halved_by_its_gain(gains, options):
    plants = [Integrator(0.5)] * 2
    before = following_fault(LAP, plants, pair(gains, delay=0, **options))
    what, factor = of_remedy(before)
    assert what == "gain"
    raised = [gain * factor for gain in gains]
    after = following_fault(LAP, plants, pair(raised, delay=0, **options))
    if options == FED:
        assert max(before.measured, after.measured) < 2e-6  # nothing left to halve
        return
    assert (
        0.8 < after.measured / (before.measured / 2) < 1.05
    )  # its smaller part falls to a quarter


@pytest.mark.parametrize("options", [P, FED])
@pytest.mark.parametrize("gains", [(8.0, 8.0), (10.0, 8.0)])
def test_following_with_delay_and_lag_is_halved_by_its_gain(gains, options):
    plants = [Lag(0.5, 0.02)] * 2
    before = following_fault(LAP, plants, pair(gains, **options))
    _, factor = of_remedy(before)
    after = following_fault(LAP, plants, pair([g * factor for g in gains], **options))
    assert after.measured == pytest.approx(before.measured / 2, rel=0.15)
    equal_p = options is P and gains[0] == gains[1]
    assert (1 < factor < 1.3) if equal_p else (1.6 < factor < 2.2)


def test_following_of_a_resonance_knows_its_lateness():
    plants = [Resonance(0.5, 100.0, 0.15)] * 2
    fault = following_fault(LAP, plants, pair(**FED))
    assert fault.measured == pytest.approx(fault.closed, rel=0.1)


@dataclass(frozen=True)
class TwoLags(LinearPlant):
    """K / (s (a s + 1) (b s + 1)), a plant that the library doesn't know."""

    gain: float
    a: float
    b: float

    def matrices(self):
        a, b = self.a, self.b
        A = np.array([[0, 1, 0], [0, -1 / a, 1 / a], [0, 0, -1 / b]])
        return A, np.array([0, 0, self.gain / b])

    def discrete(self, tick):
        A, B = self.matrices()
        whole = expm(tick * np.block([[A, B[:, None]], [np.zeros((1, 4))]]))
        return whole[:3, :3], whole[:3, 3]


class Unspoken(Plant):
    """A lag that can be run but has no linear form to show."""

    def __init__(self, lag):
        self.lag = lag

    def command(self, rate, position):
        return self.lag.command(rate, position)

    def rest(self, position):
        return self.lag.rest(position)

    def numbers(self, tick):
        return self.lag.numbers(tick)

    def functions(self):
        return self.lag.functions()


@pytest.mark.parametrize("options", [P, FED])
def test_a_plant_new_to_the_library_gets_the_closed_form_of_its_own_lateness(options):
    """A ramp's answer is late by the first moment of the plant's: 30 ms here."""
    plant = [TwoLags(0.5, 0.02, 0.01)] * 2
    fault = following_fault(LAP, plant, pair(**options))
    assert fault.closed > 2e-5
    assert fault.measured == pytest.approx(fault.closed, rel=0.02)
    rounded = encoder_fault(LAP, plant, pair(**options))
    assert 0.6 < rounded.measured / rounded.closed < 1.5
    # Opened for good from rest, it ends behind the steady rate by 30 ms of it.
    commanded, state = plant[0], plant[0].rest(0.0)
    step = commanded.stepper(0.001)
    for _ in range(2000):
        state = step(state, 1.0)
    assert 2.0 - state[0] / 0.5 == pytest.approx(0.03, rel=1e-9)
    assert plant[0].lateness == pytest.approx(0.03, rel=1e-12)


def test_a_plant_without_a_linear_form_gets_no_closed_form_and_no_verdict_on_stability():
    lag = Lag(0.5, 0.02)
    plant, known = [Unspoken(lag)] * 2, [lag] * 2
    for source in (following_fault, encoder_fault):
        fault, same = (source(LAP, one, pair(**FED)) for one in (plant, known))
        assert fault.closed is None and same.closed > 0
        np.testing.assert_array_equal(fault.deviation, same.deviation)
    assert [fault.closed is None for fault in budget(LAP, plant, pair(**FED))] == [False] * 6 + [
        True
    ] * 2
    for call in (trailing, lambda *given: gain_limit(given[1][0], given[2][0])):
        with pytest.raises(NoLinearForm, match=r"^plant: must have a linear form, .*Unspoken"):
            call(LAP, plant, pair(**FED))
    track = follow(plant, pair(count=0.0), LAP.setvalues)
    assert track.stable == (None, None)


EVERY = [
    Integrator(0.5),
    Lag(0.5, 0.02),
    Resonance(0.5, 100.0, 0.15),
    TwoLags(0.5, 0.02, 0.01),
    ValveResonance(0.6, 0.5, 90.0, 0.2, 0.01),
    *map(Rigid, AXES),
    *map(Compressible, AXES),
]


@pytest.mark.parametrize("plant", EVERY, ids=lambda plant: type(plant).__name__)
@pytest.mark.parametrize("angle", [-0.4, 0.3])
def test_lateness_is_the_phase_of_a_slow_swing_over_its_frequency(plant, angle):
    linear = plant.linear(angle)
    slow = 1e-2  # rad/s
    rate = 1j * slow * linear.transfer(1j * slow)
    assert linear.lateness == pytest.approx(-np.angle(rate) / slow, rel=1e-4, abs=1e-12)


def test_a_lap_whose_stroke_lacks_the_angle_0_has_closed_forms():
    axis = replace(AXES[0], low=-1.0, high=-0.1)
    with pytest.raises(ValueError, match=r"^angle: must lie within the stroke"):
        Compressible(axis).linear(0.0)
    off = np.linspace(-0.6, -0.2, 5)
    passed = rounding_passed(Compressible(axis), pair()[0], np.full(5, 1e-6), off)
    assert passed == pytest.approx(np.full(5, 1 / 12), rel=0.02)


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: budget(LAP, Integrator(0.5), pair(integral=1.0)), "without integral"),
        (lambda: encoder_fault(LAP, Integrator(0.5), pair(dead_band=0.1)), "without integral"),
        (lambda: trailing(LAP, Integrator(0.5), pair(integral=1.0)), "without integral"),
        (lambda: trailing(LAP, [Integrator(0.5)] * 3, pair()), "plant: must be two, theta's and"),
        (lambda: knot_fault(starved(LAP, [Task("line", 5000, 400)], 150_000)), "must not wait"),
        (lambda: budget(LAP, Integrator(0.5), Loop(10.0, 0.01)), "must have the plan's tick"),
        (lambda: budget(LAP, Integrator(0.5), 3), "loop: must be of class Loop"),
        (lambda: budget(3, Integrator(0.5), pair()), "plan: must be of class Plan"),
        (lambda: budget(LAP, Integrator(0.5), pair(), pose=3), "pose: must be of class Pose"),
        (lambda: budget(starved(LAP, [Task("line", 5000, 400)], 150_000), Integrator(0.5), pair()),
         "must not wait"),
    ],
)  # fmt: skip
def test_budget_refuses_what_its_closed_forms_lack(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize("fault", [following_fault, encoder_fault, trailing])
@pytest.mark.parametrize("option", [{"integral": 1.0}, {"dead_band": 0.1}], ids=str)
def test_closed_forms_of_loops_refuse_what_is_not_linear(fault, option):
    with pytest.raises(
        ValueError, match=r"^loop: must be without integral and dead band, for which there is no c"
    ):
        fault(LAP, Integrator(0.5), pair(**option))


def test_budget_counts_its_sources_from_the_first():
    said = []
    budget(LAP, Integrator(0.5), pair(), say=said.append)
    assert said == [f"budget: source {k} of 8" for k in range(1, 9)]


def test_encoder_and_pose_are_halved_by_half():
    before = encoder_fault(LAP, [Lag(0.5, 0.02)] * 2, pair(**FED))
    finer = pair(count=BITS16 * of_remedy(before)[1], **FED)
    after = encoder_fault(LAP, [Lag(0.5, 0.02)] * 2, finer)
    assert after.measured == pytest.approx(before.measured / 2, rel=0.3)
    half = replace(POSE, **{n: getattr(POSE, n) / 2 for n in ("y", "z", "roll", "pitch", "yaw")})
    whole, less = pose_fault(LAP, POSE), pose_fault(LAP, half)
    assert less.measured == pytest.approx(whole.measured * of_remedy(whole)[1], rel=0.01)


def test_budget_adds_up_to_all_together():
    loops, plant = pair(**FED), [Lag(0.5, 0.02)] * 2
    faults = budget(LAP, plant, loops, pose=POSE)
    assert [fault.source for fault in faults] == [
        "knots", "projected chord", "corners", "setpoints", "counts", "feed ripple", "following",
        "encoder", "pose",
    ]  # fmt: skip
    ticks = len(LAP.setvalues)
    total = np.zeros(ticks)
    for fault in (fault for fault in faults if not fault.along):
        total[: len(fault.deviation)] += fault.deviation
    track = follow(plant, loops, LAP.setvalues, slopes=LAP.slopes)
    centre = LAP.centres(track.position, pose=POSE)
    together = -CIRCUIT.profile.depth(centre[:, 1], centre[:, 2])
    assert np.abs(together).max() > 3e-3
    # What is left is the product of knots and following: corners at knots, cut by the lag.
    assert np.abs(total - together).max() < 0.4e-3
    assert np.sqrt(np.mean((total - together) ** 2)) < 0.05e-3


# The derivatives


def test_velocity_and_acceleration_against_differences():
    torus, rng = Torus(0.08, 0.8), np.random.default_rng(5)
    q, rate = rng.uniform(-0.6, 0.6, (50, 2)), rng.normal(size=(50, 2))
    h = 1e-4
    points = [torus.point(*(q + k * h * rate).T) for k in (-1, 0, 1)]
    np.testing.assert_allclose((points[2] - points[0]) / (2 * h), torus.velocity(q, rate),
                               atol=1e-7)  # fmt: skip
    second = (points[2] - 2 * points[1] + points[0]) / h**2
    np.testing.assert_allclose(second, torus.acceleration(q, rate), atol=1e-6)


@CIRCUITS
def test_gradient_and_bend_against_differences_of_the_overbreak(circuit):
    s = np.linspace(0.01, circuit.profile.perimeter - 0.01, 60)
    q, h = circuit.position(s), 1e-4
    for k, unit in enumerate(np.eye(2)):
        slope = (circuit.overbreak(q + h * unit) - circuit.overbreak(q - h * unit)) / (2 * h)
        np.testing.assert_allclose(gradient(circuit, s, q)[:, k], slope, atol=1e-6)
    for rate in np.random.default_rng(6).normal(size=(5, 2)):
        sides = circuit.overbreak(q + h * rate), circuit.overbreak(q - h * rate)
        bend = (sides[0] + sides[1] - 2 * circuit.overbreak(q)) / h**2
        away = np.min(np.abs(s[:, None] - circuit.profile.blends), axis=1) > 2e-3
        np.testing.assert_allclose(joint_bend(circuit, s, q, np.broadcast_to(rate, q.shape))[away],
                                   bend[away], atol=2e-3)  # fmt: skip


def test_geodesic_bend_of_a_great_torus_is_the_sections_curvature():
    flat = replace(REFERENCE_MACHINE, r=1e-9, R=500.0, height=0.0)
    circuit = cutting_circuit(flat, Egg(0.5))
    s = np.linspace(0.01, circuit.profile.perimeter - 0.01, 40)
    q = circuit.position(s)
    normal = circuit.profile.normal(s)
    along = np.stack([np.zeros_like(s), -normal[:, 1], normal[:, 0]], axis=-1)
    np.testing.assert_allclose(geodesic_bend(circuit, s, q, along), circuit.profile.curvature(s),
                               atol=0.02)  # fmt: skip
