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
from scipy.ndimage import gaussian_filter

from tunneller_lib.reporting.number_format import MORE, decimals_of

NUMBERS = 1e-9  # relative difference that is none
BLUR = 2.0  # px, of a page printed at 215 dpi: what the eye takes together
# Of 255: by how much two blurred pictures may differ anywhere. Another version of the GL library
# comes to 16 (dots of a cloud, seen only by blinking), the paler of two colours in a line to 37,
# another digit in a label to 100.
SEEN = 24.0

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
    a, b = pixels(old), pixels(new)
    if a.shape != b.shape:
        return f"{old.name}: {a.shape} pixels are committed, {b.shape} came out now."
    if (most := seen(a, b)) > SEEN:
        return f"{old.name} differs from the committed figure by {most:.0f} of 255 somewhere."


def seen(a, b):
    """Return by how much two pictures (n, m, 3) differ to the eye where they differ most."""
    return float(np.abs(gaussian_filter(a - b, (BLUR, BLUR, 0))).max())


def pixels(path):
    """Return a figure as numbers from 0 to 255, a drawing at the resolution of print."""
    if path.suffix == ".svg":
        page = b'#set page(width: auto, height: auto, margin: 0pt)\n#image("%s")'
        path = io.BytesIO(
            typst.compile(page % path.name.encode(), root=path.parent, format="png", ppi=215)
        )
    return np.asarray(PIL.Image.open(path).convert("RGB"), dtype=float)


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
    a, b = (_decoded(picture) for picture in pictures)
    return a.shape == b.shape and seen(a, b) <= SEEN


def _decoded(picture):
    content = io.BytesIO(base64.b64decode(picture))
    return np.asarray(PIL.Image.open(content).convert("RGB"), dtype=float)
