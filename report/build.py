"""Bring the figures, the numbers and the report up to date: `make report`.

Every task is decided by content (report/sources.py). A task is left alone when its sources are
those of its last run and its results are still those it left then.
"""

import os
import sys
import time
from functools import partial

import doit
from doit.exceptions import TaskFailed, UnmetDependency
from doit.reporter import ZeroReporter

from report.compile import ReportFailed, compile_report
from report.execute import NotebookFailed, run_notebook
from report.sources import (
    INDEX,
    ROOT,
    figure_files,
    file_digest,
    notebook_results,
    notebook_sources,
    notebooks,
    records,
    report_sources,
)

PDF = ROOT / "report" / "report.pdf"
FIGURE_LIST = ROOT / "figures" / "README.md"


class Progress(ZeroReporter):
    """One line when a task starts, one when it ends."""

    def __init__(self, *args):
        super().__init__(*args)
        self.started = {}

    def execute_task(self, task):
        if task.actions:
            self.started[task.name] = time.monotonic()
            self.say(f"{task.name} ...")

    def skip_uptodate(self, task):
        if task.name == "report":
            self.say("report/report.pdf is up to date")

    def add_success(self, task):
        if task.actions:
            self.say(f"{task.name} done in {time.monotonic() - self.started[task.name]:.1f} s")

    def add_failure(self, task, fail):
        if isinstance(fail, UnmetDependency):
            if task.actions:
                self.say(f"{task.name} left as it was, because of the failure above")
        else:
            self.say(f"{task.name} failed: {fail.get_msg().strip()}")

    def say(self, text):
        print(text, file=self.outstream, flush=True)


DOIT_CONFIG = {
    "dep_file": str(ROOT / "build" / "state.json"),
    "backend": "json",
    "reporter": Progress,
    "num_process": len(os.sched_getaffinity(0)),
    "par_type": "thread",  # the work is done in the kernels' own processes
    "continue": True,
}


def task_notebook():
    every = notebooks()
    for path in every:
        yield {
            "name": path.stem,
            "actions": [(plainly, [run_notebook, path])],
            "task_dep": [f"notebook:{n.stem}" for n in every if INDEX == path.stem != n.stem],
            "uptodate": [
                unchanged(partial(notebook_sources, path), partial(notebook_results, path))
            ],
            "io": {"capture": False},
        }


def task_report():
    return {
        "actions": [(plainly, [write_report])],
        "task_dep": ["notebook"],
        "uptodate": [unchanged(report_sources, partial(file_digest, ROOT, [PDF, FIGURE_LIST]))],
        "io": {"capture": False},
    }


def unchanged(sources, results):
    """Return doit's question whether a task is up to date.

    The sources are taken before the task runs: what is edited meanwhile makes it run again.
    """

    def check(task, values):
        before = sources()
        task.value_savers.append(lambda: {"sources": before, "results": results()})
        return values.get("sources") == before and values.get("results") == results()

    return check


def plainly(action, *args):
    """Call an action, its expected failures told as a sentence instead of a traceback."""
    try:
        action(*args)
    except (NotebookFailed, ReportFailed) as error:
        return TaskFailed(str(error))


def write_report():
    forget_deleted_notebooks()
    replace(FIGURE_LIST, figure_list().encode())
    replace(PDF, compile_report())


def forget_deleted_notebooks():
    """Remove the results of notebooks that are gone."""
    kept = {file for n in notebooks() for file in (records(n)[0], *figure_files(n))}
    for numbers in (ROOT / "report" / "numbers").glob("*.json"):
        if numbers not in kept:
            gone = figure_files(ROOT / "notebooks" / numbers.name)
            for path in {numbers, *gone} - kept:
                path.unlink(missing_ok=True)


def figure_list():
    """Return figures/README.md: where each figure comes from and what it shows."""
    lines = ["# Figures", "", "Made by `make report`; each by one notebook.", ""]
    lines += ["| figure | notebook | what it shows |", "| --- | --- | --- |"]
    for notebook in notebooks():
        for _, figure in sorted(records(notebook)[1].get("figures", {}).items()):
            link = f"[{notebook.name}](../notebooks/{notebook.name})"
            lines.append(f"| [{figure['file']}]({figure['file']}) | {link} | {figure['alt']} |")
    return "\n".join(lines) + "\n"


def replace(path, content):
    """Write a file beside its place and rename it, so that nobody finds half of it."""
    path.parent.mkdir(exist_ok=True)
    beside = path.with_name(f".{path.name}.new")
    beside.write_bytes(content)
    os.replace(beside, path)


if __name__ == "__main__":
    (ROOT / "build").mkdir(exist_ok=True)
    try:
        doit.run(globals())
    except KeyboardInterrupt:
        print("Interrupted; the next build goes on from here.", file=sys.stderr, flush=True)
        os._exit(130)  # at once: the threads wait for kernels, which end when we are gone
