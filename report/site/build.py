"""Put the site together: chapters, report, proofs, reference, figures, scenes, search."""

import json
import re
import shutil
import unicodedata
from html import escape
from pathlib import Path

import jinja2
import nbformat
from pygments.formatters import HtmlFormatter

from report.site import policy
from report.site.chapter import Chapter, page_name, title
from report.site.front import front_page
from report.site.library import Reference, modules, room
from report.site.markup import attribute, markdown, plain
from report.site.paper import captions, report_page, tables
from report.site.proofs import proof_html, proof_page, proofs
from report.site.scenes import add_viewer, name, scene_script
from report.site.search import script, sections
from report.sources import ROOT, notebooks, results_digest, scene_files

SITE = ROOT / "build" / "site"
HERE = Path(__file__).parent
# Pygments' styles whose every word stands out from the ground behind it, by 4.5 to 1.
LIGHT, DARK = "xcode", "github-dark"
PAGES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(HERE), trim_blocks=True, lstrip_blocks=True, autoescape=True
)
EMPTY_HEAD = re.compile(r"<th\b([^>]*)>\s*</th>")
ONLY_MATH = re.compile(r"<(a|th)\b([^>]*)>\s*(<math\b(?:(?!</math>).)*</math>)\s*</\1>", re.S)
INLINE_MATH = re.compile(r'(<math(?![^>]*display="block")\b.*?</math>)([.,;:)]*)', re.S)
LONG = 25  # letters of a formula
HEADING = re.compile(r'(<h[2-4][^>]*\bid="([^"]+)"[^>]*>)(.*?)(</h[2-4]>)', re.S)
BUILD = "library"  # the page of the guide with how to install it, and ten lines
PLACES = [
    ("Chapters", "chapters/00_index.html"),
    ("Report", "report.html"),
    ("Supplement", "supplement.html"),
    ("Verdicts", "supplement.html#verdicts"),
    ("Words", "supplement.html#glossary"),
    ("Library", "library/index.html"),
    ("Build", f"guide/{BUILD}.html"),
]
GUIDE = ROOT / "report" / "guide"


class Site:
    """A folder of pages, and the entries of their search.

    `live` describes what pages that run the study have in addition (report/live), or is None.
    """

    def __init__(self, folder, live=None):
        self.folder, self.live = folder, live
        self.found = []
        self.origin = f"Shows results with the digest {results_digest()[:16]}."

    def page(self, address, title, body, *, kind, here=None, style="", near=("", ()), **more):
        """Write a page; `here` names the place in the header that it belongs to.

        `body` and `style` are HTML and CSS as they are; everything else is text. `near` is the
        name of a list of pages and its links.
        """
        root = "../" * address.count("/")
        body = EMPTY_HEAD.sub(r"<td\1></td>", body)  # a head that says nothing is none
        body = ONLY_MATH.sub(named_by_its_letters, INLINE_MATH.sub(in_a_box, body))
        headings = [
            entry(plain(text), f"#{name}", level=int(begin[2]))
            for begin, name, text, _ in HEADING.findall(body)
            if begin[2] < "4" and kind != "front"
        ]
        lists = [listed for listed in (("On this page", headings), near) if listed[1]]
        html = PAGES.get_template("page.html").render(
            root=root, title=plain(title), description=described(body), style=style, kind=kind,
            body=HEADING.sub(with_permalink, body),
            policy=policy.content_policy(style, runs=self.live is not None),
            places=[*PLACES, *(self.live.places if self.live else ())],
            live=self.live, lists=lists,
            address=address, here=here or address, footer=self.origin, **more,
        )  # fmt: skip
        self.write(address, html)
        self.found += sections(plain(title), address, body)

    def write(self, address, content):
        path = self.folder / address
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


def build(folder, chosen=None, live=None):
    """Make the site in a folder, which is emptied first.

    Parameters
    ----------
    folder : pathlib.Path
        Where to.
    chosen : list of pathlib.Path, optional
        Notebooks that become chapters, all unless told; links to others lead to the index.
    live : report.live.build.LivePages, optional
        What makes the pages run.
    """
    shutil.rmtree(folder, ignore_errors=True)
    site = Site(folder, live)
    chosen = notebooks() if chosen is None else chosen
    add_shared(site)
    shown = add_reports(site, chosen)
    add_front(site, chosen)
    add_chapters(site, chosen, shown)
    add_proofs(site)
    add_library(site)
    add_guide(site)
    if live:
        live.add(site)
    site.write("search-index.js", script(site.found))


def add_shared(site):
    """Write what pages share: figures, style, script and fonts."""
    shutil.copytree(ROOT / "figures", site.folder / "figures", ignore=lambda *_: ["README.md"])
    style = (HERE / "style.css").read_text() + (site.live.style if site.live else "")
    site.write("style.css", f"{colours(LIGHT)}\n{style}")
    site.write("dark.css", f"{colours(DARK)}\n{(HERE / 'dark.css').read_text()}")
    for file in ("site.js", "scheme.js"):
        site.write(file, (HERE / file).read_bytes())
    for file in ("formulas.woff", "OFL.txt"):
        site.write(f"fonts/{file}", (HERE / "fonts" / file).read_bytes())


def in_a_box(match):
    """Return a formula within a line in a box, because browsers break the line before a comma.

    A long one scrolls on a narrow screen; a short one keeps the signs that follow it.
    """
    math, signs = match.groups()
    if len(plain(math)) > LONG:
        return f'<span class="wide">{math}</span>{signs}'
    return f'<span class="kept">{math}{signs}</span>' if signs else math


def named_by_its_letters(match):
    """Return a link or a table's head that is a formula alone, with its letters for screen readers.

    They are a link's label; in a head they are hidden text, without which it counts as empty.
    """
    tag, attributes, math = match.groups()
    letters = unicodedata.normalize("NFKD", plain(math))
    if tag == "a":
        return f'<a{attributes} aria-label="{attribute(letters)}">{math}</a>'
    hidden = math.replace("<math", '<math aria-hidden="true"', 1)
    return f'<th{attributes}>{hidden}<span class="heard">{escape(letters)}</span></th>'


def described(body):
    """Return the first sentences of a page, for lists of what was found elsewhere."""
    said = (plain(text) for text in re.findall(r"<p(?:\s[^>]*)?>(.*?)</p>", body, re.S))
    long = next((text for text in said if len(text) > 60), "")
    return long if len(long) < 200 else f"{long[:200].rpartition(' ')[0]} …"


def with_permalink(match):
    """Return a heading with a link to itself behind it."""
    begin, name, text, end = match.groups()
    said = attribute(f"Link to {plain(text)}")
    return f'{begin}{text}<a class="permalink" href="#{name}" aria-label="{said}">#</a>{end}'


def colours(name):
    """Return the rules of code in one of Pygments' styles."""
    return HtmlFormatter(cssclass="code", style=name).get_style_defs(".code")


def add_front(site, chosen):
    """Write the first page, and its small pictures."""
    form = ", or in the planner's form" if site.live else ""
    moved = "pictures to move and " if site.live else ""
    doors = [
        ("Read", "report.html", "the article: what was claimed, what came out, and the proofs"),
        ("Play", page_name(chosen[0]), f"chapters with one question each, {moved}scenes to turn"),
        ("Build", f"guide/{BUILD}.html", f"install it; plan a cut of your own in ten lines{form}"),
    ]
    body, pictures = front_page(chosen, doors)
    site.page("index.html", "The open tunneller study", body, kind="front")
    for address, content in pictures.items():
        site.write(address, content)


def add_chapters(site, chosen, figure_captions):
    """Write a page for each notebook, their pictures and scenes."""
    titles = {page_name(n): f"{n.stem[:2]} {title(n)}" for n in chosen}
    order, set_tables = list(titles), tables()
    for notebook in chosen:
        here = page_name(notebook)
        root = "../" * here.count("/")
        scenes = scene_files(notebook)
        chapter = Chapter(
            notebook, lambda url, root=root: follow(url, chosen, root), root,
            [name(path) for path in scenes], set_tables, figure_captions, site.live,
        )  # fmt: skip
        body = chapter.html()
        at = order.index(here)
        contents = [entry(titles[page], root + page, here=page == here) for page in order]
        turn = {
            side: entry(titles[order[i]], root + order[i])
            for side, i in (("before", at - 1), ("after", at + 1))
            if 0 <= i < len(order)
        }
        site.page(
            here, title(notebook), body, kind="chapter", here="chapters/00_index.html",
            near=("Chapters", contents), file=notebook.name, **turn,
        )  # fmt: skip
        file = to_run(notebook)
        site.write(f"notebooks/{notebook.name}", file)  # the PDF leads there
        site.write(f"notebooks/{notebook.name}.js", f"window.notebook = {json.dumps(file)};\n")
        for file, content in chapter.pictures.items():
            site.write(f"figures/{file}", content)
        for path in scenes:
            site.write(f"scenes/{name(path)}.js", scene_script(path))
    add_viewer(site)


def to_run(notebook):
    """Return a notebook's file without its outputs."""
    content = nbformat.read(notebook, as_version=4)
    for cell in content.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    return nbformat.writes(content)


def follow(url, chosen, root):
    """Return where a link of a notebook or of the report leads on the site."""
    path, hash_, anchor = url.partition("#")
    name = Path(path).name
    if name in ("report.pdf", "supplement.pdf", "corrigenda.pdf"):
        return f"{root}report/{name}"
    if name.startswith("test_"):
        return f"{root}{proof_page(Path(name))}{hash_}{anchor}"
    if name.endswith(".ipynb"):
        found = [page_name(n) + hash_ + anchor for n in chosen if n.name == name]
        return root + (found or ["index.html"])[0]
    return url


def add_reports(site, chosen):
    """Write the pages of the article and of its supplement; return the captions of both."""
    shown = {}
    for document, called in (("report", "article"), ("supplement", "supplement")):
        made = report_page(document)
        add_report(site, document, made, chosen)
        for file, caption in captions(made[1], called).items():
            shown[file] = caption.replace('href="#', f'href="{document}.html#')
    return shown


def add_report(site, name, made, chosen):
    """Write the page of the report or of its supplement, and the PDF beside it."""
    style, body = made
    body = re.sub(r'href="(\.\./[^"]+)"', lambda m: f'href="{follow(m[1], chosen, "")}"', body)
    body = f'<p><a href="report/{name}.pdf">This page as a PDF</a></p>{body}'
    site.page(f"{name}.html", name.title(), body, kind="report", style=style)
    site.write(f"report/{name}.pdf", (ROOT / "report" / f"{name}.pdf").read_bytes())


def add_proofs(site):
    """Write a page for each file of tests that the ledger names, and the file."""
    for path in proofs():
        site.page(
            proof_page(path), path.name, proof_html(path), kind="library", here="supplement.html"
        )
        site.write(f"tests/{path.name}", path.read_bytes())


def add_library(site):
    """Write the reference's pages."""
    reference = Reference(modules())
    home = "library/index.html"
    site.page(home, "The library", reference.index(), kind="library")
    for module in reference.modules:
        near = [m for m in reference.modules if room(m) == room(module)]
        contents = [entry(m.short, f"../{m.page}", here=m == module) for m in near]
        site.page(
            module.page, module.short, reference.body(module), kind="library", here=home,
            near=(room(module) or "Library", contents),
        )  # fmt: skip


def add_guide(site):
    """Write the pages on how to use the checkout, the command and the library."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(GUIDE.glob("*.md"))}
    titles = {path: text.partition("\n")[0].lstrip("# ") for path, text in texts.items()}

    def led(url):
        if url.startswith("https://"):
            return url
        if url in [path.name for path in texts]:
            return url.replace(".md", ".html")
        file = (GUIDE / url).resolve().relative_to(ROOT)
        site.write(f"checkout/{file}", (ROOT / file).read_bytes())
        return f"../checkout/{file}"

    for path, text in texts.items():
        contents = [
            entry(titles[other], f"{other.stem}.html", here=other == path) for other in texts
        ]
        site.page(
            f"guide/{path.stem}.html", titles[path], markdown(text, led), kind="guide",
            here=f"guide/{BUILD}.html", near=("Guide", contents),
        )  # fmt: skip


def entry(text, target, **more):
    """Return a link as the template wants it."""
    return {"text": text, "target": target, "level": 2, "here": False, **more}
