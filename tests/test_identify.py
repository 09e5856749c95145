"""Gain, lag and delay from simulated logs with noise: what was put in comes out, as errors say."""

import numpy as np
import pytest

from tests.audit.long import many
from tunneller_lib.motion import Compressible, reference_axes
from tunneller_lib.motion.identify import identify_axis
from tunneller_lib.surfaces import REFERENCE_MACHINE

TICK = 0.005


def openings(rng, rows=1500):
    """Return a valve that is set anew every 40 ticks."""
    valve = np.repeat(rng.uniform(-0.5, 0.5, rows // 40 + 1), 40)[:rows]
    valve[:20] = 0.0
    return valve


def exact_log(gain, lag, valve, delay=0, most=np.inf):
    """Return speeds and positions of a lag, whose speed that is asked for may be bounded.

    Apart from the library: between two ticks the speed goes exponentially to the gain times the
    opening.
    """
    speed = position = 0.0
    rows = []
    kept = np.exp(-TICK / lag)
    for opening in [0.0] * delay + valve.tolist():
        rows.append((speed, position))
        wanted = float(np.clip(gain * opening, -most, most))
        position += wanted * TICK + (speed - wanted) * lag * (1 - kept)
        speed = wanted + (speed - wanted) * kept
    return np.array(rows[: len(valve)]).T


@pytest.mark.parametrize("kind", ["speed", "position"])
@pytest.mark.parametrize("gain, lag, delay", [(0.5, 0.02, 0), (0.08, 0.05, 10), (2.0, 0.004, 1)])
def test_axis_without_noise_is_found_also_where_its_log_begins_in_motion(kind, gain, lag, delay):
    valve = openings(np.random.default_rng(1))
    measured = exact_log(gain, lag, valve, delay)[int(kind == "position")]
    for first in (0, 500):
        found = identify_axis(valve[first:], measured[first:], TICK, kind=kind)
        assert found.delay == delay and found.rms < 1e-6 * np.ptp(measured)
        assert found.gain == pytest.approx(gain, rel=1e-4)
        assert found.lag == pytest.approx(lag, rel=1e-3)


def random_log(rng, number):
    """Return a random good log: kind, valve, what was measured, gain, lag and delay."""
    gain, delay = rng.uniform(0.1, 2.0), int(rng.integers(0, 9))
    lag = np.exp(rng.uniform(np.log(0.005), np.log(0.1)))
    valve = openings(rng, int(rng.integers(400, 1000)))
    speed, position = exact_log(gain, lag, valve, delay)
    if number % 2:
        noise = 0.3 * gain * TICK * 10 ** rng.uniform(-2, 1)
        return "position", valve, position + noise * rng.normal(size=len(valve)), gain, lag, delay
    noise = np.std(speed) * 10 ** rng.uniform(-4, -1)
    return "speed", valve, speed + noise * rng.normal(size=len(valve)), gain, lag, delay


def test_true_values_lie_within_their_errors_as_often_as_these_say():
    rng = np.random.default_rng(11)
    away, mistaken, count = [], 0, many(60, 1000)
    for number in range(count):
        kind, valve, measured, gain, lag, delay = random_log(rng, number)
        found = identify_axis(valve, measured, TICK, kind=kind)  # none is refused
        mistaken += found.delay != delay
        away.append([(found.gain - gain) / found.gain_error, (found.lag - lag) / found.lag_error])
    assert mistaken > 0  # noise takes one delay for another: the errors know of it
    for size, share in ((1, 0.683), (2, 0.954), (3, 0.997)):
        within = np.mean(np.abs(away) < size, axis=0)
        assert np.abs(within - share).max() < 4 * np.sqrt(share * (1 - share) / count), within


def with_overlap(valve, width):
    return np.sign(valve) * np.maximum(np.abs(valve) - width, 0)


BAD_AXES = {
    "an overlap of 4 %": lambda valve: exact_log(0.47, 0.02, with_overlap(valve, 0.04), 1),
    "saturation": lambda valve: exact_log(0.47, 0.02, valve, 1, most=0.15),
    "a delay of 11 ticks": lambda valve: exact_log(0.47, 0.02, valve, 11),
    "a delay of 40 ticks": lambda valve: exact_log(0.47, 0.02, valve, 40),
}  # fmt: skip


@pytest.mark.parametrize(("kind", "noise"), [
    ("speed", 0.0), ("speed", 1e-2), ("position", 0.0), ("position", 1e-3),
])  # fmt: skip
@pytest.mark.parametrize("case", BAD_AXES)
def test_axis_that_does_not_fit_a_lag_is_refused(case, kind, noise):
    rng = np.random.default_rng(12)
    valve = openings(rng)
    measured = BAD_AXES[case](valve)[int(kind == "position")]
    measured = measured + noise * rng.standard_normal(len(valve))
    with pytest.raises(ValueError, match=r"^measured: must fit a lag.*\.$"):
        identify_axis(valve, measured, TICK, kind=kind)


def test_axis_of_oil_is_refused_unless_noise_hides_its_oil():
    plant = Compressible(reference_axes(REFERENCE_MACHINE)[1])
    rng = np.random.default_rng(3)
    valve = openings(rng, 800) / 4
    step = plant.stepper(TICK)
    states = [plant.rest(0.1)]
    for opening in valve[:-1]:
        states.append(step(states[-1], opening))
    speed = np.array(states)[:, 1]
    with pytest.raises(ValueError, match=r"^measured: must fit a lag, which leaves white noise; g"):
        identify_axis(valve, speed, TICK)
    found = identify_axis(valve, speed + 0.1 * rng.standard_normal(len(speed)), TICK)
    assert found.gain == pytest.approx(0.05 / plant.command(0.05, 0.1), rel=0.1)


@pytest.mark.parametrize("digits", [3, 5])
def test_positions_in_counts_fit_a_lag_and_their_errors_hold(digits):
    rng = np.random.default_rng(14)
    for _ in range(5):
        valve = openings(rng)
        _, position = exact_log(0.47, 0.02, valve, 2)
        found = identify_axis(valve, np.round(position, digits), TICK, kind="position")
        assert abs(found.gain - 0.47) < 4 * found.gain_error
        assert abs(found.lag - 0.02) < 4 * found.lag_error < 0.02


def test_wrong_logs_are_refused():
    ramp = np.linspace(0, 1, 100)
    for valve, measured, said in [
        (ramp, ramp[:99], r"measured: must have as many rows as valve, at least 20; got 99 a"),
        (ramp[:19], ramp[:19], r"measured: must have as many rows as valve, at least 20; got 19 a"),
        (0 * ramp, ramp, r"valve: must change; got a column that stays the same\.$"),
        (ramp, 0 * ramp, r"measured: must change; got a column that stays the same\.$"),
        (100 * ramp, ramp, r"valve: must hold numbers of at most 1 in size; got 1\.0101\.$"),
    ]:
        with pytest.raises(ValueError, match=f"^{said}"):
            identify_axis(valve, measured, TICK)
