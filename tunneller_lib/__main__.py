"""The command line: `python -m tunneller_lib atlas`."""

import argparse
import csv
import os
from pathlib import Path

import numpy as np

from .paths import atlas
from .reporting.sweep import sweep


def main(arguments=None):
    """Run the command that `arguments`, a list of str, names."""
    parser = argparse.ArgumentParser(prog="python -m tunneller_lib", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    command = commands.add_parser("atlas", help="sweep tori and pairs of positions (minutes)")
    command.add_argument(
        "--folder", type=Path, default=Path("build/atlas"), help="where blocks are kept"
    )
    command.add_argument(
        "--table", type=Path, default=Path("notebooks/atlas.csv"), help="the summary"
    )
    command.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster")
    command.add_argument("--jobs", type=int, help="local processes, one a core unless told")
    command.set_defaults(run=run_atlas)
    options = parser.parse_args(arguments)
    if not options.table.parent.is_dir():
        parser.error(f"--table: there is no folder {options.table.parent}.")
    if options.jobs is not None and options.jobs < 1:
        parser.error(f"--jobs: must be at least 1; got {options.jobs}.")
    options.run(options)


def run_atlas(options):
    """Sweep the blocks that are missing, then write the summary."""
    files = sweep(
        atlas.survey, atlas.blocks(), options.folder,
        scheduler=options.scheduler, jobs=options.jobs,
    )  # fmt: skip
    rows = atlas.summary(map(np.load, files))
    beside = options.table.with_suffix(".part")
    with beside.open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({name: plain(value) for name, value in row.items()} for row in rows)
    os.replace(beside, options.table)


def plain(value):
    """Return a number with nine digits, other values as they are."""
    return f"{value:.9g}" if isinstance(value, float) else value


if __name__ == "__main__":
    main()
