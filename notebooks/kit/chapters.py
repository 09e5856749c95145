"""The study's chapters, its notebooks: what each asks and found, their tables, ways to them."""

import json
import math
import re
import tomllib
from dataclasses import dataclass
from html import escape

from .displays import RAISED
from .record import CHECKOUT

NOTEBOOKS = CHECKOUT / "notebooks"
NEEDS = re.compile(r"\*\*You need\*\*\s+(.*?)\.(?:\s|$)", re.DOTALL)
HEADS = "", "question", "what came out", "you need", "minutes"
# Of prose and of code in sight that are read in a minute, as a reader who has calculus took for two
# essays and for chapters: code takes longer than prose.
WORDS = 160
LINES = 18
# The look of a chapter's number on the machine's picture.
CHIP = (
    "position: absolute; padding: 0 0.3em; font-size: 0.85em; color: #222222; "
    "background: #FFFFFF; border: 1px solid #595959; border-radius: 3px"
)


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

    @property
    def link(self):
        """The chapter's number as a link in Markdown."""
        return f"[{self.number:02}]({self.file})"


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
    """Return the kind and the text of each cell of a notebook that is in sight."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [
        (cell["cell_type"], "".join(cell["source"]))
        for cell in cells
        if "hide-input" not in cell["metadata"].get("tags", ())
    ]


def _minutes(cells):
    """Return the minutes that cells take to read, up to the next five.

    Examples
    --------
    >>> _minutes([("markdown", "word " * 800), ("code", "line\\n" * 89)])
    10
    >>> _minutes([("markdown", "word " * 801), ("code", "line\\n" * 89)])
    15
    """
    words = sum(len(text.split()) for kind, text in cells if kind == "markdown")
    lines = sum(text.count("\n") + 1 for kind, text in cells if kind == "code")
    return 5 * math.ceil((words / WORDS + lines / LINES) / 5)


def ending(show, words=""):
    """Return what a notebook found, in the numbers that it recorded, and the ways on from it.

    Parameters
    ----------
    show : Show
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
    >>> from kit import Show
    >>> print(ending(Show("08_cone"), "It is so.").data)
    It is so.
    <BLANKLINE>
    [00 index](00_index.ipynb) · [07 chord](07_chord.ipynb) · [09 geodesic](09_geodesic.ipynb)
    """
    index, *names = [path.stem for path in sorted(NOTEBOOKS.glob("[0-9]*.ipynb"))]
    at = names.index(show.notebook)
    near = [index, *names[max(at - 1, 0) : at], *names[at + 1 : at + 2]]
    links = " · ".join(f"[{name.replace('_', ' ')}]({name}.ipynb)" for name in near)
    said = filled(show.notebook, words or _contents()["found"][show.notebook], show.root)
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
        first, last = part["chapters"]
        for c in (chapter for chapter in every if first <= chapter.number <= last):
            lines.append(f"| {c.link} | {c.question} | {c.found} | {c.needs} | {c.minutes} |")
        lines.append("")
    return _markdown("\n".join(lines))


def _markdown(text):
    from IPython.display import Markdown  # drawings need no IPython: the extra [picture] has none

    return Markdown(text)


def course_table():
    """Return a table of the courses, each with its hours, goals and prerequisites, as Markdown."""
    every = {chapter.number: chapter for chapter in read_chapters()}
    lines = ["| notebooks | hours | you can do afterwards | you need |", "|-|-|-|-|"]
    for course in _contents()["course"]:
        way = [every[number] for number in course["chapters"]]
        links = ", ".join(chapter.link for chapter in way)
        hours = sum(chapter.minutes for chapter in way) / 60
        lines.append(f"| {links} | {hours:.1f} | {course['goals']} | {course['needs']} |")
    return _markdown("\n".join(lines))


def machine_map():
    """Return the machine's picture with links to the chapters at its parts, as HTML."""
    from IPython.display import HTML

    every = {chapter.number: chapter for chapter in read_chapters()}
    machine = _contents()["machine"]
    links = "".join(
        f'<a href="{every[int(number)].file}" title="{escape(every[int(number)].question)}" '
        f'style="{CHIP}; left: {across}%; top: {down}%">{number}</a>'
        for number, (across, down) in machine["places"].items()
    )
    source = f"../figures/{machine['figure']}"
    picture = f'<img src="{source}" alt="{escape(machine["alt"])}" style="width: 100%">'
    return HTML(f'<div style="position: relative; max-width: 800px">{picture}{links}</div>')


def worth(words, notebook="42_budget"):
    """Return a line on what a chapter's subject is worth on the wall, as Markdown.

    The names in braces are those of numbers that the notebook recorded.
    """
    return _markdown(f"**What it is worth on the wall.** {filled(notebook, words)}")


def _contents():
    return tomllib.loads((NOTEBOOKS / "contents.toml").read_text())
