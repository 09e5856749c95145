"""Make the pages: `make site`."""

import os
import shutil
import sys
import time

from report.site.build import SITE, build
from report.site.links import faults
from report.sources import ROOT

LARGEST = 64e6  # bytes that can be published without much ado

if __name__ == "__main__":
    started = time.monotonic()
    beside = SITE.with_name(".site.new")
    build(beside)
    if told := faults(beside):
        sys.exit("\n".join(told))
    size = sum(path.stat().st_size for path in beside.rglob("*") if path.is_file())
    if size > LARGEST:
        sys.exit(f"The pages have {size / 1e6:.0f} MB, more than {LARGEST / 1e6:.0f} MB.")
    shutil.rmtree(SITE, ignore_errors=True)
    os.replace(beside, SITE)
    print(
        f"{SITE.relative_to(ROOT)}/index.html: {size / 1e6:.0f} MB "
        f"in {time.monotonic() - started:.1f} s"
    )
