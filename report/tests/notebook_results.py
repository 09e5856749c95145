"""Pytest's view of a notebook: its cells run again, its outputs, numbers and figures compared.

Built on nbval, whose comparison of outputs is exact; here numbers may differ in their last bits,
which depend on the processor. Figures are compared as files, not as outputs. A notebook that a
build has run here isn't run again while its sources and its results are those of that build.
"""

import functools
import math
from contextlib import ExitStack
from pathlib import Path
from queue import Empty
from tempfile import TemporaryDirectory

import pytest
from nbval.kernel import RunningKernel
from nbval.plugin import IPyNbCell, IPyNbFile

from report.kernels import shared_imports
from report.sources import is_run, notebook_sources, records
from report.state import State


@pytest.fixture(autouse=True, scope="session")
def _elsewhere(tmp_path_factory):
    """No test, and no doctest, records anything in the checkout."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TUNNELLER_RESULTS", str(tmp_path_factory.getbasetemp() / "results"))
        yield


@functools.cache
def share_imports(config):
    """Let the kernels of this process share what they import, from now on."""
    stack = ExitStack()
    stack.enter_context(shared_imports())
    config.add_cleanup(stack.close)


@pytest.fixture(scope="session")
def shared_kernels(pytestconfig):
    """Kernels that share what they import."""
    share_imports(pytestconfig)


def pytest_collect_file(file_path, parent):
    if file_path.match("[0-9]*.ipynb"):  # the others are a visitor's own
        return Notebook.from_parent(parent, path=file_path)


def compare():
    """Return the module that compares: its matplotlib takes a second, where nothing is compared."""
    from report import compare

    return compare


class Kernel(RunningKernel):
    """A kernel whose death is noticed at once instead of at the end of the cell's time."""

    def execute_cell_input(self, cell_input, allow_stdin=None):
        # With history, as a notebook is run: without it a semicolon no longer hides a value.
        return self.kc.execute(cell_input, allow_stdin=allow_stdin, stop_on_error=False)

    def get_message(self, stream, timeout=None):
        for _ in range(math.ceil(4 * timeout)):
            try:
                return super().get_message(stream, timeout=0.25)
            except Empty:
                if not self.is_alive():
                    pytest.fail("The kernel died; is the GL library there?", pytrace=False)
        raise Empty


class Cell(IPyNbCell):
    def sanitize(self, text):
        return compare().Text(text) if isinstance(text, str) else text


class Check(pytest.Item):
    """A question about a notebook as a whole; the answer is what's wrong, or nothing."""

    def __init__(self, *, question, **kwargs):
        super().__init__(**kwargs)
        self.question = question

    def runtest(self):
        if problem := self.question():
            pytest.fail(problem, pytrace=False)

    def reportinfo(self):
        return self.path, 0, self.name  # a report of a skipped item asks for a line


class Notebook(IPyNbFile):
    def collect(self):
        yield Check.from_parent(self, name="stored as run", question=self.stored_as_run)
        self.built = not self.stale()
        if self.built:
            yield Check.from_parent(self, name="as it was built here", question=self.stale)
            return
        for cell in super().collect():
            yield Cell.from_parent(
                self, name=cell.name, cell_num=cell.cell_num, cell=cell.cell, options=cell.options
            )
        yield Check.from_parent(self, name="numbers", question=self.compare_numbers)
        yield Check.from_parent(self, name="figures", question=self.compare_figures)

    def setup(self):
        self.results = TemporaryDirectory()
        if self.built:
            return
        share_imports(self.config)
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("TUNNELLER_RESULTS", self.results.name)
            patch.setenv("PYVISTA_JUPYTER_BACKEND", "static")  # a scene's picture, as it is stored
            self.kernel = Kernel("python3", cwd=str(self.path.parent))

    def teardown(self):
        super().teardown()
        self.results.cleanup()

    def stored_as_run(self):
        if not is_run(self.path):
            return "The notebook isn't stored as run from top to bottom: `make report` does it."

    def stale(self):
        """Return why it has to run again, or None if the last build here left it as it is now."""
        state = State(self.path.parents[1], self.path.stem)
        return state.stale(notebook_sources(self.path) if state.sources else {})

    def records(self):
        """Return what is committed, and what this run recorded."""
        again = Path(self.results.name, "notebooks", self.path.name)
        return records(self.path)[1], records(again)[1]

    def compare_numbers(self):
        return compare().difference(*self.records())

    def compare_figures(self):
        for figure in self.records()[0].get("figures", {}).values():
            old, new = (
                Path(root, "figures", figure["file"])
                for root in (self.path.parent.parent, self.results.name)
            )
            if problem := compare().picture_difference(old, new):
                return problem
