"""The report: made from its sources alone, every record used and every use recorded."""

import json
import re
import shutil

import pytest
import typst

from report.compile import ReportFailed, compile_report
from report.lists import (
    DOCUMENTS,
    FIGURE_LIST,
    PDFS,
    RECORD_LIST,
    VERDICT_LIST,
    figure_list,
    record_list,
    uses,
    verdict_list,
)
from report.sources import ROOT, figure_files, notebooks, records
from report.tests.check import git
from report.tests.prose import sources

READS = [
    "report/*",
    "figures/*",
    "notebooks/*.ipynb",
    "notebooks/*.toml",
    "environment.txt",
    "CITATION.cff",
    "tests/audit/recognised.csv",
]


@pytest.fixture(scope="module")
def compiled():
    return {name: compile_report(name=name) for name in DOCUMENTS}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_report_is_what_its_sources_give(compiled, name):
    if compiled[name] != PDFS[name].read_bytes():  # not an assertion, which would print two PDFs
        pytest.fail(f"{name}.pdf is stale: `make report` renews it.", pytrace=False)


def test_report_of_a_copy_has_the_same_bytes(copy, compiled):
    """The folder, the time, the code and what was built before leave no trace."""
    assert compile_report(copy) == compiled["report"]


def test_lists_are_what_the_records_give():
    assert FIGURE_LIST.read_text() == figure_list()
    assert RECORD_LIST.read_text() == record_list()
    assert VERDICT_LIST.read_text() == verdict_list()


def test_every_record_is_used_and_every_use_recorded():
    recorded = {
        (notebook.stem, kind, name)
        for notebook in notebooks()
        for kind, entries in records(notebook)[1].items()
        for name in entries
    }
    assert uses().keys() == recorded


def test_folders_hold_nothing_but_records():
    figures = [file for notebook in notebooks() for file in figure_files(notebook)]
    assert len(figures) == len(set(figures)), "two notebooks make the same figure"
    assert {*figures, FIGURE_LIST} == committed("figures")
    numbers = {records(notebook)[0] for notebook in notebooks()}
    assert committed("report/numbers") <= numbers


def committed(folder):
    """Return the files of a folder that git keeps, or all where the checkout is none of git's."""
    known = git("ls-files", folder)
    names = (
        known.splitlines() if known else [f"{folder}/{f.name}" for f in (ROOT / folder).iterdir()]
    )
    return {ROOT / name for name in names}


@pytest.fixture
def copy(tmp_path):
    """Return a study of its own, with a report that says what a test wants."""
    shutil.copytree(ROOT / "report", tmp_path / "report")
    for folder in ("figures", "notebooks"):  # which no test changes
        (tmp_path / folder).symlink_to(ROOT / folder)
    (tmp_path / "tests").mkdir()
    for file in ("environment.txt", "CITATION.cff"):
        shutil.copy(ROOT / file, tmp_path / file)
    return tmp_path


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('#num("none", "it")', "file not found"),
        ('#num("a", "it")', "Notebook a records nothing named 'it' among its numbers."),
        ('#than("a", "it", "less")', "Notebook a records nothing named 'it' among its orders."),
        ('#than("a", "one", "longer")', "records 'one' as less, which isn't 'longer'."),
        ('#than("a", "one", "shortish")', "records 'one' as less, which isn't 'shortish'."),
        ('#count("a", "half")', "Notebook a counts nothing as 'half'."),
        ('#rows-of("tunneller", "right")', "The ledger has no verdict 'right'."),
        ('#tab("a", "it")', "Notebook a records nothing named 'it' among its tables."),
        ('#fig("a", "it", [])', "Notebook a records nothing named 'it' among its figures."),
        ('#verdicts-of("eq99")', "The ledger has no row 'eq99'."),
        ('#text(font: "No Such Font")[a]', "unknown font family"),
    ],
)
def test_wrong_use_is_refused(copy, text, message):
    half = {"value": 0.5, "unit": "", "digits": 1, "text": "0.5", "cell": 1}
    recorded = {"numbers": {"half": half}, "orders": {"one": {"order": "less", "cell": 1}}}
    (copy / "report" / "numbers" / "a.json").write_text(json.dumps(recorded))
    (copy / "report" / "report.typ").write_text(f'#import "lib.typ": *\n{text}')
    with pytest.raises(ReportFailed) as error:
        compile_report(copy)
    assert message in str(error.value)


# What may stand in the report's prose as digits: what the documents and the notebooks take as
# given, section and figure numbers.
GIVEN = {"0.5", "0.3", "0.1", "1", "3.1", "3.3.1", "3.3.2", "4.3", "40°", "60°", "35°", "90°", "5°",
         "10°", "30°", "20°"}  # fmt: skip
# Calls that read records, labels, formulas and code hold no results.
NOT_PROSE = re.compile(
    r"//[^\n]*|`[^`]*`|#(?:import|bibliography|set)[^\n]*|<[\w-]+>|@[\w-]+"
    r"|\b\w+: *(?:\"[^\"]*\"|[\d.]+(?:%|pt))|#?\w[\w.-]*\((?:\"[^\"]*\"(?:, *)?)+"
)
RESULT = re.compile(r"(?<![\w.])\d+(?:\.\d+)*(?:°|(?= ?(?:mm|%|ppm)\b))|(?<![\w.])\d+\.\d[\d.]*")


def test_no_result_is_typed_in_the_report():
    for path in sources():
        prose = NOT_PROSE.sub(" ", path.read_text())
        assert {number.rstrip(".") for number in RESULT.findall(prose)} - GIVEN == set(), path


def test_every_figure_of_the_pdf_has_its_text():
    texts = [path.read_text() for path in (ROOT / "report").rglob("*.typ")]
    figures = sum(len(re.findall(r'#fig\("', text)) for text in texts)
    pdfs = b"".join(PDFS[name].read_bytes() for name in ("report", "supplement"))
    assert pdfs.count(b"/Alt") >= figures > 0


def test_pdfs_can_be_kept_and_heard():
    """They declare the standards that Typst checked: PDF/A-2b and PDF/UA-1."""
    for pdf in PDFS.values():
        metadata = re.search(rb"<x:xmpmeta.*?</x:xmpmeta>", pdf.read_bytes(), re.S)[0]
        for standard in (b"pdfaid:part>2<", b"pdfaid:conformance>B<", b"pdfuaid:part>1<"):
            assert standard in metadata, (pdf.name, standard)


WORDS = {
    "R\\/r": "capital r over r",
    "w'' + w = psi": "w prime prime plus w equals psi",
    "sqrt(m_1^2 + m_3^2)": "the square root of m sub 1 squared plus m sub 3 squared end root",
    "-60° <= theta": "minus 60 degrees is at most theta",
    "F = 1/(2 Theta)": "capital f equals the fraction 1 over 2 capital theta end",
    "x^(n+1)": "x to the power n plus 1",
    "integral_0^a tilde(y) dif y": "the integral from 0 to a of y tilde d y",
    "sum_(i+j=3) vec(x, y)": "the sum over i plus j equals 3 of the vector with parts x, and y end "
    "vector",
}


@pytest.mark.parametrize("formula", WORDS)
def test_formula_has_its_words(formula):
    text = f'#import "/report/spoken.typ": spoken\n#metadata(spoken(${formula}$.body)) <words>'
    found = typst.query(text.encode(), "<words>", field="value", one=True, root=ROOT)
    assert json.loads(found) == WORDS[formula]
