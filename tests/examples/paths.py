"""Examples for the room paths."""

from tunneller_lib.paths import CHORD_PATHS, ConeChord, geodesic_inverse
from tunneller_lib.paths.chord_paths import ChordPath
from tunneller_lib.paths.circuit import Circuit
from tunneller_lib.paths.direct_problem import GeodesicPoints
from tunneller_lib.paths.inverse_problem import Geodesic
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg, Torus

_GEODESIC = geodesic_inverse(Torus(0.08, 0.8), (0.3, 0.2), [(-0.4, 0.1), (0.5, -0.6)])

INSTANCES = {
    ChordPath: CHORD_PATHS["one-third rule"],
    Circuit: Circuit(REFERENCE_MACHINE, Egg(0.5)),
    ConeChord: ConeChord(1.0, 1.0, 0.5, 0.25),
    Geodesic: _GEODESIC,
    GeodesicPoints: _GEODESIC.points(3),
}

_ENDS = {"p": (0.3, 0.2), "q": (-0.4, 0.1)}

CALLS = {
    "ChordLaw.gap": {"u": [0.0, 0.5, 1.0]},
    "ChordPath.__call__": {"t": [0.0, 0.5, 1.0]},
    "Circuit.path_overbreak": {"s": (0.0, 0.5, 1.0)},
    "GeodesicPoints.deviation": {"position": [(0.3, 0.2), (0.1, 0.1)]},
    "competing_geodesics": _ENDS,
    "corrected_chord": _ENDS,
    "geodesic_inverse": _ENDS,
    "path_length": _ENDS,
    "project_chord": _ENDS,
}  # fmt: skip
