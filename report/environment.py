"""Make the private environment .venv that every make target runs in, or find it whole.

Needs nothing but Python's standard library. What is installed is said by environment.txt alone;
`python3 -m report.environment bench` makes another one for `make bench`, with its peers.
"""

import ctypes
import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from report.lock import ROOT, locked

PINS = ROOT / "environment.txt"
PEERS = ROOT / "pyproject.toml"  # its group "bench"
NEEDED = 2.2e9  # bytes: 1.6 GB of packages, and what they unpack
GL_LIBRARY, GL_PACKAGES = "libEGL.so.1", ["libegl1", "libgl1-mesa-dri"]

# Imported when Python starts: a notebook uses the library of the checkout that it lies in, and the
# packages beside it, whichever checkout's environment runs it.
OWN_CHECKOUT = """import os, sys
try:
    near = [os.getcwd(), os.path.dirname(os.getcwd())]
except OSError:
    near = []
own = [folder for folder in near if os.path.isdir(os.path.join(folder, "tunneller_lib"))]
checkout = [*own, {root!r}][0]
sys.path += [checkout, os.path.join(checkout, "notebooks")]
"""

# JupyterLab asks nobody for news or newer versions, nor whether it may.
SETTINGS = {
    "@jupyterlab/apputils-extension:notification": {
        "checkForUpdates": False, "doNotDisturbMode": False, "fetchNews": "false"
    }
}  # fmt: skip


class Environment:
    """A virtual environment of the checkout.

    Parameters
    ----------
    name : str
        Of its folder.
    peers : bool
        Whether it holds what `make bench` compares the library with.
    """

    def __init__(self, name=".venv", *, peers=False):
        self.folder, self.peers = ROOT / name, peers
        self.python = self.folder / "bin" / "python"
        self.stamp = self.folder / "stamp"

    def wanted(self):
        """Return a digest of what the environment depends on, the checkout's place included."""
        text = PINS.read_bytes() + str(ROOT).encode() + Path(__file__).read_bytes()
        text += PEERS.read_bytes() if self.peers else b""
        return hashlib.sha256(text).hexdigest()

    def is_whole(self):
        """Tell whether it is what the pins want, with every package as it was installed."""
        if not self.python.exists() or not self.stamp.exists():
            return False
        wanted, *packages = self.stamp.read_text().splitlines()
        if wanted != self.wanted():
            return False
        if lost := sorted(set(packages) - set(self.packages())):
            say(f"{self.folder.name} isn't as it was set up: {', '.join(lost)} changed or missing")
            return False
        return True

    def packages(self):
        """Return the packages that are installed, as ``name-version``, without Python's own."""
        records = self.folder.glob("lib/python3*/site-packages/*.dist-info/RECORD")
        names = (record.parent.name.removesuffix(".dist-info") for record in records)
        return sorted(name for name in names if not name.startswith(("pip-", "setuptools-")))

    def install(self):
        """Make it anew; the stamp comes last, so that a set-up cut short is done again."""
        if self.folder.is_symlink():  # it would be emptied under whoever else uses it
            fail(f"{self.folder.name} is a link to another environment: remove the link first.")
        say(f"Setting up {self.folder.name} (once, about a minute)")
        run(sys.executable, "-m", "venv", "--clear", self.folder)
        pip = [self.python, "-m", "pip", "--disable-pip-version-check", "--quiet", "install"]
        pinned = ["--no-deps", "--require-hashes", "-r"]
        with tempfile.TemporaryDirectory() as folder:
            uv_pin = Path(folder) / "uv.txt"
            uv_pin.write_text(re.search(r"^uv==(.*\\\n)*.*\n", PINS.read_text(), re.M).group())
            run(*pip, "--retries", "1", *pinned, uv_pin)
        say("Installing the packages of environment.txt")
        uv = self.folder / "bin" / "uv"
        add = [uv, "pip", "install", "--quiet", "--python", self.python]
        try:
            run(*add, *pinned, PINS)
        except (OSError, subprocess.CalledProcessError):
            say("uv could not; trying the slower pip")
            run(*pip, *pinned, PINS)
        if self.peers:
            run(*add, "--constraint", PINS, "--no-verify-hashes", "--group", f"{PEERS}:bench")
        self.settle()
        # A later look asks for these packages, and leaves alone what somebody installed besides.
        self.stamp.write_text("\n".join([self.wanted(), *self.packages()]))

    def settle(self):
        """Write, where it isn't there, what makes the checkout importable and JupyterLab quiet."""
        [packages] = self.folder.glob("lib/python3*/site-packages")
        for path, content in [
            (packages / "_own_checkout.py", OWN_CHECKOUT.format(root=str(ROOT))),
            (packages / "checkout.pth", "import _own_checkout\n"),
            (self.folder / "share/jupyter/lab/settings/overrides.json", json.dumps(SETTINGS)),
        ]:
            if not path.exists() or path.read_text() != content:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content)


def main(environment):
    if sys.version_info < (3, 11):  # noqa: UP036 - whoever runs this may have any Python
        found = sys.version.split()[0]
        fail(
            f"This study needs Python 3.11 or newer, and this is {found}: "
            "say which one to use with `make PYTHON=python3.12 ...`."
        )
    whole = environment.is_whole()
    provide_libraries(for_venv=not whole)
    if whole:
        environment.settle()
        return
    free = shutil.disk_usage(ROOT).free
    if free < NEEDED:
        fail(f"Set-up needs {NEEDED / 1e9:.1f} GB; {free / 1e9:.1f} GB are free in {ROOT}.")
    with locked("set-up"):
        if not environment.is_whole():  # nobody made it while we waited
            environment.install()


def provide_libraries(*, for_venv):
    """Install the system's packages that are missing, or say how, before anything is fetched."""
    venv = ["python3-venv"] if importlib.util.find_spec("ensurepip") is None else []
    missing = (venv if for_venv else []) + ([] if _loads(GL_LIBRARY) else GL_PACKAGES)
    if not missing:
        return
    command = ["apt-get", "install", "-y", "--no-install-recommends", *missing]
    if os.geteuid() == 0 and shutil.which("apt-get"):
        say(f"This set-up runs as root, so it installs Debian packages now: {' '.join(missing)}")
        environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
        run("apt-get", "update", stdout=subprocess.DEVNULL)
        run(*command, stdout=subprocess.DEVNULL, env=environment)
        return
    mend = f"on Debian or Ubuntu, `sudo {' '.join(command)}` installs what is missing."
    if for_venv and venv:
        more = " (and the GL library that scenes need)" if len(missing) > 1 else ""
        fail(f"Python's venv module is incomplete{more}: {mend}")
    print(f"Without an off-screen GL library scenes are left out: {mend}", flush=True)


def _loads(library):
    try:
        return bool(ctypes.CDLL(library))
    except OSError:
        return False


def run(*command, **options):
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL, **options)


def say(text):
    print(f"{text} ...", flush=True)


def fail(text):
    print(text, file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    try:
        if sys.argv[1:] == ["bench"]:
            main(Environment("build/bench", peers=True))
        else:
            main(Environment())
    except KeyboardInterrupt:
        fail("Interrupted; the next call goes on.")
    except subprocess.CalledProcessError as error:
        command = " ".join(map(str, error.cmd))
        fail(
            f"Set-up stopped, because `{command}` failed: are the package registries in reach, is "
            "there room on the disk, and no limit on the size of files? The next call goes on."
        )
    except OSError as error:
        where = f" ({error.filename})" if error.filename else ""
        fail(f"Set-up stopped: {error.strerror}{where}. The next call goes on.")
