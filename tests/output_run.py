"""A run in a process of its own, for tests that kill it: fifteen files, written slowly.

python -m tests.output_run FOLDER STAMP PAUSE LAST: it pauses, in s, after each file and before each
rename, and kills itself before the rename of the number LAST, if that isn't negative.
"""

import os
import signal
import sys
import time
from itertools import count
from pathlib import Path

from tunneller_lib.atomic_write import list_files, output

NAMES = [f"{k}.csv" for k in range(15)]


def write(new, stamp, pause=0.0):
    """Write what a run of this stamp leaves: each file holds it, and one has its name."""
    new.mkdir()
    for name in [*NAMES, f"only_{stamp}.csv"]:
        (new / name).write_text(stamp)
        time.sleep(pause)
    list_files(new, stamp)


def main(folder, stamp, pause, last):
    rename, number = os.rename, count()

    def slow(*paths):
        if next(number) == int(last):
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(float(pause))
        rename(*paths)

    os.rename = slow
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with output(Path(folder)) as new:
        write(new, stamp, float(pause))


if __name__ == "__main__":
    main(*sys.argv[1:])
