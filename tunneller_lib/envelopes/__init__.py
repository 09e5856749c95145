"""Envelopes of moving cones: which surfaces are some, and which cones hyperosculate a surface."""

from . import developable, families, isotropic
from .adapted import adapted_frames, model_jet
from .cone_pose import ConePose
from .hyperosculate import hyperosculating_cones
from .jet import jet_variables
from .measured import fit_surface
from .recognition import recognise

__all__ = [
    "ConePose",
    "adapted_frames",
    "developable",
    "families",
    "fit_surface",
    "hyperosculating_cones",
    "isotropic",
    "jet_variables",
    "model_jet",
    "recognise",
]
