"""The environment .venv: packages that lack a file or hold another are noticed, by name."""

import base64
import hashlib
import shutil
import sys
from pathlib import Path

import pytest

from report import environment as module
from report.environment import Environment, main

READS = ["environment.txt"]

FILES = {"thing/__init__.py": b"x = 1\n", "thing/core.py": b"y = 2\n"}


@pytest.fixture
def installed(tmp_path):
    """An environment with one package, which recorded its files."""
    environment = Environment()
    environment.folder = tmp_path
    packages = tmp_path / "lib" / "python3.11" / "site-packages"
    lines = ["thing-1.0.dist-info/RECORD,,"]
    for name, content in FILES.items():
        (packages / name).parent.mkdir(parents=True, exist_ok=True)
        (packages / name).write_bytes(content)
        sha256 = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={sha256},{len(content)}")
    (packages / "thing-1.0.dist-info").mkdir()
    (packages / "thing-1.0.dist-info" / "RECORD").write_text("\n".join(lines) + "\n")
    return environment, packages / "thing" / "core.py"


def test_what_is_as_recorded_is_whole(installed):
    environment, _ = installed
    assert environment.spoilt() == []


def test_missing_file_is_noticed(installed):
    environment, file = installed
    file.unlink()
    assert environment.spoilt() == ["thing"]


def test_content_is_read_where_it_may_have_changed(installed):
    environment, file = installed
    file.write_bytes(b"y = 3\n")
    assert environment.spoilt() == ["thing"]
    assert environment.spoilt(since=file.stat().st_ctime + 1) == []


@pytest.fixture
def whole(installed, tmp_path):
    """That environment as `install` leaves it."""
    environment, file = installed
    environment.python, environment.stamp = Path(sys.executable), tmp_path / "stamp"
    environment.settle()
    environment.stamp.write_text("\n".join([environment.wanted(), *environment.packages()]))
    assert environment.is_whole()
    return environment, file.parent.parent


def rename(packages, version):
    """Have the package in another version, as pip leaves it, its record in order."""
    old, new = "thing-1.0.dist-info", f"thing-{version}.dist-info"
    (packages / old).rename(packages / new)
    record = packages / new / "RECORD"
    record.write_text(record.read_text().replace(old, new))


def test_package_in_another_version_is_noticed(whole, capsys):
    environment, packages = whole
    rename(packages, "1.0.1")
    assert environment.spoilt() == [] and not environment.is_whole()
    said = capsys.readouterr().out
    assert said.endswith("isn't as it was set up: thing-1.0 changed or missing ...\n")


def test_package_that_somebody_installed_besides_is_left_alone(whole):
    environment, packages = whole
    (packages / "more-2.0.dist-info").mkdir()
    (packages / "more-2.0.dist-info" / "RECORD").write_text("more-2.0.dist-info/RECORD,,\n")
    assert environment.is_whole()


@pytest.mark.parametrize("spoil", ["changed", "missing"])
def test_build_sets_up_anew_what_changed(whole, monkeypatch, spoil):
    environment, packages = whole
    if spoil == "changed":
        rename(packages, "0.9")
    else:
        shutil.rmtree(packages / "thing-1.0.dist-info")
    calls = []
    monkeypatch.setattr(environment, "install", lambda: calls.append("install"))
    monkeypatch.setattr(module, "provide_libraries", lambda **_: None)
    main(environment)
    assert calls == ["install"]


def test_environment_behind_a_link_is_never_emptied(installed, capsys):
    environment, file = installed
    link = file.parent / "link"
    link.symlink_to(environment.folder)
    environment.folder = link
    with pytest.raises(SystemExit):
        environment.install()
    assert file.read_bytes() == FILES["thing/core.py"]
    assert "link is a link to another environment" in capsys.readouterr().err


def test_jupyterlab_asks_no_new_user_for_news(tmp_path):
    settings = pytest.importorskip(
        "jupyterlab_server.settings_handler", reason="JupyterLab is in the study's environment only"
    )
    lab = Path(sys.prefix) / "share" / "jupyter" / "lab"
    if not lab.is_dir():
        pytest.skip("JupyterLab is in the study's environment only")
    found, _ = settings.get_settings(
        app_settings_dir=str(lab / "settings"),
        schemas_dir=str(lab / "schemas"),
        settings_dir=str(tmp_path),  # of somebody who never changed any
        schema_name="@jupyterlab/apputils-extension:notification",
    )
    usual = {name: about["default"] for name, about in found["schema"]["properties"].items()}
    # "none" asks on the first start whether news may be fetched.
    assert usual["fetchNews"] == "false"
    assert usual["checkForUpdates"] is False
    assert usual["doNotDisturbMode"] is False  # our own notices are still seen
