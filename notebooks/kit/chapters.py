"""The study's chapters, its notebooks: what each asks and found, their table, their map."""

import base64
import io
import json
import math
import re
import tomllib
from dataclasses import dataclass

import PIL.Image
from matplotlib.patches import FancyBboxPatch

from .displays import RAISED
from .record import CHECKOUT
from .style import COLOURS

NOTEBOOKS = CHECKOUT / "notebooks"
NEEDS = re.compile(r"\*\*You need\*\*\s+(.*?)\.(?:\s|$)", re.DOTALL)
HEADS = "", "question", "what came out", "you need", "minutes"
# Of prose and of code that are read in a minute. A reader who has calculus took 17 and 19 minutes
# for essays 64 and 65, and for chapters a quarter more than 150 words and 30 lines a minute give:
# code takes longer than prose, and these rates give all three.
WORDS = 160
LINES = 18
ACROSS = 7  # small pictures beside each other
THUMB = 1.6  # width of a small picture over its height


@dataclass(frozen=True)
class Chapter:
    """One notebook: its number, file, question, and what it found.

    Parameters
    ----------
    number : int
        Number of the notebook.
    file : str
        Its file name.
    question : str
        Its title.
    found : str
        The answer in a sentence.
    needs : str
        What a reader must know, in Markdown.
    minutes : int
        What it takes to read, up to the next five.
    """

    number: int
    file: str
    question: str
    found: str
    needs: str
    minutes: int


def read_chapters():
    """Return the chapters in order."""
    said = _contents()["found"]
    made = []
    _index, *paths = sorted(NOTEBOOKS.glob("[0-9]*.ipynb"))
    for path in paths:
        cells = _cells(path)
        opening = cells[0][1]
        question = opening.split("\n")[0].lstrip("# ")
        found = filled(path.stem, said[path.stem])
        needs = " ".join(NEEDS.search(opening)[1].split())
        number = int(path.stem[:2])
        made.append(Chapter(number, path.name, question, found, needs, _minutes(cells)))
    return made


def _cells(path):
    """Return the kind and the text of each cell of a notebook."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in cells]


def _minutes(cells):
    """Return the minutes that cells take to read, up to the next five."""
    words = sum(len(text.split()) for kind, text in cells if kind == "markdown")
    lines = sum(text.count("\n") + 1 for kind, text in cells if kind == "code")
    return 5 * math.ceil((words / WORDS + lines / LINES) / 5)


def ending(record, words=""):
    """Return what a notebook found, in the numbers that it recorded, and the ways on from it.

    Parameters
    ----------
    record : Record
        Of the notebook.
    words : str
        The finding in Markdown, with the names of recorded numbers in braces; the sentence of
        ``contents.toml`` by default.

    Returns
    -------
    ending : IPython.display.Markdown
        The finding; links to the chapter before, the index and the next.

    Examples
    --------
    >>> from kit import Record
    >>> print(ending(Record("08_cone"), "It is so.").data)
    It is so.
    <BLANKLINE>
    [00 index](00_index.ipynb) · [07 chord](07_chord.ipynb) · [09 geodesic](09_geodesic.ipynb)
    """
    index, *names = [path.stem for path in sorted(NOTEBOOKS.glob("[0-9]*.ipynb"))]
    at = names.index(record.notebook)
    near = [index, *names[max(at - 1, 0) : at], *names[at + 1 : at + 2]]
    links = " · ".join(f"[{name.replace('_', ' ')}]({name}.ipynb)" for name in near)
    sentence = words or _contents()["found"][record.notebook]
    said = filled(record.notebook, sentence, record.root)
    return _markdown(f"{said}\n\n{links}")


def filled(stem, sentence, root=CHECKOUT):
    """Return a sentence with the numbers of a notebook in place of their names in braces.

    Parameters
    ----------
    stem : str
        The notebook's name, without its suffix.
    sentence : str
        The sentence.
    root : pathlib.Path
        The folder in which the numbers lie under report/numbers.
    """
    file = root / "report" / "numbers" / f"{stem}.json"
    numbers = json.loads(file.read_text())["numbers"] if file.exists() else {}  # an essay's
    return re.sub(r"\{([^{}]+)\}", lambda name: printed(**numbers[name[1]]), sentence)


def printed(text, unit, **more):
    r"""Return a recorded number as it stands in prose: digits in groups, exponents raised.

    Parameters
    ----------
    text, unit : str
        As recorded.
    **more
        What else was recorded; a bound is said to be one.

    Examples
    --------
    >>> printed("1e-12", "m^3", bound=1e-12), printed("1078272", ""), printed("-5.0", "deg")
    ('at most 10⁻¹²\u202fm³', '1\u202f078\u202f272', '−5.0°')
    """
    mantissa, _, power = text.partition("e")
    whole, point, fraction = mantissa.partition(".")
    if len(whole.lstrip("-")) > 4:
        whole = f"{int(whole):_}".replace("_", "\u202f")
    digits = (whole + point + fraction).replace("-", "−")
    if power:
        raised = "10" + power.translate(RAISED)
        digits = raised if digits == "1" else f"{digits} · {raised}"
    shown = re.sub(r"\^(-?\d+)", lambda m: m[1].translate(RAISED), unit)
    gap = "" if unit in ("", "deg") else "\u202f"
    return ("at most " if "bound" in more else "") + digits + gap + shown.replace("deg", "°")


def contents_table():
    """Return a table of the chapters, part by part, as Markdown."""
    every = read_chapters()
    lines = []
    for part in _contents()["part"]:
        lines += [f"### {part['name']}", "", f"| {' | '.join(HEADS)} |", "|-|-|-|-|-|"]
        for c in _chapters_of(part, every):
            link = f"[{c.number:02}]({c.file})"
            lines.append(f"| {link} | {c.question} | {c.found} | {c.needs} | {c.minutes} |")
        lines.append("")
    return _markdown("\n".join(lines))


def _markdown(text):
    from IPython.display import Markdown  # drawings need no IPython: the extra [picture] has none

    return Markdown(text)


def draw_map(ax):
    """Draw the parts of the study and which builds on which.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        The drawing.
    """
    every = read_chapters()
    parts = {part["name"]: part for part in _contents()["part"]}
    arrow = {"arrowstyle": "->", "color": COLOURS["tangent sphere"], "lw": 1.2}
    arrow |= {"shrinkA": 0, "shrinkB": 2}
    for name, part in parts.items():
        x, y = part["place"]
        inside = _chapters_of(part, every)
        corner = (x - 0.38, y - 0.24)
        look = {"boxstyle": "round,pad=0.03", "fc": "white", "ec": COLOURS["cutter"]}
        ax.add_patch(FancyBboxPatch(corner, 0.76, 0.48, **look))
        numbers = f"{inside[0].number:02} to {inside[-1].number:02}"
        ax.text(x, y, f"{_two_lines(name)}\n{numbers}", ha="center", va="center")
        for other in part["follows"]:
            u, v = parts[other]["place"]
            ax.annotate("", (x - 0.41, y), (u + 0.41, v), arrowprops=arrow)
    ax.set(xlim=(-0.5, max(p["place"][0] for p in parts.values()) + 0.5), ylim=(-0.4, 2.4))
    ax.axis("off")


def draw_first_pictures(ax):
    """Draw the first picture of each chapter, small, with the chapter's number.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        The drawing.
    """
    _index, *paths = sorted(NOTEBOOKS.glob("[0-9]*.ipynb"))
    for k, path in enumerate(paths):
        picture = _first_picture(path)
        column, row = k % ACROSS, -(k // ACROSS)
        wide = min(0.88, 0.75 * picture.width / picture.height / THUMB)
        high = wide * picture.height / picture.width * THUMB
        place = (column - wide / 2, column + wide / 2, row - high / 2, row + high / 2)
        ax.imshow(picture, extent=place, aspect="auto")
        ax.text(column - 0.47, row + 0.41, path.stem[:2], va="center", fontsize=7)
    ax.set(xlim=(-0.5, ACROSS - 0.5), ylim=(-((len(paths) - 1) // ACROSS) - 0.5, 0.5))
    ax.axis("off")


def _first_picture(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    outputs = (output.get("data", {}) for cell in cells for output in cell.get("outputs", []))
    content = next((data["image/png"] for data in outputs if "image/png" in data), None)
    if content is None:
        raise ValueError(f"{path.name}: must hold a picture; run it.")
    picture = PIL.Image.open(io.BytesIO(base64.b64decode(content))).convert("RGB")
    picture.thumbnail((320, 320))
    return picture


def _two_lines(name):
    middle = min((i for i, c in enumerate(name) if c == " "), key=lambda i: abs(i - len(name) / 2))
    return f"{name[:middle]}\n{name[middle + 1 :]}"


def _chapters_of(part, every):
    first, last = part["chapters"]
    return [chapter for chapter in every if first <= chapter.number <= last]


def _contents():
    return tomllib.loads((NOTEBOOKS / "contents.toml").read_text())
