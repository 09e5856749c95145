"""What a notebook's sliders need of it, cut out as a program of its own.

A page can't wait for a whole notebook. So it runs the statements alone that bind or change a name
which the drawing needs, directly or through others, down to the call of ``sliders``.
"""

import ast
import symtable
from dataclasses import dataclass

from report.reach import needed
from report.sources import DRAWS_SCENES, ROOT, cells

COMPREHENSIONS = {"listcomp", "setcomp", "dictcomp", "genexpr"}  # functions that run at once


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
    before, found, number = [], [], 0
    for kind, source in cells(notebook):
        if kind != "code":
            continue
        number += 1
        for statement in ast.parse(source).body:
            if call := _call_of_sliders(statement):
                found.append(Program(number, _cut_out(before, call)))
            before.append(statement)
    return found


def _call_of_sliders(statement):
    for node in ast.walk(statement):
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) == "sliders":
            return node
    return None


def _cut_out(statements, call):
    """Return the statements that a call needs, and the call, as a text.

    They are gone through backwards with the names that matter so far: one that is bound anew
    matters no farther back. A function reads its names whenever it is called: so what functions
    before a statement read matters there, too, and where one is found all begins again.
    """
    kept, settled = {}, False
    while not settled:
        matters, settled = set.union(*_read(call)), True
        for number in reversed(range(len(statements))):
            statement = statements[number]
            called = [late for other, (_, late) in kept.items() if other < number]
            if not matters.union(*called) & _changed(statement):
                continue
            matters -= _bound_anew(statement)
            if isinstance(statement, ast.Import | ast.ImportFrom):
                kept.setdefault(number, (set(), set()))
                continue
            if number not in kept:
                kept[number] = _read(statement)
                settled = settled and not kept[number][1]
            matters |= set.union(*kept[number])
    wanted = set.union(*_read(call)).union(*(now | late for now, late in kept.values()))
    body = [_narrowed(statements[number], wanted) for number in sorted(kept)]
    return ast.unparse(ast.Module([*filter(None, body), ast.Expr(call)], [])) + "\n"


def _read(node):
    """Return the names that a statement reads when it is run, and those that functions in it do."""
    table = _table(node)
    now = {symbol.get_name() for symbol in table.get_symbols() if symbol.is_referenced()}
    late = set()
    for scope in table.get_children():
        (now if scope.get_name() in COMPREHENSIONS else late).update(_global_names(scope))
    return (now - _bound_anew(node.target) if isinstance(node, ast.For) else now), late


def _global_names(scope):
    inner = map(_global_names, scope.get_children())
    return {name.get_name() for name in scope.get_symbols() if name.is_global()}.union(*inner)


def _bound_anew(node):
    """Return the names that a statement surely binds, whatever they were."""
    match node:
        case ast.Import() | ast.ImportFrom() | ast.FunctionDef() | ast.ClassDef():
            return _changed(node)
        case ast.Assign():
            return set().union(*map(_bound_anew, node.targets))
        case ast.Name():
            return {node.id}
        case ast.Tuple() | ast.List():
            return set().union(*map(_bound_anew, node.elts))
        case ast.Starred():
            return _bound_anew(node.value)
    return set()


def _changed(statement):
    """Return the names that a statement binds, or whose value it may change in place."""
    symbols = _table(statement).get_symbols()
    changed = {s.get_name() for s in symbols if s.is_assigned() or s.is_imported()}
    for node in ast.walk(statement):
        match node:
            case ast.Attribute(ctx=ast.Store()) | ast.Subscript(ctx=ast.Store()):
                changed.add(_root(node))
            case ast.Expr(value=ast.Call(func=ast.Attribute() as method)):
                changed.add(_root(method))
    return changed


def _table(node):
    return symtable.symtable(ast.unparse(node), "a cell", "exec")


def _root(node):
    """Return the name at the start of ``name.a[0].b``; None where something else is."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return getattr(node, "id", None)


def _narrowed(statement, wanted):
    """Return an import of the wanted names alone, other statements as they are."""
    if not isinstance(statement, ast.Import | ast.ImportFrom):
        return statement
    names = [
        alias
        for alias in statement.names
        if (alias.asname or alias.name.partition(".")[0]) in wanted
    ]
    if not names:
        return None
    if isinstance(statement, ast.Import):
        return ast.Import(names)
    return ast.ImportFrom(statement.module, names, statement.level)
