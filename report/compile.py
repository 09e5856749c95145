"""Compile the report and the corrigenda: the same sources give the same bytes everywhere."""

import json
import re
from datetime import UTC, datetime

import typst

from report.sources import ROOT, results_digest

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
    """Return what the report's source is told from outside."""
    return {"hash": results_digest(root)[:16], "versions": json.dumps(versions(root))}


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
    try:
        pdf, warnings = typst.compile_with_warnings(
            root / "report" / f"{name}.typ",
            root=root,
            ignore_system_fonts=True,
            sys_inputs=inputs(root),
            timestamp=release_date(root),
            pdf_standards="a-2b",  # to be kept: fonts, colours and date inside
        )
    except typst.TypstError as error:
        raise ReportFailed(f"{name}.typ: {error.diagnostic}") from None
    if warnings:
        raise ReportFailed(f"{name}.typ: {warnings[0].diagnostic}")
    return pdf
