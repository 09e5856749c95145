"""Pack documents, wheel, live pages and chapters into one archive, with its digest: `make dist`.

The archive holds the same bytes whenever it is made from the same commit by the same versions.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from report.compile import release_date
from report.lists import PDFS
from report.live.build import LIVE
from report.sources import ROOT
from tunneller_lib import __version__

PLACE = ROOT / "build" / "dist" / f"tunneller-{__version__}.zip"
SETUPTOOLS = "setuptools==80.9.0"  # another one would write its own version into the wheel


def wheel(folder):
    """Build the library's wheel into a folder, from a copy of the sources; return its path."""
    sources = folder / "sources"  # setuptools would leave its own files in the checkout
    shutil.copytree(ROOT / "tunneller_lib", sources / "tunneller_lib",
                    ignore=shutil.ignore_patterns("__pycache__"))  # fmt: skip
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    constraint = folder / "constraint.txt"
    constraint.write_text(SETUPTOOLS)
    uv = Path(sys.executable).with_name("uv")
    command = [uv, "build", "--quiet", "--wheel", "--python", sys.executable, "--out-dir", folder]
    when = {"SOURCE_DATE_EPOCH": f"{release_date().timestamp():.0f}"}
    subprocess.run(
        [*command, "--build-constraints", constraint, sources], check=True, env=os.environ | when
    )
    [made] = folder.glob("*.whl")
    return made


def pack(files, place):
    """Write files, given by their names in it, to a zip archive, and its sha256 beside it."""
    place.parent.mkdir(parents=True, exist_ok=True)
    when = release_date().timetuple()[:6]
    with zipfile.ZipFile(place, "w") as archive:
        for name, path in sorted(files.items()):
            entry = zipfile.ZipInfo(f"{place.stem}/{name}", when)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())
    with place.open("rb") as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()
    place.with_name(f"{place.name}.sha256").write_text(f"{digest}  {place.name}\n")
    return digest


def chapters():
    """Return the notebooks without outputs, and what they read, by their names in the checkout."""
    folder = ROOT / "notebooks"
    own = [path for path in folder.rglob("*.*") if path.suffix in (".py", ".toml", ".csv")]
    read = [*(ROOT / "report" / "numbers").iterdir(), *(ROOT / "tests" / "references").iterdir()]
    files = [*own, *read, ROOT / "figures" / "machine_model.png"]
    made = {f"notebooks/{path.name}": path for path in (LIVE / "notebooks").glob("*.ipynb")}
    return made | {str(path.relative_to(ROOT)): path for path in files if path.is_file()}


def main():
    """Pack everything; return the exit code."""
    files = {path.name: path for path in [*PDFS.values(), ROOT / "LICENSE", ROOT / "CITATION.cff"]}
    files |= chapters()
    files |= {f"pages/{path.relative_to(LIVE)}": path for path in LIVE.rglob("*") if path.is_file()}
    with tempfile.TemporaryDirectory() as folder:
        try:
            made = wheel(Path(folder))
        except subprocess.CalledProcessError:
            print("The wheel wasn't built: is the package registry in reach?", file=sys.stderr)
            return 1
        digest = pack(files | {made.name: made}, PLACE)
    size = PLACE.stat().st_size / 1e6
    print(f"{PLACE.relative_to(ROOT)}: {len(files) + 1} files, {size:.0f} MB, sha256 {digest[:16]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
