"""What a page's Python needs beside the library: sliders that the page draws, and exercises.

The notebooks' ``sliders`` runs here as it is. It needs ipywidgets and IPython, which a page doesn't
have, so stand-ins below take their place and pass on to the page what is shown.
"""

import ast
import io
import json
import os
import sys
from contextlib import redirect_stdout
from functools import cache, lru_cache
from types import ModuleType

os.environ["MPLBACKEND"] = "agg"
os.chdir("/study/notebooks")
sys.path[:0] = ["/study", "/study/notebooks"]


class Slider:
    """A slider as the library describes it; its class says whether its numbers are whole."""

    def __init__(self, **about):
        self.about = about


class IntSlider(Slider):
    """A slider of whole numbers."""


class FloatSlider(Slider):
    """A slider of any numbers."""


class Image:
    """A picture that is shown."""

    def __init__(self, data, *, alt="", **look):
        self.data, self.alt = data, alt


class Moved:
    """What is drawn anew when a slider moves."""

    def __init__(self, show, controls):
        self.show, self.controls = show, controls


def display(thing):
    """Keep what is shown last."""
    shown.append(thing)


shown = []
stand_ins = {
    "IPython": {"get_ipython": lambda: None, "version_info": (9,)},  # matplotlib looks at both
    "IPython.display": {"display": display, "Image": Image, "Markdown": str},
    "ipywidgets": {
        "IntSlider": IntSlider, "FloatSlider": FloatSlider, "VBox": list,
        "interactive_output": Moved,
    },
}  # fmt: skip
for name, content in stand_ins.items():
    sys.modules[name] = ModuleType(name)
    vars(sys.modules[name]).update(content)

# ruff: noqa: E402 - after what stands in for IPython
import js
import numpy as np
from pyodide.ffi import to_js

from kit import record
from report.live.excerpt import excerpt
from report.live.javascript import Untranslated, script, take_back
from tunneller_lib.kernels import compiled

record.MOVED = {"format": "bmp"}  # to pack a picture takes a tenth of the time to draw it


@cache
def translated(function, *parts):
    """Return a function of the library as the browser's own, or None."""
    try:
        return js.compiled(script(function, **dict(parts)))
    except Untranslated:
        return None


def run_in_browser(function, *arguments, **parts):
    """Do what `compiled.call` does."""
    run = translated(function, *parts.items())
    if run is None:
        return compiled.call_plain(function, *arguments, **parts)
    given = [handed(one) for one in arguments]
    answer = run(*(rows for rows, _ in given))
    for _, changed in given:
        for array, flat in changed:
            if array.flags.writeable:
                take_back(array, flat.to_py())
    return answer


def handed(one):
    """Return an argument for the browser, and pairs of its arrays and their flat numbers there."""
    if isinstance(one, np.ndarray):
        flat = to_js(one.astype(float).ravel())
        return js.rowsOf(flat, one.shape[1]) if one.ndim == 2 else flat, [(one, flat)]
    if isinstance(one, tuple) and any(isinstance(part, np.ndarray) for part in one):
        parts = [handed(part) for part in one]
        rows = [row for row, _ in parts]
        if hasattr(one, "_fields"):
            rows = dict(zip(one._fields, rows, strict=True))
        changed = [pair for _, pairs in parts for pair in pairs]
        return to_js(rows, dict_converter=js.Object.fromEntries), changed
    return named(one) if isinstance(one, tuple) else one, []


@lru_cache(64, typed=True)  # tuples of the same numbers may have other names
def named(numbers):
    """Return a tuple for the browser, one whose fields have names as an object of these."""
    return to_js(fields(numbers), dict_converter=js.Object.fromEntries)


def fields(numbers):
    if not isinstance(numbers, tuple):
        return numbers
    if hasattr(numbers, "_asdict"):
        return {name: fields(value) for name, value in numbers._asdict().items()}
    return [fields(value) for value in numbers]


compiled.replace_plain(run_in_browser)


class Drawing:
    """A program's sliders, and the picture for where they stand."""

    def __init__(self, program):
        exec(compile(program, "the chapter", "exec"), {"__name__": "__main__"})
        *_, box = shown
        *self.sliders, self.moved = box
        shown.clear()

    def controls(self):
        """Return each slider for the page."""
        names = self.moved.controls
        return [
            {"name": name, "whole": isinstance(slider, IntSlider)}
            | {key: slider.about.get(key) for key in ("min", "max", "value", "description")}
            for name, slider in names.items()
        ]

    def drawn(self, values):
        """Return the picture's bytes, BMP, and its words."""
        controls = self.moved.controls
        whole = {name: isinstance(slider, IntSlider) for name, slider in controls.items()}
        self.moved.show(**{n: round(v) if whole[n] else float(v) for n, v in values.items()})
        picture = shown.pop()
        return picture.data, picture.alt


class Exercise:
    """A cell of a notebook for the reader to change; of the cells above it runs what it needs.

    Parameters
    ----------
    notebook : str
        The notebook's file.
    cell : int
        Number of its code cell, from 1.
    """

    def __init__(self, notebook, cell):
        every = json.loads(notebook)["cells"]
        code = ["".join(one["source"]) for one in every if one["cell_type"] == "code"]
        self.above = [statement for text in code[: cell - 1] for statement in ast.parse(text).body]
        self.source = code[cell - 1]

    def printed(self, text):
        """Return what the cell prints as the reader wrote it."""
        needed = excerpt(self.above, ast.parse(text))
        names = dict(names_of(ast.unparse(ast.Module(needed, []))))
        with redirect_stdout(io.StringIO()) as said:
            exec(compile(text, "the exercise", "exec"), names)
        return said.getvalue()


@lru_cache(2)  # whoever tries again needs mostly the same
def names_of(text):
    """Return what a program has bound when it has run."""
    names = {"__name__": "__main__"}
    exec(compile(text, "the chapter", "exec"), names)
    return names
