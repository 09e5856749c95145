"""Surfaces in space, shaded on a drawing: light enough for a picture that moves."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from kit.style import COLOURS

LEVELS = 9  # of brightness; few colours keep a picture that moves small
DARKEST = 0.55  # share of a colour's brightness where a sheet is edge-on to the light
LIGHT = np.array([-0.3, 0.6, 0.75])  # towards it: to the right, up, towards the eye


def on_paper(direction):
    """Return the axes (3, 3) of a drawing: to the right, up, and towards a far eye.

    The direction (3,) leads to the eye; what is up in space is up on the paper.
    """
    eye = np.array(direction) / np.linalg.norm(direction)
    right = np.cross((0, 0, 1), eye)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right), eye])


def draw_shaded(ax, direction, sheets):
    """Draw sheets, grids (n, m, 3) by the names of their colours, as a far eye sees them.

    The direction (3,) leads to the eye. Far pieces are drawn first, so that near ones cover them.
    """
    quads, colours = [], []
    for name, grid in sheets.items():
        seen = grid @ on_paper(direction).T
        corners = np.stack([seen[:-1, :-1], seen[1:, :-1], seen[1:, 1:], seen[:-1, 1:]], axis=2)
        quads.append(corners.reshape(-1, 4, 3))
        normal = np.cross(quads[-1][:, 2] - quads[-1][:, 0], quads[-1][:, 3] - quads[-1][:, 1])
        lit = np.abs(normal @ LIGHT) / np.linalg.norm(normal, axis=1) / np.linalg.norm(LIGHT)
        bright = DARKEST + (1 - DARKEST) * np.round(lit * LEVELS) / LEVELS
        colours.append(bright[:, None] * to_rgb(COLOURS[name]))
    quads, colours = np.concatenate(quads), np.concatenate(colours)
    far_first = np.argsort(quads[..., 2].mean(axis=1))
    faces = PolyCollection(quads[far_first, :, :2], lw=0.4)
    faces.set(facecolor=colours[far_first], edgecolor=colours[far_first])
    ax.add_collection(faces)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.03)
    ax.axis("off")
