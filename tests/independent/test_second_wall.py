"""The wall and its errors: balls on the circuit, loops stepped tick by tick, rigid motions."""

import numpy as np

from tests.independent.section import (
    BALL,
    HALF,
    HEIGHT,
    INSIDE,
    SMALL,
    beyond,
    centre,
    egg,
    even,
    joints,
)

READS = ["report/numbers/*.json"]

STEP = 0.05  # m, of the machine between laps


def test_cutter_leans_out_of_the_sections_plane(printed):
    points = centre(*joints(*egg(INSIDE).T))
    ahead = np.diff(points, axis=0)
    lean = np.arctan2(np.abs(ahead[:, 0]), np.hypot(ahead[:, 1], ahead[:, 2]))
    assert np.degrees(lean.max()) == printed("41_wall", "largest lean")


def reaches(across, every=100, count=1001):
    """Return how far the balls of two laps reach along the section's normal (n, m), in m.

    From the curve of their centres, at places of it and at distances `across` along the tunnel.
    """
    curve = centre(*joints(*egg(INSIDE, count).T))[:-1]
    found = []
    for k in range(every // 2, len(curve), every):
        ahead = curve[k + 1, 1:] - curve[k - 1, 1:]
        out = np.array([0, ahead[1], -ahead[0]]) / np.hypot(*ahead)
        near = curve[np.linalg.norm(curve - curve[k], axis=-1) < BALL]
        balls = np.concatenate([near, near - [STEP, 0, 0]]) - curve[k]
        off = balls + across[:, None, None] * [1, 0, 0]
        along = off @ out
        square = BALL**2 - np.sum(off**2, axis=-1) + along**2
        reach = np.where(square > 0, along + np.sqrt(np.maximum(square, 0)), 0)
        found.append(reach.max(axis=-1))
    return np.array(found)


def test_greatest_cusp_between_two_laps(printed):
    cusps = BALL - reaches(np.linspace(0, STEP, 101)).min(axis=-1)
    assert 1e3 * cusps.max() == printed("41_wall", "greatest cusp")


def test_volume_of_a_lap_beside_another(printed):
    """From the wall as it was to where the balls reach, summed along normals of the four arcs."""
    across = STEP * (np.arange(20) + 0.5) / 20
    bend = np.arctan2(1.5, 2)
    volume = 0.0
    for reach, radius, turn in zip(
        np.split(reaches(across, every=20), 4),
        np.array([HALF, 3 * HALF, HALF / 2, 3 * HALF]) - INSIDE,
        (np.pi, bend, np.pi - 2 * bend, bend),
        strict=True,
    ):
        ring = turn * ((radius + reach) ** 2 - (radius + INSIDE) ** 2) / 2
        volume += STEP * ring.mean()
    assert 1e3 * volume == printed("41_wall", "lap volume, closed form")


def test_arm_keeps_clear_of_the_tunnel(printed):
    theta, phi = joints(*egg(INSIDE, 1001).T)
    along = np.linspace(0, 1, 201)[:, None]
    end = centre(theta, phi)
    joint = np.stack([SMALL * np.cos(theta), 0 * theta, HEIGHT - SMALL * np.sin(theta)], axis=-1)
    arm = joint + along[..., None] * (end - joint)
    clear = -beyond(arm[..., 1], arm[..., 2]).max()
    assert 1e3 * (clear - 0.1) == printed("41_wall", "arm clearance")
    assert 1e3 * clear == printed("41_wall", "thickest arm")


def test_machine_that_stands_elsewhere(printed):
    """Every place of the circuit turned about the joint and shifted."""
    points = centre(*joints(*egg(INSIDE, 4001).T))

    def off(y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0):
        c, s = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
        about_x = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
        about_y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
        about_z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
        foot = np.array([0, 0, HEIGHT])
        moved = (points - foot) @ (about_z @ about_y @ about_x).T + foot
        away = 1e3 * beyond(moved[:, 1] + y, moved[:, 2] + z, INSIDE)
        return away.max(), -away.min()

    survey = off(y=2e-3, z=-1e-3, roll=2e-3, pitch=1e-3, yaw=-2e-3)
    assert max(survey) == printed("42_budget", "pose")
    for row, name in enumerate(("y", "z", "roll", "pitch", "yaw")):
        over, under = off(**{name: 1e-3})
        assert over == printed("42_budget", "poses", row, "over / mm")
        assert under == printed("42_budget", "poses", row, "under / mm")


# Loops on a lap at 60 mm/s, in ticks of 5 ms

TICK, FEED, LAG = 0.005, 0.06, 0.02  # s, m/s, s


def lap():
    """Return joint angles (2, n) at the ticks of a lap, from rest and to it at 0.5 m/s^2."""
    points = egg(INSIDE, 20_001)
    moves = np.linalg.norm(np.diff(centre(*joints(*points.T)), axis=0), axis=-1)
    way = np.append(0, np.cumsum(moves))
    ramp = FEED / 0.5
    whole = way[-1] / FEED + ramp
    time = TICK * np.arange(int(whole / TICK) + 200)
    gone = np.minimum(time, ramp) ** 2 * 0.25 + FEED * np.clip(time - ramp, 0, whole - 2 * ramp)
    gone += FEED * np.clip(time - whole + ramp, 0, ramp)
    gone -= np.clip(time - whole + ramp, 0, ramp) ** 2 * 0.25
    at = np.stack([np.interp(gone, way, axis) for axis in points.T])
    return np.stack(joints(*at))


def off_the_wall(gains, share, wanted):
    """Return over- and underbreak, in mm, of loops that answer a tick late.

    The valve of each joint is told its rate, gain times the error and a share of the set rate, and
    takes it with a lag.
    """
    place = wanted[:, 0].copy()
    rate = told = np.zeros(2)
    kept = np.exp(-TICK / LAG)
    places = [place]
    for k in range(wanted.shape[1] - 1):
        next_told = np.array(gains) * (wanted[:, k] - place)
        next_told += share * (wanted[:, k + 1] - wanted[:, k]) / TICK
        place = place + told * TICK + LAG * (1 - kept) * (rate - told)
        rate = told + kept * (rate - told)
        told = next_told
        places.append(place)
    theta, phi = np.transpose(places)
    points = centre(theta, phi)
    off = 1e3 * beyond(points[:, 1], points[:, 2], INSIDE)
    return max(off.max(), 0), max(-off.min(), 0)


def test_following_errors_on_the_wall(printed):
    wanted = lap()
    assert off_the_wall((10, 10), 0, wanted)[1] == printed("42_budget", "P loop, equal gains")
    assert off_the_wall((10, 8), 0, wanted)[1] == printed("42_budget", "P loop, unequal gains")
    assert off_the_wall((10, 10), 1, wanted)[0] == printed("42_budget", "following")


def test_best_gain_of_loops_without_feed_forward(printed):
    wanted = lap()
    gains = np.arange(16, 21)
    left = [max(off_the_wall((gain, gain), 0, wanted)) for gain in gains]
    assert gains[np.argmin(left)] == printed("43_better", "best Kv of P")
    assert min(left) == printed("43_better", "best P loop")


def slopes(points):
    """Return how far a radian of each joint moves the centre out of the curve (2, n), in m."""
    theta, phi = joints(*points.T)

    def off(more, swung):
        return beyond(*centre(theta + more, phi + swung)[..., 1:].T, INSIDE)

    h = 1e-6
    return np.array([off(h, 0) - off(-h, 0), off(0, h) - off(0, -h)]) / (2 * h)


def test_counts_leave_a_uniform_rounding_of_both_joints(printed):
    count = 2 * np.pi / 2**16
    square = np.mean(np.sum(slopes(even(egg(INSIDE), 4001)) ** 2, axis=0))
    closed = 1e3 * count * np.sqrt(square / 12)
    assert closed == printed("42_budget", "faults", "counts, rms", "closed form")
