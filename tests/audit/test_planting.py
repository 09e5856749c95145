"""How `make mutants` plants faults and keeps what it finds: tried on a library of two modules."""

import sys

import pytest

from tests.audit import mutants
from tests.audit.mutants import Mutant, Verdict


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Return a checkout of a library of two modules, with a test of each, and a build for it."""
    build = tmp_path / "build"
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    monkeypatch.setattr(mutants, "BUILD", build)
    monkeypatch.setattr(mutants, "COPY", build / "copy")
    monkeypatch.setattr(mutants, "TABLE", tmp_path / "mutants.csv")
    monkeypatch.setattr(mutants, "REASONS", tmp_path / "mutants.toml")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # its tests need none
    for name, text in STUDY.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    caches = (mutants.rules, mutants.reach, mutants.reach_of_notebooks, mutants.public,
              mutants.tests_of)  # fmt: skip
    for cached in caches:
        cached.cache_clear()
    yield tmp_path
    for cached in caches:
        cached.cache_clear()


FAR = "from tunneller_lib.two import g\n\n\ndef test_g():\n    assert g(2) == 4\n"
ONE = "from tunneller_lib.one import f\n\n\ndef test_f():\n    assert f(3, 1) == 6\n"
STUDY = {
    "tunneller_lib/__init__.py": "",
    "tunneller_lib/one.py": "def f(x, y):\n    return x**2 - 3 * y\n",
    "tunneller_lib/two.py": "from .one import f\n\n\ndef g(x):\n    return f(x, 0)\n",
    "tests/__init__.py": "",
    "tests/test_far.py": FAR,
    "tests/test_one.py": ONE,
    "tests/test_form.py": 'READS = ["tunneller_lib/*"]\n\n\ndef test_form():\n    assert False\n',
    "tests/test_none.py": "def test_none():\n    assert False\n",
    "pytest.ini": "[pytest]\n",
}


def plant(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["mutants", "--no-notebooks", "--workers", "2", *words])
    mutants.main()
    return capsys.readouterr()


def test_draw_is_the_same_each_time_and_changes_one_line(study):
    mutants.copy()
    file = "tunneller_lib/one.py"
    first, second = mutants.draw(file), mutants.draw(file)
    assert first == second and len(first) == 1
    assert any(mutants.draw(file, str(seed)) != first for seed in range(5))
    mutant = first[0]
    before, after = mutant.lines()
    assert [a != b for a, b in zip(before, after, strict=True)] == [False, True]
    assert isinstance(mutant, Mutant) and mutant.row("t")["killed by"] == "t"


def test_long_modules_have_more_faults(study):
    (study / "tunneller_lib" / "one.py").write_text("a = b + 1\n" * 250)
    mutants.copy()
    assert len(mutants.draw("tunneller_lib/one.py")) == 1 + len(mutants.LENGTHS)
    assert len({mutant.line for mutant in mutants.draw("tunneller_lib/one.py")}) == 3
    assert mutants.draw("tunneller_lib/one.py", each=5)[:3] == mutants.draw("tunneller_lib/one.py")
    assert len(mutants.draw("tunneller_lib/one.py", each=5)) == 5


def test_tests_are_those_that_lead_to_a_module_the_nearest_first(study):
    mutants.copy()
    assert mutants.tests_of("tunneller_lib/one.py") == ["tests/test_one.py", "tests/test_far.py"]
    assert mutants.tests_of("tunneller_lib/two.py") == ["tests/test_far.py"]


def test_what_runs_a_module_by_its_name_leads_to_it(study):
    for number, text in enumerate(("import_module('tunneller_lib.one')", "f'tunneller_lib.{a}'")):
        (study / "tests" / f"test_names{number}.py").write_text(text)
    mutants.copy()
    found = mutants.tests_of("tunneller_lib/one.py")
    assert {"tests/test_names0.py", "tests/test_names1.py"} <= set(found)
    assert "tests/test_names0.py" not in mutants.tests_of("tunneller_lib/two.py")


def test_faults_are_noticed_and_the_table_says_by_whom(study, monkeypatch, capsys):
    plant(monkeypatch, capsys)
    head, rows = mutants.read_table((study / "mutants.csv").read_text())
    score = f"all: {len(rows)} of {len(rows)}, 100.0 %"
    assert head[:3] == [f"seed {mutants.SEED}", "survivors met all tests", score]
    assert {row["file"]: row["killed by"] for row in rows}["tunneller_lib/one.py"] == (
        "tests/test_one.py::test_f"
    )
    # Again, it's known; a change leaves what was noticed.
    assert "not noticed" not in plant(monkeypatch, capsys).err


def test_parts_make_a_whole(study, monkeypatch, capsys):
    for part in ("1/2", "2/2"):
        plant(monkeypatch, capsys, "--shard", part)
    assert not (study / "mutants.csv").exists()
    monkeypatch.setattr(mutants, "try_all", lambda mutants, known, given, explained: None)
    plant(monkeypatch, capsys)
    _, rows = mutants.read_table((study / "mutants.csv").read_text())
    assert len(rows) == 2 and all(row["killed by"] for row in rows)


def test_few_survivors_of_the_nearest_tests_are_enough_for_a_table(study, monkeypatch, capsys):
    plant(monkeypatch, capsys, "--near")
    head, rows = mutants.read_table((study / "mutants.csv").read_text())
    assert head[1] == "survivors met the nearest tests only" and len(rows) == 2
    (study / "mutants.csv").unlink()
    (study / "tests" / "test_far.py").write_text(FAR.replace(" == 4", " is not None"))
    (study / "tunneller_lib" / "two.py").write_text("def g(x):\n    return x**2\n")
    said = plant(monkeypatch, capsys, "--near").err
    assert "No table: more than a twentieth survived" in said
    assert not (study / "mutants.csv").exists()


def test_modules_that_the_table_has_not_join_it(study, monkeypatch, capsys):
    plant(monkeypatch, capsys, "--of", "two")
    table = study / "mutants.csv"
    before = table.read_text()
    plant(monkeypatch, capsys, "--new")
    _, rows = mutants.read_table(table.read_text())
    assert [row["file"] for row in rows] == ["tunneller_lib/one.py", "tunneller_lib/two.py"]
    assert mutants.read_table(before)[1] == rows[1:]
    plant(monkeypatch, capsys, "--of", "one")
    assert len(mutants.read_table(table.read_text())[1]) == 2
    with pytest.raises(SystemExit, match="No table: its other faults are of another seed"):
        plant(monkeypatch, capsys, "--of", "one", "--seed", "other")


def test_state_of_tests_changes_with_what_they_reach(study):
    names = "tests/test_one.py", "tests/test_far.py", "tunneller_lib/two.py"

    def states():
        mutants.copy()
        return [mutants.state_of(name) for name in names]

    before = states()
    (study / "tunneller_lib" / "two.py").write_text("from .one import f\n\ng = f\n")
    middle = states()
    assert [a == b for a, b in zip(before, middle, strict=True)] == [True, False, False]
    (study / "tunneller_lib" / "one.py").write_text("def f(x, y):\n    return x - y\n")
    assert not any(a == b for a, b in zip(middle, states(), strict=True))


def test_tests_that_fail_by_themselves_are_named(study, monkeypatch, capsys):
    (study / "tests" / "test_one.py").write_text(ONE.replace("6", "7"))
    with pytest.raises(SystemExit, match=r"must pass before.*\ntests/test_one.py::test_f\n"):
        plant(monkeypatch, capsys)


def test_survivors_wait_for_tests_that_need_other_packages(study, monkeypatch, capsys):
    (study / "tests" / "test_one.py").write_text("import no_such_package\n" + ONE)
    (study / "tests" / "test_far.py").write_text(FAR.replace(" == 4", " is not None"))
    with pytest.raises(SystemExit, match=r"wait for tests that need other packages"):
        plant(monkeypatch, capsys)
    assert not (study / "mutants.csv").exists()


def test_what_fails_by_chance_does_not_count(study, monkeypatch):
    said = iter([("tests/a.py::test_a", ""), ("", ""), ("", "")])
    asked = []

    def run(tree, tests, limit, *, bare, passing=()):
        asked.append((tests, list(passing)))
        return next(said)

    monkeypatch.setattr(mutants, "run", run)
    assert mutants.notice(["tests/a.py"], 9, True) == ""
    name = "tests/a.py::test_a"
    assert asked == [(["tests/a.py"], []), ([name], []), (["tests/a.py"], [name])]


def test_verdicts_are_final_until_something_changes():
    assert Verdict(by="it").final("x", mutants.NOTEBOOKS)
    survived = Verdict(of="x", lot=mutants.TESTS)
    assert survived.final("x", mutants.TESTS) and not survived.final("y", mutants.TESTS)
    assert not survived.final("x", mutants.NOTEBOOKS)
    assert not Verdict(of="x", lot=mutants.TESTS, left=("a",)).final("x", mutants.TESTS)
