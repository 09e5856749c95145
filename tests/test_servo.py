"""Position loops: limits of the gain, ramps, steps, and what encoder, delay and valve do."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from tests.shapes import log_uniform
from tunneller_lib.motion import (
    Compressible,
    Integrator,
    Lag,
    Loop,
    Resonance,
    Rigid,
    follow,
    polyline,
    polyline_slopes,
    reference_axes,
)
from tunneller_lib.motion.plant import ValveResonance
from tunneller_lib.motion.stability import (
    closed_loop,
    continuous_limit,
    delay_limit,
    eigenvalue_limit,
    gain_limit,
    integral_limits,
    is_stable,
    lag_limit,
    resonance_limit,
    ripple,
    sampled_resonance_limit,
    stable_gains,
)
from tunneller_lib.surfaces import REFERENCE_MACHINE

T = 0.005
AXES = reference_axes(REFERENCE_MACHINE)
LINEAR = [Integrator(0.5), Lag(0.5, 0.02), Resonance(0.5, 100.0, 0.15),
          ValveResonance(0.5, 0.5, 100.0, 0.15, 0.004)]  # fmt: skip
every_linear = pytest.mark.parametrize("plant", LINEAR, ids=["T0", "T1", "resonance", "valve"])


def ramp(speed, ticks, tick=T):
    return speed * tick * np.arange(ticks + 1)


@pytest.mark.parametrize("shape", [(11,), (11, 1)])
@every_linear
def test_answers_of_a_run_share_no_memory(plant, shape):
    track = follow(plant, Loop(5.0, T), ramp(0.01, 10).reshape(shape))
    assert not np.shares_memory(track.position, track.states[0])


# ---- limits of the gain ---------------------------------------------------------------------


@pytest.mark.parametrize("delay", range(9))
@pytest.mark.parametrize("tick", [1e-4, T, 0.3])
def test_delay_limit_is_that_of_the_eigenvalues(delay, tick):
    limit = delay_limit(tick, delay)
    found = eigenvalue_limit(Integrator(0.5), Loop(limit / 3, tick, delay=delay))
    assert found == pytest.approx(limit, rel=1e-9)


@given(log_uniform(1e-5, 1e2), log_uniform(1e-4, 1.0))
def test_lag_limit_is_that_of_the_eigenvalues(lag, tick):
    limit = lag_limit(lag, tick)
    found = eigenvalue_limit(Lag(0.5, lag), Loop(limit / 50, tick))
    assert found == pytest.approx(limit, rel=1e-9)


@given(log_uniform(1e-3, 1.9), log_uniform(1e-3, 1.0))
def test_integral_limits_are_those_of_the_eigenvalues(root, tick):
    integral = (root / tick) ** 2
    low, high = integral_limits(integral, tick)
    loop = Loop((low + high) / 2, tick, integral=integral)
    for side, limit in (("lower", low), ("upper", high)):
        found = eigenvalue_limit(Integrator(0.5), loop, side=side)
        assert found == pytest.approx(limit, rel=1e-9)


def test_integral_limits_close_at_four():
    low, high = integral_limits(4 / T**2, T)
    assert low == pytest.approx(high)
    assert not is_stable(Integrator(1.0), Loop(2.5 / T, T, integral=5 / T**2))


@pytest.mark.parametrize("integral", [1.0, 20.0, 3e4])
def test_stable_gains_with_an_integral_are_its_limits(integral):
    found = stable_gains(Integrator(0.5), Loop(1.0, T, integral=integral))
    assert found == pytest.approx(integral_limits(integral, T), rel=1e-9)


def test_stable_gains_of_oil_are_those_at_the_worst_angle():
    plant = Compressible(AXES[0])
    angles = np.linspace(-0.8, 0.4, 5)
    low, high = stable_gains(plant, Loop(1.0, T, integral=5.0), angles)
    each = [stable_gains(plant, Loop(1.0, T, integral=5.0), angle) for angle in angles]
    assert (low, high) == pytest.approx((max(a for a, _ in each), min(b for _, b in each)))
    assert 0 < low < 1 and high == pytest.approx(gain_limit(plant, Loop(1.0, T), angles), rel=0.01)
    inside, outside = (Loop(gain, T, integral=5.0) for gain in (0.99 * high, 1.01 * high))
    assert is_stable(plant, inside, angles) and not is_stable(plant, outside, angles)


def test_stable_gains_of_none_are_empty():
    assert stable_gains(Integrator(0.5), Loop(1.0, T, integral=5 / T**2)) == (np.inf, 0.0)


@given(log_uniform(1.0, 1e4), log_uniform(0.01, 3.0))
def test_resonance_limit_is_that_of_the_eigenvalues(frequency, damping):
    limit = resonance_limit(frequency, damping)
    assert continuous_limit(Resonance(0.5, frequency, damping)) == pytest.approx(limit, rel=1e-9)


@given(log_uniform(1.0, 1e4), log_uniform(0.01, 3.0), log_uniform(1e-3, 1e2))
def test_resonance_limit_behind_a_valve_is_that_of_the_eigenvalues(frequency, damping, share):
    lag = share / frequency
    limit = resonance_limit(frequency, damping, lag)
    plant = ValveResonance(0.5, 0.5, frequency, damping, lag)
    assert continuous_limit(plant) == pytest.approx(limit, rel=1e-9)
    livelier = ValveResonance(0.6, 0.5, frequency, damping, lag)
    assert continuous_limit(livelier) == pytest.approx(limit / 1.2, rel=1e-9)


@given(log_uniform(1.0, 1e4), log_uniform(0.01, 3.0), log_uniform(0.01, 30.0))
def test_sampled_resonance_limit_is_that_of_the_eigenvalues(frequency, damping, phase):
    tick = phase / frequency
    limit = sampled_resonance_limit(frequency, damping, tick)
    found = eigenvalue_limit(Resonance(0.5, frequency, damping), Loop(limit / 50, tick))
    assert found == pytest.approx(limit, rel=1e-9)


@pytest.mark.parametrize("tick", [1e-9, 1e-7, 1e-5])
def test_sampled_resonance_limit_of_short_ticks_is_the_continuous_one(tick):
    found = sampled_resonance_limit(100.0, 0.15, tick)
    assert found == pytest.approx(resonance_limit(100.0, 0.15), rel=max(100 * tick, 1e-6))


def test_sampled_resonance_limit_of_long_ticks_is_that_of_the_integrator():
    assert sampled_resonance_limit(100.0, 0.15, 30.0) == pytest.approx(2 / 30.0, rel=0.01)


def test_sampling_shifts_the_limit_of_a_resonance_a_little():
    plant = Resonance(0.5, 100.0, 0.15)
    limits = [eigenvalue_limit(plant, Loop(1.0, tick)) for tick in (1e-5, 1e-3, T, 0.01)]
    assert limits[0] == pytest.approx(resonance_limit(100.0, 0.15), rel=1e-3)
    assert limits == pytest.approx([resonance_limit(100.0, 0.15)] * 4, rel=0.05)


@pytest.mark.parametrize("plant", [*LINEAR, ValveResonance(0.6, 0.5, 90.0, 0.2, 0.01)])
@pytest.mark.parametrize("options", [{}, {"delay": 1}, {"delay": 4}, {"integral": 20.0},
                                     {"integral": 9.0, "delay": 2}], ids=str)  # fmt: skip
def test_closed_loop_is_what_follow_runs(plant, options):
    loop = Loop(6.0, T, limit=1e9, **options)
    step = np.full(60, 0.1)
    step[0] = 0.0
    found = follow(plant, loop, step).states[0]
    matrix = closed_loop(plant, loop)
    order = found.shape[1]
    # From rest with set-value 0.1: the same run, seen from its end, starts at -0.1.
    state = np.zeros(len(matrix))
    state[0] = -0.1
    for n in range(1, 40):
        assert np.allclose(found[n, 0] - 0.1, state[0], atol=1e-12)
        state = matrix @ state
    assert len(matrix) == order + loop.delay + bool(loop.integral)


@every_linear
def test_unstable_loops_are_run_and_said_so(plant):
    limit = eigenvalue_limit(plant, Loop(1.0, T))
    step = np.concatenate([[0.0], np.full(2000, 0.0113)])
    calm, wild = (follow(plant, Loop(f * limit, T), step) for f in (0.8, 1.3))
    assert calm.stable == (True,) and wild.stable == (False,)
    assert abs(calm.error[-1]) < 1e-4 < abs(wild.error[-100:]).max()
    assert np.all(np.isfinite(wild.position)) and np.max(np.abs(wild.command)) <= 1


@pytest.mark.parametrize("tier", [Rigid, Compressible])
@pytest.mark.parametrize(("axis", "angle"), [(0, -1.04), (0, 0.6), (1, 0.0), (1, -0.65)])
@pytest.mark.parametrize("options", [{}, {"delay": 2}, {"delay": 1, "integral": 15.0}], ids=str)
def test_unstable_loops_of_hydraulic_axes_are_run_and_said_so(tier, axis, angle, options):
    # The linear model knows where a tiny step dies out and where it grows: to 7 % with oil that
    # gives way, to 10 % with rigid oil, whose gain isn't that of its linear model in both ways.
    plant, near = tier(AXES[axis]), 0.07 if tier is Compressible else 0.1
    limit = eigenvalue_limit(plant.linear(angle), Loop(12.0, T, **options))
    step = np.concatenate([[angle], np.full(900, angle + 1e-5)])
    calm, wild = (follow(plant, Loop(f * limit, T, **options), step) for f in (1 - near, 1 + near))
    assert calm.stable == (True,) and wild.stable == (False,)
    late = slice(-200, None)
    assert np.abs(calm.error[late]).max() < 1e-6 and np.abs(wild.error[late]).max() > 1e-4
    assert np.all(np.isfinite(wild.position)) and np.max(np.abs(wild.command)) <= 1


def test_swings_decay_as_fast_as_the_linear_model_says():
    plant, loop = Compressible(AXES[1]), Loop(20.0, T)
    error = follow(plant, loop, np.concatenate([[0.0], np.full(500, 1e-5)])).error
    radius = np.max(np.abs(np.linalg.eigvals(closed_loop(plant.linear(0.0), loop))))
    early, later = (np.max(np.abs(error[n : n + 40])) for n in (160, 360))
    assert (later / early) ** (1 / 200) == pytest.approx(radius, abs=2e-3)


def test_stability_is_asked_for_all_angles_of_the_set_values():
    plant = Compressible(AXES[0])
    low, high = (eigenvalue_limit(plant.linear(a), Loop(12.0, T)) for a in (-1.04, 0.0))
    loop = Loop((low + high) / 2, T)
    assert is_stable(plant, loop) and not is_stable(plant, loop, [0.0, -1.04])
    assert follow(plant, loop, np.linspace(0.0, 0.01, 50)).stable == (True,)
    assert follow(plant, loop, np.linspace(-1.04, -0.9, 500)).stable == (False,)


def test_stability_with_an_inverse_of_the_callers_own_is_not_known():
    track = follow(LINEAR[0], Loop(10.0, T), np.zeros(3), inverse=lambda rate, _: 3 * rate)
    assert track.stable == (None,)


def test_eigenvalue_limit_refuses_an_unstable_start():
    with pytest.raises(ValueError, match=r"^gain: the search must start from a stable loop; got"):
        eigenvalue_limit(Integrator(0.5), Loop(500, T))
    with pytest.raises(ValueError, match=r'^side: must be "upper" or "lower"'):
        eigenvalue_limit(Integrator(0.5), Loop(5, T), side="both")
    still = Loop(1e-9, 1e-9)  # 1 - g T is 1 in floats: neither stable nor unstable
    with pytest.raises(ValueError, match=r"^gain: the search must start .*; got 1e-09 1/s\.$"):
        eigenvalue_limit(Integrator(0.5), still)


# ---- ramps and steps ------------------------------------------------------------------------


@every_linear
@pytest.mark.parametrize("gain", [3.0, 10.0])
@pytest.mark.parametrize("speed", [0.01, -0.2])
def test_ramp_error_is_speed_over_gain(plant, gain, speed):
    track = follow(plant, Loop(gain, T), ramp(speed, 3000))
    assert track.error[-1] == pytest.approx(speed / gain, rel=1e-9)


@pytest.mark.parametrize("axis", AXES, ids=["theta", "phi"])
@pytest.mark.parametrize("tier", [Rigid, Compressible])
def test_ramp_error_of_a_hydraulic_axis_is_nearly_speed_over_gain(axis, tier):
    track = follow(tier(axis), Loop(10.0, T), ramp(0.1, 600))
    assert track.error[-1] == pytest.approx(0.01, rel=0.01)
    assert track.stable == (True,)


def test_step_of_t0_is_an_exponential():
    step = np.concatenate([[0.0], np.full(400, 0.01)])
    track = follow(Integrator(0.5), Loop(10.0, T), step)
    n = np.arange(400)
    np.testing.assert_allclose(track.error[1:], 0.01 * (1 - 10.0 * T) ** n, atol=1e-15)
    assert track.settling(0.001) == pytest.approx(T * (1 + np.ceil(np.log(0.1) / np.log(0.95))))


def test_feedforward_by_the_exact_slope_leaves_no_error_of_t0():
    knots, ticks = np.array([[0, 0], [900, -333], [901, 400], [901, 401]]), [200, 301, 99]
    count = 2 * np.pi / 2**16
    exact = np.concatenate([[[0, 0]], np.cumsum(polyline_slopes(knots, ticks), axis=0)]) * count
    slopes = polyline_slopes(knots, ticks) * count / T
    loop = Loop(10.0, T, feedforward=1.0)
    assert np.max(follow(Integrator(0.5), loop, exact, slopes=slopes).largest_error) < 1e-14
    counted = follow(Integrator(0.5), loop, polyline(knots, ticks) * count, slopes=slopes)
    assert np.all(counted.largest_error < count)


def test_differences_of_counts_shake_a_resonance_that_exact_slopes_do_not():
    count = 2 * np.pi / 2**13
    knots, ticks = [[0], [1501]], [4000]
    setvalues = polyline(knots, ticks) * count
    exact = polyline_slopes(knots, ticks) * count / T
    plant, loop = Resonance(0.5, 100.0, 0.15), Loop(10.0, T, feedforward=1.0)
    ripples = [
        np.std(np.diff(follow(plant, loop, setvalues, slopes=s).position[1000:], axis=0))
        for s in (exact, np.diff(setvalues, axis=0) / T)
    ]
    assert ripples[1] > 5 * ripples[0]


def test_integral_removes_the_ramp_error():
    loop = Loop(10.0, T, integral=20.0)
    for plant in LINEAR:
        assert abs(follow(plant, loop, ramp(0.1, 3000)).error[-1]) < 1e-9


def test_integral_waits_while_the_valve_is_open():
    step = np.concatenate([[0.0], np.full(1500, 0.5)])
    waiting = follow(Integrator(0.1), Loop(10.0, T, integral=20.0), step)
    assert waiting.saturated_share > 0.5
    assert waiting.position.max() < 0.5 * 1.1


# ---- encoder, valve, inverse ----------------------------------------------------------------


def test_encoder_holds_the_error_within_a_count():
    count = 2 * np.pi / 2**13
    track = follow(Integrator(0.5), Loop(10.0, T, count=count, feedforward=1.0),
                     ramp(0.05, 2000), slopes=np.full(2000, 0.05))  # fmt: skip
    assert count / 16 < track.largest_error < count


def test_dead_band_hides_small_errors_unless_compensated():
    setvalues = np.concatenate([[0.0], np.full(2000, 0.02)])
    stuck = follow(Integrator(0.5), Loop(10.0, T, dead_band=0.05), setvalues)
    assert stuck.error[-1] == pytest.approx(0.05 * 0.5 / 10.0, rel=1e-3)
    freed = follow(Integrator(0.5), Loop(10.0, T, dead_band=0.05, compensated=True), setvalues)
    plain = follow(Integrator(0.5), Loop(10.0, T), setvalues)
    np.testing.assert_allclose(freed.position, plain.position, atol=1e-12)


def test_saturation_is_counted():
    track = follow(Integrator(0.5), Loop(10.0, T), ramp(1.0, 400))
    assert track.saturated_share > 0.9 and np.all(track.command <= 1)
    assert np.max(np.diff(track.position)) <= 0.5 * T * (1 + 1e-12)


def test_delay_puts_the_answer_off():
    step = np.concatenate([[0.0], np.full(50, 0.01)])
    prompt, late = (follow(Integrator(0.5), Loop(10.0, T, delay=m), step) for m in (0, 3))
    assert np.all(late.position[:5] == 0) and prompt.position[2] > 0
    assert np.all(late.command[:4] == 0) and late.command[4] == prompt.command[1] > 0


def test_static_inverse_beats_one_gain_for_all():
    axis = AXES[0]
    setvalues = np.radians(-30) + np.radians(20) * np.sin(np.arange(1001) * 2 * np.pi / 1000)
    slopes = np.diff(setvalues) / T
    loop = Loop(10.0, T, feedforward=1.0)
    gain = axis.resonance(0.0).gain
    errors = [
        follow(Rigid(axis), loop, setvalues, slopes=slopes, inverse=inverse).rms_error
        for inverse in (None, lambda rate, position: rate / gain)
    ]
    assert errors[0] < 0.3 * errors[1]


# ---- ripple ---------------------------------------------------------------------------------


@pytest.mark.parametrize("interval", [0.02, 0.05, 0.0628])
@pytest.mark.parametrize("speed", [0.01, 0.1])
def test_ripple_is_that_of_a_staircase(interval, speed):
    plant, gain, parts = Resonance(0.5, 100.0, 0.15), 8.0, 400
    tick, periods = interval / parts, int(3.0 / interval)
    staircase = speed * interval * np.repeat(np.arange(periods), parts)
    rates = follow(plant, Loop(gain, tick), staircase).states[0][-2 * parts : -parts, 1]
    harmonics = 2 * np.abs(np.fft.rfft(rates)) / parts / speed
    for k in (1, 2, 3):
        assert harmonics[k] == pytest.approx(ripple(plant, gain, interval, k), rel=0.02, abs=1e-5)


def test_ripple_peaks_at_the_resonance_and_t0_has_no_peak():
    intervals = np.linspace(0.02, 0.2, 400)
    resonant = ripple(Resonance(0.5, 100.0, 0.15), 8.0, intervals)
    peak = intervals[np.argmax(resonant)]
    assert peak == pytest.approx(2 * np.pi / 100.0, rel=0.05)
    assert np.all(np.diff(ripple(Integrator(0.5), 8.0, intervals)) > 0)
    assert ripple(Integrator(0.5), 8.0, 0.1) == pytest.approx(2 / abs(1 + 2j * np.pi / 0.8))


# ---- arguments ------------------------------------------------------------------------------


def test_follow_takes_one_axis_or_several():
    values = np.stack([ramp(0.1, 50), ramp(-0.05, 50)], axis=1)
    kept = values.copy()
    both = follow([LINEAR[0], LINEAR[1]], [Loop(10.0, T), Loop(5.0, T)], values)
    first, second = (follow(LINEAR[i], Loop((10.0, 5.0)[i], T), values[:, i]) for i in (0, 1))
    np.testing.assert_array_equal(
        both.position, np.stack([first.position, second.position], axis=1)
    )
    np.testing.assert_array_equal(both.command[:, 1], second.command)
    np.testing.assert_array_equal(values, kept)
    assert (both.position.shape, both.command.shape, first.position.shape) == (
        (51, 2), (50, 2), (51,))  # fmt: skip
    assert both.time[-1] == pytest.approx(50 * T)
    assert both.saturated_share.shape == both.largest_error.shape == (2,)


def test_settling_is_endless_where_the_error_stays():
    assert follow(LINEAR[0], Loop(10.0, T), ramp(0.1, 50)).settling(1e-6) == np.inf
    assert follow(LINEAR[0], Loop(10.0, T), np.zeros(5)).settling(1e-6) == 0


@pytest.mark.parametrize(("name", "values"), [
    ("gain", [0, -1.0, np.nan, "1", None]), ("tick", [0, -1.0, np.inf]), ("limit", [0, -1, np.inf]),
    ("integral", [-1.0, np.nan]), ("feedforward", [-0.1, 2.5]), ("count", [-1e-9, np.inf]),
    ("dead_band", [-0.1, 1.0]), ("delay", [-1, 0.5, None, [1, 2], 10**6]),
])  # fmt: skip
def test_loop_refuses_wrong_numbers(name, values):
    loop = Loop(10.0, T)
    for value in values:
        with pytest.raises(ValueError, match=rf"^{name}: must .*; got .*\.$"):
            replace(loop, **{name: value})


def test_follow_refuses_what_does_not_fit():
    loop = Loop(10.0, T)
    for values in (1.0, [1.0], np.zeros((3, 2, 2)), np.zeros((3, 0))):
        with pytest.raises(ValueError, match=r"^setvalues: must "):
            follow(LINEAR[0], loop, values)
    for values in ([0, np.nan], [0, np.inf]):
        with pytest.raises(ValueError, match=r"^setvalues: must hold finite numbers"):
            follow(LINEAR[0], loop, values)
    two = np.zeros((9, 2))
    with pytest.raises(ValueError, match=r"^plant: must be one, or one for each of 2 axes; got 4"):
        follow(LINEAR, loop, two)
    with pytest.raises(
        ValueError, match=r"^loop: all axes must share one tick; got \[0\.\d+, 0\.01\] s\.$"
    ):
        follow(LINEAR[0], [loop, Loop(10.0, 0.01)], two)
    forward = replace(loop, feedforward=1.0)
    with pytest.raises(ValueError, match=r"^slopes: a loop with feed-forward needs them"):
        follow(LINEAR[0], forward, two)
    for slopes in (np.zeros((9, 2)), np.zeros(8)):
        with pytest.raises(ValueError, match=r"^slopes: must be of shape \(8, 2\)"):
            follow(LINEAR[0], forward, two, slopes=slopes)
    with pytest.raises(ValueError, match=r"^slopes: must hold finite numbers"):
        follow(LINEAR[0], forward, two, slopes=np.full((8, 2), np.nan))
    for inverse in (len, lambda rate, position: None, lambda rate, position: np.nan):
        with pytest.raises(ValueError, match=r"^inverse: must "):
            follow(LINEAR[0], loop, two, inverse=inverse)
    for plant in (None, [LINEAR[0], "T1"]):
        with pytest.raises(ValueError, match=r"^plant(\[1\])?: must be of class Plant"):
            follow(plant, loop, two)


@pytest.mark.parametrize("tier", [Rigid, Compressible])
def test_follow_refuses_set_values_outside_the_stroke(tier):
    axis = AXES[0]
    for end in (axis.low - 1e-9, axis.high + 1e-9):
        with pytest.raises(ValueError, match=r"^setvalues: must lie within the stroke, -1.082 to"):
            follow(tier(axis), Loop(10.0, T), [0.0, end])
    with pytest.raises(ValueError, match=r"^tick: must be at most .* 1000 steps"):
        follow(tier(axis), Loop(1e-3, 1e3), [0.0, 0.1])


@pytest.mark.parametrize("value", [0, -1.0, np.nan])
def test_limits_refuse_wrong_numbers(value):
    for name, call in [("tick", lambda x: delay_limit(x)), ("lag", lambda x: lag_limit(x, 1)),
                       ("integral", lambda x: integral_limits(x, 1)),
                       ("damping", lambda x: resonance_limit(1, x)),
                       ("tick", lambda x: sampled_resonance_limit(1, 1, x)),
                       ("gain", lambda x: ripple(LINEAR[0], x, 0.1))]:  # fmt: skip
        with pytest.raises(ValueError, match=f"^{name}: must be one finite number above zero"):
            call(value)
    with pytest.raises(ValueError, match=r"^delay: must be one whole number from 0 to 100"):
        delay_limit(T, -1)
    with pytest.raises(ValueError, match=r"^lag: must be one finite number, not below zero"):
        resonance_limit(1, 1, -1.0)


@pytest.mark.parametrize("last", [3, 2, 11])
def test_part_of_a_track_ends_behind_its_begin_and_within_the_run(last):
    track = follow(Integrator(1.0), Loop(10.0, 5e-3, count=1e-3), np.arange(11))
    assert len(track.between(3, 10).setvalue) == 8
    with pytest.raises(ValueError) as refusal:
        track.between(3, last)
    assert str(refusal.value) == f"last: must be behind 3 and at most 10; got {last}."
