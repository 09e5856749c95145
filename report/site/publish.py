"""A folder of pages, put in the old one's place when it is whole."""

import os
import shutil
import sys
import time

from report.site.links import faults
from report.sources import ROOT


class Unavailable(Exception):
    """Something that the pages need is missing and can't be fetched."""


def publish(build, folder, largest):
    """Make pages beside their folder, and put them there if nothing is wrong with them.

    Parameters
    ----------
    build : function
        Makes the pages in a folder that it is given.
    folder : pathlib.Path
        Where they shall be.
    largest : float
        The most bytes that they may have.

    Raises
    ------
    SystemExit
        If a link is dead, the pages are too large, or what they need can't be had.
    """
    started = time.monotonic()
    beside = folder.with_name(f".{folder.name}.new")
    try:
        build(beside)
    except Unavailable as error:
        sys.exit(str(error))
    if told := faults(beside):
        sys.exit("\n".join(told))
    size = sum(path.stat().st_size for path in beside.rglob("*") if path.is_file())
    if size > largest:
        sys.exit(f"The pages have {size / 1e6:.0f} MB, more than {largest / 1e6:.0f} MB.")
    shutil.rmtree(folder, ignore_errors=True)
    os.replace(beside, folder)
    print(
        f"{folder.relative_to(ROOT)}/index.html: {size / 1e6:.0f} MB "
        f"in {time.monotonic() - started:.1f} s"
    )
