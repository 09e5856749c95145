"""Scenes that can be turned: one viewer, and the data of each as a script."""

import base64
import json
import re
from functools import cache
from importlib.metadata import files
from pathlib import Path

import trame_vtk.tools

from report.site.publish import Unavailable

LICENCES = Path(__file__).with_name("licences")
ICON = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png"
STYLE = re.compile(r"__vtkStyle\.textContent = (\"(?:[^\"\\]|\\.)*\");")
VIEWER = re.compile(r'<script type="module">(.*?)</script>', re.S)


def scene_script(path):
    """Return a scene as a script: pages that are opened as files can load nothing else."""
    content = base64.b64encode(path.read_bytes()).decode()
    return f"(window.scenes ??= {{}})[{json.dumps(name(path))}] = {json.dumps(content)};\n"


def name(path):
    """Return a scene's name on the site: notebook, cell, number."""
    return f"{path.parent.name}-{path.stem}"


@cache
def viewer_page():
    """Return the viewer's page, vtk.js in one piece, that comes with the packages."""
    return Path(trame_vtk.tools.__file__).with_name("static_viewer.html").read_text()


@cache
def viewer_style():
    """Return what the viewer puts into an element <style> of the page that it is in."""
    [style] = STYLE.findall(VIEWER.search(viewer_page())[1])
    return json.loads(style)


def add_viewer(site):
    """Write the viewer as a script, with the licences of vtk.js and of the page around it."""
    page = viewer_page()
    if ICON not in page:
        raise Unavailable("The viewer isn't the one whose only address from elsewhere is known.")
    viewer = VIEWER.search(page)[1].replace(ICON, "data:,")
    # As a module it would be loaded by a server only; its names are kept to itself.
    site.write("scenes/viewer.js", f"window.global ??= window;\n(() => {{{viewer}}})();\n")
    for path in sorted(LICENCES.iterdir()):
        site.write(f"scenes/licences/{path.name}", path.read_bytes())
    [around] = [path for path in files("trame-vtk") if path.name == "LICENSE"]
    site.write("scenes/licences/trame-vtk-BSD-3-Clause.txt", around.read_text())
