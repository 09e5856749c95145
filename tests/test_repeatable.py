"""Elementary functions that are made of sums, products, quotients and roots."""

import mpmath as mp
import numpy as np
import pytest

from tunneller_lib.kernels import repeatable

RNG = np.random.default_rng(0)
SMALL = 10.0 ** RNG.uniform(-20, 0, 300)
ANGLES = np.concatenate([SMALL, RNG.uniform(-3.9, 3.9, 300), [np.pi / 2, -np.pi]])
CASES = {
    "growth": (mp.expm1, repeatable.growth,
               np.concatenate([SMALL, RNG.uniform(0, 3, 300), RNG.uniform(0, 700, 300)])),
    "area_sine": (mp.asinh, repeatable.area_sine,
                  np.concatenate([SMALL, RNG.uniform(0, 9, 300), 1e140 * SMALL])),
    "sine": (mp.sin, lambda x: repeatable.sine_cosine(x)[0], ANGLES),
    "cosine": (mp.cos, lambda x: repeatable.sine_cosine(x)[1], ANGLES),
}  # fmt: skip


def off(found, known):
    """Return the greatest relative error of numbers, in roundings."""
    with mp.workprec(120):
        shares = [abs(mp.mpf(one) / other - 1) for one, other in zip(found, known, strict=True)]
    return float(max(shares)) / 2**-52


@pytest.mark.parametrize("name", CASES)
def test_function_is_right_to_two_roundings(name):
    exact, function, x = CASES[name]
    with mp.workprec(120):
        known = [exact(mp.mpf(one)) for one in x.tolist()]
    assert off(map(function, x.tolist()), known) < 2


def test_arctangent_is_right_to_two_roundings():
    pairs = np.stack(
        [RNG.normal(size=600) * 10.0 ** RNG.uniform(-12, 2, 600), RNG.normal(size=600)]
    )
    with mp.workprec(120):
        known = [mp.atan2(*pair) for pair in pairs.T.tolist()]
    assert off((repeatable.arctangent(*pair) for pair in pairs.T.tolist()), known) < 2


def test_hyperbolic_tangent_is_right_to_three_roundings():
    x = np.concatenate([SMALL, -SMALL, RNG.uniform(-25, 25, 3000), [0.0, 20.0, -20.0]])
    with mp.workprec(120):
        known = [mp.tanh(mp.mpf(one)) for one in x.tolist() if one]
    assert off((repeatable.tangent(one) for one in x.tolist() if one), known) < 3
    assert repeatable.tangent(0.0) == 0


@pytest.mark.parametrize("name", ["sine", "cosine"])
def test_far_angles_are_right_to_their_own_rounding(name):
    x = RNG.uniform(-1e5, 1e5, 600)
    with mp.workprec(120):
        known = [getattr(mp, name[:3])(mp.mpf(one)) for one in x.tolist()]
        off = [abs(mp.mpf(getattr(repeatable, f"{name}_of")(one)) - value)
               for one, value in zip(x.tolist(), known, strict=True)]  # fmt: skip
    assert float(max(off)) < 2 * 2**-52


@pytest.mark.parametrize("y, x", [(0, 1), (0, -1), (1, 0), (-1, 0), (0, 0)])
def test_arctangent_along_the_axes_is_exact(y, x):
    assert repeatable.arctangent(float(y), float(x)) == np.arctan2(y, x)
