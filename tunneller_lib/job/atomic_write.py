"""Files that nobody finds half-written."""

import errno
import os
from contextlib import contextmanager
from pathlib import Path


def check_writable(path):
    """Raise OSError if a file can't be made or replaced; nothing is made yet.

    Examples
    --------
    >>> check_writable("build/wall.stl")
    >>> check_writable("/")
    Traceback (most recent call last):
    IsADirectoryError: [Errno 21] is a folder, not a file: '/'
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder, not a file", str(path))
    there = next(folder for folder in path.absolute().parents if folder.exists())
    if not there.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, f"can't be written; {there} is no folder",
                                 str(path))  # fmt: skip
    if not os.access(there, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, f"can't be written; {there} is read-only", str(path))


def write(path, content):
    """Write a text or bytes, whole or not at all; return the path where it is now.

    A path-like; a text ends its lines as it says, on every system.
    """
    with beside(path) as new:
        new.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return Path(path)


@contextmanager
def beside(path):
    """Give a path beside the wanted one to write to, with its suffix; rename it at the end.

    The folder is made where it is missing; what an error left half-written is removed.

    Examples
    --------
    >>> import tempfile
    >>> wanted = Path(tempfile.mkdtemp(), "new", "wall.stl")
    >>> with beside(wanted) as path:
    ...     _ = path.write_text("solid")
    >>> [file.name for file in wanted.parent.iterdir()]
    ['wall.stl']
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f".new-{os.getpid()}-{path.name}")
    try:
        yield new
        os.replace(new, path)
    finally:
        new.unlink(missing_ok=True)
