"""Tunnelling robot, section 2: the tunnel, Fig. 4.

`printed` is always the form that the document prints. Where it is wrong, a counterexample shows
it, the corrected form is proved, and the library is held against what was proved. The verdicts
stand in report/ledger/tunneller.toml.
"""

import numpy as np
import sympy as sp

from tests.symbols_tunneller import close
from tunneller_lib.surfaces import Egg

READS = ["report/ledger/*"]


def test_standard_section(judge):
    judge("standard-section", missing="the standards of the world's sewers since 1850")
    # One size gives all of the printed section: box and area scale with it.
    for a in (0.1, 0.5, 3.0):
        width, height = np.ptp(Egg(a).box, axis=0)
        assert close([width, height], [2 * a, 3 * a], a)
        assert round(Egg(a).area / a**2, 3) == 4.594


def test_fig4_section(judge):
    size = sp.symbols("a", positive=True)
    roof, wall, floor = size, 3 * size, size / 2
    # C1: the centres of two blended arcs lie on one line with their common point.
    offset, drop = sp.symbols("offset drop", positive=True)
    drop_from = offset**2 + drop**2 - (wall - floor) ** 2
    centres = sp.solve([offset - (wall - roof), drop_from], [offset, drop])
    assert centres == [(2 * size, 3 * size / 2)]  # with 5a/2: a triangle 3-4-5
    # The wall's arc goes on in the floor's: their common point lies on both centres' line.
    blend = sp.Matrix([2 * size, 0]) + wall * sp.Matrix([-4, -3]) / 5
    assert blend == sp.Matrix([-2 * size / 5, -9 * size / 5])
    wall_centre, floor_centre = sp.Matrix([2 * size, 0]), sp.Matrix([0, -3 * size / 2])
    on_both = (blend - floor_centre).norm() == floor and (blend - wall_centre).norm() == wall
    [(across, down)] = centres
    blended = across == wall - roof and sp.Matrix([across, down]).norm() == wall - floor
    box = 2 * roof, roof + down + floor  # width and height
    judge("fig4", bool(on_both and blended and box == (2 * size, 3 * size)))
