"""The models of an axis: exact ticks, linkage and cylinders, rigid and compressible oil."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from scipy.integrate import solve_ivp

from tunneller_lib.motion import Compressible, Integrator, Lag, Resonance, Rigid, reference_axes
from tunneller_lib.motion.oil import compressible_slopes, flows, land, resistance
from tunneller_lib.motion.plant import ValveResonance
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
    step, states = partial(plant.functions()["ticked"], plant.numbers(tick)), [state]
    for u in commands:
        states.append(step(states[-1], u))
    return np.array(states)


def solved(slopes, tick, commands, state, **options):
    """Return states by scipy, begun anew each tick; `slopes` of a state and a command."""
    states = [np.array(state)]
    for u in commands:
        again = solve_ivp(lambda _, y, u=u: slopes(y, u), (0, tick), states[-1], **options)
        states.append(again.y[:, -1])
    return np.array(states)


def changes(axis, state, u=0.0):
    """Return the changes (5,) a second of an axis with compressible oil."""
    return np.array(compressible_slopes(axis.numbers, tuple(state), u))


# ---- linear plants --------------------------------------------------------------------------


@pytest.mark.parametrize("plant", LINEAR, ids=repr)
@pytest.mark.parametrize("tick", [5e-4, 0.005, 0.1])
def test_stepper_equals_a_solver_restarted_each_tick(plant, tick):
    A, B = plant.matrices()
    given = tick, np.random.default_rng(3).uniform(-1, 1, 12), plant.rest(0.3)
    wanted = solved(lambda y, u: A @ y + B * u, *given, method="DOP853", rtol=1e-13, atol=1e-15)
    found = run(plant, *given)
    scale = np.max(np.abs(found), axis=0) + 0.3
    assert np.all(np.abs(found - wanted) <= 1e-12 * scale)


@pytest.mark.parametrize("gain", [0.5, 1e3, 1e9])
@pytest.mark.parametrize("tick", [0.005, 0.026, 0.076, 0.094, 0.14])
def test_discrete_of_a_resonance_keeps_its_digits_at_any_gain(gain, tick):
    """In the states' own units: up to a norm of 19 without a halving the quotient is off."""
    w = 100.0
    for plant in (Resonance(gain, w, 0.15), ValveResonance(gain, gain, w, 0.15, 0.004)):
        A, B = plant.matrices()
        order = len(B)
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


@pytest.mark.parametrize("plant", LINEAR, ids=repr)
def test_response_and_command_agree_with_the_gain(plant):
    slow = 1e-5
    assert abs(1j * slow * plant.response(slow) - plant.gain) < 1e-4 * plant.gain
    steady = run(plant, 0.05, [plant.command(0.2)] * 200, plant.rest(0.0))[:, 0]
    assert np.isclose(steady[-1] - steady[-2], 0.2 * 0.05, rtol=1e-9)


# ---- linkage --------------------------------------------------------------------------------


def angles(lever):
    """Return joint angles at which a lever's triangles are open."""
    low, high = sorted(lever.sense * (gamma - lever.mounting) for gamma in (0.1, 3.0))
    if lever.pair:
        low, high = max(low, -high), min(high, -low)
    return np.linspace(low, high, 41)


@every_lever
def test_linkage_displacements_are_rates_of_the_volumes(lever):
    q, h = angles(lever)[1:-1], 1e-5
    ends = angles(lever)[[0, -1]]
    ahead, behind = (np.array(lever.volumes(q + d, *ends)) for d in (h, -h))
    rates = (ahead - behind) / (2 * h) * np.array([[1], [-1]])
    np.testing.assert_allclose(lever.displacements(q), rates, rtol=1e-6)
    assert np.min(lever.volumes(q, *ends)) > 0


def test_linkage_refuses_an_unreachable_stroke():
    lift = usual_linkages(REFERENCE_MACHINE.R)[0]
    with pytest.raises(ValueError, match=r"^stroke: .* must fit into the shortest cylinder; got"):
        replace(lift, dead_length=0.25).check(-1.0, 0.6)
    with pytest.raises(
        ValueError, match=r"^stroke: between the limits gamma must .*; got 40.62 to 189.6 deg\.$"
    ):
        lift.check(-2.0, 0.6)
    with pytest.raises(ValueError, match=r"^low: a pair needs limits as far to either side"):
        reference_axes(replace(REFERENCE_MACHINE, phi_max=np.radians(30)))


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


@every_axis
@given(st.floats(-0.6, 0.6), st.floats(-1, 1))
def test_command_inverts_the_rate(axis, angle, spool):
    rate = float(axis.rate(angle, spool))
    assert axis.command(rate, angle) == pytest.approx(spool, rel=1e-12, abs=1e-300)
    assert axis.command(np.copysign(50.0, spool), angle) == np.copysign(np.inf, spool)


@every_axis
def test_natural_frequency_is_that_of_the_linear_equations(axis):
    for angle in (-0.5, 0.0, 0.4):
        state = np.array(Compressible(axis).rest(angle))
        columns = []
        for step in np.diag([1e-7, 1e-7, 1.0, 1.0, 1.0])[:4]:
            ahead, behind = (changes(axis, state + side * step) for side in (1, -1))
            columns.append((ahead - behind)[:4] / (2 * step.max()))
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
        _, still, *filling, _ = changes(axis, (angle, 0.0, first, total - first, spool))
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


def test_leaks_run_from_the_higher_pressure_to_the_lower():
    leaky = replace(PHI, piston_leak=3e-12, valve_leak=2e-13)
    first, second = 9e6, 5e6  # Pa; the first chamber loses oil past the piston to the second
    past = 3e-12 * (first - second)
    lands = [2e-13 * ((leaky.supply - p) - (p - leaky.tank)) for p in (first, second)]
    found = flows(leaky.numbers, first, second, 0.0)
    assert found == pytest.approx((lands[0] - past, -lands[1] - past))


@every_axis
def test_compressible_follows_a_stiff_solver(axis):
    plant, commands = Compressible(axis), 0.3 * np.sin(np.arange(60) / 7)
    given = 0.005, commands, plant.rest(0.1)
    found = solved(partial(changes, axis), *given, method="LSODA", rtol=1e-9, atol=1e-12)
    assert np.all(np.abs(run(plant, *given) - found) <= [1e-7, 1e-5, 2e3, 2e3, 2e-5])


@every_axis
def test_rigid_follows_a_solver(axis):
    def slopes(y, u):
        return [float(axis.rate(y[0], y[1])), (u - y[1]) / axis.valve_lag]

    plant = Rigid(axis)
    given = 0.02, [0.4, -0.2, 0.3], plant.rest(0.1)
    found = solved(slopes, *given, rtol=1e-11, atol=1e-13, max_step=1e-3)
    np.testing.assert_allclose(run(plant, *given), found, atol=1e-7)


def test_compressible_oil_is_held_at_no_pressure_and_not_before():
    turning = 0.3  # rad/s, towards the first chamber's emptying
    for side, rate in ((2, turning), (3, -turning)):
        rates = []
        for pressure in (0.0, 0.5, 1e3):
            state = np.array([0.0, rate, 2e6, 2e6, 0.0])
            state[side] = pressure
            rates.append(changes(THETA, state)[side])
        assert rates[0] == 0 and rates[1] == pytest.approx(rates[2], rel=1e-3) and rates[1] < -1e6
    heavy = Compressible(replace(THETA, inertia=400.0, supply=60e5))
    states = run(heavy, 0.005, [1.0] * 60 + [-1.0] * 40, heavy.rest(-0.5))
    assert np.min(states[:, 2:4]) == 0


@every_axis
@pytest.mark.parametrize("plant", [Rigid, Compressible])
def test_joints_stay_at_rest_at_the_ends_of_their_stroke_too(axis, plant):
    light = replace(axis, gravity=0.0)
    for one, end in ((axis, 0.5), (light, axis.low), (light, axis.high)):
        rest = plant(one).rest(end)
        moved = run(plant(one), 0.005, [0.0] * 20, rest) - np.array(rest)
        assert np.all(np.abs(moved) <= 1e-9 * np.array([1, 1, 1e8, 1e8, 1])[: moved.shape[1]])


def test_valve_may_open_wholly_and_no_farther():
    half, whole = (PHI.loaded(0.0, 0.1, 100.0, opened) for opened in (0.5, 1.0))
    assert 1.5 * half < whole < 2 * half
    with pytest.raises(ValueError, match=r"^opened: must be at most 1; got 1\.01\.$"):
        PHI.loaded(0.0, 0.1, 100.0, 1.01)


@every_axis
def test_angles_outside_the_stroke_are_refused(axis):
    # Volumes were negative there, and frequencies complex.
    for angle in (1.5, axis.low - 1e-9, axis.high + 1e-9):
        for call in (axis.natural_frequency, axis.swing, axis.sides, lambda q: axis.rate(q, 1.0),
                     Compressible(axis).linear, Rigid(axis).rest):  # fmt: skip
            with pytest.raises(ValueError, match=r"^(angle|position): must lie within the stroke"):
                call(angle)


def test_axes_have_their_rated_flow_at_35_bar_and_their_damping_nearest_to_angle_0():
    lift, swing = reference_axes(replace(REFERENCE_MACHINE, theta_min=0.1))
    assert lift.resonance(lift.low).damping == pytest.approx(0.15)
    assert 60e3 * swing.flow * np.sqrt(35e5) == pytest.approx(4.0)


@pytest.mark.parametrize(("change", "said"), [
    ({"tank": THETA.supply}, "tank: must be below the supply"),
    ({"gravity": 1e5}, "supply: must move the weight both ways"),
    ({"gravity": -1e5}, "supply: must move the weight both ways"),
])  # fmt: skip
def test_hydraulics_refuse_sizes_that_do_not_fit_each_other(change, said):
    with pytest.raises(ValueError, match=f"^{said}"):
        replace(THETA, **change)
