"""Paths of the cutter's centre: projected chords, the tunnel's circuit, the cone's test case."""

from .chord_paths import CHORD_PATHS, one_third_rule, path_length
from .circuit import Circuit, cutting_circuit
from .cone_chord import ConeChord
from .geodesic import geodesic_direct
from .geodesic_inverse import competing_geodesics, geodesic_inverse
from .projection import project_chord, projected_length

__all__ = [
    "CHORD_PATHS",
    "Circuit",
    "ConeChord",
    "competing_geodesics",
    "cutting_circuit",
    "geodesic_direct",
    "geodesic_inverse",
    "one_third_rule",
    "path_length",
    "project_chord",
    "projected_length",
]
