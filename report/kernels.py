"""Kernels that share what they import: forked from one process that has imported it already.

Matplotlib, scipy, pyvista, numba and IPython take two seconds of processor to import, and each of
some thirty notebooks has a kernel of its own. Within `shared_imports` Jupyter's kernel "python3" is
a process of a few lines that asks a nursery, over a socket, for a child: same folder, environment
and streams, no library of ours imported. The child is ended when the asking process is, and the
nursery when whoever began it is gone.
"""

import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

PACKAGES = (
    "ipykernel.debugger", "ipykernel.kernelapp", "IPython.display", "ipywidgets",
    "matplotlib.backends.backend_svg", "matplotlib.pyplot", "numba", "numpy", "PIL.Image",
    "pyvista", "scipy.integrate", "scipy.linalg", "scipy.ndimage", "scipy.optimize",
    "scipy.spatial", "sympy", "trame_pyvista", "wslink.backends.aiohttp",
)  # fmt: skip

NURSERY = "TUNNELLER_NURSERY"  # where a nursery listens, for what is started within

# What Jupyter starts. It needs no package; its end is the kernel's and the other way round.
ASK = """import json, os, socket, sys
asked = socket.socket(socket.AF_UNIX)
asked.connect(sys.argv[1])
about = {"cwd": os.getcwd(), "environ": dict(os.environ), "argv": sys.argv[2:]}
socket.send_fds(asked, [json.dumps(about).encode() + b"\\n"], [0, 1, 2])
asked.recv(1)
"""


@contextmanager
def shared_imports():
    """Let kernels that are started within share their imports, with those of a caller's, too."""
    if NURSERY in os.environ:
        yield
        return
    with tempfile.TemporaryDirectory() as folder:
        place = str(Path(folder, "socket"))
        spec = {
            "argv": [sys.executable, "-ISc", ASK, place, "-f", "{connection_file}"],
            "display_name": "Python 3 (ipykernel)",
            "language": "python",
            "interrupt_mode": "message",
        }
        kernel = Path(folder, "kernels", "python3", "kernel.json")
        kernel.parent.mkdir(parents=True)
        kernel.write_text(json.dumps(spec), encoding="utf-8")
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(place)
        listener.listen(64)
        command = [sys.executable, "-m", "report.kernels", str(listener.fileno())]
        nursery = subprocess.Popen(
            command, cwd=Path(__file__).parents[1], stdin=subprocess.PIPE,
            pass_fds=[listener.fileno()], start_new_session=True,
        )  # fmt: skip
        listener.close()
        paths = os.pathsep.join(filter(None, [folder, os.environ.get("JUPYTER_PATH")]))
        try:
            with patch.dict(os.environ, {"JUPYTER_PATH": paths, NURSERY: place}):
                yield
        finally:
            nursery.stdin.close()
            nursery.wait()


def nursery(listener):
    """Fork a kernel for whoever asks, until our own standard input ends."""
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"  # as a kernel has it
    sys.modules["debugpy"] = None  # nobody stops a build's kernels in a debugger
    for name in PACKAGES:
        importlib.import_module(name)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # children that end leave nothing behind
    while True:
        ready, _, _ = select.select([listener, sys.stdin], [], [])
        if sys.stdin in ready:
            return
        asked, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            be_kernel(asked)
        asked.close()


def be_kernel(asked):
    """Become the kernel that is asked for; this doesn't return."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()
    text, streams, _, _ = socket.recv_fds(asked, 2**20, 3)
    while not text.endswith(b"\n"):
        text += asked.recv(2**20)
    about = json.loads(text)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.environ.clear()
    os.environ.update(about["environ"])
    os.chdir(about["cwd"])
    parent = f"--IPKernelApp.parent_handle={os.getppid()}"
    sys.argv = ["ipykernel_launcher", *about["argv"], parent]
    threading.Thread(target=end_with, args=[asked], daemon=True).start()
    from ipykernel.kernelapp import launch_new_instance

    launch_new_instance()
    os._exit(0)


def end_with(asked):
    """End this process when the one that asked for it has ended."""
    asked.recv(1)
    os._exit(1)


if __name__ == "__main__":
    nursery(socket.socket(fileno=int(sys.argv[1])))
