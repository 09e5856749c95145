"""What a page's Python needs beside the library: sliders that the page draws.

The library's own ``sliders`` runs here. It asks ipywidgets for sliders and IPython to display: a
page has neither, so what it asks for stands below and tells the page.
"""

import os
import sys
from types import ModuleType

os.environ["MPLBACKEND"] = "agg"
os.chdir("/study/notebooks")
sys.path.insert(0, "/study")


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

from matplotlib.mathtext import MathTextParser  # noqa: E402 - after what stands in for IPython

from tunneller_lib.reporting import record  # noqa: E402 - likewise

record.MATHTEXT = MathTextParser("agg")  # as Pyodide's matplotlib 3.10 wants it; ours is 3.11


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
        """Return the picture's bytes, PNG, and its words."""
        controls = self.moved.controls
        whole = {name: isinstance(slider, IntSlider) for name, slider in controls.items()}
        self.moved.show(**{n: round(v) if whole[n] else float(v) for n, v in values.items()})
        picture = shown.pop()
        return picture.data, picture.alt
