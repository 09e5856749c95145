"""The report as a page, and its tables for the chapters: set by Typst, as the PDF is."""

import base64
import hashlib
import json
import re
from itertools import chain, count

import typst

from report.compile import inputs, release_date
from report.site.markup import anchor
from report.site.pictures import sizes
from report.sources import ROOT, notebooks, records

STYLE = re.compile(r"<style>(.*?)</style>", re.S)
BODY = re.compile(r"<body>(.*)</body>", re.S)
EMBEDDED = re.compile(
    r'src="data:image/[\w+]+;base64,([^"]+)"( alt="[^"]*")?(?: width="\d+" height="\d+")?'
)
FIGURE = re.compile(r'<figure(?: id="([^"]*)")?>(.*?)<figcaption>(.*?)</figcaption>', re.S)
NUMBERED = re.compile(r"^(\w+\s\d+):(?:<span[^>]*>[^<]*</span>)?\s*")
NUMBER = re.compile(r"^\s*\d[\d.]*\s+")  # of a section, which another may have tomorrow
HEADING = re.compile(r"<h([2-4])([^>]*)>(.*?)</h\1>", re.S)


def to_html(source):
    """Return the style and body that Typst makes of a file or of a text in report/."""
    html, _ = typst.compile_with_warnings(
        source,
        root=ROOT,
        ignore_system_fonts=True,
        sys_inputs=inputs(ROOT) | {"target": "html"},
        timestamp=release_date(ROOT),
        format="html",
    )
    html = html.decode()
    # Layout is the style sheet's here, so Typst's warnings of what it left out are expected.
    return STYLE.search(html)[1], BODY.search(html)[1]


def report_page(name):
    """Return a document's style and its body, each figure by its file."""
    figures = {digest(path.read_bytes()): path.name for path in (ROOT / "figures").iterdir()}
    style, body = to_html(ROOT / "report" / f"{name}.typ")

    def by_file(match):
        content = base64.b64decode(match[1])
        name = figures[digest(content)]
        return f'loading="lazy" {sizes(content)} src="figures/{name}"{match[2] or ""}'

    names = set(re.findall(r'\bid="([^"]+)"', body))

    def named(match):
        level, attributes, text = match.groups()
        found = re.search(r'id="([^"]+)"', attributes)
        name = found[1] if found else unused(anchor(NUMBER.sub("", text)), names)
        names.add(name)
        kept = attributes if found else f'{attributes} id="{name}"'
        return f"<h{level}{kept}>{text}</h{level}>"

    body = HEADING.sub(named, EMBEDDED.sub(by_file, body))
    return style, body


def unused(name, names):
    """Return a name that none of others is: itself, or with the first number that is free."""
    numbered = (f"{name}-{number}" for number in count(2))
    return next(one for one in chain([name], numbered) if one not in names)


def captions(body, called="supplement"):
    """Return each figure's caption, its number a link into the report, by the figure's file."""
    return {
        file: NUMBERED.sub(rf'<a href="#{name}">\1</a> of the {called}: ', caption.strip())
        for name, content, caption in FIGURE.findall(body)
        for file in re.findall(r'src="figures/([^"]+)"', content)
    }


def tables():
    """Return each recorded table as HTML, by notebook and name."""
    names = [
        (notebook.stem, name)
        for notebook in notebooks()
        for name in records(notebook)[1].get("tables", {})
    ]
    calls = (f"tab({json.dumps(stem)}, {json.dumps(name)})" for stem, name in names)
    text = "".join(f'#html.elem("section", {call})\n' for call in calls)
    _, body = to_html(f'#import "/report/lib.typ": tab\n{text}'.encode())
    found = re.findall(r"<section>(.*?)</section>", body, re.S)
    return dict(zip(names, found, strict=True))


def digest(content):
    return hashlib.sha256(content).hexdigest()
