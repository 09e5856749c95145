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


def test_emptied_file_is_noticed_however_old(installed):
    environment, file = installed
    file.write_bytes(b"")
    assert environment.spoilt(since=2e9) == ["thing"]


def test_content_is_read_where_it_may_have_changed(installed):
    environment, file = installed
    file.write_bytes(b"y = 3\n")
    assert environment.spoilt() == ["thing"]
    assert environment.spoilt(since=file.stat().st_ctime + 1) == []


@pytest.fixture
def whole(installed, tmp_path, monkeypatch):
    """That environment as `install` leaves it, with pins, of which another system needs one."""
    environment, file = installed
    pins = tmp_path / "environment.txt"
    pins.write_text("elsewhere==3.0 ; sys_platform == 'never' \\\n    --hash=x\nthing==1.0 \\\n")
    monkeypatch.setattr(module, "PINS", pins)
    environment.python, environment.stamp = Path(sys.executable), tmp_path / "stamp"
    environment.settle()
    environment.stamp.write_text(f"{environment.wanted()}\nthing")
    assert environment.is_whole()
    return environment, file.parent.parent


def rename(packages, version):
    """Have the package in another version, as pip leaves it, its record in order."""
    old, new = "thing-1.0.dist-info", f"thing-{version}.dist-info"
    (packages / old).rename(packages / new)
    record = packages / new / "RECORD"
    record.write_text(record.read_text().replace(old, new))


def test_package_in_another_version_than_pinned_is_noticed(whole, capsys):
    environment, packages = whole
    rename(packages, "1.0.1")
    assert environment.spoilt() == [] and not environment.is_whole()
    assert capsys.readouterr().out.endswith("isn't as it was set up: thing is 1.0.1, not 1.0 ...\n")


def test_package_that_was_uninstalled_is_noticed(whole, capsys):
    environment, packages = whole
    shutil.rmtree(packages / "thing")
    shutil.rmtree(packages / "thing-1.0.dist-info")
    assert environment.spoilt() == [] and not environment.is_whole()
    assert capsys.readouterr().out.endswith("thing is missing, not 1.0 ...\n")


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


@pytest.mark.parametrize("name", ["checkout.pth", "_own_checkout.py"])
@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_text("")])
def test_build_writes_again_what_makes_the_checkout_importable(whole, monkeypatch, name, spoil):
    environment, packages = whole
    before = (packages / name).read_text()
    spoil(packages / name)
    monkeypatch.setattr(environment, "install", pytest.fail)
    monkeypatch.setattr(module, "provide_libraries", lambda **_: None)
    main(environment)
    assert (packages / name).read_text() == before


def test_package_is_found_by_its_pinned_name_however_its_folder_writes_it(whole):
    environment, packages = whole
    for folder in ("Jinja2-3.1.6", "ruamel.yaml-0.18", "jupyter_core-5.9"):
        (packages / f"{folder}.dist-info").mkdir()
        (packages / f"{folder}.dist-info" / "RECORD").touch()
    versions = {"jinja2": "3.1.6", "jupyter-core": "5.9", "ruamel-yaml": "0.18", "thing": "1.0"}
    assert environment.versions() == versions


def test_every_pin_is_read_with_its_version():
    pins = module.pinned_versions()
    assert {"numpy", "scipy", "mpmath", "ruff", "uv", "nbval"} <= pins.keys()
    assert len(pins) == module.PINS.read_text().count("==") - module.PINS.read_text().count(" == ")


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
