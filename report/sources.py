"""Say what the study is made from, as digests of contents: file times are never looked at."""

import hashlib
import json
import sys
import tomllib
from pathlib import Path

from report.reach import meaning, needed, package_of

ROOT = Path(__file__).resolve().parent.parent
INDEX = "00_index"  # the notebook that tells what the others found
SCENES = Path("build", "scenes")  # what the web pages turn; not committed
WRITTEN = (".typ", ".toml", ".bib")  # what the report consists of, besides results
DRAWS_SCENES = Path("notebooks", "kit", "scene.py")  # needs an off-screen GL library


def digest(*parts):
    """Return one digest of a sequence of byte strings."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(len(part).to_bytes(8, "big") + part)
    return whole.hexdigest()


def file_digests(root, paths):
    """Return the digest of each file's content by its name; one that's missing has none."""
    return {
        str(path.relative_to(root)): digest(path.read_bytes()) if path.is_file() else None
        for path in sorted(paths)
    }


def notebooks(root=ROOT):
    """Return the study's notebooks, which have a number; a reader's own are left alone."""
    return sorted((root / "notebooks").glob("[0-9]*.ipynb"))


def cells(notebook):
    """Return what its author wrote in a notebook, without what running it left there."""
    return [(cell["cell_type"], "".join(cell["source"])) for cell in _content(notebook)]


def code(notebook):
    """Return the Python of a notebook as one text, IPython's own commands left out."""
    lines = "\n".join(source for kind, source in cells(notebook) if kind == "code").split("\n")
    return "\n".join("" if line.startswith(("%", "!")) else line for line in lines)


def is_run(notebook):
    """Tell whether a notebook is stored as one run from top to bottom leaves it."""
    code = [cell for cell in _content(notebook) if cell["cell_type"] == "code"]
    return [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))


def _content(notebook):
    # Not by nbformat, which takes two seconds to import.
    try:
        return json.loads(notebook.read_bytes())["cells"]
    except (ValueError, KeyError, TypeError):
        sys.exit(f"{notebook.name} is no notebook: its JSON is broken.")


def records(notebook):
    """Return the file of a notebook's numbers and what it holds."""
    file = notebook.parent.parent / "report" / "numbers" / f"{notebook.stem}.json"
    try:
        return file, json.loads(file.read_bytes())
    except (FileNotFoundError, ValueError):  # a damaged one holds nothing, and is made again
        return file, {}


def figure_files(notebook):
    """Return the files of a notebook's figures."""
    folder = notebook.parent.parent / "figures"
    figures = records(notebook)[1].get("figures", {})
    return [folder / figure["file"] for _, figure in sorted(figures.items())]


def scene_files(notebook):
    """Return the files of the scenes that a notebook left when it was run, by cell."""
    return sorted((notebook.parent.parent / SCENES / notebook.stem).glob("*.vtksz"))


def draws_scenes(path, root=ROOT):
    """Tell whether a notebook or a module draws in space, which takes an off-screen GL library."""
    if path.suffix == ".ipynb":
        return root / DRAWS_SCENES in needed(code(path), root)
    text = path.read_text(encoding="utf-8")
    return root / DRAWS_SCENES in needed(text, root, package_of(path, root))


def notebook_sources(notebook):
    """Return digests, by name, of all that the results of a notebook depend on.

    A module counts by its meaning: comments and docstrings change no result.
    """
    root = notebook.parent.parent
    text = code(notebook)
    files = needed(text, root)
    python = {file for file in files if file.suffix == ".py"}
    modules = {
        str(file.relative_to(root)): meaning(file.read_text(encoding="utf-8"))
        for file in sorted(python)
    }
    data = [
        file
        for folder in ("notebooks", "tests/references")
        for file in (root / folder).glob("*.csv")
        if file.name in text
    ]
    shared = file_digests(root, [root / "environment.txt", *data, *files - python])
    written = {"its cells": _of(cells(notebook)), "its place in the study": _place(notebook)}
    return written | modules | shared


def _place(notebook):
    """Return the digest of what a notebook tells of the study: the index of all, others of near."""
    every = notebooks(notebook.parent.parent)
    file = notebook.with_name("contents.toml")
    contents = tomllib.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    if notebook.stem == INDEX:
        others = [other for other in every if other != notebook]
        return _of(contents, [[n.name, cells(n), records(n)[1]] for n in others])
    at = every.index(notebook)
    near = [n.name for n in every[max(at - 1, 0) : at + 2]]
    return _of(contents.get("found", {}).get(notebook.stem), near)


def _of(*things):
    return digest(json.dumps(things).encode())


def results_digest(root=ROOT):
    """Return the one digest of the results that the report shows: its numbers and figures."""
    made = [file for n in notebooks(root) for file in (records(n)[0], *figure_files(n))]
    return _of(file_digests(root, made))


def report_sources(root=ROOT):
    """Return digests, by name, of all that the report is made from."""
    report = root / "report"
    written = [p for p in report.rglob("*") if p.suffix in WRITTEN and p.is_file()]
    named = ["environment.txt", "CITATION.cff", "tests/audit/recognised.csv"]
    files = [*written, report / "compile.py", *(root / name for name in named)]
    return file_digests(root, files) | {"the results": results_digest(root)}
