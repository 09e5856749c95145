"""Lines in whole counts, gains, resonances and tasks: simulated, or by roots of polynomials."""

import numpy as np

from tests.independent.section import INSIDE, LARGE, SMALL, egg, even, joints

READS = ["report/numbers/*.json"]

TICK = 0.005  # s


def bisect(low, high, is_low):
    """Return where a condition ends that holds at `low` and not at `high`."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if is_low(middle) else (low, middle)
    return low


def test_tallest_harmonic_of_the_rounded_line(printed):
    """93 counts in 256 ticks, rounded by floor and a half, by Fourier's sum."""
    n = np.arange(256)
    off = (2 * 93 * n + 256) // 512 - 93 * n / 256
    waves = np.exp(-2j * np.pi * np.outer(np.arange(1, 128), n) / 256)
    found = 2 * np.abs(waves @ off).max() / 256
    assert found == printed("21_line", "amplitude of the tallest harmonic")


def test_gain_limits_of_the_first_order_model_by_its_delay(printed):
    """Where a root of z^m (z - 1) + gain tick leaves the unit circle."""
    for delay in range(5):

        def calm(gain, delay=delay):
            polynomial = [1.0, -1.0] + [0.0] * delay
            polynomial[-1] += gain * TICK
            return np.abs(np.roots(polynomial)).max() < 1

        row = f"T0, delay in ticks: {delay}"
        assert bisect(1.0, 1000.0, calm) == printed("23_gain", "limits", row, "formula")


def sampled(A, B):
    """Return what a tick does to the state of x' = A x + B u, by the exponential's series."""
    whole = np.zeros((len(A) + 1, len(A) + 1))
    whole[:-1, :-1], whole[:-1, -1] = A, B
    term = total = np.eye(len(whole))
    for k in range(1, 40):
        term = term @ whole * TICK / k
        total = total + term
    return total[:-1, :-1], total[:-1, -1]


def sampled_limit(A, B):
    """Return the gain at which a loop about the first state, once a tick, begins to swing."""
    Ad, Bd = sampled(A, B)
    first = np.eye(len(A))[0]
    return bisect(
        1e-3, 1e4, lambda gain: np.abs(np.linalg.eigvals(Ad - gain * np.outer(Bd, first))).max() < 1
    )


def test_gain_limit_of_a_lagging_valve(printed):
    lag = 0.02  # s
    found = sampled_limit(np.array([[0, 1], [0, -1 / lag]]), np.array([0, 1 / lag]))
    assert found == printed("23_gain", "limits", "T1, lag 20 ms", "formula")


# The hydraulics of the reference machine: oil of 1 GPa, hoses of 50 cm^3 on either side

BULK, HOSE, HEAD, BEAM = 1e9, 50e-6, 30.0, 60.0
MARGIN = np.radians(2)  # of the stroke beyond the joints' limits
LIFT = (0.45, 0.11, np.radians(75), -1, 0.050, 0.028, *np.radians([-62, 37]), [1])
SWING = (0.30, 0.07, np.radians(90), 1, 0.040, 0.022, *np.radians([-42, 42]), [1, -1])


def oil(cylinders, angle):
    """Return displacements, m^3/rad, and volumes, m^3, of both sides, by differences of lengths.

    A cylinder spans two pivots a and b from the joint; the second of a pair is a mirror image.
    """
    a, b, mounting, sense, bore, rod, low, high, images = cylinders
    whole, ring = np.pi / 4 * bore**2, np.pi / 4 * (bore**2 - rod**2)
    sides = np.array([[0.0, HOSE], [0.0, HOSE]])  # that drive the joint on and back
    for image in images:

        def long(q, way=sense * image):
            gamma = mounting + way * q
            return np.hypot(a - b * np.cos(gamma), b * np.sin(gamma))

        lever = (long(angle + 1e-5) - long(angle - 1e-5)) / 2e-5
        ends = sorted([long(low), long(high)])
        sides[0 if lever > 0 else 1] += [whole * abs(lever), whole * (long(angle) - ends[0])]
        sides[1 if lever > 0 else 0] += [ring * abs(lever), ring * (ends[1] - long(angle))]
    return sides


def resonance(cylinders, inertia, angle):
    """Return the frequency, in rad/s, of an arm on the oil of both shut sides."""
    return np.sqrt(sum(BULK * d**2 / volume for d, volume in oil(cylinders, angle)) / inertia)


ABOUT_PHI = HEAD * LARGE**2 + BEAM * LARGE**2 / 3
ABOUT_THETA = HEAD * (SMALL + LARGE) ** 2 + BEAM * (SMALL**2 + SMALL * LARGE + LARGE**2 / 3)
RATIO = 0.15  # of damping, at angle 0


def test_resonance_of_phi_and_the_gain_that_it_bears(printed):
    """Continuous, where a root of the loop's cubic turns to growth; and once a tick."""
    w = resonance(SWING, ABOUT_PHI, 0.0)
    assert w / (2 * np.pi) == printed("23_gain", "resonance of phi")

    def calm(gain):
        return np.roots([1, 2 * RATIO * w, w * w, gain * w * w]).real.max() < 0

    assert bisect(1.0, 100.0, calm) == printed("23_gain", "gain limit by the resonance")
    A = np.array([[0, 1, 0], [0, 0, 1], [0, -w * w, -2 * RATIO * w]])
    found = sampled_limit(A, np.array([0, 0, w * w]))
    assert found == printed("23_gain", "gain limit by the resonance, sampled")


def test_resonances_of_theta_over_its_stroke(printed):
    for row, degrees in enumerate((-60, 0, 35)):
        found = resonance(LIFT, ABOUT_THETA, np.radians(degrees)) / (2 * np.pi)
        assert found == printed("23_gain", "axes", row, "$f_h$ / Hz")


def test_ground_in_which_a_joint_swings_up_if_picks_are_in_step(printed):
    """The least damper of picks 12 times a second that turns oil, loop and ground to growth."""
    theta, phi = joints(*even(egg(INSIDE), 21).T)
    frequency = np.linspace(0.2, 60, 20_001)
    s = 2j * np.pi * frequency
    loop = 10 * np.exp(-s * 1.5 * TICK) / (s * (1 + 0.004 * s))  # a tick late, the valve 4 ms
    delayed = 12 * (1 - np.exp(-s / 12))
    calm = np.inf
    for cylinders, inertia, angles, lever in (
        (LIFT, ABOUT_THETA, theta, SMALL + LARGE * np.cos(phi)),
        (SWING, ABOUT_PHI, phi, LARGE + 0 * phi),
    ):
        rub = 2 * RATIO * resonance(cylinders, inertia, 0.0)
        for angle, arm in zip(angles, lever, strict=True):
            spring = resonance(cylinders, inertia, angle) ** 2
            air = inertia * (s * s + rub * s + spring * (1 + loop))
            damper = -air / (arm**2 * delayed)
            turns = np.diff(np.sign(damper.imag)) != 0
            turns &= np.abs(np.diff(damper.imag)) < np.abs(damper.real[:-1])  # no pole
            found = damper.real[:-1][turns]
            calm = min(calm, found[found > 0].min())
    assert calm / 1e3 == printed("45_ground", "greatest calm damper")


def test_resonances_of_similar_machines(printed):
    """Theta's least along the circuit; lengths as the scale, so times go with it."""
    least = min(resonance(LIFT, ABOUT_THETA, angle) for angle in joints(*egg(INSIDE, 500).T)[0])
    hertz = least / (2 * np.pi)
    assert hertz / 0.5 == printed("45_ground", "resonance at half scale")
    assert hertz / 3 == printed("45_ground", "resonance at scale 3")


def test_ripple_of_stairs_at_one_period_of_the_resonance(printed):
    """The first harmonic of the rate of a loop, gain 10/s, stepped finely after a staircase."""
    w, gain, parts = resonance(SWING, ABOUT_PHI, 0.0), 10.0, 4000
    h = 2 * np.pi / w / parts
    place = rate = pull = 0.0
    rates = []
    for k in range(20 * parts):  # in units of a stair a period
        wanted = k // parts
        pull += h * (w * w * (gain * (wanted - place) - rate) - 2 * RATIO * w * pull)
        rate += h * pull
        place += h * rate
        rates.append(rate)
    last = np.array(rates[-parts:])
    wave = np.exp(-2j * np.pi * np.arange(parts) / parts)
    found = 2 * np.abs(last @ wave) / parts / (1 / (parts * h))
    assert found == printed("23_gain", "ripple at one period")


def test_interval_that_leaves_a_ripple(printed):
    """The saw's first harmonic, 1/pi of a stair, through the closed loop."""
    w, gain = resonance(SWING, ABOUT_PHI, 0.0), 10.0

    def ripple(periods):
        s = 1j * w / periods
        loop = np.polyval([1, 2 * RATIO * w, w * w, gain * w * w], s)
        return 2 * abs(gain * w * w / loop)

    for percent in (10, 1):
        found = bisect(0.05, 1.0, lambda t, share=percent / 100: ripple(t) < share)
        assert found == printed("23_gain", f"interval for {percent} percent")


def test_a_ramp_is_followed_late_by_its_rate_over_the_gain(printed):
    place = 0.0
    for k in range(1000):  # 0.1 rad/s, 10/s
        error = 0.1 * TICK * k - place
        place += TICK * 10 * error
    assert np.degrees(error) == printed("23_gain", "ramp error")


def test_response_of_the_slow_task(printed):
    """Work of 14 ms in the gaps that interpolation and servo leave, a tenth of a ms at a time."""
    gaps = left = 0
    while left < 140:
        left += gaps % 50 >= 3 + 9  # 0.3 ms and 0.9 ms of each tick of 5 ms
        gaps += 1
    assert gaps / 10 == printed("25_tasks", "response")
    assert 100 * (3 + 9) / 50 == printed("25_tasks", "load of the fast tasks")
