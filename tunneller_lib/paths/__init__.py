"""Paths of the cutter's centre: projected chords, the tunnel's circuit, the cone's test case."""

from .chord_law import ChordLaw
from .chord_paths import CHORD_PATHS, SHORT_CHORD_PATHS, path_length
from .circuit import cutting_circuit
from .cone_chord import ConeChord
from .correction import corrected_chord
from .direct_problem import geodesic_direct
from .inverse_problem import competing_geodesics, geodesic_inverse
from .projection import project_chord

__all__ = [
    "CHORD_PATHS",
    "SHORT_CHORD_PATHS",
    "ChordLaw",
    "ConeChord",
    "competing_geodesics",
    "corrected_chord",
    "cutting_circuit",
    "geodesic_direct",
    "geodesic_inverse",
    "path_length",
    "project_chord",
]
