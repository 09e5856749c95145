"""One build at a time in a checkout: a lock whose holder is told to whoever waits for it.

Needs nothing but Python's standard library. As a program it runs a command under the lock:
`python3 -m report.lock "make clean" rm -rf build`.
"""

import fcntl
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@contextmanager
def locked(task, *, shared=False, root=ROOT):
    """Hold the checkout's lock, after waiting for whoever holds it.

    Parameters
    ----------
    task : str
        What is done meanwhile, as those who wait are told: ``"make report"``.
    shared : bool
        Whether others that only read, such as tests, may hold it too.
    root : pathlib.Path
        The checkout.

    Raises
    ------
    OSError
        If the checkout can't be written.

    Notes
    -----
    The system frees the lock when its holder ends, however it ends.
    """
    path = root / "build" / "lock"
    kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    with _taken(path, kind) as file:
        try:
            file.truncate(0)
            file.write(f"`{task}`, process {os.getpid()}, since {time.strftime('%H:%M:%S')}")
            file.flush()
        except OSError:
            pass  # a full disk doesn't matter here: the name of the holder is a courtesy
        yield


def _taken(path, kind):
    """Return the lock's file, open and locked."""
    while True:
        path.parent.mkdir(exist_ok=True)
        file = path.open("a+", encoding="utf-8")
        try:
            fcntl.flock(file, kind | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            holder = file.read() or "another build"
            print(f"Waiting for {holder}, which works in this checkout ...", flush=True)
            fcntl.flock(file, kind)
        # `make clean` removes the file together with its folder: then the lock is another one.
        try:
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        except FileNotFoundError:
            pass
        file.close()


if __name__ == "__main__":
    task, *command = sys.argv[1:]
    with locked(task):
        sys.exit(subprocess.run(command).returncode)
