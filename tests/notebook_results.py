"""Pytest's view of a notebook: its cells run again, its outputs, numbers and figures compared.

Built on nbval, whose comparison of outputs is exact; here numbers may differ in their last bits,
which depend on the processor. Figures are compared as files, not as outputs.
"""

import io
import json
import math
import re
from pathlib import Path
from queue import Empty
from tempfile import TemporaryDirectory

import numpy as np
import PIL.Image
import pytest
import typst
from nbval.kernel import RunningKernel
from nbval.plugin import IPyNbCell, IPyNbFile

from report.sources import is_run, records

NUMBERS = 1e-9  # relative difference that is none
PICTURES = 2.0  # RMS difference that nobody sees, of 255

FLOAT = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?")


@pytest.fixture(autouse=True)
def _elsewhere(monkeypatch, tmp_path_factory):
    """No test, and no doctest, records anything in the checkout."""
    monkeypatch.setenv("TUNNELLER_RESULTS", str(tmp_path_factory.getbasetemp() / "results"))


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".ipynb":
        return Notebook.from_parent(parent, path=file_path)


class Kernel(RunningKernel):
    """A kernel whose death is noticed at once instead of at the end of the cell's time."""

    def execute_cell_input(self, cell_input, allow_stdin=None):
        # With history, as a notebook is run: without it a semicolon no longer hides a value.
        return self.kc.execute(cell_input, allow_stdin=allow_stdin, stop_on_error=False)

    def get_message(self, stream, timeout=None):
        for _ in range(math.ceil(timeout)):
            try:
                return super().get_message(stream, timeout=1)
            except Empty:
                if not self.is_alive():
                    pytest.fail("The kernel died; is the GL library there?", pytrace=False)
        raise Empty


class Text(str):
    """Text equal to another that differs only in the last bits of its numbers."""

    __hash__ = str.__hash__

    def __eq__(self, other):
        return FLOAT.sub("#", self) == FLOAT.sub("#", other) and all(
            close(float(a), float(b)) for a, b in zip(FLOAT.findall(self), FLOAT.findall(other))
        )

    def __ne__(self, other):
        return not self == other


class Cell(IPyNbCell):
    def sanitize(self, text):
        return Text(text) if isinstance(text, str) else text


class Check(pytest.Item):
    """A question about a notebook as a whole; the answer is what's wrong, or nothing."""

    def __init__(self, *, question, **kwargs):
        super().__init__(**kwargs)
        self.question = question

    def runtest(self):
        if problem := self.question():
            pytest.fail(problem, pytrace=False)


class Notebook(IPyNbFile):
    def collect(self):
        yield Check.from_parent(self, name="stored as run", question=self.stored_as_run)
        for cell in super().collect():
            yield Cell.from_parent(
                self, name=cell.name, cell_num=cell.cell_num, cell=cell.cell, options=cell.options
            )
        yield Check.from_parent(self, name="numbers", question=self.compare_numbers)
        yield Check.from_parent(self, name="figures", question=self.compare_figures)

    def setup(self):
        self.results = TemporaryDirectory()
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("TUNNELLER_RESULTS", self.results.name)
            self.kernel = Kernel("python3", cwd=str(self.path.parent))

    def teardown(self):
        super().teardown()
        self.results.cleanup()

    def stored_as_run(self):
        if not is_run(self.path):
            return "The notebook isn't stored as run from top to bottom: `make report` does it."

    def records(self):
        """Return what is committed, and what this run recorded."""
        again = Path(self.results.name, "notebooks", self.path.name)
        return records(self.path)[1], records(again)[1]

    def compare_numbers(self):
        return difference(*self.records())

    def compare_figures(self):
        for figure in self.records()[0].get("figures", {}).values():
            old, new = (
                Path(root, "figures", figure["file"])
                for root in (self.path.parent.parent, self.results.name)
            )
            if problem := picture_difference(old, new):
                return problem


def close(a, b):
    return math.isclose(a, b, rel_tol=NUMBERS)


def difference(old, new, where="records"):
    """Return the first difference between two records as a sentence, or None."""
    if isinstance(old, float) and isinstance(new, int | float):
        if not close(old, new):
            return f"{where}: {old!r} is committed, {new!r} came out now."
    elif isinstance(old, dict) and isinstance(new, dict):
        if odd := set(old) ^ set(new):
            side = "committed" if min(odd) in old else "recorded now"
            return f"{where}: {min(odd)!r} is only {side}."
        return next(filter(None, (difference(old[k], new[k], f"{where}, {k}") for k in old)), None)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        both = enumerate(zip(old, new))
        return next(filter(None, (difference(a, b, f"{where}, {i}") for i, (a, b) in both)), None)
    elif old != new:
        return f"{where}: {json.dumps(old)} is committed, {json.dumps(new)} came out now."


def picture_difference(old, new):
    """Return how two pictures differ as a sentence, or None."""
    for path in (old, new):
        if not path.exists():
            return f"{old.name} is {'not committed' if path == old else 'no longer made'}."
    if old.read_bytes() == new.read_bytes():
        return None
    a, b = pixels(old), pixels(new)
    if a.shape != b.shape:
        return f"{old.name}: {a.shape} pixels are committed, {b.shape} came out now."
    rms = np.sqrt(np.mean((a - b) ** 2))
    if rms > PICTURES:
        return f"{old.name} differs from the committed figure by {rms:.1f} of 255 (RMS)."


def pixels(path):
    """Return a figure as numbers from 0 to 255."""
    if path.suffix == ".svg":
        page = b'#set page(width: auto, height: auto, margin: 0pt)\n#image("%s")'
        path = io.BytesIO(
            typst.compile(page % path.name.encode(), root=path.parent, format="png", ppi=100)
        )
    return np.asarray(PIL.Image.open(path).convert("RGB"), dtype=float)
