"""The first page: the machine moving, one sentence, three doors, a picture of each chapter."""

import base64
import tomllib
from html import escape

import nbformat
import numpy as np

from report.site.chapter import page_name, title
from report.site.markup import attribute
from report.site.pictures import packed
from report.site.publish import Unavailable
from report.sources import INDEX, ROOT
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

SENTENCE = (
    "A robot reams old sewers with a ball-shaped cutter on two joints; this study repeats the "
    "paper on how to steer it, judges its claims, and lets you try them yourself."
)
SECONDS = 16  # for the circuit
PLACES = 64  # at which the moving machine is drawn
COURSE = 4  # of so many points of the section one has a line along the tunnel
RINGS = np.arange(-0.4, 1.3, 0.4)  # m along the tunnel, where its section is drawn
# Directions of the picture's right and of its up, seen from behind, from the right and from above.
TURN, TILT = np.radians([-62.0, 20.0])
RIGHT = np.array([np.sin(TURN), np.cos(TURN) * -1, 0.0])
UP = np.array([np.cos(TURN) * np.sin(TILT), np.sin(TURN) * np.sin(TILT), np.cos(TILT)])
SCALE = 300  # units of the drawing in a metre
WIDE = 300  # px, of a small picture


def seen(points):
    """Return where points (..., 3), in m, are in the drawing, to a tenth of its units."""
    points = np.asarray(points, dtype=float)
    return np.stack([SCALE * points @ RIGHT, -SCALE * points @ UP], axis=-1).round(1)


def as_points(places):
    return " ".join(f"{x:g},{y:g}" for x, y in places)


def moving_machine():
    """Return a drawing, SVG, in which the reference machine follows its circuit."""
    machine, section = REFERENCE_MACHINE, Egg(0.5)
    circuit = cutting_circuit(machine, section)
    theta, phi = circuit.position(np.linspace(0, circuit.profile.perimeter, PLACES)).T
    joint = np.stack([machine.r * np.cos(theta), 0 * theta, -machine.r * np.sin(theta)], axis=-1)
    centre = machine.torus.point(theta, phi)
    arms = seen(np.stack([np.zeros_like(joint), joint, centre], axis=1))
    balls = arms[:, -1]
    outline = section_points(machine, section)
    rings = [seen(outline + np.array([x, 0.0, 0.0])) for x in RINGS]
    every = np.concatenate([*rings, arms.reshape(-1, 2)])
    margin = SCALE * machine.cutter_radius / 2
    low, high = every.min(axis=0) - margin, every.max(axis=0) + margin
    bricks = zip(rings[0][::COURSE], rings[-1][::COURSE], strict=True)
    parts = [f'<polyline class="tunnel brick" points="{as_points(pair)}"/>' for pair in bricks]
    parts += [f'<polygon class="tunnel" points="{as_points(ring)}"/>' for ring in rings]
    parts.append(f'<polyline class="circuit" points="{as_points(balls)}"/>')
    parts.append(
        f'<polyline class="arm" points="{as_points(arms[0])}">'
        + animated("points", map(as_points, arms)) + "</polyline>"
    )  # fmt: skip
    parts.append(
        f'<circle class="cutter" r="{SCALE * machine.cutter_radius:g}" '
        f'cx="{balls[0, 0]:g}" cy="{balls[0, 1]:g}">'
        + animated("cx", (f"{x:g}" for x in balls[:, 0]))
        + animated("cy", (f"{y:g}" for y in balls[:, 1])) + "</circle>"
    )  # fmt: skip
    box = " ".join(f"{number:.0f}" for number in (*low, *(high - low)))
    said = "The machine moves its cutter, a ball, along the circuit in an egg-shaped tunnel."
    return (
        f'<svg id="moving" role="img" aria-label="{said}" viewBox="{box}">'
        + "".join(parts) + "</svg>"
    )  # fmt: skip


def moving_file():
    """Return the same drawing as a file of its own, with its colours for light and dark pages."""
    style = (
        "<style>* { fill: none; stroke: #777; stroke-width: 2 } .circuit { stroke: #c08fb0 } "
        ".brick { stroke-width: 0.7; stroke: #aaa } "
        ".arm { stroke: #d9a400; stroke-width: 10; stroke-linejoin: round } "
        ".cutter { fill: #777 }</style>"
    )
    head, box, rest = moving_machine().partition('viewBox="')
    width, height = map(float, rest.partition('"')[0].split()[2:])
    size = f'width="{width:.0f}" height="{height:.0f}" '
    drawing = f'{head}xmlns="http://www.w3.org/2000/svg" {size}{box}{rest}'
    return drawing.replace(">", f">{style}", 1) + "\n"


def section_points(machine, section):
    """Return points (n, 3) of the tunnel's section about the machine, in m, at x = 0."""
    along = np.linspace(0, section.perimeter, 73)[:-1]
    outline = section.point(along)
    return np.stack([0 * along, outline[:, 0], outline[:, 1] - machine.height], axis=-1)


def animated(name, values):
    """Return what makes an attribute of a drawing go through values, again and again."""
    return (
        f'<animate attributeName="{name}" dur="{SECONDS}s" repeatCount="indefinite" '
        f'values="{";".join(values)}"/>'
    )


def first_picture(notebook):
    """Return a notebook's first picture, small, as WebP."""
    for cell in nbformat.read(notebook, as_version=4).cells:
        for output in cell.get("outputs", []):
            if content := output.get("data", {}).get("image/png"):
                return packed(base64.b64decode(content), WIDE)
    raise Unavailable(f"{notebook.name}: it holds no picture.")


def front_page(chosen, doors):
    """Return the first page's body, and its small pictures by address.

    Parameters
    ----------
    chosen : list of pathlib.Path
        The notebooks that are chapters.
    doors : list of (str, str, str)
        Each a word, an address, and what is behind it.
    """
    pictures = {}
    entries = "".join(
        f'<li><a class="door" href="{address}"><b>{word}</b> {escape(what)}</a></li>'
        for word, address, what in doors
    )
    parts = [
        "<h1>The open tunneller study</h1>",
        f'<p class="lead">{SENTENCE}</p>',
        f'<div class="moving">{moving_machine()}',
        '<button type="button" id="still" aria-pressed="false">Stop the motion</button></div>',
        f'<ul class="doors">{entries}</ul>',
        f'<p><a href="{page_name(ROOT / "notebooks" / f"{INDEX}.ipynb")}">Where to begin, '
        "courses, words of the trade, and what came out</a></p>"
        if any(n.stem == INDEX for n in chosen) else "",
    ]  # fmt: skip
    for part in tomllib.loads((ROOT / "notebooks" / "contents.toml").read_text())["part"]:
        first, last = part["chapters"]
        within = [n for n in chosen if first <= int(n.stem[:2]) <= last]
        if not within:
            continue
        cards = []
        for notebook in within:
            address = f"thumbnails/{notebook.stem}.webp"
            pictures[address] = first_picture(notebook)
            cards.append(
                f'<li><a href="{page_name(notebook)}"><img src="{address}" loading="lazy" alt="'
                f'{attribute(f"First picture of chapter {notebook.stem[:2]}")}">'
                f"<span>{notebook.stem[:2]} {escape(title(notebook))}</span></a></li>"
            )
        name = part["name"]
        parts.append(f'<h2 id="part-{first}">{escape(name)}</h2>')
        parts.append(f'<ul class="cards">{"".join(cards)}</ul>')
    return "\n".join(parts), pictures
