"""What the last builds left: for each task its sources and its results.

Each task has a file, build/state/<task>.json. A file that is missing, cut short or something else
counts as no state, and the task is done again.
"""

import json

from report.sources import file_digests


class NotebookFailed(Exception):
    """A notebook that didn't run to its end; the message says where and why."""


class State:
    """The state of one task.

    Parameters
    ----------
    root : pathlib.Path
        The checkout.
    task : str
        Name of the task: of a notebook, without its suffix, or ``report``.
    """

    def __init__(self, root, task):
        self.root = root
        self.file = root / "build" / "state" / f"{task}.json"
        try:
            kept = json.loads(self.file.read_bytes())
            self.sources, self.results = dict(kept["sources"]), dict(kept["results"])
        except (OSError, ValueError, TypeError, KeyError):
            self.sources, self.results = {}, {}

    def stale(self, sources):
        """Return why a task has to be done, in a few words, or None.

        Parameters
        ----------
        sources : dict of str to str
            Digests of what it is made from now, by name.
        """
        if not self.sources:
            return "not built here yet"
        changed = [n for n in {**sources, **self.sources} if sources.get(n) != self.sources.get(n)]
        if changed:
            return f"{_few(changed)} changed"
        there = file_digests(self.root, [self.root / name for name in self.results])
        lost = [name for name in there if there[name] is None]
        altered = [name for name in there if there[name] != self.results[name]]
        if lost:
            return f"{_few(lost)} {'is' if len(lost) == 1 else 'are'} missing"
        if altered:
            return f"{_few(altered)} {'was' if len(altered) == 1 else 'were'} altered"
        return None

    def save(self, sources, results):
        """Keep the digests of what a task was made from, and of its results, by name."""
        kept = {"sources": sources, "results": results}
        self.file.parent.mkdir(parents=True, exist_ok=True)
        self.file.write_text(json.dumps(kept, indent=1))


def _few(names):
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
