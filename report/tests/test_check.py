"""`make check`: what a change reaches, no more and no less; `make test`: it ends."""

import json
import subprocess

import pytest

from report.tests import check

READS = [
    "notebooks/*.ipynb", "notebooks/*.csv", "notebooks/contents.toml", "report/numbers/*",
    "tests/references/*", "environment.txt",
]  # fmt: skip


@pytest.fixture
def reached(monkeypatch):
    def asked(*names, before=None):
        monkeypatch.setattr(check, "git", lambda *command: before)
        return check.reached(set(names))

    return asked


def test_prose_reaches_the_report_the_pages_the_equations_and_the_words_alone(reached):
    expected = ["displayed", "inline", "paper_pages", "report", "words"]
    found = [f"report/tests/test_{name}.py" for name in expected]
    assert reached("report/sections/rods.typ") == found


def test_leaf_reaches_its_tests_its_doctests_and_its_notebook(reached):
    found = reached("tunneller_lib/paths/cone_chord.py")
    assert found[-1] == "tunneller_lib/paths/cone_chord.py"
    assert "tests/test_cone_chord.py" in found and "report/tests/test_report.py" not in found
    assert [n for n in found if n.startswith("notebooks")] == ["notebooks/08_cone.ipynb"]


TORUS = "tunneller_lib/surfaces/torus.py"


def test_docstring_reaches_the_doctests_and_what_reads_the_text_alone(reached):
    text = (check.ROOT / TORUS).read_text()
    found = reached(TORUS, before=text.replace('"""', '"""Once: ', 1))
    names = ["report/tests/test_live_programs", "report/tests/test_site", "tests/test_layout",
             "tests/test_public", "tests/test_wheel"]  # fmt: skip
    assert found == [*(f"{name}.py" for name in names), TORUS]


def test_notebook_and_its_data_reach_it(reached):
    assert "notebooks/11_rivals.ipynb" in reached("notebooks/atlas.csv")
    found = [n for n in reached("notebooks/11_rivals.ipynb") if n.startswith("notebooks")]
    assert found == ["notebooks/11_rivals.ipynb"]


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("markdown", ["contents", "dist", "site", "chord_paths", "layout"]),
        ("code", ["live_programs"]),
    ],
)
def test_notebook_is_run_where_its_code_changed_and_not_for_a_word_of_its_text(
    reached, kind, names
):
    name = "notebooks/11_rivals.ipynb"
    before = json.loads((check.ROOT / name).read_text())
    next(cell for cell in before["cells"] if cell["cell_type"] == kind)["source"] = ["another"]
    found = reached(name, before=json.dumps(before))
    assert (name in found) == (kind == "code")
    tests = [one.partition("test_")[2].removesuffix(".py") for one in found if "/test_" in one]
    assert tests == names if kind == "markdown" else set(tests) > set(names)


def test_ground_reaches_all(reached):
    assert reached("environment.txt") == ["notebooks", "report/tests", "tests", "tunneller_lib"]


def test_commit_that_is_none_is_refused():
    with pytest.raises(SystemExit, match=r"^SINCE: must name a commit; got 'no such'\.$"):
        check.changed("no such")


def test_new_files_count_in_the_studys_folders_alone(monkeypatch, tmp_path):
    for folder in (*check.STUDY, "plain"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "new.py").touch()
    (tmp_path / "notes.txt").touch()
    monkeypatch.setattr(check, "ROOT", tmp_path)
    for command in (["init"], ["commit", "--allow-empty", "-m", "none"]):
        who = ["-c", "user.name=nobody", "-c", "user.email=nobody@example.org"]
        subprocess.run(["git", *who, *command, "--quiet"], cwd=tmp_path, check=True)
    assert check.changed("HEAD") == {f"{folder}/new.py" for folder in check.STUDY}


def test_tests_answer_for_the_study_s_files_and_not_for_a_visitor_s(request, tmp_path, monkeypatch):
    ours = ["README.md", "notebooks/job.toml", "report/ledger/rows.toml"]
    others = ["tunneller_lib.egg-info/PKG-INFO", "plain/pyvenv.cfg", ".coverage", "build/lock"]
    for name in [*ours, *others]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    conftest = request.config.pluginmanager.getplugin(str(check.ROOT / "conftest.py"))
    monkeypatch.setattr(conftest, "ROOT", tmp_path)
    monkeypatch.setattr(conftest, "opened", {str(tmp_path / name) for name in [*ours, *others]})
    assert conftest.unsaid(None) == ours
