"""Whether results agree: the same up to last bits, pictures the same to the eye.

Last bits depend on the processor, pixels at edges on the version of the GL library. A build keeps
the results that are there where the new ones agree with them, and the tests ask no more.
"""

import base64
import io
import json
import math
import re

import nbformat
import numpy as np
import PIL.Image
import typst
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter, uniform_filter

from kit.number_format import MORE, decimals_of
from kit.style import FONTS

NUMBERS = 1e-9  # relative difference that is none
BLUR = 2.0  # px, of a page printed at 215 dpi: what the eye takes together
# Of 255: by how much two blurred pictures may differ anywhere. The paler of two colours in a line
# comes to 37, another digit in a label to 100.
SEEN = 24.0
# Scenes are made by the GL library. Another version puts edges a pixel aside, and where surfaces
# touch, or a line lies in one, its rounding decides which is seen: in up to 0.26 % of the pixels
# between Mesa 22 and 26.
ASIDE = 1  # px
SHARE = 0.005  # of a scene's pixels may differ by more than SEEN
# Such pixels are scattered, a letter's lie together. In a square of 32 x 32 two drivers of Mesa,
# one without its smoothing of edges, differ in up to 64; a P of 8 points fills 280.
SQUARE, CROWD = 32, 200
BLANK = (  # a white pixel
    b"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N"
    b"70a4AAAAAElFTkSuQmCC"
)
EMBEDDED = re.compile(rb"data:image/png;base64,([^\"]*)")

FLOAT = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?")


def close(a, b):
    """Tell whether two numbers differ in their last bits only."""
    return math.isclose(a, b, rel_tol=NUMBERS)


class Text(str):
    """Text equal to another that differs only in the last bits of its numbers."""

    __hash__ = str.__hash__

    def __eq__(self, other):
        return FLOAT.sub("#", self) == FLOAT.sub("#", other) and all(
            close(float(a), float(b))
            for a, b in zip(FLOAT.findall(self), FLOAT.findall(other), strict=True)
        )

    def __ne__(self, other):
        return not self == other


def difference(old, new, where="records", unit=0.0):
    """Return the first difference between two records as a sentence, or None.

    Numbers may differ by one unit of the last digit that is stored, which is behind those that
    are printed: these may not differ.
    """
    if isinstance(old, float) and isinstance(new, int | float):
        if not close(old, new) and abs(old - new) > 1.01 * unit:
            return f"{where}: {old!r} is committed, {new!r} came out now."
    elif isinstance(old, dict) and isinstance(new, dict):
        if odd := set(old) ^ set(new):
            side = "committed" if min(odd) in old else "recorded now"
            return f"{where}: {min(odd)!r} is only {side}."
        units = _units(old)
        pairs = ((k, units.get(k, unit)) for k in old)
        return _first(difference(old[k], new[k], f"{where}, {k}", u) for k, u in pairs)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        units = unit if isinstance(unit, list) else [unit] * len(old)
        each = enumerate(zip(old, new, units, strict=True))
        return _first(difference(a, b, f"{where}, {i}", u) for i, (a, b, u) in each)
    elif old != new:
        return f"{where}: {json.dumps(old)} is committed, {json.dumps(new)} came out now."


def _units(entry):
    """Return the unit of the last stored digit of a number's value, or of a table's rows."""
    if entry.get("digits") is not None:
        return {"value": 10.0 ** -(decimals_of(entry["value"], entry["digits"]) + MORE)}
    if "rows" in entry and "text" in entry:
        decimals = [[len(cell.partition(".")[2]) for cell in row] for row in entry["text"]]
        return {"rows": [[10.0 ** -(d + MORE) for d in row] for row in decimals]}
    return {}


def _first(sentences):
    return next(filter(None, sentences), None)


def picture_difference(old, new):
    """Return how two files of pictures differ as a sentence, or None."""
    for path in (old, new):
        if not path.exists():
            return f"{old.name} is {'not committed' if path == old else 'no longer made'}."
    if old.read_bytes() == new.read_bytes():
        return None
    if old.suffix == ".png":
        return _scene_difference(old.name, old.read_bytes(), new.read_bytes())
    scenes = [
        [base64.b64decode(image) for image in EMBEDDED.findall(path.read_bytes())]
        for path in (old, new)
    ]
    if len(scenes[0]) != len(scenes[1]):
        return (
            f"{old.name}: {len(scenes[0])} pictures are in the committed one, {len(scenes[1])} now."
        )
    drawings = [EMBEDDED.sub(BLANK, path.read_bytes()) for path in (old, new)]
    if drawings[0] != drawings[1]:
        a, b = map(_drawn, drawings)
        if a.shape != b.shape:
            return f"{old.name}: {a.shape} pixels are committed, {b.shape} came out now."
        if (most := seen(a - b).max()) > SEEN:
            return f"{old.name} differs from the committed figure by {most:.0f} of 255 somewhere."
    return _first(_scene_difference(old.name, *pair) for pair in zip(*scenes, strict=True))


def _scene_difference(name, old, new):
    """Return how two scenes, files' contents, differ as a sentence, or None."""
    if old == new:
        return None
    a, b = _pixels(old), _pixels(new)
    wider = np.abs(np.subtract(a.shape, b.shape)).max()
    if wider > 2 * ASIDE:
        return f"{name}: {a.shape} pixels are committed, {b.shape} came out now."
    changed = min((changed_pixels(x, y) for x, y in _overlays(a, b)), key=np.mean)
    if (share := np.mean(changed)) > SHARE:
        return f"{name} differs from the committed figure in {100 * share:.1f} % of its pixels."
    around = uniform_filter(changed.astype(float), SQUARE, mode="constant") * SQUARE**2
    if around.max() > CROWD:
        row, column = np.unravel_index(around.argmax(), around.shape)
        return f"{name} differs from the committed figure about pixel ({column}, {row})."


def _overlays(a, b):
    """Yield both pictures cut to the size that they share, laid over each other in every way."""
    height, width = np.minimum(a.shape, b.shape)[:2]
    for x in _cuts(a, height, width):
        for y in _cuts(b, height, width):
            yield x, y


def _cuts(picture, height, width):
    for top in range(picture.shape[0] - height + 1):
        for left in range(picture.shape[1] - width + 1):
            yield picture[top : top + height, left : left + width]


def changed_pixels(a, b):
    """Tell of which pixels (n, m) the eye sees that two pictures (n, m, 3) differ."""
    # Colours leave a range by no more than they differ: nearly always this says enough, sooner.
    most = gaussian_filter(np.abs(a - b).max(axis=-1), BLUR) > SEEN
    if not most.any():
        return most
    return np.maximum(seen(beyond(a, b)), seen(beyond(b, a))).max(axis=-1) > SEEN


def beyond(a, b):
    """Return by how much a picture leaves the range of colours that another has nearby.

    Both (n, m, 3), nearby within `ASIDE` pixels: zero where only edges lie aside.
    """
    size = (2 * ASIDE + 1, 2 * ASIDE + 1, 1)
    above = np.maximum(b - maximum_filter(a, size), 0)
    return above - np.maximum(minimum_filter(a, size) - b, 0)


def seen(difference):
    """Return what the eye sees of a difference (n, m, 3) of two pictures."""
    return np.abs(gaussian_filter(difference, (BLUR, BLUR, 0)))


def _drawn(svg):
    """Return a drawing, a file's content, as numbers from 0 to 255 at the resolution of print."""
    page = b"#set page(width: auto, height: auto, margin: 0pt)\n#image(bytes(sys.inputs.svg))"
    how = {"format": "png", "ppi": 215, "font_paths": [FONTS], "ignore_system_fonts": True}
    return _pixels(typst.compile(page, **how, sys_inputs={"svg": svg.decode()}))


def _pixels(content):
    """Return a picture, a file's content, as numbers from 0 to 255."""
    return np.asarray(PIL.Image.open(io.BytesIO(content)).convert("RGB"), dtype=np.float32)


def agree(old, new):
    """Tell whether two files hold the same result; what they are is told by their names."""
    if not old.exists():
        return False
    if old.read_bytes() == new.read_bytes():
        return True
    if new.suffix in (".png", ".svg"):
        return picture_difference(old, new) is None
    if new.suffix == ".json":
        try:
            return difference(json.loads(old.read_bytes()), json.loads(new.read_bytes())) is None
        except ValueError:
            return False
    if new.suffix == ".ipynb":
        return _same_notebook(*(nbformat.read(path, as_version=4) for path in (old, new)))
    return False


def _same_notebook(old, new):
    if old.metadata != new.metadata or len(old.cells) != len(new.cells):
        return False
    return all(_same_cell(a, b) for a, b in zip(old.cells, new.cells, strict=True))


def _same_cell(old, new):
    """Compare two cells; of the pictures among the outputs only what they show counts."""
    outputs = [cell.pop("outputs", []) for cell in (old, new)]
    return old == new and len(outputs[0]) == len(outputs[1]) and all(map(_same_output, *outputs))


def _same_output(old, new):
    pictures = [output.get("data", {}).pop("image/png", None) for output in (old, new)]
    if Text(json.dumps(old, sort_keys=True)) != Text(json.dumps(new, sort_keys=True)):
        return False
    if pictures[0] == pictures[1]:
        return True
    if None in pictures:
        return False
    return _scene_difference("", *map(base64.b64decode, pictures)) is None
