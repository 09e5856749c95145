"""Envelopes of moving cones: which surfaces are some, and which cones hyperosculate a surface."""

from .hyperosculate import Cones, hyperosculating_cones
from .recognise import Recognition, recognise

__all__ = ["Cones", "Recognition", "hyperosculating_cones", "recognise"]
