"""What a piece of Python needs from the checkout: modules, found by following its imports.

Imports are followed name by name. A package's `__init__` that only passes names on is looked
through: `from tunneller_lib.paths import project_chord` needs paths/projection.py and what that
imports, not all of paths. Comments, docstrings and the form of the code have no meaning.
"""

import ast
import gc
import hashlib
import sys
from functools import cache
from pathlib import Path

PACKAGES = {"tunneller_lib", "report", "tests"}


@cache
def parsed(text):
    """Return the syntax tree of a source text without its docstrings.

    A text that reads a ``__doc__`` keeps them.
    """
    tree = _tree_of(text)
    if "__doc__" not in text:
        for node in _statements(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                if ast.get_docstring(node, clean=False) is not None:
                    del node.body[0]
    return tree


def _tree_of(text):
    """Return a text's syntax tree, made without looking for garbage among its many nodes."""
    looked = gc.isenabled()
    gc.disable()
    try:
        return ast.parse(text)
    finally:
        if looked:
            gc.enable()


def _statements(tree):
    """Yield a tree and the statements in it: expressions, nearly all of a tree, hold none."""
    inside = [tree]
    while inside:
        node = inside.pop()
        yield node
        for body in ("body", "handlers", "cases", "orelse", "finalbody"):
            inside += getattr(node, body, ())


@cache
def meaning(text):
    """Return a digest of a source text that comments, docstrings and form leave as it is.

    Examples
    --------
    >>> meaning("x = (1 +\\n     2)  # three") == meaning("x = 1 + 2") != meaning("x = 2 + 1")
    True
    """
    return hashlib.sha256(ast.dump(parsed(text)).encode()).hexdigest()


def needed(text, root, package=()):
    """Return the files that a source text needs, directly or through others.

    Parameters
    ----------
    text : str
        The source of a module, or all code of a notebook.
    root : pathlib.Path
        The checkout.
    package : tuple of str
        The package that the text is in, for its relative imports.

    Returns
    -------
    files : set of pathlib.Path
        Modules of the checkout, without those that only pass names on.
    """
    return set(steps(text, root, package))


def steps(text, root, package=()):
    """Return the files that `needed` returns, each with how many imports away it is: from 1."""
    found, away = {}, 1
    reached = set(_imported(parsed(text), root, package))
    while reached:
        found |= dict.fromkeys(reached, away)
        reached = {file for near in reached for file in _imported_by(near, root)} - found.keys()
        away += 1
    return found


@cache
def _imported_by(file, root):
    return set(_imported(_tree(file), root, file.relative_to(root).parts[:-1]))


def _imported(tree, root, package):
    """Yield the files that a tree's import statements lead to."""
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from _whole(root, tuple(alias.name.split(".")))
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield from _named(root, _source(node, package), alias.name)


def _whole(root, module):
    """Yield the files of a module whose names aren't told: of a package, all that it passes on."""
    for file in _file(root, module):
        if _passes_on(_tree(file)):
            yield from _imported_by(file, root)
        else:
            yield file


def _named(root, module, name):
    """Yield the files that one name of a module leads to."""
    if inside := list(_whole(root, (*module, name))):
        yield from inside
        return
    for file in _file(root, module):
        tree = _tree(file)
        if not _passes_on(tree):
            yield file
            continue
        for node in tree.body:
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    if name in (alias.asname or alias.name, "*"):
                        yield from _named(root, _source(node, module), alias.name)


def _source(node, package):
    """Return the module that an import statement in a package takes names from."""
    above = package[: len(package) - node.level + 1] if node.level else ()
    return (*above, *(node.module.split(".") if node.module else ()))


def _file(root, module):
    """Return the file of a module of the checkout in a list, or an empty one."""
    if not module or module[0] not in PACKAGES:
        return []
    place = Path(root, *module)
    return [f for f in (place.with_suffix(".py"), place / "__init__.py") if f.is_file()][:1]


def _passes_on(tree):
    """Tell whether a module only imports names and lists them, as a package's __init__ does."""
    return all(
        isinstance(node, ast.Import | ast.ImportFrom)
        or (isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__")
        for node in tree.body
    )


@cache
def _tree(file):
    try:
        return parsed(file.read_text(encoding="utf-8"))
    except SyntaxError as error:
        sys.exit(f"{file}, line {error.lineno}: {error.msg}.")
