"""Write a file, or a run's folder of files, whole or not at all."""

import errno
import hashlib
import os
import shutil
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path

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


@contextmanager
def writing(path):
    """Give an OSError that names no file, as one of a full disk, the file that is written."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


def list_files(folder, stamp):
    """Write a folder's manifest, a `stamp` and the digests of its files; return its path.

    ``sha256sum -c manifest.txt`` checks the files.
    """
    path = folder / MANIFEST
    with writing(path):
        lines = [_line(file) for file in sorted(folder.iterdir())]
        path.write_text(_manifest(stamp, lines), encoding="utf-8", newline="\n")
    return path


@contextmanager
def output(path):
    """Yield a new path; the folder made there replaces an earlier run's at `path` at the end.

    After an error or an interrupt the earlier folder stays. What a killed run leaves lies in a
    folder whose name begins with a dot and the name of `path`; the next run to `path` puts the
    earlier folder back, or ends the exchange, and removes the rest. A folder that can't be moved,
    as a mount, or that the process works in, stays, and its files are exchanged.

    Raises
    ------
    OSError
        If another run is writing to `path`, or something other than an earlier run's unchanged
        files lies there. What fails at the end leaves the new folder too, and says where.
    """
    place = Path(os.path.realpath(path))
    inside = place.is_dir() and (_is_mount(place) or not os.access(place.parent, os.W_OK))
    stays = inside or Path.cwd().is_relative_to(place)  # else a shell would stand in no folder
    beside = place if inside else place.parent  # on the same disk, so that all moves are renames
    beside.mkdir(parents=True, exist_ok=True)
    staging = beside / f".{place.name}.unfinished"
    new = staging / "new"
    try:
        with _claimed(staging, path):
            _settle(place, staging)
            if place.exists():
                _refuse_foreign(place, staging, path)
            try:
                yield new
                new.stat()  # without a new folder the earlier one stays
                with _kept(new, beside / f"{place.name}.new"):
                    _set_aside(place, staging, stays, path)
            finally:
                try:
                    _settle(place, staging)
                finally:  # also if an interrupt came into the first
                    _settle(place, staging)
    except OSError as error:
        if error.filename:  # as people know it
            name = str(error.filename).replace(str(new), str(path))
            error.filename = name.replace(str(staging), str(path))
        raise


@contextmanager
def _kept(new, wanted):
    """Move the new folder to a wanted path, or the next that is free, if the block fails."""
    try:
        yield
    except OSError as error:
        paths = (wanted.with_name(f"{wanted.name}{n or ''}") for n in count())
        free = next(path for path in paths if not os.path.lexists(path))
        os.rename(new, free)
        error.strerror = f"{error.strerror or error}; the new results are in {free}"
        raise


@contextmanager
def _claimed(folder, path):
    """Make a folder, or take over a killed run's; none else does before the block ends."""
    try:
        folder.mkdir()
        found = False
    except FileExistsError:
        found = True
    with ExitStack() as lock:
        try:
            import fcntl

            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            lock.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # The other run may have ended, and removed the folder, before it was locked.
            taken = not os.path.samestat(os.fstat(handle), os.stat(folder))
        except BlockingIOError:
            taken = True
        except (ImportError, OSError):  # without locks, as on Windows, it may be a living run's
            taken = found
        if taken:
            why = f"is being written by another run; if there is none, move {folder} elsewhere"
            raise BlockingIOError(errno.EAGAIN, why, str(path))
        try:
            yield
        finally:
            with suppress(OSError):  # it isn't empty if the exchange couldn't be ended
                folder.rmdir()


def _set_aside(place, staging, stays, path):
    """Move an earlier run's folder, or its files if it `stays`, to where they may be removed."""
    old, gone = staging / "old", staging / "gone"
    if not place.exists():
        gone.mkdir()
        return
    _refuse_foreign(place, staging, path)
    if stays:
        old.mkdir()
    try:
        _move(place, old, staging)
    except OSError as error:
        if stays or error.errno not in (errno.EBUSY, errno.EXDEV):
            raise
        old.mkdir()
        _move(place, old, staging)
    _refuse_foreign(old, staging, path)  # once more, where nobody finds it
    os.rename(old, gone)  # from here on the new folder is wanted


def _settle(place, staging):
    """End an exchange wherever it stopped: bring back what is still `old`, else bring the new.

    What is removed is half made, or `gone`: seen to be a run's after nobody could find it.
    """
    old, gone, new = (staging / name for name in ("old", "gone", "new"))
    if old.exists():
        _move(old, place)
    elif gone.exists() and new.exists():
        _move(new, place)
    for folder in (old, gone, new):
        if folder.exists():
            shutil.rmtree(folder)


def _move(source, target, staging=None):
    """Move a folder; if there is a target already, move what the folder holds into it.

    The manifest is the first that leaves the place where `staging` may lie, and the last that
    comes, so that there is none beside half of the files.
    """
    pairs = [(source, target)]
    if target.exists():
        files = _sorted(source)[:: 1 if staging else -1]
        pairs = [(file, target / file.name) for file in files if file != staging]
    for one, to in pairs:
        if os.path.lexists(to):
            raise FileExistsError(errno.EEXIST, f"is in the way of {one}", str(to))
        os.rename(one, to)


def _is_mount(folder):
    """Return whether a folder is a mount, also of a folder of the same disk."""
    try:  # which moves nothing in any case, and between mounts fails for another reason
        os.replace(folder, folder / folder.name)
    except OSError as error:
        return error.errno in (errno.EBUSY, errno.EXDEV) or os.path.ismount(folder)


def _refuse_foreign(folder, staging, path):
    """Raise an error if a folder holds more than the files that its manifest lists, unchanged."""
    listed = _listed(folder / MANIFEST)
    for file in _sorted(folder):
        if file != staging and not (file.is_file() and _line(file) in listed):
            why = f"holds {file.name}, which isn't as a run has left it; move it elsewhere, "
            raise FileExistsError(errno.EEXIST, why + "or give another --out", str(path))


def _sorted(folder):
    """Return what a folder holds, its manifest first."""
    return sorted(folder.iterdir(), key=lambda file: (file.name != MANIFEST, file))


def _listed(manifest):
    """Return a manifest's lines and its own line, or none if it isn't as a run has left it."""
    if manifest.is_file():
        text = manifest.read_bytes().decode(errors="replace")
        head, *lines = text.split("\n")[:-1] or [""]
        if text == _manifest(head[2:].partition(";")[0], lines):
            return {*lines, _line(manifest)}
    return set()


def _manifest(stamp, lines):
    """Return a manifest with its own digest, so that no change in it goes unseen."""
    rest = "".join(f"{line}\n" for line in lines)
    digest = hashlib.sha256(f"{stamp}\n{rest}".encode()).hexdigest()
    return f"# {stamp}; sha256 {digest} of this list, and of each file:\n{rest}"


def _line(file):
    """Return a file's line in a manifest: the SHA-256 of its content, and its name."""
    with file.open("rb") as content:
        return f"{hashlib.file_digest(content, 'sha256').hexdigest()}  {file.name}"
