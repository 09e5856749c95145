"""Long sweeps, block by block, on local cores or a Dask cluster, on from where one stopped."""

import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from .. import __version__
from ..arguments import Whole, checked
from ..job.atomic_write import replacement
from ..job.progress import say


@checked
def compute_blocks(
    survey: Callable[[tuple], np.ndarray],
    blocks: list,
    folder: str | os.PathLike,
    *,
    scheduler: str | None = None,
    jobs: Whole(1, 10_000) | None = None,
):
    """Compute the blocks of a sweep that a folder lacks, and return all of them.

    Parameters
    ----------
    survey : callable
        A module's function of a block, to an array.
    blocks : list of tuple of int
        The blocks.
    folder : path-like
        Where they are kept, a file each, in a subfolder named after the survey and this package's
        digest. Each is written whole or not at all: an interrupted sweep goes on from there.
    scheduler : str, optional
        Address of a Dask scheduler. Each worker must have this library installed, the same to the
        byte, with the same numpy; nothing is sent but blocks. Without it the local cores work.
        The same blocks give the same bits.
    jobs : int, optional
        Number of local processes, at most 10 000; as many as there are cores by default.

    Returns
    -------
    files : list of pathlib.Path
        The blocks' files, for `numpy.load`.

    Raises
    ------
    ValueError
        If an argument is none of those, or a worker hasn't this library.
    """
    folder = Path(folder) / f"{survey.__name__}-{_digest()}"
    folder.mkdir(parents=True, exist_ok=True)
    files = {block: folder / ("-".join(map(str, block)) + ".npy") for block in blocks}
    missing = [block for block in blocks if not files[block].exists()]
    done = len(blocks) - len(missing)
    start = time.monotonic()
    say(f"{done} of {len(blocks)} blocks are there")
    if missing:
        with _cluster(scheduler) if scheduler else _cores(jobs) as results:
            for block, table in results(survey, missing):
                with replacement(files[block]) as new:  # another sweep may fill the same folder
                    np.save(new, table)
                done += 1
                pace = (time.monotonic() - start) / (done - len(blocks) + len(missing))
                say(f"{done} of {len(blocks)} blocks, {pace * (len(blocks) - done):.0f} s to go")
    return list(files.values())


def _asking():
    """Return a function that tells one state of this package, and one numpy, from another.

    One within another is sent to a worker as it is, which may have no module of ours; it returns
    None there.
    """

    def digest():
        import hashlib
        from importlib.util import find_spec
        from pathlib import Path

        try:
            import numpy
        except ImportError:
            return None
        found = find_spec("tunneller_lib")
        if not found or not found.origin:
            return None
        files = sorted(Path(found.origin).parent.rglob("*.py"))
        parts = [*(path.read_bytes() for path in files), numpy.__version__.encode()]
        return hashlib.sha256(b"".join(parts)).hexdigest()[:12]

    return digest


_digest = _asking()


@contextmanager
def _cores(jobs):
    """Give a function that yields blocks and their results as local processes finish them."""
    count = jobs or len(os.sched_getaffinity(0))
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:

        def results(survey, blocks):
            waiting = {pool.submit(survey, block): block for block in blocks}
            for future in as_completed(waiting):
                yield waiting[future], future.result()

        try:
            yield results
        except BaseException:  # an interrupt, too: what hasn't begun isn't begun
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def _cluster(scheduler):
    """Give a function that yields blocks and their results as a cluster's workers finish them."""
    import distributed

    with distributed.Client(scheduler) as client:
        workers = _checked_workers(client)

        def results(survey, blocks):
            waiting = {
                client.submit(survey, block, pure=False, workers=workers): block for block in blocks
            }
            for future, table in distributed.as_completed(waiting, with_results=True):
                yield waiting[future], table

        yield results


def _checked_workers(client):
    """Return the addresses of a cluster's workers, or raise ValueError if one isn't as we are."""
    states = client.run(_digest)
    wrong = [address for address, found in states.items() if found != _digest()]
    if wrong or not states:
        came = f"{len(wrong)} of {len(states)} without" if states else "none"
        first = f", such as {wrong[0]}" if wrong else ""
        raise ValueError(
            f"scheduler: must have workers with tunneller_lib {__version__}, its files and numpy "
            f"the same as here; got {came}{first}."
        )
    return list(states)
