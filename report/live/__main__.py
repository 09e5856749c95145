"""Make the pages that run: `make live`."""

import os
import shutil
import sys
import time

from report.live.build import LIVE, build
from report.site.links import faults
from report.sources import ROOT

LARGEST = 120e6  # bytes, of all

if __name__ == "__main__":
    started = time.monotonic()
    beside = LIVE.with_name(".live.new")
    try:
        build(beside)
    except LookupError as error:
        sys.exit(str(error))
    if told := faults(beside):
        sys.exit("\n".join(told))
    size = sum(path.stat().st_size for path in beside.rglob("*") if path.is_file())
    if size > LARGEST:
        sys.exit(f"The pages have {size / 1e6:.0f} MB, more than {LARGEST / 1e6:.0f} MB.")
    shutil.rmtree(LIVE, ignore_errors=True)
    os.replace(beside, LIVE)
    print(
        f"{LIVE.relative_to(ROOT)}/index.html: {size / 1e6:.0f} MB "
        f"in {time.monotonic() - started:.1f} s"
    )
