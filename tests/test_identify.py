"""Gains and lags from simulated logs with noise: what was put in comes out, within its error."""

import numpy as np
import pytest

from tests.audit.long import many
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


def test_axis_of_oil_is_refused_unless_noise_hides_its_oil():
    axis = reference_axes(REFERENCE_MACHINE)[1]
    plant = Compressible(axis)
    rng = np.random.default_rng(3)
    valve = openings(rng, 800) / 4
    _, speed = axis_log(plant, valve)
    with pytest.raises(ValueError, match=r"^measured: doesn't fit a lag: what it leaves must be n"):
        identify_axis(valve, speed, TICK)
    found = identify_axis(valve, speed + 0.1 * rng.standard_normal(len(speed)), TICK)
    assert found.gain.value == pytest.approx(0.05 / plant.command(0.05, 0.1), rel=0.1)


# Logs of an axis, made apart from the library: between two ticks its speed goes exponentially to
# the gain times the opening.


def exact_log(gain, lag, valve, delay=0, tick=TICK, most=np.inf):
    """Return speeds and positions of a lag, whose speed that is asked for may be bounded."""
    speed = position = 0.0
    rows = []
    kept = np.exp(-tick / lag)
    for opening in [0.0] * delay + valve.tolist():
        rows.append((speed, position))
        wanted = float(np.clip(gain * opening, -most, most))
        position += wanted * tick + (speed - wanted) * lag * (1 - kept)
        speed = wanted + (speed - wanted) * kept
    return np.array(rows[: len(valve)]).T


def random_log(rng, number):
    """Return a random good log: kind, valve, what was measured, gain, lag and delay."""
    gain, delay = rng.uniform(0.1, 2.0), int(rng.integers(0, 9))
    lag = np.exp(rng.uniform(np.log(0.005), np.log(0.1)))
    valve = openings(rng, int(rng.integers(400, 1000)))
    valve[:20] = 0.0
    speed, position = exact_log(gain, lag, valve, delay)
    if number % 2:
        noise = 0.3 * gain * TICK * 10 ** rng.uniform(-2, 1)
        return "position", valve, position + noise * rng.normal(size=len(valve)), gain, lag, delay
    noise = np.std(speed) * 10 ** rng.uniform(-4, -1)
    return "speed", valve, speed + noise * rng.normal(size=len(valve)), gain, lag, delay


def test_true_values_lie_within_their_errors_as_often_as_these_say():
    rng = np.random.default_rng(11)
    away, mistaken, count = [], 0, many(200, 1000)
    for number in range(count):
        kind, valve, measured, gain, lag, delay = random_log(rng, number)
        found = identify_axis(valve, measured, TICK, kind=kind)  # none is refused
        mistaken += found.delay != delay
        away.append(
            [
                (found.gain.value - gain) / found.gain.error,
                (found.lag.value - lag) / found.lag.error,
            ]
        )
    assert mistaken > 0  # noise takes one delay for another: the errors know of it
    away = np.abs(away)
    for size, share in ((1, 0.683), (2, 0.954), (3, 0.997)):
        within = np.mean(away < size, axis=0)
        assert np.abs(within - share).max() < 4 * np.sqrt(share * (1 - share) / count), within


def with_overlap(valve, width):
    return np.sign(valve) * np.maximum(np.abs(valve) - width, 0)


BAD_AXES = {
    "an overlap of 4 %": lambda valve: exact_log(0.47, 0.02, with_overlap(valve, 0.04), 1),
    "an overlap of 4 %, made up for": lambda valve: exact_log(
        0.47 / 0.96, 0.02, with_overlap(valve, 0.04), 1
    ),
    "saturation": lambda valve: exact_log(0.47, 0.02, valve, 1, most=0.15),
    "a delay of 12 ticks": lambda valve: exact_log(0.47, 0.02, valve, 12),
    "a delay of 15 ticks": lambda valve: exact_log(0.47, 0.02, valve, 15),
    "a delay of 40 ticks": lambda valve: exact_log(0.47, 0.02, valve, 40),
}  # fmt: skip


@pytest.mark.parametrize(("kind", "noise"), [
    ("speed", 0.0), ("speed", 1e-3), ("speed", 1e-2),
    ("position", 0.0), ("position", 1e-4), ("position", 1e-3),
])  # fmt: skip
@pytest.mark.parametrize("case", BAD_AXES)
def test_axis_that_does_not_fit_a_lag_is_refused(case, kind, noise):
    rng = np.random.default_rng(12)
    for _ in range(many(3, 30)):
        valve = openings(rng)
        valve[:20] = 0.0
        speed, position = BAD_AXES[case](valve)
        measured = speed if kind == "speed" else position
        measured = measured + noise * rng.standard_normal(len(valve))
        with pytest.raises(ValueError, match=r"^measured: doesn't fit a lag[: ].*got .*\.$"):
            identify_axis(valve, measured, TICK, kind=kind)


def test_valve_in_percent_is_refused():
    valve = openings(np.random.default_rng(13))
    speed, _ = exact_log(0.47, 0.02, valve)
    most = f"{100 * np.abs(valve).max():g}"
    with pytest.raises(ValueError, match=rf"^valve: must be shares from -1 to 1 .*; got {most}\.$"):
        identify_axis(100 * valve, speed, TICK)
    limit = np.repeat([0.0, 1.0, -1.0, 0.3], 200)
    speed, _ = exact_log(0.47, 0.5, limit)
    assert identify_axis(limit, speed, TICK).gain.value == pytest.approx(0.47)
    with pytest.raises(ValueError, match=r"^valve: must be shares"):
        identify_axis(np.nextafter(1, 2) * limit, speed, TICK)


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_positions_in_counts_fit_a_lag_and_their_errors_hold(digits):
    rng = np.random.default_rng(14)
    for _ in range(10):
        valve = openings(rng)
        valve[:20] = 0.0
        _, position = exact_log(0.47, 0.02, valve, 2)
        found = identify_axis(valve, np.round(position, digits), TICK, kind="position")
        assert abs(found.gain.value - 0.47) < 4 * found.gain.error
        assert abs(found.lag.value - 0.02) < 4 * found.lag.error < 0.02


def test_a_delay_at_the_end_of_its_range_is_found_and_one_beyond_is_refused():
    valve = openings(np.random.default_rng(15))
    valve[:20] = 0.0
    for delay in (9, 10):
        speed, _ = exact_log(0.47, 0.02, valve, delay)
        assert identify_axis(valve, speed, TICK).delay == delay
    speed, _ = exact_log(0.47, 0.02, valve, 11)
    said = r"^measured: doesn't fit a lag with a delay of at most 10 ticks; got one of about 11\.$"
    with pytest.raises(ValueError, match=said):
        identify_axis(valve, speed, TICK)


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


BAD_LOOPS = {
    "an overlap": {"dead_band": 0.04},
    "a valve that is full": {"limit": 0.2},
    "a long delay": {"delay": 15},
}


@pytest.mark.parametrize("noise", [0.0, 2e-4])
@pytest.mark.parametrize("case", BAD_LOOPS)
def test_loop_that_does_not_fit_a_lag_is_refused(case, noise):
    rng = np.random.default_rng(16)
    wanted = set_values(rng)
    loop = Loop(8.0, TICK, **{"delay": 1} | BAD_LOOPS[case])
    actual = follow(Lag(0.5, 0.02), loop, wanted).position
    actual = actual + noise * rng.standard_normal(len(actual))
    with pytest.raises(ValueError, match=r"^actual: doesn't fit a lag[: ].*got .*\.$"):
        identify_loop(wanted, actual, TICK)


def test_true_values_of_loops_lie_within_four_of_their_errors():
    rng = np.random.default_rng(17)
    for _ in range(many(12, 100)):
        gain, lag, delay = rng.uniform(3, 15), rng.uniform(0.005, 0.04), int(rng.integers(0, 4))
        wanted = set_values(rng)
        clean = follow(Lag(0.5, lag), Loop(gain, TICK, delay=delay), wanted).position
        noisy = clean + 10 ** rng.uniform(-6, -3.5) * rng.standard_normal(len(clean))
        found = identify_loop(wanted, noisy, TICK)
        assert abs(found.gain.value - gain) < 4 * found.gain.error
        assert abs(found.lag.value - lag) < 4 * found.lag.error


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
    with pytest.raises(ValueError, match=r"^actual: must be one column of 20 rows or more"):
        identify_loop(ramp, ramp[:5], TICK)
