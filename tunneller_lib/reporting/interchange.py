"""Files for others: knots and set-values as CSV, the wall as STL and VTP, the section as DXF.

Tables and VTP are in metres, radians and whole counts; STL and DXF, which carry no unit, are in
millimetres as most programs take them.
"""

import json
import re
from html import escape
from pathlib import Path

import matplotlib
import numpy as np
import PIL.Image
import pyvista

from ..arrays import instance
from ..motion.export import csv
from ..ream import Plan, standing
from ..surfaces import Arc, Section
from .files import beside
from .style import ERROR_MAP

JOINTS = "theta", "phi"
MM = 1000.0
# The viewer takes the page's element of the class content, or else all of its body.
PAGE = """<body>
    <main class="content" role="img" aria-label="{0}" style="width: 100vw; height: 100vh"></main>
    <p style="position: fixed; left: 1em; bottom: 0; color: #444; pointer-events: none">
      {0}. Drag to turn, turn the wheel to zoom, drag with shift to move.
    </p>"""
WHOLE_TURN = 2 * np.pi - 1e-9  # from here on an arc is a circle, in rad


def knots_csv(plan):
    """Return the knots of a plan as a table: arc lengths in m and joint positions in counts."""
    circuit = instance("plan", plan, Plan).circuit
    counts = np.rint(circuit.position(plan.knots) / plan.count).astype(np.int64)
    places = [[repr(float(s))] for s in plan.knots]
    what = "knots: s in m along the offset section, theta and phi in counts"
    return _described(plan, what, _columns(["knot", "s", *JOINTS], places, counts))


def setpoints_csv(plan):
    """Return the set-points of a lap as a table, whole numbers: ticks of each move and its end.

    The first row, of no ticks, is where the lap begins; `motion.polyline` makes the set-values.
    """
    ticks = np.append(0, instance("plan", plan, Plan).ticks)[:, None].tolist()
    what = "set-points of a lap: ticks of the move to each, theta and phi in counts"
    return _described(plan, what, _columns(["setpoint", "ticks", *JOINTS], ticks, plan.counts))


def setvalues_csv(plan):
    """Return the set-values of a lap as a table, whole numbers: tick and joint positions."""
    values = np.rint(instance("plan", plan, Plan).setvalues / plan.count).astype(np.int64)
    what = "set-values of a lap: theta and phi in counts"
    return _described(plan, what, csv(values, JOINTS).replace(" ", ","))


def _columns(names, left, counts):
    """Return numbered rows under their heading, parted by commas."""
    rows = ([i, *a, *b] for i, (a, b) in enumerate(zip(left, counts.tolist())))
    return "".join(",".join(map(str, row)) + "\n" for row in (names, *rows))


def _described(plan, what, text):
    """Return a table under the lines that say what it is."""
    return "".join(f"# {line}\n" for line in (
        what, f"tick_s = {plan.tick!r}", f"count_rad = {plan.count!r}", f"laps = {plan.laps}",
        f"advance_m = {plan.advance!r}",
    )) + text  # fmt: skip


def read_csv(text):
    """Return a table as it was written: by `knots_csv`, `setpoints_csv` or `setvalues_csv`.

    Parameters
    ----------
    text : str
        Lines of ``# name = value``, a heading, rows of numbers.

    Returns
    -------
    about : dict of str to float
        What the head says: ``tick_s``, ``count_rad``, ``laps``, ``advance_m``.
    columns : dict of str to (n,) int or float
        By their names.

    Raises
    ------
    ValueError
        If a row has another length than the heading, or holds no numbers.
    """
    head = [line[2:].split(" = ") for line in text.splitlines() if line.startswith("# ")]
    about = {name: float(value) for name, value in (pair for pair in head if len(pair) == 2)}
    lines = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    for number, row in enumerate(lines[1:], start=1):
        if len(row) != len(lines[0]):
            raise ValueError(f"text: row {number} has {len(row)} numbers under {len(lines[0])} "
                             "names.")  # fmt: skip
    return about, {name: _numbers(name, cells) for name, *cells in zip(*lines)}


def _numbers(name, cells):
    """Return the cells of a column as whole numbers, or else as numbers."""
    for kind in (np.int64, np.float64):
        try:
            return np.array(cells, dtype=str).astype(kind)
        except ValueError:
            continue
    raise ValueError(f"text: column {name} must hold numbers; got {cells[:3]}.")


def wall_solid(wall):
    """Return the ground that stands as a closed body, for a printer or a CAD program.

    Parameters
    ----------
    wall : DexelGrid
        The ground round a tunnel, on rays, not cut through.

    Returns
    -------
    mesh : pyvista.PolyData
        Triangles facing outwards, in m: wall, back of the modelled ground, ends at the first and
        the last rays. Ground that the cutter has undercut is left out.
    """
    inner, (n, m) = standing(wall), wall.low.shape[1:]
    back = wall.high.max(axis=0)
    outer = np.stack([inner[..., 0], back * wall.lines.cos, back * wall.lines.sin], axis=-1)
    k = np.arange(2 * n * m).reshape(2, n, m)
    sheets = [(k[0], -1), (k[1], 1), (k[:, 0], 1), (k[:, -1], -1)]
    faces = []
    for sheet, side in sheets:
        near, far = sheet[:-1], sheet[1:]
        a, b, c, d = near, np.roll(near, -1, 1), np.roll(far, -1, 1), far
        for corners in ((a, b, c), (a, c, d)):
            faces.append(np.stack(corners[::side], axis=-1).reshape(-1, 3))
    points = np.concatenate([inner.reshape(-1, 3), outer.reshape(-1, 3)])
    return pyvista.PolyData.from_regular_faces(points, np.concatenate(faces))


def dxf(curves):
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
        If a curve is no Section.
    """
    pairs = [(999, "by tunneller_lib, in millimetres"), (0, "SECTION"), (2, "ENTITIES")]
    for layer, section in curves.items():
        for piece in instance("curves", section, Section).arcs:
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


def write(path, content):
    """Write a text, a mesh, a scene or the pictures of an animation, whole or not at all.

    Parameters
    ----------
    path : path-like
        Its suffix says how: .stl for a mesh in m, written in mm; .vtp for a mesh as it is; .html
        for a scene that turns without a network; .png for a picture, .gif for several; others for
        text.
    content : str, pyvista.PolyData, pyvista.Plotter, (n, m, 3) uint8 or iterable of them
        What.

    Returns
    -------
    path : pathlib.Path
        Where it is now.
    """
    writers = {".stl": _stl, ".vtp": _vtp, ".html": _html, ".png": _png, ".gif": _gif}
    path = Path(path)
    with beside(path) as new:
        writers.get(path.suffix, _text)(new, content)
    return path


def _text(path, text):
    path.write_text(text, newline="\n")


def _stl(path, mesh):
    mesh.scale(MM, inplace=False).save(path, binary=True)


def _vtp(path, mesh):
    mesh.save(path, binary=True)


def _html(path, plotter):
    page, title = plotter.trame.export_html(None).getvalue(), escape(plotter.title)
    for bar in plotter.scalar_bars.values():  # the viewer has a word of its own for them all
        page = page.replace('"Below"', json.dumps(bar.GetBelowRangeAnnotation() or "below"))
    plotter.close()
    page = re.sub("<title>.*?</title>", f"<title>{title}</title>", page, count=1)
    page = page.replace("<body>", PAGE.format(title), 1)
    # The viewer inside asks its makers' site for the icon of the page; nothing else is loaded.
    _text(path, re.sub(r"https://kitware\.github\.io/[^`\"']*", "data:,", page))


def _png(path, pixels):
    PIL.Image.fromarray(pixels).save(path, optimize=True)


def _gif(path, pictures, milliseconds=80):
    """Write pictures in 255 colours, those of the error scale and of the last picture's rest."""
    pictures = [PIL.Image.fromarray(pixels) for pixels in pictures]
    scale = matplotlib.colormaps[ERROR_MAP](np.linspace(0, 1, 64), bytes=True)[:, :3]
    others = pictures[-1].quantize(190, dither=PIL.Image.Dither.NONE).getpalette()
    others = np.reshape(others, (-1, 3))
    others = others[others.max(axis=1) < 248]  # nothing that white paper would be mistaken for
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *np.concatenate([scale, others]).ravel().tolist()])
    pictures = [p.quantize(palette=palette, dither=PIL.Image.Dither.NONE) for p in pictures]
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0)
