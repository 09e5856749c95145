"""Scenes that can be turned: one viewer, and the data of each as a script."""

import base64
import json
import re
from pathlib import Path

import trame_vtk.tools

ICON = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png"
VIEWER = re.compile(r'<script type="module">(.*?)</script>', re.S)


def scene_script(path):
    """Return a scene as a script: pages that are opened as files can load nothing else."""
    content = base64.b64encode(path.read_bytes()).decode()
    return f"(window.scenes ??= {{}})[{json.dumps(name(path))}] = {json.dumps(content)};\n"


def name(path):
    """Return a scene's name on the site: notebook, cell, number."""
    return f"{path.parent.name}-{path.stem}"


def add_viewer(site):
    """Write the viewer, vtk.js in one piece, that comes with the packages."""
    page = Path(trame_vtk.tools.__file__).with_name("static_viewer.html").read_text()
    if ICON not in page:
        raise LookupError("The viewer isn't the one whose only address from elsewhere is known.")
    viewer = VIEWER.search(page)[1].replace(ICON, "data:,")
    # As a module it would be loaded by a server only; its names are kept to itself.
    site.write("scenes/viewer.js", f"window.global ??= window;\n(() => {{{viewer}}})();\n")
