"""Sections as a drawing in DXF, in millimetres, as most programs read it."""

import numpy as np

from ..surfaces import Arc

MM = 1000.0
WHOLE_TURN = 2 * np.pi - 1e-9  # rad, the sweep from which on an arc is a circle
# R12 has no units. Later programs read $INSUNITS all the same; 4 stands for millimetres.
HEADER = [(0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009")]
HEADER += [(9, "$INSUNITS"), (70, 4), (0, "ENDSEC")]


def dxf(curves):
    """Return sections, a dict by the names of their layers, as a drawing in DXF (R12).

    Arcs stay arcs and lines stay lines. X is the section's y (left), Y its z (up), in millimetres:
    the section as seen when facing the machine.
    """
    pairs = [(999, "by tunneller_lib, in millimetres"), *HEADER, (0, "SECTION"), (2, "ENTITIES")]
    for layer, section in curves.items():
        for piece in section.arcs:
            kind, numbers = _entity(piece)
            pairs += [(0, kind), (8, layer)]
            pairs += [(code, repr(float(number))) for code, number in numbers.items()]
    pairs += [(0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code:3d}\n{value}\n" for code, value in pairs)


def _entity(piece):
    """Return an entity's kind, and its numbers in mm and degrees by their group codes."""
    if not isinstance(piece, Arc):
        (y, z), (to_y, to_z) = MM * piece.locate(np.array([0.0, piece.length]))[0]
        return "LINE", {10: y, 20: z, 30: 0.0, 11: to_y, 21: to_z, 31: 0.0}
    about = {10: MM * piece.y, 20: MM * piece.z, 30: 0.0, 40: MM * piece.radius}
    if piece.sweep >= WHOLE_TURN:
        return "CIRCLE", about
    ends = np.degrees([piece.start, piece.start + piece.sweep]) % 360
    return "ARC", {**about, 50: ends[0], 51: ends[1]}
