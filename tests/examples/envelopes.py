"""Examples for the room envelopes: its callers' functions are sane ones of jets."""

import numpy as np

from tunneller_lib.envelopes import ConePose, fit_surface, hyperosculating_cones, jet_variables
from tunneller_lib.envelopes.families import cubic, cyclide, helix, saddle, turning
from tunneller_lib.envelopes.hyperosculate import TouchingCone
from tunneller_lib.envelopes.jet import Jet
from tunneller_lib.envelopes.measured import Fit

RNG = np.random.default_rng(1)
S, T = RNG.uniform(0.2, 0.8, (2, 14))
BALL = RNG.uniform(0.3, 0.9, (260, 3))
BALL /= np.linalg.norm(BALL, axis=1, keepdims=True)
MEASURED = {"contact": BALL, "n": BALL, "contact_error": 0.0, "normal_error": 1e-6}


def graph(s, t):
    return [s, t, s * s - t * t + 0.3 * s**3 * t]


def edge(s):
    return cubic(s, bend=0.8)[0]


INSTANCES = {
    ConePose: ConePose((0.3, -0.2, 1.0), (1.0, 2.0, 2.0), 0.4, near=0.5, far=2.0),
    Fit: fit_surface(**MEASURED),
    Jet: cyclide(*jet_variables(0.5, 0.3)),
    TouchingCone: hyperosculating_cones(cyclide, 0.5, 0.3, half_angle=0.5)[0],
    np.random.Generator: RNG,
}

CALLS = {
    "Fit.surface": {"x": 0.1, "y": -0.2},
    "adapted_frames": {"surface": graph, "model": "space"},
    "isotropic.conic": {"centre": (0.4, -0.7)},
    "isotropic.cone_vertex": {"centre": (0.4, -0.7)},
    "isotropic.osculating_conic": {"centre": (0.4, -0.7)},
    "developable.curve_derivatives": {"curve": edge},
    "developable.osculating_cone": {"curve": edge},
    "developable.tangent_planes": {"curve": edge},
    "families.channel": {"curve": helix},
    "families.moving_cone": {"motion": turning(edge, edge, 0.8), "half_angle": 0.3},
    "families.ruled": {"lines": saddle},
    "families.swept_ball": {"path": lambda s: helix(s)[:2]},
    "families.tangent_lines": {"curve": helix},
    "families.turning": {"vertex": edge, "velocity": edge},
    "fit_surface": MEASURED,
    "frames_along": {"surface": graph},
    "hyperosculating_cones": {"surface": cyclide},
    "isotropic.surface_points": {"f": cyclide},
    "model_jet": {"surface": graph},
    "recognise": {"surface": cyclide, "s": S, "t": T, "kind": "cone"},
}
