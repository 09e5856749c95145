"""Gains and lags from simulated logs with noise: what was put in comes out, within its error."""

import numpy as np
import pytest

from tunneller_lib.motion import Compressible, Lag, Loop, follow, identify, reference_axes
from tunneller_lib.motion.identify import identify_axis, identify_loop
from tunneller_lib.surfaces import REFERENCE_MACHINE

READS = []

TICK = 0.005


def openings(rng, rows=1500):
    """Return a valve that is set anew every 40 ticks."""
    return np.repeat(rng.uniform(-0.5, 0.5, rows // 40 + 1), 40)[:rows]


def axis_log(plant, valve, delay=0):
    """Return positions and speeds of an axis at the ticks of a valve's openings."""
    step = plant.stepper(TICK)
    state = plant.rest(0.1)
    rows = []
    for opening in [0.0] * delay + valve[: len(valve) - delay].tolist():
        rows.append(state[:2])
        state = step(state, opening)
    return np.array(rows).T


@pytest.mark.parametrize("kind", ["speed", "position"])
@pytest.mark.parametrize("gain, lag, delay", [(0.5, 0.02, 0), (0.08, 0.05, 3), (2.0, 0.004, 1)])
def test_axis_without_noise_is_found(kind, gain, lag, delay):
    valve = openings(np.random.default_rng(1))
    valve[:20] = 0.0
    position, speed = axis_log(Lag(gain, lag), valve, delay)
    found = identify_axis(valve, speed if kind == "speed" else position, TICK, kind=kind)
    assert found.delay == delay
    assert found.gain.value == pytest.approx(gain, rel=1e-4)
    assert found.lag.value == pytest.approx(lag, rel=1e-3)
    assert found.rms < 1e-4 * np.ptp(speed)


def test_no_more_delays_are_tried_than_tell(monkeypatch):
    tried = set()
    columns = identify._columns

    def watched(valve, tick, lag, delay, kind):
        tried.add(delay)
        return columns(valve, tick, lag, delay, kind)

    monkeypatch.setattr(identify, "_columns", watched)
    valve = openings(np.random.default_rng(1))
    position, _ = axis_log(Lag(0.5, 0.02), valve, 3)
    assert identify_axis(valve, position, TICK, kind="position").delay == 3
    assert max(tried) <= 6  # two that fit worse than 3, and one that fits worse than these


def test_delay_of_a_slow_log_without_noise_is_found():
    # A tick later or earlier is a hundred-millionth of the way off, what gain and lag make up for.
    valve = 0.4 * np.sin(np.linspace(0, 2 * np.pi, 20_000))
    position, _ = axis_log(Lag(0.5, 0.02), valve, 3)
    assert identify_axis(valve, position, TICK, kind="position").delay == 3


@pytest.mark.parametrize("kind, noise", [("speed", 5e-3), ("position", 3e-4)])
def test_standard_errors_are_those_of_many_logs(kind, noise):
    rng = np.random.default_rng(2)
    valve = openings(rng)
    valve[:20] = 0.0
    clean = axis_log(Lag(0.5, 0.02), valve, 1)[0 if kind == "position" else 1]
    logs = [clean + noise * rng.standard_normal(len(clean)) for _ in range(25)]
    found = [identify_axis(valve, log, TICK, kind=kind) for log in logs]
    assert {one.delay for one in found} == {1}
    for name, true in (("gain", 0.5), ("lag", 0.02)):
        values, errors = np.array([getattr(one, name) for one in found]).T
        away = (values - true) / errors
        assert np.std(values) == pytest.approx(np.mean(errors), rel=0.5)  # 25 logs tell it so far
        assert np.abs(np.mean(away)) < 3.5 / np.sqrt(len(logs)) and np.abs(away).max() < 4
    assert np.mean([one.rms for one in found]) == pytest.approx(noise, rel=0.02)


def test_a_delay_above_the_true_one_is_named_in_one_of_ten_noisy_logs_at_most():
    # By two standard deviations of the likelihood it would be one of twenty; by one, one of three.
    rng = np.random.default_rng(2)
    above = 0
    for _ in range(60):
        valve = openings(rng, 400)
        valve[:20] = 0.0
        speed = axis_log(Lag(0.5, 0.04), valve, 2)[1]
        above += identify_axis(valve, speed + 0.1 * rng.standard_normal(400), TICK).delay > 2
    assert above <= 6


def test_axis_of_oil_gives_its_steady_gain_within_a_tenth():
    axis = reference_axes(REFERENCE_MACHINE)[1]
    plant = Compressible(axis)
    valve = openings(np.random.default_rng(3), 800) / 4
    _, speed = axis_log(plant, valve)
    found = identify_axis(valve, speed, TICK)
    assert found.gain.value == pytest.approx(0.05 / plant.command(0.05, 0.1), rel=0.1)


def set_values(rng, rows=1500):
    """Return set-values from rest to rest, there and back at two speeds."""
    rate = np.repeat([0.0, 0.15, -0.1, 0.0, 0.2, -0.2], rows // 6)
    rate = np.convolve(rate, np.ones(30) / 30, mode="same")
    rate[:20] = 0.0
    return 0.2 + TICK * np.cumsum(rate)


@pytest.mark.parametrize(
    "gain, lag, share, delay", [(10.0, 0.02, 0.0, 0), (8.0, 0.03, 1.0, 1), (15.0, 0.01, 0.5, 2)]
)
def test_loop_is_found_within_its_errors(gain, lag, share, delay):
    rng = np.random.default_rng(4)
    wanted = set_values(rng)
    loop = Loop(gain, TICK, feedforward=share, delay=delay)
    slopes = np.diff(wanted) / TICK
    clean = follow(Lag(0.5, lag), loop, wanted, slopes=slopes).position
    exact = identify_loop(wanted, clean, TICK, feedforward=share)
    assert exact.delay == delay and exact.gain.value == pytest.approx(gain, rel=1e-3)
    assert exact.lag.value == pytest.approx(lag, rel=1e-2)
    noisy = clean + 5e-5 * rng.standard_normal(len(clean))
    found = identify_loop(wanted, noisy, TICK, feedforward=share)
    assert found.rms == pytest.approx(5e-5, rel=0.1)
    if found.delay == delay:
        for name, true in (("gain", gain), ("lag", lag)):
            value, error = getattr(found, name)
            assert abs(value - true) < 4 * error + 1e-6
    # A tick of delay more is nearly as much lag less, so that noise may take one for the other.
    assert abs(found.delay * TICK + found.lag.value - delay * TICK - lag) < TICK


@pytest.mark.parametrize("kind", ["speed", "position"])
def test_axis_may_move_where_its_log_begins(kind):
    position, speed = axis_log(Lag(0.5, 0.02), openings(np.random.default_rng(1)), 3)
    valve = openings(np.random.default_rng(1))[500:]
    measured = (speed if kind == "speed" else position)[500:]
    assert abs(speed[500]) > 0.05
    found = identify_axis(valve, measured, TICK, kind=kind)
    assert found.delay == 3 and found.gain.value == pytest.approx(0.5, rel=1e-4)
    assert found.lag.value == pytest.approx(0.02, rel=1e-3)


def loop_log(seed=4):
    """Return set and actual positions of a loop of gain 8, lag 30 ms and a delay of 2 ticks."""
    wanted = set_values(np.random.default_rng(seed))
    return wanted, follow(Lag(0.5, 0.03), Loop(8.0, TICK, delay=2), wanted).position


@pytest.mark.parametrize("noise", [0.0, 5e-5, 1e-3])
def test_log_of_a_loop_that_begins_in_motion_is_refused(noise):
    wanted, actual = loop_log()
    actual = actual + noise * np.random.default_rng(5).standard_normal(len(actual))
    with pytest.raises(ValueError, match=r"^setvalue: must stay the same in the first 10 rows, "):
        identify_loop(wanted[400:], actual[400:], TICK)
    # Between two motions the set-values rest while the axis still comes to them.
    stop = 766
    with pytest.raises(ValueError, match=r"^actual: must rest in the first \d+ rows, as the set"):
        identify_loop(wanted[stop:], actual[stop:], TICK)
    # Where it has come the log may begin.
    found = identify_loop(wanted[stop + 170 :], actual[stop + 170 :], TICK)
    assert found.gain.value == pytest.approx(8, rel=1e-3 if noise < 1e-3 else 0.05)


@pytest.mark.parametrize("count", [0.0, 1e-4, 1.5e-3], ids=["exact", "fine", "coarse"])
@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-3])
def test_noise_and_counts_of_an_axis_at_rest_are_no_motion(count, noise):
    rng = np.random.default_rng(6)
    wanted, clean = loop_log()
    for _ in range(300):
        actual = clean + rng.uniform(0, 0.01) + noise * rng.standard_normal(len(clean))
        identify._check_rest(wanted, count * np.rint(actual / count) if count else actual)


def test_wrong_logs_are_refused():
    ramp = np.linspace(0, 1, 100)
    with pytest.raises(
        ValueError, match=r"^measured: must have as many rows as valve, 100; got 99"
    ):
        identify_axis(ramp, ramp[:99], TICK)
    with pytest.raises(ValueError, match=r"^valve: must move the axis; got a column that stays"):
        identify_axis(0 * ramp, ramp, TICK)
    with pytest.raises(ValueError, match=r"^setvalue: must move the axis"):
        identify_loop(0 * ramp, ramp, TICK)
    with pytest.raises(ValueError, match=r"^actual: must be one column of 20 to 200000 rows"):
        identify_loop(ramp, ramp[:5], TICK)
