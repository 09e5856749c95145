"""Examples for the room replica."""

import numpy as np

from tunneller_lib.envelopes.jet import Jet, jet_variables
from tunneller_lib.replica import rod_cases, rod_methods
from tunneller_lib.surfaces import Torus

_x, _y = jet_variables(0.3, -0.2)
_LINES = rod_cases.vertical_lines(np.random.default_rng(1), 3)

INSTANCES = {
    Jet: np.sin(2 * _x) * np.cos(_y) + 0.3 * _x * _y**2,
    Torus: Torus(0.08, 0.8),
    np.random.Generator: np.random.default_rng(1),
}

CALLS = {
    "interpolators.listing": {"t1": 0.0, "t2": 10.0, "T": 1.0},
    "quartics.line_quartic": {"b": (1.0, 2.0, 3.0)},
    "quartics.meet_line": {"b": (1.0, 2.0, 3.0)},
    "rod_exact.judge": {"found": rod_methods.slab(*_LINES), "lines": _LINES, "margin": 1e-9},
    "rod_exact.rounding": {"found": rod_methods.slab(*_LINES), "lines": _LINES},
}
