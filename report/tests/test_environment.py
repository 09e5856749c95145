"""The environment .venv: a package that is gone or of another version is noticed, by name."""

import shutil
import sys
from pathlib import Path

import pytest

from report import environment as module
from report.environment import Environment, main

READS = ["environment.txt"]


@pytest.fixture
def installed(tmp_path):
    """An environment with one package, and the package's record."""
    environment = Environment()
    environment.folder = tmp_path
    packages = tmp_path / "lib" / "python3.11" / "site-packages"
    return environment, recorded(packages, "thing-1.0")


def recorded(packages, name):
    """Leave a package's record, as pip does; return it."""
    record = packages / f"{name}.dist-info" / "RECORD"
    record.parent.mkdir(parents=True)
    record.write_text(f"{name}.dist-info/RECORD,,\n")
    return record


@pytest.fixture
def whole(installed, tmp_path):
    """That environment as `install` leaves it."""
    environment, record = installed
    environment.python, environment.stamp = Path(sys.executable), tmp_path / "stamp"
    environment.settle()
    environment.stamp.write_text("\n".join([environment.wanted(), *environment.packages()]))
    assert environment.is_whole()
    return environment, record.parent.parent


def test_package_in_another_version_is_noticed(whole, capsys):
    environment, packages = whole
    (packages / "thing-1.0.dist-info").rename(packages / "thing-1.0.1.dist-info")
    assert not environment.is_whole()
    said = capsys.readouterr().out
    assert said.endswith("isn't as it was set up: thing-1.0 changed or missing ...\n")


def test_package_that_somebody_installed_besides_is_left_alone(whole):
    environment, packages = whole
    recorded(packages, "more-2.0")
    assert environment.is_whole()


@pytest.mark.parametrize("spoil", ["changed", "missing"])
def test_build_sets_up_anew_what_changed(whole, monkeypatch, spoil):
    environment, packages = whole
    if spoil == "changed":
        (packages / "thing-1.0.dist-info").rename(packages / "thing-0.9.dist-info")
    else:
        shutil.rmtree(packages / "thing-1.0.dist-info")
    calls = []
    monkeypatch.setattr(environment, "install", lambda: calls.append("install"))
    monkeypatch.setattr(module, "provide_libraries", lambda **_: None)
    main(environment)
    assert calls == ["install"]


def test_environment_behind_a_link_is_never_emptied(installed, capsys):
    environment, record = installed
    link = record.parent / "link"
    link.symlink_to(environment.folder)
    environment.folder = link
    with pytest.raises(SystemExit):
        environment.install()
    assert record.exists()
    assert "link is a link to another environment" in capsys.readouterr().err
