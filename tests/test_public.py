"""Who uses what a room lists: a name that nobody outside the library asks for isn't public.

A user is a notebook, what notebooks share, the command line, a program of the report or the
README. Kinds of answers need no listing: who has an answer has its fields and methods, which are
documented in its module.
"""

import ast
import importlib
import re

import pytest

from report.sources import ROOT, code

READS = ["notebooks/*.ipynb", "report/*.py", "README.md", "tunneller_lib/*"]

LIBRARY = ROOT / "tunneller_lib"
ROOMS = sorted(
    path.parent.name for path in LIBRARY.glob("*/__init__.py") if path.parent.name != "kernels"
)


def imported():
    """Yield (room, name) of what users import from a room, or from a module of one."""
    texts = [(code(path), "") for path in ROOT.glob("notebooks/[0-9]*.ipynb")]
    files = [*ROOT.glob("notebooks/*/*.py"), *ROOT.glob("report/**/*.py"), LIBRARY / "__main__.py"]
    texts += [(path.read_text(), path.parent.name) for path in files]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    texts += [(block, "") for block in re.findall(r"^```python\n(.*?)^```", readme, re.M | re.S)]
    for text, package in texts:
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom):
                start = [package] * bool(node.level) + (node.module or "").split(".")
                for alias in node.names:
                    _, *inner = [*filter(None, start), alias.name]
                    if start[0] == "tunneller_lib" and len(inner) > 1:
                        yield from ((inner[0], name) for name in inner[1:])


def asked_for():
    """Return the names of classes that stand in annotations: kinds of arguments."""
    found = set()
    for path in LIBRARY.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.arg | ast.AnnAssign) and node.annotation:
                found |= {one.id for one in ast.walk(node.annotation) if isinstance(one, ast.Name)}
    return found


@pytest.fixture(scope="module")
def kept():
    """Return the (room, name) of all that users import, and the names that arguments ask for."""
    return {*imported()}, asked_for()


@pytest.mark.parametrize("room", ROOMS)
def test_every_public_name_has_a_user_or_is_a_kind_of_argument(room, kept):
    used, kinds = kept
    package = importlib.import_module(f"tunneller_lib.{room}")
    unused = []
    for name in package.__all__:
        # A class is a kind of argument by itself, or by a class that it derives from.
        derived = getattr(getattr(package, name, None), "__mro__", ())[:-1]
        if (room, name) not in used and not kinds & {name, *(one.__name__ for one in derived)}:
            unused.append(name)
    assert not unused
