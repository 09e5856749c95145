"""The first page: the machine moving, one sentence, three doors, a picture of each chapter."""

import base64
import tomllib
from html import escape

import nbformat

from report.lists import MOVING, judged
from report.site.chapter import page_name, title
from report.site.markup import attribute, markdown
from report.site.pictures import packed
from report.site.publish import Unavailable
from report.sources import INDEX, ROOT

SENTENCE = (
    "Old sewers are repaired from within: a robot in the pipe mills a layer off its wall with a "
    "ball of teeth on an arm. A paper says how to steer it. This study tests each of its claims by "
    "a program, and lets you try them yourself."
)
# Where a visitor begins, by headings of the index.
BEGIN = {
    "where-to-begin": "Where to begin", "for-a-course": "Courses", "chapters": "What came out",
    "words-of-the-trade": "Words of the trade",
}  # fmt: skip
WIDE = 300  # px, of a small picture


def first_picture(notebook):
    """Return a notebook's first picture, small, as WebP."""
    for cell in nbformat.read(notebook, as_version=4).cells:
        for output in cell.get("outputs", []):
            if content := output.get("data", {}).get("image/png"):
                return packed(base64.b64decode(content), WIDE)
    raise Unavailable(f"{notebook.name}: it holds no picture.")


def front_page(chosen, doors):
    """Return the first page's body, and its small pictures by address.

    Parameters
    ----------
    chosen : list of pathlib.Path
        The notebooks that are chapters.
    doors : list of (str, str, str)
        Each a word, an address, and what is behind it.
    """
    pictures = {}
    entries = "".join(
        f'<li><a class="door" href="{address}"><b>{word}</b> {escape(what)}</a></li>'
        for word, address, what in doors
    )
    index = page_name(ROOT / "notebooks" / f"{INDEX}.ipynb")
    links = [f'<a href="{index}#{name}">{words}</a>' for name, words in BEGIN.items()]
    parts = [
        "<h1>The open tunneller study</h1>",
        f'<p class="lead">{SENTENCE}</p>',
        markdown(judged(), lambda _: "supplement.html#verdicts"),
        f'<div class="moving">{MOVING.read_text(encoding="utf-8")}',
        '<button type="button" id="still" aria-pressed="false">Stop the motion</button></div>',
        f'<ul class="doors">{entries}</ul>',
        f"<p>{' · '.join(links)}</p>",
    ]  # fmt: skip
    for part in tomllib.loads((ROOT / "notebooks" / "contents.toml").read_text())["part"]:
        first, last = part["chapters"]
        within = [n for n in chosen if first <= int(n.stem[:2]) <= last]
        if not within:
            continue
        cards = []
        for notebook in within:
            address = f"thumbnails/{notebook.stem}.webp"
            pictures[address] = first_picture(notebook)
            cards.append(
                f'<li><a href="{page_name(notebook)}"><img src="{address}" loading="lazy" alt="'
                f'{attribute(f"First picture of chapter {notebook.stem[:2]}")}">'
                f"<span>{notebook.stem[:2]} {escape(title(notebook))}</span></a></li>"
            )
        name = part["name"]
        parts.append(f'<h2 id="part-{first}">{escape(name)}</h2>')
        parts.append(f'<ul class="cards">{"".join(cards)}</ul>')
    return "\n".join(parts), pictures
