"""What pages that run need: fetched, by content, from whichever source has it."""

import hashlib
import re
import zipfile

import pytest

from report.live import runtime
from report.site.publish import NotToBeHad, publish
from report.sources import ROOT

READS = ["Makefile", "report/guide/pages.md", "report/live/runtime.toml"]


@pytest.fixture
def listed(monkeypatch):
    """Return the content of the one file that is on the list."""
    content = b"a wheel"
    about = {"name": "a.whl", "size": 7, "sha256": hashlib.sha256(content).hexdigest()}
    monkeypatch.setattr(runtime, "read_list", lambda: {"file": [about]})
    return content


def source(name, content):
    """Return a source that gives a content, or fails, and keeps count."""

    def give(file):
        give.asked.append(file)
        if isinstance(content, Exception):
            raise content
        return content

    give.asked = []
    give.__qualname__ = name
    return give


def test_provide_goes_from_source_to_source_and_keeps_what_it_got(tmp_path, listed):
    away, other = source("away", OSError("no such host")), source("other", b"a wheeL")
    right, last = source("right", listed), source("last", listed)
    assert runtime.provide(tmp_path, [away, other, right, last]) == {"a.whl": listed}
    assert [len(s.asked) for s in (away, other, right, last)] == [1, 1, 1, 0]
    assert runtime.provide(tmp_path, []) == {"a.whl": listed}


@pytest.mark.parametrize("content", [b"a wheeL", b"a whee", b"a wheel "])
def test_provide_refuses_another_content(tmp_path, listed, content):
    with pytest.raises(NotToBeHad, match=r"a.whl: no source gave it. .*refused"):
        runtime.provide(tmp_path, [source("other", content)])
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_had_is_one_line_and_a_fault_of_ours_is_not(tmp_path):
    def build(folder):
        raise error

    for error, found in ((NotToBeHad("no wheel"), SystemExit), (KeyError("name"), KeyError)):
        with pytest.raises(found, match=error.args[0]):
            publish(build, tmp_path / "pages", 1e6)


def test_provide_fetches_anew_what_was_damaged(tmp_path, listed):
    (tmp_path / "a.whl").write_bytes(b"damaged")
    assert runtime.provide(tmp_path, [source("right", listed)])["a.whl"] == listed
    assert (tmp_path / "a.whl").read_bytes() == listed


def test_release_that_does_not_answer_is_asked_once(monkeypatch):
    asked = []
    monkeypatch.setattr(runtime, "urlopen", lambda url, timeout: asked.append(url) or no_host())
    release = runtime.Release("https://a.org/full/")
    for _ in range(2):
        with pytest.raises(OSError, match="no host"):
            release("a.whl")
    assert asked == ["https://a.org/full/a.whl"]


def test_wheel_in_the_place_of_the_release_is_named_with_what_it_is_for(monkeypatch, tmp_path,
                                                                        capsys):  # fmt: skip
    def download(command, check):
        assert command[-1] == "some-wheel==1.0"
        with zipfile.ZipFile(tmp_path / "some_wheel-1.0.whl", "w") as archive:
            archive.writestr("inside/a.js", "1")

    monkeypatch.setattr(runtime.subprocess, "run", download)
    wheel = runtime.Wheel("some-wheel==1.0", "inside/", tmp_path)
    assert wheel("a.js") == wheel("a.js") == b"1"
    said = "Fetching some-wheel==1.0, a wheel that carries Pyodide's files ...\n"
    assert capsys.readouterr().out == said


def test_wheel_of_the_list_is_named_where_the_build_is_described():
    name = runtime.read_list()["wheel"].partition("==")[0]
    for path in ("Makefile", "report/guide/pages.md"):
        (line,) = (one for one in (ROOT / path).read_text().splitlines() if "106 MB" in one)
        assert name in line


def no_host():
    raise OSError("no host")


def test_list_names_digests_of_one_version():
    listed = runtime.read_list()
    assert listed["pyodide"] in listed["release"]
    assert len({about["name"] for about in listed["file"]}) == len(listed["file"])
    assert all(re.fullmatch("[0-9a-f]{64}", about["sha256"]) for about in listed["file"])
