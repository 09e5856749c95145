"""Whether scenes can be drawn: without an off-screen GL library VTK doesn't raise, it crashes.

It needs nothing but Python's standard library until it tries, and is a program, too: its exit
code is 0 where scenes can be drawn, else 1, with a sentence.
"""

import os
import select
import signal
import subprocess
import sys
import warnings
from contextlib import suppress

PACKAGES = ("libegl1", "libgl1-mesa-dri")  # of Debian and Ubuntu
REMEDY = (
    f"on Debian or Ubuntu, `sudo apt-get install {' '.join(PACKAGES)}` installs the off-screen GL "
    "library that scenes need."
)
LONGEST = 300.0  # s that a picture may take, which without a graphics card takes a few
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


def drawn_apart(draw):
    """Return whether a child process, which a missing library may crash, did what `draw` does.

    That spares a try where all works. Nothing is done where there is no such process, or where it
    is known already that scenes can be drawn.

    Raises
    ------
    TimeoutError
        If the child hangs; it is ended.
    """
    if os.environ.get(TRIED) == "works" or not hasattr(os, "fork"):
        return False
    ending, held = os.pipe()  # the end that the child holds closes however it ends
    # Python 3.12 warns of a fork beside threads, whose locks it may copy held. A command has none
    # but OpenBLAS's, which OpenBLAS itself ends for a fork; a process begun anew would import
    # everything a second time.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child:
        os.close(held)
        try:
            if not select.select([ending], [], [], LONGEST)[0]:
                raise TimeoutError(f"drawing it took more than {LONGEST:g} s.")
            return os.waitpid(child, 0)[1] == 0
        except BaseException:  # an interrupt, too: nothing is written after it
            with suppress(OSError):  # it has ended meanwhile
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
            raise
        finally:
            os.close(ending)
    done = 1
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # a crash has said enough
        os.environ[TRIED] = "works"
        draw()
        done = 0
    finally:
        os._exit(done)  # nothing that the parent has yet to do is done twice


def require():
    """Raise OSError, with the command that mends it, where no scene can be drawn."""
    if said := problem():
        raise OSError(said)


if __name__ == "__main__":
    sys.exit(problem())
