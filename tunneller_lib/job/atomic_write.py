"""Files that nobody finds half-written."""

import errno
import os
from contextlib import contextmanager
from pathlib import Path

from ..arguments import checked, shown


@checked
def check_writable(path: Path):
    """Raise OSError if a file can't be made or replaced; nothing is made yet.

    Examples
    --------
    >>> check_writable(Path("build/wall.stl"))
    >>> check_writable(Path("/"))
    Traceback (most recent call last):
    IsADirectoryError: [Errno 21] is a folder, not a file: '/'
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder, not a file", str(path))
    there = next(folder for folder in path.absolute().parents if folder.exists())
    if not there.is_dir():
        why = f"can't be written; {there} is no folder"
        raise NotADirectoryError(errno.ENOTDIR, why, str(path))
    if not os.access(there, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, f"can't be written; {there} is read-only", str(path))


@checked
def write(path: Path, content: str | bytes):
    """Write a text or bytes, whole or not at all; return the path where it is now.

    A text is written in UTF-8, and ends its lines as it says, on every system.
    """
    if isinstance(content, str):
        try:
            content = content.encode("utf-8")
        except UnicodeEncodeError:
            what = shown(content)
            raise ValueError(f"content: must be a text that UTF-8 has; got {what}.") from None
    with replacement(path) as new:
        new.write_bytes(content)
    return path


@checked
@contextmanager
def replacement(path: Path):
    """Give a path to write to, with the suffix of the wanted one, whose place it takes at the end.

    The folder is made where it is missing; what an error left half-written is removed.

    Examples
    --------
    >>> import tempfile
    >>> wanted = Path(tempfile.mkdtemp(), "new", "wall.stl")
    >>> with replacement(wanted) as path:
    ...     _ = path.write_text("solid")
    >>> [file.name for file in wanted.parent.iterdir()]
    ['wall.stl']
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f".new-{os.getpid()}-{path.name}")
    try:
        yield new
        os.replace(new, path)
    except OSError as error:
        if error.filename in (None, str(new)):  # of a full disk the system names none
            error.filename = str(path)
        raise
    finally:
        new.unlink(missing_ok=True)
