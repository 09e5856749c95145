"""A notebook's exercises, and the programs that its sliders need, cut out of it.

A page can't wait for a whole notebook, so it runs only the statements that bind or change a name
which the drawing needs, directly or through others, down to the call of ``sliders``.
"""

import ast
import sys
from dataclasses import dataclass
from functools import cache

from report.live.excerpt import excerpt
from report.reach import needed
from report.sources import DRAWS_SCENES, ROOT, cells

# What a page's Python can import.
PACKAGES = {"tunneller_lib", "kit", "exhibits", "numpy", "scipy", "matplotlib"}
PACKAGES |= sys.stdlib_module_names


@dataclass(frozen=True)
class Program:
    """One call of ``sliders`` and what leads to it.

    Parameters
    ----------
    cell : int
        Number of the code cell that calls, from 1.
    source : str
        Python that ends with the call.
    """

    cell: int
    source: str

    @property
    def draws_scene(self):
        """Whether it draws in space, which takes VTK: no page has that."""
        return ROOT / DRAWS_SCENES in needed(self.source, ROOT)


def programs(notebook):
    """Return the programs of a notebook's sliders, in their order."""
    before, found = [], []
    for number, cell in enumerate(_code(notebook), 1):
        for statement in cell.body:
            if call := _call_of_sliders(statement):
                body = [*excerpt(before, call), ast.Expr(call)]
                found.append(Program(number, ast.unparse(ast.Module(body, [])) + "\n"))
            before.append(statement)
    return found


def exercises(notebook):
    """Return the numbers of a notebook's cells that check what the reader writes, from 1.

    Those that need a package that no page has are left out.
    """
    above, found = [], []
    for number, cell in enumerate(_code(notebook), 1):
        if _asks(cell) and _imported(excerpt(above, cell)) <= PACKAGES:
            found.append(number)
        above += cell.body
    return found


def _code(notebook):
    """Return the syntax trees of a notebook's cells of code."""
    return [_parsed(source) for kind, source in cells(notebook) if kind == "code"]


_parsed = cache(ast.parse)  # so that what is known of a statement is found again


def _asks(cell):
    """Tell whether a cell calls a check, which a folded one above it defines."""
    said = (node for node in cell.body if isinstance(node, ast.Expr))
    names = (getattr(node, "id", "") for one in said for node in ast.walk(one))
    return any(name.startswith("check_") for name in names)


def _imported(statements):
    """Return the packages that statements import."""
    names = set()
    for node in statements:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module)
    return {name.partition(".")[0] for name in names}


def _call_of_sliders(statement):
    for node in ast.walk(statement):
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) == "sliders":
            return node
    return None
