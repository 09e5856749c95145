"""Build the pages that run the study: those of `make site`, a runtime, and programs."""

import json
from pathlib import Path

from report.live.program import exercises, programs
from report.live.runtime import library, licences, lock, provide, wrapped
from report.site import build as site
from report.sources import ROOT, notebooks

LIVE = ROOT / "build" / "live"
HERE = Path(__file__).parent
OWN = ("worker.js", "worker.py", "planner.py")
# Pages of their own, each with a script of its name: address and title.
TOOLS = [("planner.html", "Planner"), ("geodesic.html", "Geodesics")]


class LivePages:
    """What pages that run have in addition to pages that only show.

    Parameters
    ----------
    chosen : list of pathlib.Path
        The notebooks whose sliders move.
    kept : dict of str to bytes
        The runtime's files by name.
    """

    scripts = ("live/parts.js", "live/live.js")
    style = (HERE / "live.css").read_text()
    places = tuple((title, address) for address, title in TOOLS)
    note = (
        "These pages run: below a picture with sliders, and below an exercise, a button loads "
        "Python into the page, once a visit to it, without a network. Scenes can be turned; their "
        "sliders move in the notebooks, which <code>make lab</code> opens."
    )

    def __init__(self, chosen, kept):
        self.kept = kept
        self.programs = {n.stem: programs(n) for n in chosen}
        self.exercises = {n.stem: exercises(n) for n in chosen}

    def below(self, stem, cell):
        """Return what stands below a cell's outputs, as HTML."""
        parts = []
        for name, program in self.named(stem):
            if program.cell != cell:
                continue
            if program.draws_scene:
                parts.append(
                    '<p class="note">The sliders of this scene need VTK, which no page has: '
                    "<code>make lab</code> opens the notebook.</p>\n"
                )
            else:
                parts.append(
                    f'<div class="live" data-program="{name}"><button type="button" '
                    f'aria-label="Move it: sliders of cell {cell}">Move it</button></div>\n'
                )
        if cell in self.exercises[stem]:
            parts.append(
                f'<div class="live" data-exercise="{cell}"><button type="button" '
                f'aria-label="Try it: exercise of cell {cell}">Try it</button></div>\n'
            )
        return "".join(parts)

    def named(self, stem):
        """Return the programs of a notebook with their names."""
        return [(f"{stem}-{k}", program) for k, program in enumerate(self.programs[stem])]

    def add(self, found):
        """Write programs, runtime and licences into the pages' folder."""
        for stem in self.programs:
            for name, program in self.named(stem):
                if not program.draws_scene:
                    text = f"(window.programs ??= {{}})[{json.dumps(name)}] = "
                    found.write(
                        f"live/programs/{name}.js", f"{text}{json.dumps(program.source)};\n"
                    )
        files = dict(self.kept)
        more = [ROOT / "notebooks" / "contents.toml", HERE / "javascript.py", HERE / "excerpt.py"]
        files["study.zip"] = library(more)
        files |= {name: (HERE / name).read_bytes() for name in OWN}
        files["lock"] = lock(self.kept).encode()
        for name, content in files.items():
            found.write(f"live/{name}.js", wrapped(name, content))
        parts = [[name, len(content)] for name, content in files.items()]
        about = {"parts": parts, "total": sum(size for _, size in parts)}
        found.write("live/parts.js", f"window.runtimeParts = {json.dumps(about)};\n")
        found.write("live/live.js", (HERE / "live.js").read_bytes())
        self.add_tools(found)
        for name, content in licences(self.kept):
            found.write(f"live/licences/{name}", content)

    def add_tools(self, found):
        """Write the planner's page and the calculator's."""
        for address, title in TOOLS:
            own = f"live/{address.removesuffix('.html')}.js"
            body = (HERE / address).read_text()
            found.page(
                address,
                title,
                body,
                kind="tool",
                more_scripts=("live/job.js", "live/sketch.js", own),
            )
            found.write(own, (HERE / Path(own).name).read_bytes())
        found.write("live/sketch.js", (HERE / "sketch.js").read_bytes())
        job = (ROOT / "notebooks" / "reference.toml").read_text()
        found.write("live/job.js", f"window.referenceJob = {json.dumps(job)};\n")


def build(folder, chosen=None, kept=None):
    """Make the pages in a folder, which is emptied first.

    Parameters
    ----------
    folder : pathlib.Path
        Where to.
    chosen : list of pathlib.Path, optional
        Notebooks that become chapters, all unless told.
    kept : dict of str to bytes, optional
        The runtime's files, fetched unless told.
    """
    chosen = notebooks() if chosen is None else chosen
    site.build(folder, chosen, LivePages(chosen, provide() if kept is None else kept))
