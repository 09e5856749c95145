"""The section's drawing, read and audited by ezdxf."""

import io

import numpy as np
import pytest

from tunneller_lib.job.drawing import dxf
from tunneller_lib.surfaces import Arc, Egg, Line, closed_profile

BEND = np.pi / 2
STADIUM = closed_profile([
    Arc(0.0, 0.0, 0.5, 0.0, np.pi), Line(-0.5, 0.0, -BEND, 0.4),
    Arc(0.0, -0.4, 0.5, np.pi, np.pi), Line(0.5, -0.4, BEND, 0.4),
])  # fmt: skip
CIRCLE = closed_profile([Arc(0.1, 0.2, 0.6, 0.0, 2 * np.pi)])


@pytest.mark.parametrize("package", ["ezdxf"])
def test_ezdxf_reads_the_drawing(package, installed, benchmark):
    curves = {"EGG": Egg(0.5), "STADIUM": STADIUM, "CIRCLE": CIRCLE}
    text = dxf(curves)
    drawing = benchmark(lambda: installed.read(io.StringIO(text)))
    audit = drawing.audit()
    assert not audit.errors and not audit.fixes
    length = {layer: 0.0 for layer in curves}
    for piece in drawing.modelspace():
        if piece.dxftype() == "LINE":
            length[piece.dxf.layer] += piece.dxf.start.distance(piece.dxf.end)
        elif piece.dxftype() == "CIRCLE":
            length[piece.dxf.layer] += 2 * np.pi * piece.dxf.radius
        else:
            sweep = (piece.dxf.end_angle - piece.dxf.start_angle) % 360
            length[piece.dxf.layer] += np.radians(sweep) * piece.dxf.radius
    for layer, section in curves.items():
        assert length[layer] == pytest.approx(1e3 * section.perimeter, rel=1e-12)
