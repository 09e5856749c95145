"""A notebook as a page: its prose, code and stored outputs, nothing run.

Code that sets up, draws or shows is folded, as it is in JupyterLab; what carries the idea isn't.
"""

import ast
import base64
import re
from html import escape

import nbformat

from report.site.markup import attribute, code, formula, markdown, plain
from report.site.pictures import packed, sizes
from report.sources import ROOT, records

# A picture with links at its places: the one output of HTML that is let through.
PLACED = re.compile(
    r'<div style="[^"<>]*"><img src="\.\./figures/[\w.]+" alt="[^"<>]*" style="[^"<>]*">'
    r'(?:<a href="\w+\.ipynb" title="[^"<>]*" style="[^"<>]*">\d+</a>)+</div>'
)
FOLDED = "hide-input"  # the tag of a cell whose code a reader opens by a click


def title(notebook):
    """Return the question that a notebook asks."""
    return nbformat.read(notebook, as_version=4).cells[0].source.split("\n")[0].lstrip("# ")


def page_name(notebook):
    """Return the page of a notebook, from the site's root."""
    return f"chapters/{notebook.stem}.html"


def where_it_moves(source, in_space):
    """Return where the sliders move that a cell's stored picture can't show."""
    if "sliders(" not in source:
        return ""
    live = "" if in_space else "in the live pages (<code>make live</code>) and "
    return f'<p class="note">Its sliders move {live}in JupyterLab (<code>make lab</code>).</p>\n'


class Chapter:
    """What turns one notebook into a page.

    Parameters
    ----------
    notebook : pathlib.Path
        The notebook, with stored outputs.
    link : function
        Gives the page's address for a link in the notebook.
    to_root : str
        Way from the page to the site's root: empty, or ``"../"``.
    scenes : list of str
        Names of the scenes that this notebook made, ``<stem>-<cell>-<n>``.
    tables : dict
        Each recorded table's HTML, by notebook and name.
    captions : dict
        Each figure's caption in the report as HTML, by file.
    live : report.live.build.LivePages, optional
        What stands below the cells that have sliders.
    """

    def __init__(self, notebook, link, to_root, scenes, tables, captions, live=None):
        self.cells = nbformat.read(notebook, as_version=4).cells
        self.link, self.to_root, self.live = link, to_root, live
        self.stem, self.scenes = notebook.stem, scenes
        made = records(notebook)[1]
        self.figures = {f["alt"]: f["file"] for f in made.get("figures", {}).values()}
        self.captions = captions
        self.tables = {
            repr(t["text"]): tables[notebook.stem, name]
            for name, t in made.get("tables", {}).items()
        }
        self.pictures = {}  # file name: content, of pictures that are in the notebook only
        self.heading = ""

    def html(self):
        """Return the page's body."""
        number, parts = 0, []
        for cell in self.cells:
            if cell.cell_type == "markdown":
                parts.append(self.prose(cell.source))
            elif cell.cell_type == "code":
                number += 1
                parts.append(self.code(cell, number))
        return "\n".join(parts)

    def prose(self, text):
        html = markdown(text, self.link)
        if headings := re.findall(r"<h\d[^>]*>(.*?)</h\d>", html):
            self.heading = plain(headings[-1])
        return html

    def code(self, cell, number):
        source = re.sub(r"\s*# fmt: skip\b", "", cell.source)
        outputs = "".join(map(self.output, cell.outputs))
        turning = self.scenes_below(number)
        moving = (
            self.live.below(self.stem, number) if self.live else where_it_moves(source, turning)
        )
        shown = f'<p class="number">cell {number}</p>{code(source)}'
        if FOLDED in cell.metadata.get("tags", ()):
            shown = f'<details class="source"><summary>code</summary>{shown}</details>'
        else:
            shown = f'<div class="source">{shown}</div>'
        return f'<div class="cell" id="cell-{number}">\n{shown}\n{outputs}{turning}{moving}</div>'

    def output(self, output):
        if output.output_type == "stream":
            return f'<pre class="output">{escape(output.text)}</pre>\n'
        data = output.data
        if "image/png" in data:
            alt = output.metadata.get("image/png", {}).get("alt", "")
            return self.figure(base64.b64decode(data["image/png"]), alt)
        if PLACED.fullmatch(data.get("text/html", "")):
            there = data["text/html"].replace('src="../', f'src="{self.to_root}')
            return re.sub(r'href="([^"]+)"', lambda m: f'href="{self.link(m[1])}"', there) + "\n"
        if recorded := self.recorded_table(data.get("text/plain", "")):
            return recorded
        if "text/markdown" in data:
            return markdown(data["text/markdown"], self.link)
        if "text/latex" in data:
            return f'<div class="output">{formula(data["text/latex"].strip("$"), "block")}</div>\n'
        return f'<pre class="output">{escape(data["text/plain"])}</pre>\n'

    def figure(self, content, alt):
        """Return a picture: the recorded figure, or what only the notebook shows."""
        if alt in self.figures:
            file = self.figures[alt]
            content = (ROOT / "figures" / file).read_bytes()  # shown in its stead
            caption = self.captions[file].replace('href="', f'href="{self.to_root}')
        else:
            file, caption = f"{self.stem}-{len(self.pictures)}.webp", escape(alt)
            alt = f"Drawing: {self.heading}"  # what it shows is said below it
            self.pictures[file] = packed(content)
        source = f"{self.to_root}figures/{file}"
        said = attribute(alt)
        below = f"<figcaption>{caption}</figcaption>" if caption else ""
        return (
            f'<figure><a href="{source}"><img src="{source}" alt="{said}" {sizes(content)} '
            'loading="lazy"></a>'
            f"{below}</figure>\n"
        )

    def scenes_below(self, number):
        """Return a cell's buttons for scenes, numbered where there are several."""
        names = [name for name in self.scenes if name.startswith(f"{self.stem}-{number:02}-")]
        count = len(names)
        parts = []
        for which, name in enumerate(names, 1):
            shown = "Turn it in 3-D" if count == 1 else f"Turn it in 3-D, {which} of {count}"
            said = attribute(f"Scene {self.scenes.index(name) + 1}, {self.heading}")
            parts.append(
                f'<div class="scene" data-scene="{name}" data-said="{said}">'
                f'<button type="button" aria-label="{shown}: {said}">{shown}</button></div>\n'
            )
        return "".join(parts)

    def recorded_table(self, text):
        """Return a recorded table as the report sets it; None if a value isn't one."""
        try:
            return self.tables.get(repr(ast.literal_eval(text)))
        except (ValueError, SyntaxError):
            return None
