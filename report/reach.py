"""What a piece of Python needs from the checkout: modules, found by following its imports.

Imports are followed name by name. A package's `__init__` that only passes names on is looked
through: `from tunneller_lib.paths import project_chord` needs paths/projection.py and what that
imports, not all of paths. A module that reads data of its package needs all data beside it.
Comments, docstrings and the form of the code have no meaning.
"""

import ast
import hashlib
import sys
from functools import cache
from pathlib import Path

# Where packages of the checkout lie in it.
PACKAGES = {
    "tunneller_lib": "", "report": "", "tests": "", "kit": "notebooks", "exhibits": "notebooks"
}  # fmt: skip


def parsed(text):
    """Return the syntax tree of a source text without its docstrings.

    A text that reads a ``__doc__`` keeps them.
    """
    tree = ast.parse(text)
    if "__doc__" not in text:
        for node in _statements(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                if ast.get_docstring(node, clean=False) is not None:
                    del node.body[0]
    return tree


def _statements(node):
    """Yield a node and all in it but expressions, which have no statement in them."""
    yield node
    for inner in ast.iter_child_nodes(node):
        if not isinstance(inner, ast.expr):
            yield from _statements(inner)


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
        Modules of the checkout, without those that only pass names on, and data of packages.
    """
    return set(steps(text, root, package))


def steps(text, root, package=()):
    """Return the files that `needed` returns, each with how many imports away it is: from 1."""
    found, away = {}, 1
    reached = set(_imported(_imports(text)[0], root, package))
    while reached:
        found |= dict.fromkeys(reached, away)
        reached = {file for near in reached for file in _imported_by(near, root)} - found.keys()
        away += 1
    for file, away in list(found.items()):
        for data in _data(file):
            found.setdefault(data, away)
    return found


@cache
def _data(file):
    """Return the data beside a module, if it reads its package's."""
    if "files(__package__)" not in file.read_text(encoding="utf-8"):
        return []
    return [near for near in file.parent.iterdir() if near.is_file() and near.suffix != ".py"]


def package_of(file, root):
    """Return the package that a module of the checkout is in, for its relative imports."""
    parts = file.relative_to(root).parts[:-1]
    return parts[1:] if parts[:1] == ("notebooks",) else parts


@cache
def _imported_by(file, root):
    return set(_imported(_imports_of(file)[0], root, package_of(file, root)))


@cache
def _imports(text):
    """Return the import statements of a text, and if it has but these and a list of their names."""
    tree, statements = parsed(text), ast.Import | ast.ImportFrom
    found = [node for node in _statements(tree) if isinstance(node, statements)]
    others = (node for node in tree.body if not isinstance(node, statements))
    return found, all(ast.unparse(node).startswith("__all__ =") for node in others)


def _imported(imports, root, package):
    """Yield the files that import statements lead to."""
    for node in imports:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from _whole(root, tuple(alias.name.split(".")))
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield from _named(root, _source(node, package), alias.name)


def _whole(root, module):
    """Yield the files of a module whose names aren't told: of a package, all that it passes on."""
    for file in _file(root, module):
        if _imports_of(file)[1]:
            yield from _imported_by(file, root)
        else:
            yield file


def _named(root, module, name):
    """Yield the files that one name of a module leads to."""
    if inside := list(_whole(root, (*module, name))):
        yield from inside
        return
    for file in _file(root, module):
        imports, alone = _imports_of(file)
        if not alone:
            yield file
            continue
        for node in imports:
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    if name in (alias.asname or alias.name, "*"):
                        yield from _named(root, _source(node, module), alias.name)


def _source(node, package):
    """Return the module that an import statement in a package takes names from."""
    above = package[: len(package) - node.level + 1] if node.level else ()
    return (*above, *(node.module.split(".") if node.module else ()))


@cache
def _file(root, module):
    """Return the file of a module of the checkout in a list, or an empty one."""
    if not module or module[0] not in PACKAGES:
        return []
    place = Path(root, PACKAGES[module[0]], *module)
    return [f for f in (place.with_suffix(".py"), place / "__init__.py") if f.is_file()][:1]


@cache
def _imports_of(file):
    try:
        return _imports(file.read_text(encoding="utf-8"))
    except SyntaxError as error:
        sys.exit(f"{file}, line {error.lineno}: {error.msg}.")
