"""Envelopes of moving cones: which surfaces are some, and which cones hyperosculate a surface."""

from . import blade, conics, developable, families, fit, isotropic
from .adapted import AdaptedFrames, adapted_frames, model_jet
from .cone_pose import ConePose, TouchingCone
from .hyperosculate import Cones, hyperosculating_cones
from .jet import Jet, jet_variables
from .measured import Fit, fit_surface, recognise_measured
from .recognition import Recognition, recognise

__all__ = [
    "AdaptedFrames",
    "ConePose",
    "Cones",
    "Fit",
    "Jet",
    "Recognition",
    "TouchingCone",
    "adapted_frames",
    "blade",
    "conics",
    "developable",
    "families",
    "fit",
    "fit_surface",
    "hyperosculating_cones",
    "isotropic",
    "jet_variables",
    "model_jet",
    "recognise",
    "recognise_measured",
]
