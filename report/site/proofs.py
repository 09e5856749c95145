"""The tests that the ledger names, as pages."""

import ast
import tomllib
from itertools import pairwise

from report.site.markup import breakable, code
from report.sources import ROOT


def proofs():
    """Return the files that the ledger's rows name."""
    ledgers = sorted((ROOT / "report" / "ledger").glob("*.toml"))
    rows = [row for file in ledgers for row in tomllib.loads(file.read_text()).values()]
    return sorted({ROOT / row["proof"].partition("::")[0] for row in rows})


def proof_page(path):
    """Return the page of a file of tests, from the site's root."""
    return f"tests/{path.stem}.html"


def proof_html(path):
    """Return a file of tests as HTML: each function under its name, with what leads to it."""
    text = path.read_text()
    tree, lines = ast.parse(text), text.splitlines(keepends=True)
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    first = [min(part.lineno for part in (node, *node.decorator_list)) - 1 for node in functions]
    head, *rest = ("".join(lines[a:b]).strip("\n") for a, b in pairwise([0, *first, len(lines)]))
    named = (
        f'<h2 id="{f.name}">{breakable(f.name)}</h2>\n{code(part)}'
        for f, part in zip(functions, rest, strict=True)
    )
    return "\n".join([f"<h1>{breakable(path.name)}</h1>", code(head), *named])
