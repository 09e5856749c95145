"""Write a file, or a run's folder of files, whole or not at all."""

import errno
import hashlib
import os
import shutil
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path

from .progress import say
from .tables import brief

try:
    import fcntl
except ImportError:  # Windows, and pages: nobody else writes there
    fcntl = None

MANIFEST = "manifest.txt"
LITTER = {MANIFEST, ".DS_Store", "Thumbs.db"}  # which systems leave where somebody looks


@contextmanager
def replacement(path):
    """Yield a path beside the wanted one, whose place it takes if all goes well.

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
    except OSError as error:
        if error.filename in (None, str(new)):  # a full disk names no file
            error.filename = str(path)
        raise
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
    """Yield a new path; the folder made there takes the place of what an earlier run left.

    What lies at `path` must be an earlier run's: a folder of files as its manifest lists them.

    Raises
    ------
    OSError
        If another process is writing there, or what is there isn't an earlier run's.

    Notes
    -----
    All is written beside it, into ``.NAME.tunneller``. At the end the earlier folder is moved in
    there, then the new one to its place, and the rest is removed. A process that is killed leaves
    the earlier folder, the new one or, between the two moves, neither: the next run then puts the
    earlier one back first. After an error the earlier one is moved to ``NAME.earlier``, so that
    nobody takes it for the result; after an interrupt it stays.
    """
    place = Path(os.path.realpath(path))
    work = place.with_name(f".{place.name}.tunneller")
    with _locked(work, path):
        _tidy(work, place)
        if what := _other(place):
            why = f"{what}; move that elsewhere, or give another --out"
            raise FileExistsError(errno.EEXIST, why, str(path))
        new = work / "new" / place.name
        new.parent.mkdir()
        try:
            yield new
            if _other(place):  # by now
                _put_aside(place, path)
            if place.exists():
                os.rename(place, work / "old")
            os.rename(new, place)
        except Exception as error:
            if isinstance(error, OSError) and not error.filename:  # of a full disk
                error.filename = str(path)
            _tidy(work, place)
            if place.exists():
                _put_aside(place, path)
            raise
        finally:
            _tidy(work, place)


@contextmanager
def _locked(work, path):
    """Hold the folder in which an output is made, and remove it at the end, if it is empty."""
    made = [folder for folder in work.parents if not folder.exists()]
    while (file := _lock(work, path)) is None:
        pass  # its last holder was removing it
    try:
        yield
    finally:
        with file, suppress(OSError):  # of a folder that isn't empty
            (work / "lock").unlink()
            for folder in (work, *made):
                folder.rmdir()


def _lock(work, path):
    """Return the locked file, or None if another run has just removed it.

    The system frees a lock when its process ends.
    """
    try:
        work.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        error.filename = str(path)
        raise
    with suppress(FileNotFoundError), ExitStack() as held:
        file = held.enter_context(open(work / "lock", "a"))
        if fcntl:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                why = "another run is writing there"
                raise BlockingIOError(errno.EAGAIN, why, str(path)) from None
        if os.path.samestat(os.fstat(file.fileno()), os.stat(work / "lock")):
            held.pop_all()
            return file
    return None


def _tidy(work, place):
    """Remove what a run has left where it worked, and put back an output that it moved away."""
    if (work / "old").exists() and not place.exists():
        os.rename(work / "old", place)
    for name in ("old", "new"):
        shutil.rmtree(work / name, ignore_errors=True)


def _put_aside(place, path):
    """Move what an earlier run left to a free name beside it, and say so."""
    names = (f"{place.name}.earlier{number or ''}" for number in count())
    aside = next(name for name in names if not os.path.lexists(place.with_name(name)))
    os.rename(place, place.with_name(aside))
    say(f"{path}: what an earlier run left there is now {path.with_name(aside)}")


def _other(place):
    """Return what at a place isn't as an earlier run has left it, or "" if all is."""
    if not place.exists():
        return ""
    if not place.is_dir():
        return "is no folder"
    if os.path.ismount(place) or os.path.samefile(place, os.curdir):
        return "is a folder that is mounted, or the one where you are"
    listed = _listed(place)
    for file in sorted(place.iterdir()):
        known = file.is_file() and not file.is_symlink() and file.name in {*listed, *LITTER}
        if not known or listed.get(file.name, digest := _digest(file)) != digest:
            return f"holds {brief(file.name)}, which isn't as a run has left it"
    return ""


def _listed(folder):
    """Return the digests of files by name, as a folder's manifest has them, if any."""
    try:
        lines = (folder / MANIFEST).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return {}
    pairs = (line.partition("  ") for line in lines if not line.startswith("#"))
    return {name: digest for digest, _, name in pairs}


def _digest(path):
    """Return the SHA-256 of a file's content, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
