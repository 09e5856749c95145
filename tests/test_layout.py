"""The house: floors, docstrings, the speed of its import, notebooks that ask a question."""

import ast
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

READS = ["notebooks/*", "tunneller_lib/*"]

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "tunneller_lib"
MODULES = sorted(LIBRARY.rglob("*.py"))
FLOORS = {
    "arguments": 0, "atomic_write": 0, "kernels": 0, "terminal": 0,
    "surfaces": 1, "envelopes": 1,
    "paths": 2, "removal": 2, "motion": 2,
    "ream": 3, "milling": 3,
    "job": 4,
    "__main__": 5,
}  # fmt: skip
# What each package outside the library may import; the library imports none of them.
BESIDE = {"kit": {"kit", "tunneller_lib"}, "exhibits": {"exhibits", "kit", "tunneller_lib"}}
SHARED = sorted((ROOT / "notebooks").glob("*/*.py"))
CORE = {"numpy", "scipy", "tunneller_lib"} | (set(sys.stdlib_module_names) - {"json"})
DRAWN = ROOT / "tunneller_lib" / "job" / "wall_plot.py"  # imported where pictures are wanted


def name_of(path):
    return str(path.relative_to(ROOT))


every_module = pytest.mark.parametrize("path", MODULES, ids=name_of)


def room(path):
    """Return the room a module is in; the package's own __init__ is in none."""
    return path.relative_to(LIBRARY).parts[0].removesuffix(".py")


@cache
def tree_of(path):
    """Return a module's syntax tree, which several tests read."""
    return ast.parse(path.read_text())


def imports(path):
    """Return the absolute names of what a module imports, relative ones resolved."""
    package = ("tunneller_lib", *path.relative_to(LIBRARY).parts[:-1])
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join([*start, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)


@every_module
def test_modules_import_only_from_floors_below(path):
    own = room(path)
    for name in imports(path):
        package, *inner = name.split(".")
        if package == "tunneller_lib" and inner:
            floor = FLOORS.get(inner[0], 0)  # the package's own names, its version, lie below all
            assert inner[0] == own or floor < FLOORS.get(own, 0), f"{own} imports {name}"
        also = {"numba"} if path.stem == "compiled" else {"matplotlib"} if path == DRAWN else set()
        assert own == "__main__" or package in CORE | also, f"{own} imports {name}"


@pytest.mark.parametrize("path", SHARED, ids=name_of)
def test_what_notebooks_share_imports_no_notebook_s_own(path):
    package = path.parent.name
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and not node.level:
            first = node.module.split(".")[0]
            assert first not in BESIDE or first in BESIDE[package], f"{package} imports {first}"


def public(tree, prefix=""):
    """Yield the name and node of every public class, function and method."""
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            if not node.name.startswith("_"):
                yield prefix + node.name, node
                if isinstance(node, ast.ClassDef):
                    yield from public(node, f"{prefix}{node.name}.")


def signature(node):
    """Return the names of a function's arguments, or of a class's fields, or of its __init__."""
    if isinstance(node, ast.FunctionDef):
        a = node.args
        every = [*a.posonlyargs, *a.args, a.vararg, *a.kwonlyargs, a.kwarg]
        return [arg.arg for arg in every if arg and arg.arg not in ("self", "cls")]
    for inner in node.body:
        if isinstance(inner, ast.FunctionDef) and inner.name == "__init__":
            return signature(inner)
    return [inner.target.id for inner in node.body if isinstance(inner, ast.AnnAssign)]


def described(docstring):
    """Return the names in a docstring's section Parameters, or None where it has none."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w[^\n]*\n-+\n|\Z)", docstring, re.M | re.S)
    if not section:
        return None
    heads = re.findall(r"^(\S[^:\n]*?)(?: :.*)?$", section[1], re.M)
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


@every_module
def test_docstrings_describe_the_signature(path):
    tree = tree_of(path)
    assert ast.get_docstring(tree), "the module has no docstring"
    for name, node in public(tree):
        docstring = ast.get_docstring(node)
        assert docstring, f"{name} has no docstring"
        assert docstring.split("\n\n")[0].rstrip().endswith((".", ":")), f"{name}: no sentence"
        names = described(docstring)
        if names is not None:
            assert names == signature(node), f"{name} describes {names}"


def test_import_brings_nothing_heavy():
    heavy = {"matplotlib", "pyvista", "vtk", "IPython", "PIL", "numba", "scipy"}  # till their use
    rooms = ", ".join(f"tunneller_lib.{room}" for room in FLOORS if (LIBRARY / room).is_dir())
    code = f"import sys, {rooms}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, text=True,
                          capture_output=True)  # fmt: skip
    assert not heavy & set(done.stdout.split())


def test_a_name_has_one_meaning_in_the_library():
    names = Counter(name for path in MODULES for name, _ in public(tree_of(path)))
    assert not [name for name, count in names.items() if count > 1]
