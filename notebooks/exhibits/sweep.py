"""Long sweeps, block by block on local cores, on from where one stopped; as a program, the atlas.

`python -m exhibits.sweep` sweeps the atlas and writes notebooks/atlas.csv.
"""

import csv
import hashlib
import os
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import tunneller_lib
from tunneller_lib.atomic_write import replacement

from . import atlas

TABLE = Path(__file__).parents[1] / "atlas.csv"


def compute_blocks(survey, blocks, folder, *, jobs=None):
    """Compute the blocks of a sweep that a folder lacks, and return the files of all of them.

    Parameters
    ----------
    survey : callable
        A module's function of a block, to an array.
    blocks : list of tuple of int
        The blocks.
    folder : path-like
        Where they are kept, a file each, in a subfolder named after the survey and a digest of the
        library and of the survey's module. Each is written whole or not at all: an interrupted
        sweep goes on from there.
    jobs : int, optional
        Number of local processes; as many as there are cores by default.

    Returns
    -------
    files : list of pathlib.Path
        The blocks' files, for `numpy.load`.
    """
    folder = Path(folder) / f"{survey.__name__}-{_digest(survey)}"
    folder.mkdir(parents=True, exist_ok=True)
    files = {block: folder / ("-".join(map(str, block)) + ".npy") for block in blocks}
    missing = [block for block in blocks if not files[block].exists()]
    count = jobs or len(os.sched_getaffinity(0))
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        try:
            waiting = {pool.submit(survey, block): block for block in missing}
            for done, future in enumerate(as_completed(waiting), len(files) - len(missing) + 1):
                with replacement(files[waiting[future]]) as new:
                    np.save(new, future.result())
                print(f"{done} of {len(blocks)} blocks", file=sys.stderr, flush=True)
        except BaseException:  # an interrupt, too: what hasn't begun isn't begun
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return list(files.values())


def _digest(survey):
    """Return a digest of the library, the survey's module and numpy's version."""
    files = sorted(Path(tunneller_lib.__file__).parent.rglob("*.py"))
    files.append(Path(survey.__code__.co_filename))
    parts = [*(path.read_bytes() for path in files), np.__version__.encode()]
    return hashlib.sha256(b"".join(parts)).hexdigest()[:12]


def write_atlas(folder, table, *, jobs=None):
    """Sweep the blocks of the atlas that a folder lacks, then write its summary as CSV."""
    files = compute_blocks(atlas.survey, atlas.blocks(), folder, jobs=jobs)
    rows = atlas.summary(map(np.load, files))
    with replacement(table) as new, new.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        for row in rows:  # numbers with nine digits
            plain = (f"{one:.9g}" if isinstance(one, float) else one for one in row.values())
            writer.writerow(dict(zip(row, plain, strict=True)))


if __name__ == "__main__":
    write_atlas("build/atlas", TABLE)
