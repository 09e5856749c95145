"""A lock that lets one build at a time work in a checkout, and tells those who wait who holds it.

It needs only Python's standard library. As a program it runs a command under the lock:
`python3 -m report.lock "make clean" rm -rf build`.
"""

import fcntl
import os
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@contextmanager
def locked(task, *, shared=False, root=None):
    """Hold the checkout's lock, after waiting for whoever holds it.

    Parameters
    ----------
    task : str
        What is done meanwhile, as those who wait are told: ``"make report"``.
    shared : bool
        Whether others that only read, such as tests, may hold it too.
    root : pathlib.Path, optional
        The checkout; this one by default.

    Raises
    ------
    OSError
        If the checkout can't be written.

    Notes
    -----
    The system frees the lock when its holder ends, however it ends.
    """
    path = (root or ROOT) / "build" / "lock"
    with _taken(path, fcntl.LOCK_SH if shared else fcntl.LOCK_EX) as file:
        with suppress(OSError):  # on a full disk: the holder's name is only a courtesy
            file.truncate(0)
            file.write(f"`{task}`, process {os.getpid()}, since {time.strftime('%H:%M:%S')}")
            file.flush()
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
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        file.close()


def main(task, *command):
    """Run a command under the lock; return its exit code."""
    try:
        with locked(task):
            return subprocess.run(command).returncode
    except OSError as error:
        print(f"`{task}` stopped: {error.strerror} ({error.filename}).", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
