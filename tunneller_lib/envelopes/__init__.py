"""Envelopes of moving cones: which surfaces are some, and which cones hyperosculate a surface."""

from . import blade, conics, developable, families, fit, isotropic
from .adapted import AdaptedFrames, adapted_frames, model_jet
from .cone_pose import ConePose, TouchingCone
from .hyperosculate import Cones, hyperosculating_cones
from .jet import Jet, jet_variables
from .recognition import Recognition, recognise

__all__ = [
    "AdaptedFrames",
    "ConePose",
    "Cones",
    "Jet",
    "Recognition",
    "TouchingCone",
    "adapted_frames",
    "blade",
    "conics",
    "developable",
    "families",
    "fit",
    "hyperosculating_cones",
    "isotropic",
    "jet_variables",
    "model_jet",
    "recognise",
]
