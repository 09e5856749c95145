"""Say what the study is made from, as digests of contents: file times are never looked at."""

import hashlib
import json
import sys
from pathlib import Path

import nbformat

ROOT = Path(__file__).resolve().parent.parent
INDEX = "00_index"  # the notebook that tells what the others found
SCENES = Path("build", "scenes")  # what the web pages turn; not committed
WRITTEN = (".typ", ".toml", ".bib")  # what the report consists of, besides results


def digest(*parts):
    """Return one digest of a sequence of byte strings."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "big") + part)
    return whole.hexdigest()


def file_digest(root, paths):
    """Return one digest of names and contents; a file that's missing counts as well."""
    parts = []
    for path in paths:
        parts += [
            str(path.relative_to(root)).encode(),
            path.read_bytes() if path.exists() else b"-",
        ]
    return digest(*parts)


def notebooks(root=ROOT):
    """Return the study's notebooks, which have a number; a reader's own are left alone."""
    return sorted((root / "notebooks").glob("[0-9]*.ipynb"))


def cells(notebook):
    """Return what its author wrote in a notebook, without what running it left there."""
    try:
        content = nbformat.read(notebook, as_version=4)
    except nbformat.reader.NotJSONError:
        sys.exit(f"{notebook.name} is no notebook: its JSON is broken.")
    return [(cell.cell_type, cell.source) for cell in content.cells]


def is_run(notebook):
    """Tell whether a notebook is stored as one run from top to bottom leaves it."""
    code = [c for c in nbformat.read(notebook, as_version=4).cells if c.cell_type == "code"]
    return [c.execution_count for c in code] == list(range(1, len(code) + 1))


def records(notebook):
    """Return the file of a notebook's numbers and what it holds."""
    file = notebook.parent.parent / "report" / "numbers" / f"{notebook.stem}.json"
    return file, json.loads(file.read_text()) if file.exists() else {}


def figure_files(notebook):
    """Return the files of a notebook's figures."""
    folder = notebook.parent.parent / "figures"
    figures = records(notebook)[1].get("figures", {})
    return [folder / figure["file"] for _, figure in sorted(figures.items())]


def scene_files(notebook):
    """Return the files of the scenes that a notebook left when it was run, by cell."""
    return sorted((notebook.parent.parent / SCENES / notebook.stem).glob("*.vtksz"))


def notebook_sources(notebook):
    """Return the digest of all that the results of a notebook depend on."""
    root = notebook.parent.parent
    code, folders = (root / "tunneller_lib").rglob("*.py"), ("notebooks", "tests/references")
    data = [file for folder in folders for file in sorted((root / folder).glob("*.csv"))]
    shared = [root / "environment.txt", notebook.with_name("contents.toml"), *sorted(code), *data]
    written = [cells(notebook)]
    if notebook.stem == INDEX:
        others = [other for other in notebooks(root) if other != notebook]
        shared += [records(n)[0] for n in others]
        written += [[n.name, cells(n)[0]] for n in others]
    return digest(json.dumps(written).encode(), file_digest(root, shared).encode())


def notebook_results(notebook):
    """Return the digest of all that running a notebook leaves, its own stored outputs included."""
    files = [notebook, records(notebook)[0], *figure_files(notebook)]
    return file_digest(notebook.parent.parent, files)


def report_sources(root=ROOT):
    """Return the one digest of everything that the report is made from."""
    report = root / "report"
    written = [report / "compile.py", *(p for p in report.rglob("*") if p.suffix in WRITTEN)]
    written += [root / "tests" / "mutants.csv", root / "tests" / "mutants.toml"]
    made = [file for n in notebooks(root) for file in (records(n)[0], *figure_files(n))]
    parts = [notebook_sources(n) for n in notebooks(root)]
    return digest(*map(str.encode, parts), file_digest(root, sorted(written) + made).encode())
