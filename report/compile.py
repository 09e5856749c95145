"""Compile the report and its companions: the same sources give the same bytes everywhere."""

import json
import re
import tempfile
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import typst

from kit.style import FONTS
from report.sources import ROOT, results_digest

STANDARDS = ["a-2b", "ua-1"]  # to be kept: fonts, colours, date inside; and to be heard
FORMULA = re.compile(r"(?<!\\)\$(?=\S)((?:[^$\\]|\\.)*?)(?<=\S)\$", re.S)  # within a line
NAMED = "numpy scipy matplotlib pyvista vtk sympy mpmath typst".split()


class ReportFailed(Exception):
    """A report that can't be compiled; the message is Typst's."""


def versions(root=ROOT):
    """Return the pinned versions of the packages that the report names."""
    text = (root / "environment.txt").read_text(encoding="utf-8")
    pins = dict(re.findall(r"^([\w.-]+)==([^\s;\\]+)", text, re.M))
    return {name: pins[name] for name in NAMED}


def release_date(root=ROOT):
    """Return the date of the edition; with today's no two builds would agree."""
    text = (root / "CITATION.cff").read_text(encoding="utf-8")
    day = re.search(r"^date-released: (\S+)$", text, re.M)[1]
    return datetime.fromisoformat(day).replace(tzinfo=UTC)


def inputs(root=ROOT):
    """Return the inputs that the report's sources read from Typst."""
    return {"hash": results_digest(root)[:16], "versions": json.dumps(versions(root))}


def with_words(text):
    """Return a text with each formula within a line wrapped in the call that adds its words.

    Examples
    --------
    >>> with_words("for $R > r$; else")
    'for #inline($R > r$);; else'
    """
    return FORMULA.sub(r"#inline($\1$);", text)  # the semicolon ends the call and isn't printed


@contextmanager
def spoken_copy(root):
    """Make a copy of the sources in which each formula within a line is given its words.

    Typst wants an alternative text of every formula where it stands; no rule can add it later. The
    prose keeps its `$x$`.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        _link(root, copy, but="report")
        _link(root / "report", copy / "report", but="sections")
        _link(root / "report" / "sections", copy / "report" / "sections")
        prose = [root / "report" / f"{name}.typ" for name in ("report", "supplement", "corrigenda")]
        for source in [*prose, *(root / "report" / "sections").glob("*.typ")]:
            if source.exists():
                target = copy / source.relative_to(root)
                target.unlink()
                target.write_text(with_words(source.read_text("utf-8")), "utf-8")
        yield copy


def _link(folder, copy, but=None):
    copy.mkdir(exist_ok=True)
    for entry in folder.iterdir() if folder.is_dir() else []:
        if entry.name != but:
            (copy / entry.name).symlink_to(entry.resolve())


def compile_report(root=ROOT, name="report"):
    """Return the report, or another of the documents beside it, as the bytes of a PDF.

    Parameters
    ----------
    root : pathlib.Path
        The folder that holds report, figures, notebooks, tests and environment.txt.
    name : str
        Of the source, without its suffix.

    Raises
    ------
    ReportFailed
        If Typst finds an error or gives a warning, such as an unknown font.
    """
    with spoken_copy(root) as copy:
        try:
            pdf, warnings = typst.compile_with_warnings(
                copy / "report" / f"{name}.typ",
                root=copy,
                font_paths=[FONTS],
                ignore_system_fonts=True,
                sys_inputs=inputs(root),
                timestamp=release_date(root),
                pdf_standards=STANDARDS,
            )
        except typst.TypstError as error:
            raise ReportFailed(f"{name}.typ: {error.diagnostic}") from None
    if warnings:
        raise ReportFailed(f"{name}.typ: {warnings[0].diagnostic}")
    return pdf
