"""What pages that run need: fetched, by content, from whichever source has it."""

import hashlib
import re

import pytest

from report.live import runtime
from report.site.publish import Unavailable, publish

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
    with pytest.raises(Unavailable, match=r"a.whl: no source gave it. .*refused"):
        runtime.provide(tmp_path, [source("other", content)])
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_had_is_one_line_and_a_fault_of_ours_is_not(tmp_path):
    def build(folder):
        raise error

    for error, found in ((Unavailable("no wheel"), SystemExit), (KeyError("name"), KeyError)):
        with pytest.raises(found, match=error.args[0]):
            publish(build, tmp_path / "pages", 1e6)


def test_provide_fetches_anew_what_was_damaged(tmp_path, listed):
    (tmp_path / "a.whl").write_bytes(b"damaged")
    assert runtime.provide(tmp_path, [source("right", listed)])["a.whl"] == listed
    assert (tmp_path / "a.whl").read_bytes() == listed


def test_list_names_digests_of_one_version():
    listed = runtime.read_list()
    assert listed["pyodide"] in listed["release"]
    assert len({about["name"] for about in listed["file"]}) == len(listed["file"])
    assert all(re.fullmatch("[0-9a-f]{64}", about["sha256"]) for about in listed["file"])
