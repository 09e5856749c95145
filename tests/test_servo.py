"""Position loops: limits of the gain, ramps, steps, and what encoder, delay and valve do."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given

from tests.draws import log_uniform
from tunneller_lib.motion import (
    Compressible,
    Integrator,
    Lag,
    Loop,
    Push,
    Resonance,
    Rigid,
    follow,
    polyline,
    polyline_slopes,
    reference_axes,
    stability,
)
from tunneller_lib.motion.plant import ValveResonance
from tunneller_lib.motion.sizing import arm_of, axes_of, usual_sizes
from tunneller_lib.surfaces import REFERENCE_MACHINE

T = 0.005
AXES = reference_axes(REFERENCE_MACHINE)
SIZES = usual_sizes(REFERENCE_MACHINE)
LINEAR = [Integrator(0.5), Lag(0.5, 0.02), Resonance(0.5, 100.0, 0.15),
          ValveResonance(0.5, 0.5, 100.0, 0.15, 0.004)]  # fmt: skip


def ramp(speed, ticks, tick=T):
    return speed * tick * np.arange(ticks + 1)


# ---- limits of the gain ---------------------------------------------------------------------


@pytest.mark.parametrize("delay", range(9))
@pytest.mark.parametrize("tick", [1e-4, T, 0.3])
def test_delay_limit_is_that_of_the_eigenvalues(delay, tick):
    limit = stability.delay_limit(tick, delay)
    found = stability.eigenvalue_limit(Integrator(0.5), Loop(limit / 3, tick, delay=delay))
    assert found == pytest.approx(limit, rel=1e-9)


@given(log_uniform(1e-5, 1e2), log_uniform(1e-4, 1.0))
def test_lag_limit_is_that_of_the_eigenvalues(lag, tick):
    limit = stability.lag_limit(lag, tick)
    found = stability.eigenvalue_limit(Lag(0.5, lag), Loop(limit / 50, tick))
    assert found == pytest.approx(limit, rel=1e-9)


@given(log_uniform(1e-3, 1.9), log_uniform(1e-3, 1.0))
@example(1.99999, T)  # the stable gains are within a hundred-thousandth of each other
def test_integral_limits_are_those_of_the_eigenvalues(root, tick):
    integral = (root / tick) ** 2
    limits = stability.integral_limits(integral, tick)
    found = stability.stable_gains(Integrator(0.5), Loop(np.mean(limits), tick, integral=integral))
    assert found == pytest.approx(limits, rel=1e-9)


def test_gains_are_stable_with_an_integral_till_none_is_left():
    assert stability.integral_limits(4 / T**2, T) == pytest.approx((4 / T, 4 / T))
    assert stability.stable_gains(Integrator(0.5), Loop(1.0, T, integral=5 / T**2)) == (np.inf, 0.0)


def test_stable_gains_of_oil_are_those_at_the_worst_angle():
    plant = Compressible(AXES[0])
    angles = np.linspace(-0.8, 0.4, 5)
    low, high = stability.stable_gains(plant, Loop(1.0, T, integral=5.0), angles)
    each = [stability.stable_gains(plant, Loop(1.0, T, integral=5.0), angle) for angle in angles]
    assert (low, high) == pytest.approx((max(a for a, _ in each), min(b for _, b in each)))
    assert 0 < low < 1 and high == pytest.approx(
        stability.gain_limit(plant, Loop(1.0, T), angles), rel=0.01
    )
    inside, outside = (Loop(gain, T, integral=5.0) for gain in (0.99 * high, 1.01 * high))
    assert stability.is_stable(plant, inside, angles) and not stability.is_stable(
        plant, outside, angles
    )


@given(log_uniform(1.0, 1e4), log_uniform(0.01, 3.0), log_uniform(1e-3, 1e2))
def test_resonance_limit_behind_a_valve_is_that_of_the_eigenvalues(frequency, damping, share):
    """And without one; a plant livelier than its steady gain bears less."""
    lag = share / frequency
    limit = stability.resonance_limit(frequency, damping, lag)
    for plant, wanted in (
        (Resonance(0.5, frequency, damping), stability.resonance_limit(frequency, damping)),
        (ValveResonance(0.5, 0.5, frequency, damping, lag), limit),
        (ValveResonance(0.6, 0.5, frequency, damping, lag), limit / 1.2),
    ):
        assert stability.continuous_limit(plant) == pytest.approx(wanted, rel=1e-9)


@given(log_uniform(1.0, 1e4), log_uniform(0.01, 3.0), log_uniform(0.01, 30.0))
def test_sampled_resonance_limit_is_that_of_the_eigenvalues(frequency, damping, phase):
    tick = phase / frequency
    limit = stability.sampled_resonance_limit(frequency, damping, tick)
    found = stability.eigenvalue_limit(Resonance(0.5, frequency, damping), Loop(limit / 50, tick))
    assert found == pytest.approx(limit, rel=1e-9)


# The linear model knows where a tiny step dies out and where it grows: to 7 % with oil that gives
# way, to 10 % with rigid oil, whose gain isn't that of its linear model in both ways.
OPTIONS = {}, {"delay": 4}, {"integral": 20.0}, {"integral": 9.0, "delay": 2}
LOOPS = [(plant, 0.1, options, 0.04) for plant in LINEAR for options in OPTIONS]
LOOPS += [(tier(AXES[axis]), angle, options, near)
          for tier, near in ((Rigid, 0.1), (Compressible, 0.07))
          for axis, angle, options in ((0, -1.04, {}), (0, 0.6, {"delay": 2}),
                                       (1, -0.65, {"delay": 1, "integral": 15.0}))]  # fmt: skip


@pytest.mark.parametrize(("plant", "angle", "options", "near"), LOOPS)
def test_loops_swing_up_beyond_the_limit_of_the_eigenvalues_and_are_said_to(
    plant, angle, options, near
):
    limit = stability.eigenvalue_limit(plant.linear(angle), Loop(12.0, T, **options))
    step = np.concatenate([[angle], np.full(1500, angle + 1e-5)])
    calm, wild = (follow(plant, Loop(f * limit, T, **options), step) for f in (1 - near, 1 + near))
    assert calm.stable == (True,) and wild.stable == (False,)
    late = slice(-200, None)
    assert np.abs(calm.error[late]).max() < 1e-6 and np.abs(wild.error[late]).max() > 1e-4
    assert np.all(np.isfinite(wild.position)) and np.max(np.abs(wild.command)) <= 1


# ---- ramps and steps ------------------------------------------------------------------------


@pytest.mark.parametrize("plant", [*LINEAR, *map(Rigid, AXES), *map(Compressible, AXES)])
@pytest.mark.parametrize("speed", [0.01, -0.2])
def test_ramp_error_is_speed_over_gain_and_an_integral_removes_it(plant, speed):
    # Near a joint's own rate, what T2 and T3 lack is the change of their gain along the way.
    near = 1e-9 if plant in LINEAR else 0.02
    ticks = 3000 if plant in LINEAR else 600
    track = follow(plant, Loop(8.0, T), ramp(speed, ticks))
    assert track.error[-1] == pytest.approx(speed / 8.0, rel=near)
    if plant in LINEAR:
        assert abs(follow(plant, Loop(8.0, T, integral=20.0), ramp(speed, ticks)).error[-1]) < 1e-9


def test_feedforward_by_the_exact_slope_leaves_no_error_of_t0():
    knots, ticks = np.array([[0, 0], [900, -333], [901, 400], [901, 401]]), [200, 301, 99]
    count = 2 * np.pi / 2**16
    exact = np.concatenate([[[0, 0]], np.cumsum(polyline_slopes(knots, ticks), axis=0)]) * count
    slopes = polyline_slopes(knots, ticks) * count / T
    loop = Loop(10.0, T, feedforward=1.0)
    assert np.max(follow(Integrator(0.5), loop, exact, slopes=slopes).largest_error) < 1e-14
    counted = follow(Integrator(0.5), loop, polyline(knots, ticks) * count, slopes=slopes)
    assert np.all(counted.largest_error < count)


def test_integral_waits_while_the_valve_is_open():
    step = np.concatenate([[0.0], np.full(1500, 0.5)])
    waiting = follow(Integrator(0.1), Loop(10.0, T, integral=20.0), step)
    assert waiting.saturated_share > 0.5
    assert waiting.position.max() < 0.5 * 1.1


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
        assert harmonics[k] == pytest.approx(
            stability.ripple(plant, gain, interval, k), rel=0.02, abs=1e-5
        )


# ---- arguments ------------------------------------------------------------------------------


def test_follow_takes_one_axis_or_several():
    values = np.stack([ramp(0.1, 50), ramp(-0.05, 50)], axis=1)
    both = follow([LINEAR[0], LINEAR[1]], [Loop(10.0, T), Loop(5.0, T)], values)
    for i, gain in enumerate((10.0, 5.0)):
        one = follow(LINEAR[i], Loop(gain, T), values[:, i])
        np.testing.assert_array_equal(both.position[:, i], one.position)
        np.testing.assert_array_equal(both.command[:, i], one.command)
        assert one.rms_error == pytest.approx(np.sqrt(np.mean((values[:, i] - one.position) ** 2)))
        assert both.largest_error[i] == one.largest_error == np.abs(one.error).max()


def test_follow_refuses_what_does_not_fit():
    loop = Loop(10.0, T)
    forward = replace(loop, feedforward=1.0)
    two = np.zeros((9, 2))
    for arguments, options, said in [
        ((LINEAR[0], loop, [1.0]), {}, r"setvalues: must be of one tick and of one axis"),
        ((LINEAR[0], [loop, Loop(10.0, 0.01)], two), {}, r"loop: all axes must share one tick;"),
        ((LINEAR[0], forward, two), {}, r"slopes: a loop with feed-forward needs them"),
        ((LINEAR[0], loop, two), {"push": Push()}, r"plant: must be two of class Compressible"),
        ((Rigid(AXES[0]), Loop(1e-3, 1e3), [0.0, 0.1]), {}, r"tick: must be at most .* 1000 steps"),
    ]:
        with pytest.raises(ValueError, match=f"^{said}"):
            follow(*arguments, **options)


@pytest.mark.parametrize("tier", [Rigid, Compressible])
def test_stroke_is_kept_by_set_values_and_by_the_axis(tier):
    axis = AXES[0]
    for end in (axis.low - 1e-9, axis.high + 1e-9):
        with pytest.raises(ValueError, match=r"^setvalues: must lie within the stroke, -1.082 to"):
            follow(tier(axis), Loop(10.0, T), [0.0, end])
    message = r"^setvalues: an axis must stay within its stroke, -62.0 to 37.0 deg; got 37"
    with pytest.raises(ValueError, match=message):
        follow(tier(axis), Loop(10.0, T), np.zeros(2000), inverse=lambda rate, position: 1.0)


@pytest.mark.parametrize("arm", [None, arm_of(REFERENCE_MACHINE, SIZES)], ids=["apart", "one arm"])
def test_axes_begin_at_rest_at_their_first_setvalues(arm):
    still = np.tile([0.2, -0.3], (6, 1))
    oily = [Compressible(axis) for axis in axes_of(REFERENCE_MACHINE, SIZES)]
    track = follow(oily, Loop(10.0, 0.005), still, slopes=np.zeros((5, 2)), arm=arm)
    np.testing.assert_array_equal(track.position[0], still[0])
    # The pressures bear the weight from the beginning: a free fall would be 1e-3 rad by now.
    np.testing.assert_allclose(track.position, still, atol=1e-5)
