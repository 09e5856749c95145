"""The web pages: nothing dead, nothing from elsewhere, every formula set, everything found."""

import base64
import io
import json
import re
import zipfile
from functools import cache
from html import unescape
from itertools import pairwise

import nbformat
import numpy as np
import PIL.Image
import pytest
from fontTools.ttLib import TTFont

from report.lists import judged
from report.live.build import LivePages
from report.site import build as pages
from report.site import paper
from report.site.chapter import Chapter, page_name, title
from report.site.links import faults
from report.site.markup import anchor, markdown, plain
from report.site.paper import unused
from report.site.pictures import packed, sizes
from report.site.policy import digest
from report.site.search import script, sections, words
from report.sources import ROOT, notebooks

# Not the report's words: test_paper_pages reads them, and the captions that chapters show, too.
READS = [
    "report/*.bib", "report/*.csv", "report/*.json", "report/*.pdf", "report/*.toml",
    "report/guide/*", "report/ledger/*", "report/lib.typ", "report/page.typ", "report/results.typ",
    "report/spoken.typ", "report/verdicts.typ", "report/site/*", "report/live/*", "figures/*",
    "notebooks/*", "tests/*", "tunneller_lib/*", "environment.txt", "CITATION.cff",
]  # fmt: skip

SOME = [n for n in notebooks() if n.stem[:2] in ("00", "02", "08", "10", "23", "56")]
RUN = [n for n in SOME if n.stem[:2] in ("00", "02", "56")]


@pytest.fixture(scope="module")
def build():
    """Return what makes pages, of documents, modules and proofs that are read once for all."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper, "to_html", cache(paper.to_html))
        patch.setattr(pages, "modules", cache(pages.modules))
        patch.setattr(pages, "proof_html", cache(pages.proof_html))
        yield pages.build


@pytest.fixture(scope="module")
def site(build, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    build(folder, SOME)
    return folder


@pytest.fixture(scope="module")
def running(build, tmp_path_factory):
    """Return pages that run, with a small thing in the runtime's place."""
    wheel = io.BytesIO()
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("some_thing-1.0.dist-info/licenses/LICENSE", "as you like")
    folder = tmp_path_factory.mktemp("live")
    files = {"pyodide.js": b"// 0", "some_thing-1.0-py3-none-any.whl": wheel.getvalue()}
    build(folder, RUN, LivePages(RUN, files))
    return folder


@pytest.fixture(scope="module")
def index(site):
    text = (site / "search-index.js").read_text()
    return json.loads(text.removeprefix("window.searchIndex = ").rstrip(";\n"))


def page(site, number):
    [notebook] = [n for n in notebooks() if n.stem.startswith(number)]
    return (site / page_name(notebook)).read_text()


def test_site_has_no_faults(site):
    assert faults(site) == []


def test_site_sets_every_formula(site):
    for path in site.glob("chapters/*.html"):
        prose = re.sub(r"<pre.*?</pre>|<div class=\"source\">.*?</div>", "", path.read_text(),
                       flags=re.S)  # fmt: skip
        assert "$" not in plain(prose) and "\\" not in plain(prose), path.name
    assert page(site, "10").count("<math") > 10


def test_site_sets_formulas_in_a_font_that_it_brings_along(site):
    font = TTFont(site / "fonts" / "formulas.woff")
    letters = set(font.getBestCmap())
    italic = set(range(0x1D434, 0x1D468)) - {
        0x1D455
    }  # what browsers make of <mi>x</mi>; h is U+210E
    assert "MATH" in font and italic <= letters
    for path in site.rglob("*.html"):
        shown = "".join(map(plain, re.findall(r"<math.*?</math>", path.read_text(), re.S)))
        assert set(map(ord, shown)) <= letters, path.name
    style = (site / "style.css").read_text()
    assert re.search(r"math {[^}]*font-family: Formulas,", style)
    assert "SIL OPEN FONT LICENSE" in (site / "fonts" / "OFL.txt").read_text()


def test_site_shows_what_the_notebook_prints(site):
    [notebook] = [n for n in SOME if n.stem.startswith("23")]
    shown = plain(page(site, "23"))
    for cell in nbformat.read(notebook, as_version=4).cells:
        for output in cell.get("outputs", []):
            if output.output_type == "stream":
                assert " ".join(output.text.split()) in shown


def test_search_finds_tests_and_equations_by_name(site, index):
    assert "\u200b" not in (site / "supplement.html").read_text()
    assert not any("&#" in text for _, _, text in index["sections"])
    places = {index["sections"][n][1] for n in index["words"]["test_eq05_quartic"]}
    assert "tests/test_equations_line.html#test_eq05_quartic" in places
    assert any(place.startswith("supplement.html#judged") for place in places)
    numbered = [title for title, _, _ in index["sections"] if title.endswith(" · Eq. 5")]
    assert numbered[0].startswith("Supplement · ") and "ruling" in numbered[0]


def test_words_of_the_trade_are_found_and_in_reach_of_every_page(site, index):
    for word, place in (("springing", "supplement.html#glossary"),
                        ("jacobian", "chapters/00_index.html#words-of-the-trade")):  # fmt: skip
        assert place in [index["sections"][n][1] for n in index["words"][word]]
    front = (site / "index.html").read_text()
    assert 'href="supplement.html#glossary">Words<' in front
    assert "chapters/00_index.html#words-of-the-trade" in front
    assert plain(markdown(judged())) in plain(front)


def test_pages_have_headings_in_steps_and_buttons_that_differ(site):
    for path in site.rglob("*.html"):
        levels = [int(level) for level in re.findall(r"<h(\d)", path.read_text())]
        assert all(b <= a + 1 for a, b in pairwise(levels)), path.name
        names = re.findall(r'<button[^>]*aria-label="([^"]+)"', path.read_text())
        assert len(names) == len(set(names)), path.name


def test_first_page_moves_and_leads_to_every_chapter(site):
    text = (site / "index.html").read_text()
    assert text.count("<animate") == 3 and 'id="still"' in text
    for notebook in SOME[1:]:
        card = f'<a href="{page_name(notebook)}"><img src="thumbnails/{notebook.stem}.webp"'
        assert card in text and (site / f"thumbnails/{notebook.stem}.webp").stat().st_size < 30e3
    doors = re.findall(r'<a class="door" href="([^"]+)"><b>(\w+)', text)
    assert [word for _, word in doors] == ["Read", "Play", "Build"]
    assert "plan(cutting_circuit" in plain((site / doors[-1][0]).read_text())


def test_library_has_every_public_name(site):
    for module in pages.modules():
        text = (site / module.page).read_text()
        for entry in module.entries:
            assert f'id="{entry.name}"' in text
    torus = (site / "library/surfaces.torus.html").read_text()
    assert "<dt>theta, phi : (...) float</dt>" in torus and "array([1., 0., 0.])" in plain(torus)


PAGE = '<html><body><h1 id="top">a</h1>{}</body></html>'


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ('<a href="b.html">b</a>', "leads to b.html, which isn't there"),
        ('<a href="#no">b</a>', "leads to #no, a page without that name"),
        ('<a href="../../etc/passwd">b</a>', "leads to ../../etc/passwd, which isn't there"),
        ('<script src="https://a.org/b.js"></script>', "loads https://a.org/b.js from elsewhere"),
        ('<p style="background: url(//a.org/b.png)">b</p>', "from elsewhere"),
        ('<img src="data:,">', "without a text"),
        ('<p id="top">b</p>', "has the name top twice"),
    ],
)
def test_faults_are_told(tmp_path, body, told):
    (tmp_path / "a.html").write_text(PAGE.format(body))
    [fault] = faults(tmp_path)
    assert fault.startswith("a.html") and told in fault


@pytest.mark.parametrize("address", ["../a.woff", "https://a.org/b.woff"])
def test_faults_are_what_a_style_sheet_loads_that_is_not_there(tmp_path, address):
    (tmp_path / "pages").mkdir()
    for font in (tmp_path / "pages" / "b.woff", tmp_path / "a.woff"):
        font.touch()
    sheet = f"a {{ src: url('b.woff'); }} b {{ src: url({address}); }}"
    (tmp_path / "pages" / "style.css").write_text(sheet)
    assert faults(tmp_path / "pages") == [f"style.css loads {address}, which isn't there"]


def test_faults_are_none_where_links_hold(tmp_path):
    links = '<a href="a.html#top">a</a><a href="https://doi.org/1">paper</a><a href="#top">b</a>'
    (tmp_path / "a.html").write_text(PAGE.format(links))
    assert faults(tmp_path) == []


def test_markdown_follows_links_and_names_headings():
    html = markdown("## A *b*\n[07](07_chord.ipynb), $x^2$", lambda url: url.upper())
    assert 'id="a-b"' in html and 'href="07_CHORD.IPYNB"' in html and "<msup>" in html


def test_plain_leaves_text_alone():
    assert plain("<p>a &lt; b</p><style>x</style><p>c&amp;d</p>") == "a < b c&d"
    assert plain("<math><mo>&#x02212;</mo><mi>&#x003B8;</mi></math>") == "−θ"
    assert anchor("Where <em>now</em>?") == "where-now"


def test_sections_are_named_by_their_words_each_once(site):
    assert unused("a", {"b"}) == "a" and unused("a", {"a", "a-2"}) == "a-3"
    for name in ("report", "supplement"):
        text = (site / f"{name}.html").read_text()
        assert not re.search(r'id="section-\d', text)
    assert '<h2 id="the-torus">5 The torus<a class="permalink" href="#the-torus"' in text


def test_pictures_have_their_size_and_keep_their_pixels(site):
    for path in site.rglob("*.html"):
        for picture in re.findall(
            r'<figure>.*?(<img[^>]*src="[^"]*figures/[^>]*>)', path.read_text()
        ):
            [(width, height)] = re.findall(r'width="(\d+)" height="(\d+)"', picture)
            assert 0 < int(height) <= 576 and int(width) > 0, (path.name, picture)
    drawn = np.random.default_rng(7).integers(0, 256, (900, 300, 3), dtype=np.uint8)
    png = io.BytesIO()
    PIL.Image.fromarray(drawn).save(png, "PNG")
    assert sizes(png.getvalue()) == 'width="192" height="576"'
    assert sizes(b'<svg width="300pt" height="150pt">') == 'width="400" height="200"'
    kept = PIL.Image.open(io.BytesIO(packed(png.getvalue())))
    assert np.array_equal(np.asarray(kept), drawn)
    assert PIL.Image.open(io.BytesIO(packed(png.getvalue(), 90))).size == (30, 90)


def policy(text):
    """Return the policy of a page: its directives, each with its words."""
    said = unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1])
    return {name: words for name, *words in (part.split() for part in said.split("; "))}


def test_pages_have_a_policy_that_lets_run_what_they_need_alone(site):
    for path in site.rglob("*.html"):
        text = path.read_text()
        allowed = policy(text)
        assert allowed["default-src"] == ["'none'"] and allowed["base-uri"] == ["'none'"]
        # Opened as files, too; no script of a page's own, and none made of a text.
        assert allowed["script-src"] == ["'self'", "file:", "'wasm-unsafe-eval'"]
        assert allowed["worker-src"] == ["blob:"] and "'unsafe-inline'" not in allowed["style-src"]
        assert text.index("Content-Security-Policy") < text.index("<link")
        scripts = re.findall(r"<script\b([^>]*)>(.*?)</script>", text, re.S)
        assert all("src=" in attributes and not inside for attributes, inside in scripts)
        for style in re.findall(r"<style>(.*?)</style>", text, re.S):
            assert digest(style) in allowed["style-src"], path.name
        tags = re.findall(r"<[a-z][^>]*>", re.sub(r"<pre.*?</pre>", "", text, flags=re.S))
        assert not [tag for tag in tags if re.search(r"\son\w+=|=\"javascript:", tag)], path.name


@pytest.mark.parametrize(
    "text",
    [
        "<script>alert(1)</script>",
        "a <img src=x onerror=alert(1)> b",
        "# <b onclick=alert(1)>a</b>",
        "```mermaid\n</pre><script>alert(1)</script>\n```",
        "```\n</pre><script>alert(1)</script>\n```",
        "| <script>a | b |\n|---|---|\n| <i>1 | 2 |",
        "$\\text{<script>alert(1)</script>}$",
        '![a"><script>](b.png "c"><script>")',
        '[a<script>](b"><script>)',
    ],
)
def test_markdown_shows_html_and_does_not_run_it(text):
    html = markdown(text)
    assert not re.findall(r"<(?:script|b\b|i\b)", html)
    assert not re.search(r"<[^>]*\son\w+=", html)


def test_markdown_lets_answers_unfold_and_no_other_html_with_them():
    html = markdown("<details>\n<summary>Answer</summary>\n\n$x$ <b>1</b>\n\n</details>")
    assert html.startswith("<details>") and html.count("<summary>Answer</summary>") == 1
    assert "<math" in html and "&lt;b&gt;" in html and html.rstrip().endswith("</details>")
    for evil in ("<details ontoggle=alert(1)>", "<details><script>alert(1)</script></details>",
                 "<details>\n<summary><b onclick=alert(1)>a</b></summary>"):  # fmt: skip
        assert "<details" not in markdown(evil) and "<script" not in markdown(evil)


def test_markdown_follows_no_link_that_is_a_script():
    html = markdown("[a](javascript:alert(1)), ![b](javascript:alert(1)), <javascript:alert(1)>")
    assert not re.search(r'(?:href|src)="javascript:', html)


def test_chapter_escapes_what_cells_say_and_print(tmp_path):
    evil = "</pre><script>alert(1)</script>"
    book = nbformat.v4.new_notebook()
    stream = nbformat.v4.new_output("stream", text=evil)
    value = nbformat.v4.new_output("execute_result", data={"text/plain": evil, "text/html": evil})
    said = nbformat.v4.new_output("display_data", data={"text/markdown": evil})
    white = io.BytesIO()
    PIL.Image.new("RGB", (4, 3)).save(white, "PNG")
    png = {"image/png": base64.b64encode(white.getvalue()).decode()}
    drawn = nbformat.v4.new_output("display_data", data=png,
                                   metadata={"image/png": {"alt": f'"{evil}'}})  # fmt: skip
    book.cells = [
        nbformat.v4.new_markdown_cell(f"# What is `{evil}`?\n{evil}"),
        nbformat.v4.new_code_cell(evil, outputs=[stream, value, said, drawn]),
    ]
    path = tmp_path / "notebooks" / "99_evil.ipynb"
    path.parent.mkdir()
    nbformat.write(book, path)
    html = Chapter(path, str, "", ["99_evil-01-0"], {}, {}).html()
    assert "<script" not in html and html.count("&lt;script") >= 7
    found = pages.Site(tmp_path / "site")
    link = pages.entry(evil, f'"{evil}')
    found.page("a.html", title(path), html, kind="chapter", near=(evil, [link]), before=link)
    page = (tmp_path / "site" / "a.html").read_text()
    assert re.findall(r"<script[^>]*>", page) == [
        '<script src="scheme.js">',
        '<script src="site.js">',
    ]


def test_search_cuts_pages_at_headings_and_names_judged_equations():
    body = (
        '<h1 id="a">A</h1>one<h2 id="b">B</h2>two<div class="judged"><math>x</math><div '
        'class="label">(5)</div><div class="mark"><span id="judged-1"></span><span class="verdict">'
        "holds</span> <code>t</code></div></div>"
    )
    one, two, equation = sections("A", "p.html", body)
    assert one == ("A", "p.html#a", "one") and two[:2] == ("A · B", "p.html#b")
    assert equation == ("A · B · Eq. 5", "p.html#judged-1", "x holds t")
    assert words("Bartoň’s 2nd 𝑅") == ["barton", "s", "2nd", "r"]
    assert '{"words":{"5":[0],"θ":[0]}' in script([("a", "p.html", "b θ 5")])


# ---- pages that run ------------------------------------------------------------------------


def wrapped(path):
    """Return the file that a script keeps for the page."""
    text = re.fullmatch(r'\(window.runtime \?\?= {}\)\["(.*)"\] = "(.*)";\n', path.read_text())
    assert f"{text[1]}.js" == path.name
    return base64.b64decode(text[2])


def test_pages_that_run_offer_it_below_each_drawing_with_sliders(running):
    assert faults(running) == []
    for number, count in (("02", 1), ("56", 0)):
        names = re.findall(r'data-program="(.*?)"><button', page(running, number))
        assert len(names) == count
        for name in names:
            text = (running / "live" / "programs" / f"{name}.js").read_text()
            assert "sliders(" in json.loads(text.partition(" = ")[2].rstrip(";\n"))
    assert "need VTK" in page(running, "56") and "These pages run" in page(running, "00")


def test_pages_that_run_let_the_worker_import_what_they_hand_over(running):
    for path in running.rglob("*.html"):
        [policy] = re.findall(r'Content-Security-Policy" content="([^"]*)"', path.read_text())
        assert "script-src &#39;self&#39; file: &#39;wasm-unsafe-eval&#39; blob:;" in policy
        assert "unsafe-eval&#39; &#39;unsafe" not in policy and "connect-src" not in policy


def test_pages_that_run_hold_the_runtime_the_library_and_their_licences(running):
    parts = json.loads((running / "live/parts.js").read_text().partition(" = ")[2].rstrip(";\n"))
    for name, size in parts["parts"]:
        assert len(wrapped(running / "live" / f"{name}.js")) == size
    packages = json.loads(wrapped(running / "live/lock.js"))["packages"]
    assert list(packages) == ["some-thing"] and packages["some-thing"]["version"] == "1.0"
    with zipfile.ZipFile(io.BytesIO(wrapped(running / "live/study.zip.js"))) as study:
        for file in ("tunneller_lib/__init__.py", "notebooks/contents.toml"):
            assert study.read(file) == (ROOT / file).read_bytes()
    found = {p.name for p in (running / "live/licences").rglob("*") if p.is_file()}
    assert {"LICENSE", "Pyodide-MPL-2.0.txt", "Python-PSF-2.0.txt"} <= found
    for name, year in (("vtk.js", "2016"), ("trame-vtk", "2022")):
        text = (running / "scenes" / "licences" / f"{name}-BSD-3-Clause.txt").read_text()
        assert f"Copyright (c) {year}, Kitware Inc." in text


@pytest.mark.parametrize(
    "name", ["site/site.js", "site/scheme.js", "site/style.css", "site/dark.css", "site/page.html",
             "live/live.js", "live/worker.js", "live/planner.js", "live/geodesic.js",
             "live/live.css"]
)  # fmt: skip
def test_no_own_script_or_style_names_an_address(name):
    text = (ROOT / "report" / name).read_text()
    text = re.sub(r"^\s*//.*$|/\*.*?\*/", "", text, flags=re.M | re.S)
    assert set(re.findall(r"https?://[^/\"]+", text)) <= {"https://local.invalid"}
