"""Whether scenes can be drawn: without an off-screen GL library VTK doesn't raise, it crashes.

It needs nothing but Python's standard library until it tries, and is a program, too: its exit
code is 0 where scenes can be drawn, else 1, with a sentence.
"""

import os
import subprocess
import sys

PACKAGES = ("libegl1", "libgl1-mesa-dri")  # of Debian and Ubuntu
REMEDY = (
    f"on Debian or Ubuntu, `sudo apt-get install {' '.join(PACKAGES)}` installs the off-screen GL "
    "library that scenes need."
)
TRIED = "TUNNELLER_GL"  # set to "works" for the kernels and tests that a run starts
PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.AddRenderer(vtkRenderer())
window.Render()
"""


def problem():
    """Return why no scene can be drawn here, with the command that mends it, or None.

    A child process tries it once; where it works, that is noted for all that this process starts.
    """
    if os.environ.get(TRIED) == "works":
        return None
    window = {} if "DISPLAY" in os.environ else {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    tried = subprocess.run(
        [sys.executable, "-c", PROBE], env=window | os.environ, capture_output=True
    )
    if tried.returncode:
        return f"No scene can be drawn here: {REMEDY}"
    os.environ[TRIED] = "works"


def require():
    """Raise OSError, with the command that mends it, where no scene can be drawn."""
    if said := problem():
        raise OSError(said)


if __name__ == "__main__":
    sys.exit(problem())
