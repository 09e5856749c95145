"""Who uses what a room lists: a name that nobody outside the library says isn't public.

A user is a notebook, what notebooks share, the command line, a program of the report or the
README. Kinds of answers need no listing: who has an answer has its fields and methods, which are
documented in its module.
"""

import importlib
import re

import pytest

from report.sources import ROOT, code

READS = ["notebooks/*.ipynb", "report/*.py", "README.md", "tunneller_lib/*"]

LIBRARY = ROOT / "tunneller_lib"
USERS = [*ROOT.glob("notebooks/*/*.py"), *ROOT.glob("report/**/*.py"), LIBRARY / "__main__.py"]
ROOMS = [path.parent.name for path in sorted(LIBRARY.glob("*/__init__.py"))]


@pytest.fixture(scope="module")
def kept():
    """Return the words of all that users write, and the classes that arguments ask for."""
    texts = [path.read_text(encoding="utf-8") for path in (*USERS, ROOT / "README.md")]
    texts += map(code, ROOT.glob("notebooks/[0-9]*.ipynb"))
    own = "".join(path.read_text(encoding="utf-8") for path in LIBRARY.rglob("*.py"))
    return set(re.findall(r"\w+", "".join(texts))), set(re.findall(r"[:|] ([A-Z]\w+)", own))


@pytest.mark.parametrize("room", [room for room in ROOMS if room != "kernels"])
def test_every_public_name_has_a_user_or_is_a_kind_of_argument(room, kept):
    used, kinds = kept
    package = importlib.import_module(f"tunneller_lib.{room}")
    for name in set(package.__all__) - used:
        # A class is a kind of argument by itself, or by a class that it derives from.
        derived = getattr(getattr(package, name, None), "__mro__", ())[:-1]
        wanted = kinds & {name, *(one.__name__ for one in derived)}
        assert wanted, f"nobody outside the library asks for {name}: take it off `__all__`"
