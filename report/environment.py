"""Make the private environment .venv that every make target runs in, or find it ready.

Needs nothing but Python's standard library. What is installed is said by environment.txt alone.
"""

import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
PINS = ROOT / "environment.txt"
STAMP = VENV / "stamp"

GL_PACKAGES = ["libegl1", "libgl1-mesa-dri"]
# Without a GL library VTK doesn't raise but crashes: so a child process opens the window.
GL_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.AddRenderer(vtkRenderer())
window.Render()
"""


def main():
    if sys.version_info < (3, 11):  # noqa: UP036 - whoever runs this may have any Python
        found = sys.version.split()[0]
        sys.exit(
            f"This study needs Python 3.11 or newer, and this is {found}: "
            "say which one to use with `make PYTHON=python3.12 ...`."
        )
    if not PYTHON.exists() or not STAMP.exists() or STAMP.read_text() != stamp():
        install()
    if not gl_works():
        say("No off-screen GL library found")
        apt_install("Pictures need an off-screen GL library", *GL_PACKAGES)
        if not gl_works():
            fail(
                "VTK cannot open an off-screen window although "
                f"{' and '.join(GL_PACKAGES)} are installed."
            )


def stamp():
    """Return what the environment depends on; a moved checkout has to be set up again too."""
    text = PINS.read_bytes() + str(ROOT).encode()
    return hashlib.sha256(text).hexdigest()


def install():
    """Make .venv anew; the stamp comes last, so that a set-up cut short is done again."""
    say("Setting up .venv (once, about a minute)")
    if importlib.util.find_spec("ensurepip") is None:  # Debian packs it separately
        apt_install("Python's venv module is incomplete", "python3-venv")
    run(sys.executable, "-m", "venv", "--clear", VENV)
    pip = [PYTHON, "-m", "pip", "--disable-pip-version-check", "--quiet", "install"]
    pinned = ["--no-deps", "--require-hashes", "-r"]
    with tempfile.TemporaryDirectory() as folder:
        uv_pin = Path(folder) / "uv.txt"
        uv_pin.write_text(re.search(r"^uv==(.*\\\n)*.*\n", PINS.read_text(), re.M).group())
        run(*pip, "--retries", "1", *pinned, uv_pin)
    say("Installing the packages of environment.txt")
    try:
        run(VENV / "bin" / "uv", "pip", "install", "--quiet", "--python", PYTHON, *pinned, PINS)
    except (OSError, subprocess.CalledProcessError):
        say("uv could not; trying the slower pip")
        run(*pip, *pinned, PINS)
    # The checkout itself is importable without being built.
    [packages] = VENV.glob("lib/python3*/site-packages")
    (packages / "checkout.pth").write_text(f"{ROOT}\n")
    STAMP.write_text(stamp())


def gl_works():
    environment = os.environ | {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    probe = subprocess.run([PYTHON, "-c", GL_PROBE], env=environment, capture_output=True)
    return probe.returncode == 0


def apt_install(problem, *packages):
    """Install Debian packages where we may, else say which command would."""
    command = ["apt-get", "install", "-y", "--no-install-recommends", *packages]
    if os.geteuid() != 0 or shutil.which("apt-get") is None:
        fail(f"{problem}: on Debian or Ubuntu, `sudo {' '.join(command)}` installs it.")
    say(f"Installing {' '.join(packages)}")
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    run("apt-get", "update", stdout=subprocess.DEVNULL)
    run(*command, stdout=subprocess.DEVNULL, env=environment)


def run(*command, **options):
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL, **options)


def say(text):
    print(f"{text} ...", flush=True)


def fail(text):
    print(text, file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        fail("Interrupted; the next call goes on.")
    except subprocess.CalledProcessError as error:
        command = " ".join(map(str, error.cmd))
        fail(f"Set-up stopped, because `{command}` failed. Are the package registries in reach?")
