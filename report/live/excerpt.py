"""What a statement needs of the statements before it, cut out of them.

The pages' own Python does so, too, with what a reader writes there: this module needs no other.
"""

import ast
import symtable
from functools import cache

COMPREHENSIONS = {"listcomp", "setcomp", "dictcomp", "genexpr"}  # functions that run at once


def excerpt(statements, node):
    """Return those of some statements, in a program's order, that a further node needs.

    Parameters
    ----------
    statements : list of ast.stmt
        What stands before it.
    node : ast.AST
        A statement, an expression or a module.

    Returns
    -------
    needed : list of ast.stmt
        Imports bind the wanted names alone.

    Notes
    -----
    The statements are gone through backwards with the names that matter so far: one that is bound
    anew matters no farther back. A function reads its names whenever it is called: so what
    functions before a statement read matters there, too, and where one is found all begins again.
    """
    kept, settled = {}, False
    while not settled:
        matters, settled = set.union(*_read(node)), True
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
    wanted = set.union(*_read(node)).union(*(now | late for now, late in kept.values()))
    return list(filter(None, (_narrowed(statements[number], wanted) for number in sorted(kept))))


def _read(node):
    """Return the names that a statement reads when it is run, and those that functions in it do.

    A name that a module's own statement has bound before isn't among them.
    """
    if isinstance(node, ast.Module):
        now, late = set(), set()
        for statement in reversed(node.body):
            read, called = _read(statement)
            now, late = now - _bound_anew(statement) | read, late | called
        return now, late
    table = _table(node)
    now = {symbol.get_name() for symbol in table.get_symbols() if symbol.is_referenced()}
    now -= _of_comprehensions(node)
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


@cache  # a notebook's statements are asked again for each of its exercises
def _changed(statement):
    """Return the names that a statement binds, or whose value it may change in place."""
    symbols = _table(statement).get_symbols()
    changed = {s.get_name() for s in symbols if s.is_assigned() or s.is_imported()}
    changed -= _of_comprehensions(statement)
    for node in ast.walk(statement):
        match node:
            case ast.Attribute(ctx=ast.Store()) | ast.Subscript(ctx=ast.Store()):
                changed.add(_root(node))
            case ast.Expr(value=ast.Call(func=ast.Attribute() as method)):
                changed.add(_root(method))
    return changed


def _of_comprehensions(node):
    """Return names that only comprehensions bind; from 3.12 on a table has them as the node's."""
    own = _targets(c for c in ast.walk(node) if isinstance(c, ast.comprehension))
    return own and own - set(_names_outside(node, frozenset()))


def _names_outside(node, bound):
    """Yield names that aren't `bound` by a comprehension around them."""
    if isinstance(node, ast.Name) and node.id not in bound:
        yield node.id
    loops = getattr(node, "generators", [])
    for child in ast.iter_child_nodes(node):
        yield from _names_outside(child, bound | _targets(loops))
    if loops:  # what the first one goes through is found outside
        yield from _names_outside(loops[0].iter, bound)


def _targets(loops):
    """Return the names that loops of comprehensions bind."""
    parts = (part for loop in loops for part in ast.walk(loop.target))
    return {part.id for part in parts if isinstance(part, ast.Name)}


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
        narrowed = ast.Import(names)
    else:
        narrowed = ast.ImportFrom(statement.module, names, statement.level)
    return ast.copy_location(narrowed, statement)
