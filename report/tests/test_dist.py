"""The archive that `make dist` packs: the same bytes twice, and a digest that fits."""

import hashlib
import re
import zipfile

import tunneller_lib
from report import dist
from report.sources import ROOT, code, notebooks

READS = ["CITATION.cff", "LICENSE", "notebooks/*", "report/live/live.css", "report/numbers/*"]


def test_archive_has_the_same_bytes_whenever_its_files_were_written(tmp_path):
    archives = []
    for name in ("one", "two"):
        file = tmp_path / name / "page.html"
        file.parent.mkdir()
        file.write_text("<p>a page</p>")
        digest = dist.pack({"pages/page.html": file, "LICENSE": ROOT / "LICENSE"},
                           tmp_path / name / "study.zip")  # fmt: skip
        archives.append((tmp_path / name / "study.zip").read_bytes())
    assert archives[0] == archives[1]
    assert hashlib.sha256(archives[0]).hexdigest() == digest
    assert (file.parent / "study.zip.sha256").read_text() == f"{digest}  study.zip\n"
    with zipfile.ZipFile(file.parent / "study.zip") as archive:
        assert archive.namelist() == ["study/LICENSE", "study/pages/page.html"]


def test_archive_has_what_chapters_read(tmp_path, monkeypatch):
    monkeypatch.setattr(dist, "LIVE", tmp_path)
    (tmp_path / "notebooks").mkdir()
    (tmp_path / "notebooks" / "00_index.ipynb").touch()
    files = dist.chapters()
    for name in ("00_index.ipynb", "contents.toml", "reference.toml", "kit/record.py"):
        assert f"notebooks/{name}" in files
    assert "report/numbers/42_budget.json" in files and all(p.is_file() for p in files.values())
    read = {
        name
        for notebook in notebooks()
        for name in re.findall(r"\.\./(tests/[\w./]+\w)", code(notebook))
    }
    assert read and read <= set(files)


def test_the_version_is_one_in_the_library_and_in_the_citation():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (\S+)$", text, re.M)[1] == tunneller_lib.__version__
    assert text.count("  - type: ") >= 3  # the three documents
