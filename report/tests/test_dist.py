"""The archive that `make dist` packs: the same bytes twice, and a digest that fits."""

import hashlib
import re
import zipfile

import tunneller_lib
from report import dist
from report.sources import ROOT

READS = ["CITATION.cff", "LICENSE", "report/live/live.css"]


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


def test_the_version_is_one_in_the_library_and_in_the_citation():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (\S+)$", text, re.M)[1] == tunneller_lib.__version__
    assert text.count("  - type: ") >= 3  # the three documents
