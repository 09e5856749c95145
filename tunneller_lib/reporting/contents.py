"""The study's table of contents, from its notebooks and what they recorded."""

import json
import re
import tomllib
from dataclasses import dataclass

from IPython.display import Markdown
from matplotlib.patches import FancyBboxPatch

from .record import CHECKOUT
from .style import COLOURS

NOTEBOOKS = CHECKOUT / "notebooks"
CONTENTS = "contents.toml"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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
    """

    number: int
    file: str
    question: str
    found: str

    @property
    def link(self):
        """The chapter's number as a link in Markdown."""
        return f"[{self.number:02}]({self.file})"


def chapters(folder=NOTEBOOKS):
    """Return the chapters in order.

    Parameters
    ----------
    folder : pathlib.Path
        The folder with the notebooks and ``contents.toml``.

    Raises
    ------
    ValueError
        If a sentence asks for a number that its notebook doesn't record.
    """
    said = _contents(folder)["found"]
    made = []
    for path in sorted(folder.glob("[0-9]*.ipynb")):
        if number := int(path.stem[:2]):
            text = "".join(json.loads(path.read_text())["cells"][0]["source"])
            question = text.split("\n")[0].lstrip("# ")
            found = filled(path.stem, said[path.stem], folder.parent)
            made.append(Chapter(number, path.name, question, found))
    return made


def ending(record):
    """Return what a notebook found, in the numbers that it recorded, and the ways on from it.

    Parameters
    ----------
    record : Record
        Of the notebook.

    Returns
    -------
    ending : IPython.display.Markdown
        The sentence of ``contents.toml``; links to the chapter before, the index and the next.
    """
    names = [path.stem for path in sorted(NOTEBOOKS.glob("[0-9]*.ipynb"))]
    at = names.index(record.notebook)
    near = dict.fromkeys([names[0], names[at - 1], *names[at + 1 : at + 2]])
    ways = " · ".join(f"[{name.replace('_', ' ')}]({name}.ipynb)" for name in near)
    said = filled(record.notebook, _contents(NOTEBOOKS)["found"][record.notebook], record.root)
    return Markdown(f"{said}\n\n{ways}")


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

    Raises
    ------
    ValueError
        If the notebook doesn't record a number of that name.
    """
    file = root / "report" / "numbers" / f"{stem}.json"
    numbers = json.loads(file.read_text())["numbers"]

    def told(match):
        if match[1] not in numbers:
            raise ValueError(f"{stem}: records no number {match[1]!r}.")
        return printed(**numbers[match[1]])

    return re.sub(r"\{([^{}]+)\}", told, sentence)


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


def contents_table(folder=NOTEBOOKS):
    """Return a table of the chapters, part by part, as Markdown; the folder is as in `chapters`."""
    every, lines = chapters(folder), []
    for part in _contents(folder)["part"]:
        if inside := _chapters_of(part, every):
            lines += [f"### {part['name']}", "", "| | question | what came out |", "|-|-|-|"]
            lines += [f"| {c.link} | {c.question} | {c.found} |" for c in inside] + [""]
    return Markdown("\n".join(lines))


def draw_map(ax, folder=NOTEBOOKS):
    """Draw the parts of the study and which builds on which.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    folder : pathlib.Path
        The folder with the notebooks and ``contents.toml``.

    Returns
    -------
    boxes : list of matplotlib.patches.FancyBboxPatch
        One for each part that has chapters.
    """
    every, boxes = chapters(folder), []
    parts = {p["name"]: p for p in _contents(folder)["part"] if _chapters_of(p, every)}
    for name, part in parts.items():
        x, y = part["place"]
        inside = _chapters_of(part, every)
        box = FancyBboxPatch((x - 0.38, y - 0.24), 0.76, 0.48, boxstyle="round,pad=0.03",
                             fc="white", ec=COLOURS["cutter"])  # fmt: skip
        boxes.append(ax.add_patch(box))
        numbers = f"{inside[0].number:02} to {inside[-1].number:02}"
        ax.text(x, y, f"{_two_lines(name)}\n{numbers}", ha="center", va="center")
        for other in part["follows"]:
            arrow = {"arrowstyle": "->", "color": COLOURS["tangent sphere"], "lw": 1.2,
                     "shrinkA": 0, "shrinkB": 2}  # fmt: skip
            u, v = parts[other]["place"]
            ax.annotate("", (x - 0.41, y), (u + 0.41, v), arrowprops=arrow)
    ax.set(xlim=(-0.5, max(p["place"][0] for p in parts.values()) + 0.5), ylim=(-0.4, 2.4))
    ax.axis("off")
    return boxes


def _two_lines(name):
    middle = min((i for i, c in enumerate(name) if c == " "), key=lambda i: abs(i - len(name) / 2))
    return f"{name[:middle]}\n{name[middle + 1 :]}"


def _chapters_of(part, every):
    first, last = part["chapters"]
    return [chapter for chapter in every if first <= chapter.number <= last]


def _contents(folder):
    return tomllib.loads((folder / CONTENTS).read_text())
