"""Make the pages: `make site`."""

import os
import shutil
import sys
import time

from report.site.build import SITE, build
from report.site.links import faults
from report.sources import ROOT

if __name__ == "__main__":
    started = time.monotonic()
    beside = SITE.with_name(".site.new")
    build(beside)
    if told := faults(beside):
        sys.exit("\n".join(told))
    shutil.rmtree(SITE, ignore_errors=True)
    os.replace(beside, SITE)
    size = sum(path.stat().st_size for path in SITE.rglob("*") if path.is_file())
    print(
        f"{SITE.relative_to(ROOT)}/index.html: {size / 1e6:.0f} MB "
        f"in {time.monotonic() - started:.1f} s"
    )
