"""The section as a drawing in DXF, in millimetres, as most programs take it."""

import re
from typing import Annotated

import numpy as np

from ..arguments import Rule, checked, instance, shown
from ..surfaces import Arc, Section

MM = 1000.0
WHOLE_TURN = 2 * np.pi - 1e-9  # from here on an arc is a circle, in rad
# R12 knows no units; later programs read $INSUNITS wherever it stands, and 4 is millimetres.
HEADER = [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"),
          (9, "$INSUNITS"), (70, 4), (0, "ENDSEC")]  # fmt: skip
LAYER = re.compile(r"[A-Za-z0-9$_-]{1,31}")  # what R12 allows; a line's end would be a command


def _by_layer(name, value):
    """Return `value`, a dict of sections by the names of layers."""
    instance(name, value, dict)
    for layer, section in value.items():
        if not isinstance(layer, str) or not LAYER.fullmatch(layer):
            raise ValueError(
                f"{name}: a layer's name must be 1 to 31 letters without accents, digits, $, - "
                f"or _; got {shown(layer)}."
            )
        instance(name, section, Section)
    return value


Curves = Annotated[dict, Rule("dict of str to Section", _by_layer)]


@checked
def dxf(curves: Curves):
    """Return sections as a drawing in DXF (R12), arcs as arcs and lines as lines.

    Parameters
    ----------
    curves : dict of str to Section
        By the names of their layers. X is y (left) and Y is z (up), in millimetres: the section
        as one sees it who faces the machine.

    Returns
    -------
    text : str
        The drawing.

    Raises
    ------
    ValueError
        If a curve is no Section, or a layer's name isn't one that DXF R12 allows.
    """
    pairs = [(999, "by tunneller_lib, in millimetres"), *HEADER, (0, "SECTION"), (2, "ENTITIES")]
    for layer, section in curves.items():
        for piece in section.arcs:
            pairs += _entity(piece, layer)
    pairs += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code:3d}\n{value}\n" for code, value in pairs)


def _entity(piece, layer):
    """Return the pairs (group code, value) of an arc, a circle or a line, in mm and degrees."""
    if not isinstance(piece, Arc):
        (y, z), (to_y, to_z) = MM * piece.locate(np.array([0.0, piece.length]))[0]
        return _pairs("LINE", layer, {10: y, 20: z, 30: 0.0, 11: to_y, 21: to_z, 31: 0.0})
    about = {10: MM * piece.y, 20: MM * piece.z, 30: 0.0, 40: MM * piece.radius}
    if piece.sweep >= WHOLE_TURN:
        return _pairs("CIRCLE", layer, about)
    ends = np.degrees([piece.start, piece.start + piece.sweep]) % 360
    return _pairs("ARC", layer, {**about, 50: ends[0], 51: ends[1]})


def _pairs(kind, layer, numbers):
    named = [(0, kind), (8, layer)]
    return named + [(code, repr(float(number))) for code, number in numbers.items()]
