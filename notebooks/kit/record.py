"""Numbers, tables and figures that a notebook shows, and that the report takes from there.

The report holds no typed result: it reads report/numbers/<notebook>.json and figures/, which the
build takes from what this module writes as it shows it.
"""

import io
import json
import math
import os
import re
import sys
from pathlib import Path

import matplotlib
import numpy as np
import PIL.Image
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from tunneller_lib.arguments import shown
from tunneller_lib.atomic_write import replacement

from .displays import RecordedTable
from .number_format import cell, decimals_of, exponent, number, significant, steady

CHECKOUT = Path(__file__).resolve().parents[2]
PREVIEW = 800  # px, the width of a figure shown in a notebook
CLOSE = 1e-6  # relative difference below which no order is recorded
# One for all drawings, as this matplotlib has it: it remembers what it has set.
MATHTEXT = FigureCanvasAgg(Figure()).get_renderer().mathtext_parser
MOVED = {"format": "png", "compress_level": 1}  # of pictures that the next one replaces
PRINTED = 1950  # px, the width of the text, 16.4 cm, at 300 dpi
# The lowest two bits of a colour, which nobody sees, are noise in a shaded scene: with all of them
# set a picture takes half of the bytes, and white stays white.
LOWEST = 3
# Numbers that place something in a drawing, in points; a hundredth of one is 4 micrometres.
PLACES = re.compile(r'\b[dxy]="[^"]*"|translate\([^)]*\)|<rect [^>]*>')
FINE = re.compile(r"-?\d+\.\d{3,}")
# Fonts for a page whose reader lacks a drawing's own.
ALIKE = {"'DejaVu Sans'": "Verdana", "'STIXGeneral'": "'Times New Roman', serif"}
# Names of clips, markers, hatches and clouds. matplotlib takes them from places in full, whose last
# bits differ from run to run, since its solver of layouts adds in the order of memory.
DIGESTS = re.compile(r'(?<=[#"])([phm]|image)[0-9a-f]{10}(?=[)"])')


class Show:
    """What shows the results of one notebook, and records them for the report.

    Parameters
    ----------
    notebook : str
        Name of the notebook, without its suffix.

    Notes
    -----
    Results go to the folder named by ``TUNNELLER_RESULTS``, which the build sets, or else to
    build/lab: a notebook run by hand changes no committed file. Each call writes at once, and a
    file is never seen half-written.

    Examples
    --------
    >>> show = Show("02_torus")
    >>> show("length of the arm", 1.0987, "m", digits=3)
    length of the arm: 1.10 m
    >>> show("residual, worst", 3.1e-14, "m", below=1e-12)
    residual, worst: at most 1e-12 m
    >>> show.order("arm against leg", 1.0987, 1.2)
    arm against leg: less
    """

    def __init__(self, notebook):
        self.notebook = _file_name(notebook)
        self.root = Path(os.environ.get("TUNNELLER_RESULTS", CHECKOUT / "build" / "lab"))

    def __call__(self, name, value, unit, *, digits=None, below=None):
        """Print a number after its name.

        Parameters
        ----------
        name : str
            What the number is; the report asks for it by this name.
        value : int or float, of Python or numpy
            The number, in that unit.
        unit : str
            Unit as printed, such as ``"mm"`` or ``"m^3/s"``; empty for a plain number.
        digits : int, optional
            Significant digits that are printed. An integer is printed whole without it.
        below : float, optional
            For a quantity at rounding level, which differs between machines: only this bound is
            recorded, and a value that's negative or above it is refused.

        Raises
        ------
        ValueError
            If the value isn't finite or breaks its bound, or there is not one of digits and below.
        """
        value = number(name, value)
        if below is not None:
            if digits is not None:
                raise ValueError(f"{name}: give digits or below, not both.")
            below = number(f"{name}: below", below)
            if not 0 <= value <= below:
                raise ValueError(f"{name}: must lie between 0 and {below}; got {value}.")
            text = exponent(repr(below))
            entry = {"bound": below, "unit": unit, "text": text}
            said = f"at most {text}"
        else:
            said = text = significant(name, value, digits)
            stored = steady(value, decimals_of(value, digits))
            entry = {"value": stored, "unit": unit, "digits": digits, "text": text}
        self._merge("numbers", name, entry)
        print(f"{name}: {said} {unit}".strip())

    def order(self, name, first, second):
        """Print whether the first number is less or greater, so that words can be compared with it.

        Parameters
        ----------
        name : str
            What is compared with what; the report asks for it by this name.
        first, second : int or float, of Python or numpy
            The numbers, in one unit.

        Raises
        ------
        ValueError
            If one isn't finite, or they differ by less than a part in a million: then the order
            isn't the same on every machine.
        """
        first = number(f"first of {name}", first)
        second = number(f"second of {name}", second)
        if math.isclose(first, second, rel_tol=CLOSE, abs_tol=0.0):
            raise ValueError(f"{name}: must differ by {CLOSE:g} of either; got {first}, {second}.")
        order = "less" if first < second else "greater"
        self._merge("orders", name, {"order": order})
        print(f"{name}: {order}")

    def table(self, name, columns, rows, *, decimals=None):
        """Show a table, in a notebook below its headings.

        Parameters
        ----------
        name : str
            What the table is; the report asks for it by this name.
        columns : list of str
            Headings with units, such as ``"$l$ / m"``; Typst's markup is set as such.
        rows : list of lists
            Cells: numbers or text.
        decimals : list of int, optional
            Decimals printed of each column. Only floats need them.

        Raises
        ------
        ValueError
            If a row has another length than the headings, or a number isn't finite or has no
            decimals.
        """
        decimals = decimals or [None] * len(columns)
        each = [list(zip(columns, row, decimals, strict=True)) for row in rows]
        text = [[cell(name, c, d) for _, c, d in row] for row in each]
        cells = [[_stored(name, c, d) for _, c, d in row] for row in each]
        self._merge("tables", name, {"columns": columns, "rows": cells, "text": text})
        _display(RecordedTable(columns, text))

    def figure(self, picture, name, alt):
        """Show a figure and save it with its alternative text.

        Parameters
        ----------
        picture : matplotlib.figure.Figure or (n, m, 3) uint8
            A drawing, saved as SVG, or pixels, saved as PNG, no wider than print can show and
            with the lowest two bits of each colour set.
        name : str
            File name, without suffix.
        alt : str
            What the figure shows, for those who can't see it.

        Raises
        ------
        ValueError
            If there's no alternative text, or the name isn't fit for a file.
        """
        _file_name(name)
        alt = " ".join(alt.split())
        if not alt:
            raise ValueError(f"{name}: needs an alternative text.")
        seen = preview(picture, alt)
        if isinstance(picture, matplotlib.figure.Figure):
            suffix = ".svg"
            layout = picture.get_layout_engine()
            picture.set_layout_engine("none")  # the file keeps the places of the preview
            content = drawing_svg(picture)
            picture.set_layout_engine(layout)
        else:
            suffix = ".png"
            content = _encoded(_narrowed(picture, min(PRINTED, picture.shape[1])) | LOWEST)
        _replace(self.root / "figures" / (name + suffix), content)
        self._merge("figures", name, {"file": name + suffix, "alt": alt})
        _display(seen)

    def _merge(self, kind, name, entry):
        if not name.isprintable():
            raise ValueError(f"name: must be of one line; got {shown(name)}.")
        file = self.root / "report" / "numbers" / f"{self.notebook}.json"
        content = json.loads(file.read_text()) if file.exists() else {}
        content.setdefault(kind, {})[name] = entry | _place()
        text = json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
        _replace(file, (text + "\n").encode())


def preview(picture, alt=""):
    """Return a picture as a notebook shows it.

    Parameters
    ----------
    picture : matplotlib.figure.Figure or (n, m, 3) uint8
        A drawing, which keeps the resolution of what is shown, or pixels.
    alt : str
        What it shows, for those who can't see it.

    Returns
    -------
    preview : IPython.display.Image
        800 pixels wide.
    """
    from IPython.display import Image  # drawings need no IPython: the extra [picture] has none

    drawn = isinstance(picture, matplotlib.figure.Figure)
    small = _drawing_preview(picture) if drawn else _encoded(_narrowed(picture, PREVIEW))
    return Image(small, format="png", width=PREVIEW, alt=alt)


def moved_preview(drawing, alt):
    """Return what `preview` does, sooner, though in more bytes: for one of many pictures."""
    from IPython.display import Image

    content = _encoded(drawing_pixels(drawing), **MOVED)
    return Image(content, format=MOVED["format"], width=PREVIEW, alt=alt)


def _display(seen):
    from IPython.display import display  # a number needs no IPython

    display(seen)


def _place():
    """Return which code cell of a notebook this runs in, or nothing, without a load of IPython.

    Run from top to bottom, the inputs so far are the code cells.
    """
    ipython = sys.modules.get("IPython")
    shell = ipython and ipython.get_ipython()
    return {"cell": len(shell.user_ns["In"]) - 1} if shell else {}


def _stored(name, value, decimals):
    return value if isinstance(value, str) else steady(number(name, value), decimals or 0)


def _file_name(name):
    if not re.fullmatch(r"[a-z0-9][a-z0-9_-]*", name):
        raise ValueError(f"name: must have only a-z, 0-9, - and _; got {shown(name)}.")
    return name


def drawing_svg(figure):
    """Return a drawing as the bytes of a file, in SVG, its places to a hundredth of a point."""
    content = io.StringIO()
    # Text as such, for search, and nothing that names the day or the run: the same bytes each time.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "tunneller"}):
        # The resolution is that of clouds of points, which a drawing may ask to be rasterized.
        figure.set_dpi(300)
        FigureCanvasSVG(figure).print_svg(content, metadata={"Date": None, "Creator": None})
    names = {}

    def named(digest):
        return names.setdefault(digest[0], f"{digest[1]}-{len(names)}")

    text = content.getvalue()
    for font, alike in ALIKE.items():
        text = text.replace(font, f"{font}, {alike}")
    text = PLACES.sub(lambda place: FINE.sub(lambda x: f"{float(x[0]):.2f}", place[0]), text)
    return DIGESTS.sub(named, text).encode()


def drawing_pixels(figure):
    """Return a drawing as the pixels (n, m, 3) that a notebook shows, 800 of them wide."""
    canvas = _canvas(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _drawing_preview(figure):
    content = io.BytesIO()
    _canvas(figure).print_png(content)
    return content.getvalue()


def _canvas(figure):
    figure.set_dpi(PREVIEW / figure.get_figwidth())
    canvas = FigureCanvasAgg(figure)  # savefig would draw twice, once for the layout
    canvas.get_renderer().mathtext_parser = MATHTEXT
    return canvas


def _encoded(pixels, format="png", **how):
    content = io.BytesIO()
    PIL.Image.fromarray(pixels).save(content, format, **how)
    return content.getvalue()


def _narrowed(pixels, width):
    height = round(width * pixels.shape[0] / pixels.shape[1])
    return np.asarray(PIL.Image.fromarray(pixels).resize((width, height)))


def _replace(path, content):
    with replacement(path) as new:
        new.write_bytes(content)
