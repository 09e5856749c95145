"""How `make mutants` plants faults and keeps what it finds: tried on a library of two modules."""

import sys

import pytest

from tests.audit import mutants
from tests.audit.mutants import Mutant


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


def test_tests_are_those_that_lead_to_a_module_the_nearest_first(study):
    mutants.copy()
    assert mutants.tests_of("tunneller_lib/one.py") == ["tests/test_one.py", "tests/test_far.py"]
    assert mutants.tests_of("tunneller_lib/two.py") == ["tests/test_far.py"]


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
