"""Functions that callers give to the envelopes: nonsense that they answer is told in a sentence."""

import numpy as np
import pytest

from tunneller_lib.envelopes import (
    adapted_frames,
    families,
    hyperosculating_cones,
    jet_variables,
    model_jet,
    recognise,
)
from tunneller_lib.envelopes.developable import curve_derivatives, osculating_cone, tangent_planes
from tunneller_lib.envelopes.isotropic import isotropic_derivatives, surface_points
from tunneller_lib.envelopes.jet import Jet

S, T = np.random.default_rng(0).uniform(0.2, 0.8, (2, 14))
NONSENSE = {
    "nothing": None,
    "a word": "abc",
    "a set": {1.0, 2.0},
    "words": ["a", "b", "c"],
    "nothings": [None, None, None],
    "complex numbers": [1j, 2j, 3j],
    "a wrong shape": [np.ones(5), np.ones(5), np.ones(5)],
    "ragged lists": [[1.0], [1.0, 2.0], [1.0]],
    "a masked array": [np.ma.masked_array([1.0], [1]), 1.0, 1.0],
    "four numbers": [1.0, 2.0, 3.0, 4.0],
    "jets of other points": [*jet_variables(np.ones(3), 1.0), 1.0],
    "a complex jet": [Jet(np.ones((15, 14), dtype=complex)), 1.0, 1.0],
    "the class itself": Jet,
}
DOORS = {
    "surface, space": lambda f: hyperosculating_cones(f, S, T, half_angle=0.5, model="space"),
    "surface, graph": lambda f: hyperosculating_cones(f, S, T, half_angle=0.5),
    "surface, recognised": lambda f: recognise(f, S, T, "ruled", model="space"),
    "surface, frames": lambda f: adapted_frames(f, S, T, "space"),
    "surface, model": lambda f: model_jet(f, S, T),
    "f": lambda f: surface_points(f, S, T),
    "curve": lambda f: curve_derivatives(f, S),
    "curve, planes": lambda f: tangent_planes(f, S),
    "curve, cone": lambda f: osculating_cone(f, S),
    "motion": lambda f: families.moving_cone(f, 0.3)(S, T),
    "motion, jets": lambda f: families.moving_cone(f, 0.3)(*jet_variables(S, T)),
    "curve, channel": lambda f: families.channel(f, 0.3)(S, T),
    "curve, tangents": lambda f: families.tangent_lines(f)(S),
    "lines": lambda f: families.ruled(f)(*jet_variables(S, T)),
    "vertex": lambda f: families.turning(f, f, 0.3)(S),
}
ARITY = {"curve": 1, "motion": 1, "lines": 1, "vertex": 1, "surface": 2, "f": 2}
every_door = pytest.mark.parametrize("door", DOORS)


@every_door
@pytest.mark.parametrize("what", NONSENSE)
def test_nonsense_that_a_function_answers_is_refused_in_a_sentence(door, what):
    name = door.partition(",")[0]
    with pytest.raises(ValueError, match=rf"^{name}: must return [^\n]*; got [^\n]*\.$"):
        DOORS[door](lambda *given: NONSENSE[what])


@every_door
@pytest.mark.parametrize(
    "what",
    [None, 1.0, "f", int, len, lambda: 0, lambda a, b, c: 0],
    ids=["None", "1.0", "f", "int", "len", "of none", "of three"],
)
def test_what_is_no_function_of_so_many_variables_is_refused(door, what):
    name = door.partition(",")[0]
    wanted = {1: "one argument", 2: "2 arguments"}[ARITY[name]]
    with pytest.raises(ValueError, match=rf"^{name}: must be a function of {wanted}; got .*\.$"):
        DOORS[door](what)


@every_door
def test_what_a_function_raises_itself_passes_through(door):
    def faulty(*given):
        return {}["no such key"]

    with pytest.raises(KeyError, match="no such key"):
        DOORS[door](faulty)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_constant_that_is_no_surface_is_told_from_a_wrong_call(value):
    """The answer's kind is right, only there is no surface: so say the states, or a sentence."""
    cones = hyperosculating_cones(lambda s, t: value + 0 * s, S, T, half_angle=0.5)
    assert set(cones.state) <= {"outside", "singular"} and not len(cones.vertex)
    with pytest.raises(ValueError, match=r"^surface: must "):
        model_jet(lambda s, t: [value, s, t], S, T)
    with pytest.raises(ValueError, match=r"^curve: must "):
        curve_derivatives(lambda s: [value, s, s], S)


def test_derivatives_need_unit_normals():
    for n in (2 * np.eye(3)[0], (1 + 1e-5) * np.eye(3)[2]):
        with pytest.raises(ValueError, match=r"^n: must have the length 1; got one that hasn't\.$"):
            isotropic_derivatives(np.zeros(3), n)
