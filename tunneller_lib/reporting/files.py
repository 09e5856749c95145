"""Files that nobody finds half-written."""

import os
from contextlib import contextmanager
from pathlib import Path


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
