"""Write a file, or a run's folder of files, whole or not at all."""

import errno
import hashlib
import os
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

MANIFEST = "manifest.txt"


@contextmanager
def replacement(path):
    """Yield a path beside the wanted one, to which the new file is moved if nothing fails.

    It has the same suffix. A missing folder is made; after an error the new file is removed.

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
    finally:
        new.unlink(missing_ok=True)


def list_files(folder, stamp):
    """Write a folder's manifest, a `stamp` and the digests of its files; return its path.

    ``sha256sum -c manifest.txt`` checks the files.
    """
    lines = [f"# {stamp}; sha256 of each file:"]
    lines += [f"{_digest(file)}  {file.name}" for file in sorted(folder.iterdir())]
    path = folder / MANIFEST
    path.write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\n")
    return path


@contextmanager
def output(path):
    """Yield a new path; the folder made there replaces an earlier run's at `path` at the end.

    After an error or an interrupt the earlier folder stays. A process that is killed between the
    two moves leaves it in a folder beside it, whose name begins with a dot and the name of `path`.

    Raises
    ------
    OSError
        If something other than an earlier run's unchanged files lies at `path`.
    """
    place = Path(os.path.realpath(path))
    if place.exists() and not _left_by_a_run(place):
        why = "holds what no run has left there; move that elsewhere, or give another --out"
        raise FileExistsError(errno.EEXIST, why, str(path))
    place.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=f".{place.name}.", dir=place.parent) as beside:
        new = Path(beside, "new")
        old = Path(beside, "old")
        yield new
        try:
            if place.exists():
                os.rename(place, old)
            os.rename(new, place)
        except BaseException:
            if old.exists():  # which the folder beside would take with it
                os.rename(old, place)
            raise


def _left_by_a_run(folder):
    """Return whether a folder holds the files that its manifest lists, unchanged, and no others."""
    try:
        files = [file for file in folder.iterdir() if file.name != MANIFEST]
        listed = (folder / MANIFEST).read_text(encoding="utf-8").splitlines() if files else ()
        return {f"{_digest(file)}  {file.name}" for file in files} <= set(listed)
    except (OSError, ValueError):  # no manifest, or a folder among the files
        return False


def _digest(path):
    """Return the SHA-256 of a file's content, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
