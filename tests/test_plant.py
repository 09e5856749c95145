"""The models of an axis: exact ticks, linkage and cylinders, rigid and compressible oil."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from tests.shapes import log_uniform
from tunneller_lib.motion import Compressible, Integrator, Lag, Resonance, Rigid, reference_axes
from tunneller_lib.motion.oil import LAMINAR, land, resistance
from tunneller_lib.motion.plant import ValveResonance
from tunneller_lib.motion.sizing import axes_of, usual_sizes
from tunneller_lib.surfaces import REFERENCE_MACHINE
from tunneller_lib.surfaces.linkage import Linkage, usual_linkages

LINEAR = [Integrator(0.5), Lag(0.5, 0.02), Lag(2e3, 3e-4), Resonance(0.5, 100.0, 0.15),
          ValveResonance(0.5, 0.5, 100.0, 0.15, 0.004)]  # fmt: skip
LEVERS = [
    *usual_linkages(REFERENCE_MACHINE.R),
    Linkage(0.3, 0.07, 1.4, 1, 0.04, 0.022, 0.1),
    Linkage(3e3, 2e3, 1.0, -1, 5.0, 1.0, 1.0),
    Linkage(0.2, 0.2, 1.2, 1, 0.01, 0.005, 0.01, pair=True),
]
AXES = reference_axes(REFERENCE_MACHINE)
THETA, PHI = AXES
every_axis = pytest.mark.parametrize("axis", AXES, ids=["theta", "phi"])
every_lever = pytest.mark.parametrize("lever", LEVERS)


def run(plant, tick, commands, state):
    """Return states from the plant's own steps."""
    step, states = plant.stepper(tick), [state]
    for u in commands:
        states.append(step(states[-1], u))
    return np.array(states)


# ---- linear plants --------------------------------------------------------------------------


@pytest.mark.parametrize("plant", LINEAR, ids=repr)
@pytest.mark.parametrize("tick", [5e-4, 0.005, 0.1])
def test_stepper_equals_a_solver_restarted_each_tick(plant, tick):
    commands = np.random.default_rng(3).uniform(-1, 1, 12)
    A, B = plant.matrices()
    state = np.array(plant.rest(0.3))
    found = run(plant, tick, commands, plant.rest(0.3))
    for n, u in enumerate(commands):
        again = solve_ivp(lambda _, y, u=u: A @ y + B * u, (0, tick), state, method="DOP853",
                          rtol=1e-13, atol=1e-15)  # fmt: skip
        state = again.y[:, -1]
        scale = np.max(np.abs(found), axis=0) + 0.3
        assert np.all(np.abs(found[n + 1] - state) <= 1e-12 * scale)


@pytest.mark.parametrize("order", [3, 4])
@pytest.mark.parametrize("gain", [0.5, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("tick", [0.005, 0.026, 0.076, 0.084, 0.094, 0.14])
def test_discrete_of_a_resonance_keeps_its_digits_at_any_gain(order, gain, tick):
    """In the states' own units: up to a norm of 19 without a halving the quotient is off."""
    w = 100.0
    plant = Resonance(gain, w, 0.15)
    if order == 4:
        plant = ValveResonance(gain, gain, w, 0.15, 0.004)
    A, B = plant.matrices()
    with mp.workdps(50):
        held = mp.zeros(order + 1)
        held[:order, :order] = mp.matrix(A.tolist()) * tick
        held[:order, order] = mp.matrix(B.tolist()) * tick
        exact = np.array(mp.expm(held, method="taylor").tolist(), dtype=float)[:order]
    units = np.array([1, w, w**2, w / gain])[:order]
    Ad, Bd = plant.discrete(tick)
    for found, wanted in (
        (Ad / units[:, None] * units, exact[:, :order] / units[:, None] * units),
        (Bd / units, exact[:, order] / units),
    ):
        assert np.abs(found - wanted).max() <= 3e-15 * np.abs(wanted).max()


@given(log_uniform(1e-6, 1e3), log_uniform(1e-6, 1e3))
def test_lag_discrete_keeps_its_digits(lag, tick):
    Ad, Bd = Lag(1.0, lag).discrete(tick)
    with mp.workdps(50):
        a = mp.exp(-mp.mpf(tick) / lag)
        exact = [[1, lag * (1 - a)], [0, a]], [tick - lag * (1 - a), 1 - a]
        for found, wanted in [(Ad[0, 1], exact[0][0][1]), *zip(Bd, exact[1], strict=True)]:
            assert abs(found - wanted) <= 4e-15 * abs(wanted)


@pytest.mark.parametrize("plant", LINEAR, ids=repr)
def test_transfer_and_command_agree_with_the_gain(plant):
    slow = 1e-5j
    assert abs(slow * plant.transfer(slow) - plant.gain) < 1e-4 * plant.gain
    steady = run(plant, 0.05, [plant.command(0.2)] * 200, plant.rest(0.0))[:, 0]
    assert np.isclose(steady[-1] - steady[-2], 0.2 * 0.05, rtol=1e-9)
    frequencies = np.array([[1j, 5j], [100j, 1 + 2j]])
    assert plant.transfer(frequencies).shape == (2, 2)
    assert plant.transfer(frequencies)[1, 0] == pytest.approx(plant.transfer(100j))


def test_lag_without_lag_is_the_integrator():
    Ad, Bd = Lag(0.5, 1e-9).discrete(0.01)
    np.testing.assert_allclose(
        [Ad[0, 0], Bd[0]], [1, Integrator(0.5).discrete(0.01)[1][0]], rtol=1e-6
    )


@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf, "1", None])
def test_linear_plants_need_sizes_above_zero(value):
    for name, build in [("gain", Integrator), ("lag", lambda x: Lag(1, x)),
                        ("frequency", lambda x: Resonance(1, x, 1)),
                        ("damping", lambda x: Resonance(1, 1, x)),
                        ("steady", lambda x: ValveResonance(1, x, 1, 1, 1)),
                        ("lag", lambda x: ValveResonance(1, 1, 1, 1, x))]:  # fmt: skip
        with pytest.raises(
            ValueError, match=rf"^{name}: must (be one finite number above zero|hold real numbers)"
        ):
            build(value)
    with pytest.raises(
        ValueError, match=r"^tick: must (be one finite number above zero|hold real numbers)"
    ):
        Lag(1, 1).discrete(value)


# ---- linkage --------------------------------------------------------------------------------


def angles(lever):
    """Return joint angles at which a lever's triangles are open."""
    low, high = 0.1 - lever.mounting, 3.0 - lever.mounting
    low, high = (low, high) if lever.sense > 0 else (-high, -low)
    return np.linspace(max(low, -high), min(high, -low), 41) if lever.pair else (
        np.linspace(low, high, 41))  # fmt: skip


@every_lever
def test_linkage_obeys_the_law_of_cosines(lever):
    q = angles(lever)
    for angle, length, arm in zip(q, lever.length(q), lever.arm(q), strict=True):
        with mp.workdps(40):
            gamma = mp.mpf(lever.mounting) + lever.sense * mp.mpf(angle)
            exact = mp.sqrt(mp.mpf(lever.a) ** 2 + mp.mpf(lever.b) ** 2
                            - 2 * mp.mpf(lever.a) * lever.b * mp.cos(gamma))  # fmt: skip
            assert abs(length - exact) <= 1e-15 * (lever.a + lever.b)
            assert (
                abs(arm - lever.sense * lever.a * lever.b * mp.sin(gamma) / exact)
                <= 4e-15 * lever.b
            )
        assert lever.length(float(angle)) == pytest.approx(length, rel=1e-15)


@every_lever
def test_linkage_displacements_are_rates_of_the_volumes(lever):
    q, h = angles(lever)[1:-1], 1e-5
    ends = angles(lever)[[0, -1]]
    ahead, behind = (np.array(lever.volumes(q + d, *ends)) for d in (h, -h))
    rates = (ahead - behind) / (2 * h) * np.array([[1], [-1]])
    np.testing.assert_allclose(lever.displacements(q), rates, rtol=1e-6)
    assert np.min(lever.volumes(q, *ends)) > 0


def test_linkage_pair_is_symmetric_only_straight_ahead():
    swing = usual_linkages(REFERENCE_MACHINE.R)[1]
    plus, minus = swing.displacements(np.array([-0.4, 0.0, 0.4]))
    np.testing.assert_allclose(plus, minus[::-1], rtol=1e-15)
    assert plus[1] == minus[1] and plus[0] != minus[0]
    np.testing.assert_allclose(swing.volumes(0.3, -0.7, 0.7), swing.volumes(-0.3, -0.7, 0.7)[::-1])


def test_linkages_grow_with_the_machine():
    small, large = (usual_linkages(R)[0] for R in (0.4, 8.0))
    assert large.length(0.2) == pytest.approx(20 * small.length(0.2), rel=1e-14)


def test_linkage_refuses_an_unreachable_stroke():
    lift = usual_linkages(REFERENCE_MACHINE.R)[0]
    with pytest.raises(ValueError, match=r"^stroke: .* must fit into the shortest cylinder; got"):
        replace(lift, dead_length=0.25).check(-1.0, 0.6)
    with pytest.raises(
        ValueError, match=r"^stroke: between the limits gamma must .*; got 40.62 to 189.6 deg\.$"
    ):
        lift.check(-2.0, 0.6)
    with pytest.raises(ValueError, match=r"^stroke: .* gamma"):
        reference_axes(replace(REFERENCE_MACHINE, theta_max=np.radians(80)))
    with pytest.raises(ValueError, match=r"^low: a pair needs limits as far to either side"):
        reference_axes(replace(REFERENCE_MACHINE, phi_max=np.radians(30)))


def test_linkage_refuses_wrong_sizes():
    lift = usual_linkages(REFERENCE_MACHINE.R)[0]
    for name in ("a", "b", "bore", "rod", "dead_length"):
        for value in (0, -1.0, np.nan, None):
            with pytest.raises(
                ValueError,
                match=rf"^{name}: must (be one finite number above zero|hold real numbers)",
            ):
                replace(lift, **{name: value})
    wrong_angles = [{"mounting": value} for value in (0, -1.0, 3.2, np.nan, None)]
    for change in ({"rod": 0.05}, {"sense": 0}, *wrong_angles):
        with pytest.raises(ValueError, match=rf"^{next(iter(change))}: must"):
            replace(lift, **change)


# ---- hydraulics -----------------------------------------------------------------------------


@every_axis
def test_rate_uses_up_the_pressure_of_both_lands(axis):
    q = np.linspace(axis.low, axis.high, 9)
    for spool in (1.0, 0.3, 0.01, -0.01, -1.0):
        for angle, rate in zip(q, axis.rate(q, spool), strict=True):
            plus, minus = axis.linkage.displacements(float(angle))
            filled, emptied = (plus, minus) if spool > 0 else (minus, plus)
            first = axis.supply - (abs(rate) * filled / (axis.flow * abs(spool))) ** 2
            second = axis.tank + (abs(rate) * emptied / (axis.flow * abs(spool))) ** 2
            resisting = np.sign(spool) * (axis.load(float(angle)) + axis.damping * rate)
            assert filled * first - emptied * second == pytest.approx(resisting, abs=1e-6)


def test_valves_of_any_machine_are_taken():
    """In SI units the smallest are near 1e-15 m^3/s/Pa^0.5."""
    least = replace(PHI, flow=1e-15, damping=1e-12)
    np.testing.assert_allclose(
        least.rate(0.2, 1.0) / least.flow, replace(PHI, damping=1e-12).rate(0.2, 1.0) / PHI.flow,
        rtol=1e-9,
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"^flow: must be from 1e-15 to 1e\+15"):
        replace(PHI, flow=9e-16)


@every_axis
@given(st.floats(-0.6, 0.6), st.floats(-1, 1))
def test_command_inverts_the_rate(axis, angle, spool):
    rate = float(axis.rate(angle, spool))
    assert axis.command(rate, angle) == pytest.approx(spool, rel=1e-12, abs=1e-300)


def test_rate_without_friction_is_the_root_law():
    axis = replace(PHI, damping=1e-12)
    np.testing.assert_allclose(axis.rate(0.2, 0.5), 5 * axis.rate(0.2, 0.1), rtol=1e-9)
    # One unequal cylinder, no load, no return pressure: speeds are as 1 to sqrt(rho).
    axis = replace(THETA, damping=1e-12, gravity=0.0, tank=1e-9)
    plus, minus = axis.linkage.displacements(0.1)
    forward, backward = axis.rate(0.1, [1, -1])
    assert -backward / forward == pytest.approx((minus / plus) ** 0.5, rel=1e-9)


def test_command_of_an_impossible_rate_is_infinite():
    assert PHI.command(50.0, 0.0) == np.inf and PHI.command(-50.0, 0.0) == -np.inf
    assert PHI.command(0.0, 0.0) == 0.0


@every_axis
def test_natural_frequency_is_that_of_the_linear_equations(axis):
    for angle in (-0.5, 0.0, 0.4):
        state = np.array(Compressible(axis).rest(angle))
        steps = np.array([1e-7, 1e-7, 1.0, 1.0])
        columns = []
        for i, h in enumerate(steps):
            ahead, behind = (np.array(Compressible(axis).derivative(state + d, 0.0)) for d in
                             (h * np.eye(5)[i], -h * np.eye(5)[i]))  # fmt: skip
            columns.append(((ahead - behind) / (2 * h))[:4])
        # Gravity and the changing arm add a stiffness of their own: leave out the angle.
        eigenvalues = np.linalg.eigvals(np.array(columns).T[1:, 1:])
        oscillating = eigenvalues[np.abs(eigenvalues.imag) > 1]
        assert abs(oscillating[0]) == pytest.approx(axis.natural_frequency(angle), rel=1e-5)
        damping = -oscillating[0].real / abs(oscillating[0])
        assert damping == pytest.approx(axis.resonance(angle).damping, rel=1e-5)


@every_axis
@pytest.mark.parametrize("angle", [-0.6, 0.0, 0.5])
def test_linear_model_is_that_of_small_swings_about_rest(axis, angle):
    # Pressures at which both lands lose the same: where swings leave them.
    plant, small = Compressible(axis), Compressible(axis).linear(angle)
    plus, minus = axis.linkage.displacements(angle)
    total = axis.supply + axis.tank
    first = (axis.load(angle) + minus * total) / (plus + minus)
    for spool in (1e-6, -1e-6):
        _, still, *filling, _ = plant.derivative((angle, 0.0, first, total - first, spool), 0.0)
        assert abs(still) < 1e-9
        shaken = (plus * filling[0] - minus * filling[1]) / axis.inertia
        steady = float(axis.rate(angle, spool))
        assert shaken == pytest.approx(small.frequency**2 * axis.swing(angle) * steady, rel=1e-4)
        assert plant.command(steady, angle) == pytest.approx(spool, rel=1e-9)
    assert small.gain == pytest.approx(axis.swing(angle) * small.steady, rel=1e-14)
    assert plant.command(1e-9, angle) <= small.command(1e-9) * (1 + 1e-9)
    spool = [run(plant, 0.001, [0.3] * 5, plant.rest(angle))[:, 4],
             run(small, 0.001, [0.3] * 5, small.rest(angle))[:, 3]]  # fmt: skip
    np.testing.assert_allclose(*spool, rtol=1e-3)


def test_dry_friction_is_whole_from_six_thousandths_of_a_radian_a_second_on():
    """And turns its direction within two thousandths, where it is three quarters."""
    axis = replace(THETA, friction=50.0, damping=1e-9)
    found = [resistance(axis, rate) / 50.0 for rate in (-6e-3, -2e-3, 0.0, 2e-3, 6e-3)]
    expected = [-0.995, -0.7616, 0.0, 0.7616, 0.995]  # tanh of -3, -1, 0, 1 and 3
    np.testing.assert_allclose(found, expected, atol=1e-4)


def test_flow_through_a_land_is_the_root_above_a_bar_and_straight_below():
    bar = 1e5
    assert land(10 * bar) == pytest.approx(np.sqrt(10 * bar), rel=3e-3)
    assert land(0.5 * bar) < 0.75 * np.sqrt(0.5 * bar)
    for lost in (0.01 * bar, 0.1 * bar):
        assert land(lost) == pytest.approx(lost / np.sqrt(bar), rel=3e-3)
        assert land(-lost) == -land(lost)


def test_axis_of_sizes_has_its_rated_flow_at_35_bar_a_land():
    sizes = usual_sizes(REFERENCE_MACHINE)
    made = axes_of(REFERENCE_MACHINE, replace(sizes, rated_flow=40e-3 / 60))
    assert [60e3 * one.flow * np.sqrt(35e5) for one in made] == pytest.approx([40.0, 40.0])


def test_swing_gain_is_the_steady_one_for_equal_areas():
    assert PHI.swing(0.0) == pytest.approx(1.0, rel=1e-14)
    angles = np.linspace(-0.6, 0.6, 7)
    np.testing.assert_allclose(PHI.swing(angles), PHI.swing(-angles), rtol=1e-14)
    assert THETA.swing(-1.04) > 1.1 and THETA.swing(0.6) < 0.95


@every_axis
@pytest.mark.parametrize("spool", [1.0, 0.1, 1e-3, -1e-3, -0.1, -1.0])
def test_compressible_steady_rate_is_rigid_within_its_bound(axis, spool):
    plant = Compressible(axis)
    for angle in (-0.5, 0.1, 0.55):
        rate = float(axis.rate(angle, spool))
        guess = [rate, 0.5 * axis.supply, 0.5 * axis.supply]
        found = least_squares(
            lambda y, angle=angle: plant.derivative((angle, *y, spool), spool)[1:4], guess,
            x_scale=[abs(rate), 1e5, 1e5], xtol=1e-15, ftol=1e-15, gtol=1e-15)  # fmt: skip
        if spool > 0:
            lost = [axis.supply - found.x[1], found.x[2] - axis.tank]
        else:
            lost = [found.x[1] - axis.tank, axis.supply - found.x[2]]
        bound = (LAMINAR / min(lost)) ** 2 / 4
        assert bound < 1e-3
        assert abs(found.x[0] / rate - 1) <= bound * (1 + 1e-3) + 1e-9


@every_axis
def test_compressible_follows_a_stiff_solver(axis):
    plant, tick = Compressible(axis), 0.005
    commands = 0.3 * np.sin(np.arange(60) / 7)
    found = run(plant, tick, commands, plant.rest(0.1))
    state = np.array(plant.rest(0.1))
    for n, u in enumerate(commands):
        again = solve_ivp(lambda _, y, u=u: plant.derivative(y, u), (0, tick), state,
                          method="LSODA", rtol=1e-9, atol=1e-12)  # fmt: skip
        state = again.y[:, -1]
        assert np.all(np.abs(found[n + 1] - state) <= [1e-7, 1e-5, 2e3, 2e3, 2e-5])


@every_axis
def test_rigid_follows_a_solver(axis):
    plant, tick = Rigid(axis), 0.02
    state, found = np.array(plant.rest(0.1)), run(plant, tick, [0.4, -0.2, 0.3], plant.rest(0.1))

    def slope(_, y, u):
        return [float(axis.rate(y[0], y[1])), (u - y[1]) / axis.valve_lag]

    for n, u in enumerate([0.4, -0.2, 0.3]):
        again = solve_ivp(slope, (0, tick), state, args=(u,), rtol=1e-9, atol=1e-12, max_step=1e-3)
        state = again.y[:, -1]
        np.testing.assert_allclose(found[n + 1], state, atol=2e-6)


@every_axis
def test_rest_stays_at_rest(axis):
    for angle in (-0.6, 0.0, 0.5):
        for plant in (Rigid(axis), Compressible(axis)):
            moved = run(plant, 0.005, [0.0] * 20, plant.rest(angle)) - np.array(plant.rest(angle))
            assert np.all(np.abs(moved) <= 1e-9 * np.array([1, 1, 1e8, 1e8, 1])[: moved.shape[1]])


def test_compressible_oil_is_held_at_no_pressure_and_not_before():
    plant, turning = Compressible(THETA), 0.3  # rad/s, towards the first chamber's emptying
    rates = [plant.derivative((0.0, turning, first, 2e6, 0.0), 0.0)[2] for first in (0.0, 0.5, 1e3)]
    assert rates[0] == 0 and rates[1] == pytest.approx(rates[2], rel=1e-3) and rates[1] < -1e6
    rates = [plant.derivative((0.0, -turning, 2e6, p, 0.0), 0.0)[3] for p in (0.0, 0.5, 1e3)]
    assert rates[0] == 0 and rates[1] == pytest.approx(rates[2], rel=1e-3) and rates[1] < -1e6


def test_compressible_oil_never_pulls():
    plant = Compressible(replace(THETA, inertia=400.0, supply=60e5))
    states = run(plant, 0.005, [1.0] * 60 + [-1.0] * 40, plant.rest(-0.5))
    assert np.min(states[:, 2:4]) >= 0


@pytest.mark.parametrize(
    "plant", [Rigid(THETA), Compressible(THETA)], ids=["rigid", "compressible"]
)
def test_end_of_the_stroke_is_told(plant):
    message = r"^setvalues: an axis must stay within its stroke, -62.0 to 37.0 deg; it got to 37"
    with pytest.raises(ValueError, match=message):
        run(plant, 0.005, [1.0] * 2000, plant.rest(0.0))


@pytest.mark.parametrize("state", [(0.0, 0.0, 1e6), np.zeros((5, 1)), 0.0])
def test_states_are_five_numbers(state):
    with pytest.raises(ValueError) as refused:
        Compressible(PHI).derivative(state, 0.0)
    assert str(refused.value) == f"state: must have the shape (5,); got {np.shape(state)}."


@every_axis
@pytest.mark.parametrize("plant", [Rigid, Compressible])
def test_joints_may_stand_at_the_ends_of_their_stroke(axis, plant):
    # Without weight and friction nothing moves them from there.
    light = replace(axis, gravity=0.0)
    for end in (light.low, light.high):
        assert run(plant(light), 0.005, [0.0], plant(light).rest(end))[1, 0] == end


def test_valve_may_open_wholly_and_no_farther():
    half, whole = (PHI.loaded(0.0, 0.1, 100.0, opened) for opened in (0.5, 1.0))
    assert 1.5 * half < whole < 2 * half
    with pytest.raises(ValueError, match=r"^opened: must be at most 1; got 1\.01\.$"):
        PHI.loaded(0.0, 0.1, 100.0, 1.01)


@every_axis
def test_angles_outside_the_stroke_are_refused(axis):
    # Volumes were negative there, and frequencies complex.
    for angle in (1.5, axis.low - 1e-9, axis.high + 1e-9):
        for call in (axis.natural_frequency, axis.swing, axis.resonance, axis.sides,
                     lambda q: axis.rate(q, 1.0), Rigid(axis).linear, Compressible(axis).linear,
                     lambda q: axis.linkage.volumes(q, axis.low, axis.high)):  # fmt: skip
            with pytest.raises(ValueError, match=r"^angle: must lie within the stroke, -.*; got"):
                call(angle)
        for plant in (axis, Rigid(axis), Compressible(axis)):
            with pytest.raises(ValueError, match=r"^position: must lie within the stroke"):
                plant.command(0.1, angle)
        for call in (Rigid(axis).rest, Compressible(axis).rest):
            with pytest.raises(ValueError, match=r"^position: must lie within the stroke"):
                call(angle)
        with pytest.raises(ValueError, match=r"^angle: must lie within the stroke"):
            axis.natural_frequency([0.0, angle])
        with pytest.raises(ValueError, match=r"^state: must lie within the stroke"):
            Compressible(axis).derivative((angle, 0.0, 1e6, 1e6, 0.0), 0.0)
    with pytest.raises(ValueError, match=r"^spool: must be from -1 to 1; got 1.1"):
        axis.rate(0.0, [0.5, -1.1])
    with pytest.raises(ValueError, match=r"^angle: must hold real numbers"):
        axis.load(True)


def test_a_stroke_without_angle_0_has_its_damping_where_it_comes_nearest():
    lift, _ = reference_axes(replace(REFERENCE_MACHINE, theta_min=0.1))
    assert lift.resonance(lift.low).damping == pytest.approx(0.15)


def test_transfer_refuses_poles():
    with pytest.raises(ValueError, match=r"^s: must be from 1e-50 to 1e50 rad/s in size"):
        LINEAR[0].transfer([0.0, 1j])
    with pytest.raises(ValueError, match=r"^s: must be no pole of the plant"):
        Lag(1.0, 0.5).transfer(-2.0)


@pytest.mark.parametrize("size", [1e-50, 1e50])
def test_transfer_takes_frequencies_up_to_its_bounds(size):
    plant = Integrator(1.0)
    assert plant.transfer(1j * size) == pytest.approx(plant.gain / (1j * size), rel=1e-14)
    beyond = size * (0.99 if size < 1 else 1.01)
    with pytest.raises(ValueError, match=r"^s: must be from 1e-50 to 1e50 rad/s in size; got "):
        plant.transfer([1.0, 1j * beyond])


def test_hydraulics_refuse_wrong_sizes():
    names = ("inertia", "damping", "supply", "tank", "bulk", "hose", "flow", "valve_lag")
    for name in names:
        for value in (0, -1.0, np.inf, "1"):
            with pytest.raises(
                ValueError,
                match=rf"^{name}: must (be one finite number above zero|hold real numbers)",
            ):
                replace(THETA, **{name: value})
    with pytest.raises(ValueError, match=r"^tank: must be below the supply"):
        replace(THETA, tank=THETA.supply)
    with pytest.raises(ValueError, match=r"^supply: must move the weight both ways"):
        replace(THETA, gravity=1e5)
    with pytest.raises(ValueError, match=r"^stroke: "):
        replace(THETA, high=2.0)
    with pytest.raises(ValueError, match=r"^linkage: must be of class Linkage"):
        replace(THETA, linkage=None)
    with pytest.raises(ValueError, match=r"^machine: must be of class Machine"):
        reference_axes(None)
