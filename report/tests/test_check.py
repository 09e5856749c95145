"""`make check`: what a change reaches, no more and no less; `make test`: it ends."""

import subprocess
import sys

import pytest

from report.tests import check

READS = ["notebooks/*", "report/numbers/*", "tests/references/*", "environment.txt"]


@pytest.fixture
def reached(monkeypatch):
    def asked(*names, before=None):
        monkeypatch.setattr(check, "git", lambda *command: before)
        return check.reached(set(names))

    return asked


def test_prose_reaches_the_report_the_pages_the_equations_and_the_words_alone(reached):
    expected = ["report", "paper_pages", "displayed", "inline", "words"]
    found = [f"report/tests/test_{name}.py" for name in expected]
    assert reached("report/sections/rods.typ") == found


def test_leaf_reaches_its_tests_its_doctests_and_its_notebook(reached):
    found = reached("tunneller_lib/paths/cone_chord.py")
    assert found[-1] == "tunneller_lib/paths/cone_chord.py"
    assert "tests/test_cone_chord.py" in found and "report/tests/test_report.py" not in found
    assert [n for n in found if n.startswith("notebooks")] == ["notebooks/08_cone.ipynb"]


TORUS = "tunneller_lib/surfaces/torus.py"


def test_comment_reaches_nothing(reached):
    text = (check.ROOT / TORUS).read_text()
    assert "# " in text
    assert reached(TORUS, before="# once\n\n" + text.replace("# ", "# not ")) == []


def test_docstring_reaches_the_doctests_and_what_reads_the_text_alone(reached):
    text = (check.ROOT / TORUS).read_text()
    found = reached(TORUS, before=text.replace('"""', '"""Once: ', 1))
    shelf = (
        "report/tests/test_site.py",
        "tests/test_layout.py",
        "report/tests/test_live_programs.py",
    )
    assert found == [*shelf, "tests/test_public.py", "tests/test_wheel.py", TORUS]


def test_code_that_was_no_python_reaches_all_that_imports_it(reached):
    assert reached(TORUS, before="def") == reached(TORUS) != []


def test_notebook_and_its_data_reach_it(reached):
    assert "notebooks/11_rivals.ipynb" in reached("notebooks/atlas.csv")
    found = [n for n in reached("notebooks/11_rivals.ipynb") if n.startswith("notebooks")]
    assert found == ["notebooks/11_rivals.ipynb"]


def test_longest_tests_are_there():
    assert all((check.ROOT / f"{name}.py").exists() for name in check.LONGEST)


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


def test_worker_that_dies_ends_the_run_with_the_name_of_its_test(tmp_path):
    (tmp_path / "test_dying.py").write_text("import os\n\ndef test_dies():\n    os._exit(3)\n")
    recipe = [
        "make",
        "--no-print-directory",
        "--dry-run",
        "test",
        f"TESTS={tmp_path} -c /dev/null -o addopts=",
    ]
    said = subprocess.run(recipe, cwd=check.ROOT, capture_output=True, text=True).stdout
    command = said[said.index("OPENBLAS") :]  # without the set-up and the linter
    run = subprocess.run(
        command, shell=True, cwd=check.ROOT, capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 1
    assert "crashed while running" in run.stdout and "test_dies" in run.stdout
    assert "worker restarting disabled" in run.stdout


def test_tests_answer_for_the_study_s_files_and_not_for_a_visitor_s(tmp_path, monkeypatch):
    ours = ["README.md", "notebooks/job.toml", "report/ledger/rows.toml"]
    others = ["tunneller_lib.egg-info/PKG-INFO", "plain/pyvenv.cfg", ".coverage", "build/lock"]
    for name in [*ours, *others]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    conftest = sys.modules["conftest"]
    monkeypatch.setattr(conftest, "ROOT", tmp_path)
    monkeypatch.setattr(conftest, "opened", {str(tmp_path / name) for name in [*ours, *others]})
    assert conftest.unsaid(None) == ours
