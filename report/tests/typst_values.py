"""What Typst math means, as sympy expressions; `typst_math` reads it."""

import itertools

import sympy as sp

from report.tests.typst_math import UnknownMath

FUNCTIONS = {
    "sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "arcsin": sp.asin, "arccos": sp.acos,
    "arctan": sp.atan, "atan2": sp.atan2, "sqrt": sp.sqrt, "floor": sp.floor,
}  # fmt: skip


def name_of(symbol, bound=None):
    """Return the name of a symbol with its index, as f_xxy; bound letters of it replaced."""
    name, index = symbol.parts
    return name + ("_" + "".join(str((bound or {}).get(i, i)) for i in index) if index else "")


def to_sympy(node, vectors=None, bound=None):
    """Return a node as a sympy expression.

    Parameters
    ----------
    node : Node
        A side of a statement.
    vectors : dict of str to int, optional
        How many components a letter has that stands for a vector; they are called n.0, n.1, ..
    bound : dict of str to int, optional
        Values of a sum's indices.

    Examples
    --------
    >>> from report.tests.typst_math import parse
    >>> to_sympy(parse("4 / 3 pi R^3").statements[0].sides[0])
    4*pi*R**3/3
    """

    def of(part):
        return to_sympy(part, vectors, bound)

    match node.kind, node.parts:
        case "number", (text,):
            return sp.Rational(text)
        case "pi", _:
            return sp.pi
        case "imaginary", _:
            return sp.I
        case "symbol", (name, ()) if name in (bound or {}):
            return sp.Integer(bound[name])
        case ("symbol", _) | ("bold", _) | ("tilde", _) | ("gradient", _):
            return _letter(node, vectors or {}, bound)
        case "group", (inner,):
            return of(inner)
        case "vector", items:
            return sp.Matrix([of(item) for item in items])
        case "sum", terms:
            first, *more = [of(part) if sign == "+" else -of(part) for sign, part in terms]
            return sum(more, first)
        case "product", factors:
            result = of(factors[0][1])
            for joint, factor in factors[1:]:
                result = _times(result, of(factor), joint)
            return result
        case "over", (above, below):
            return of(above) / of(below)
        case "power", (base, exponent):
            base, exponent = of(base), of(exponent)
            if _is_vector(base) and exponent != 2:
                raise UnknownMath(f"A vector to the power {exponent}.")
            return base.dot(base) if _is_vector(base) else base**exponent
        case "abs", (inner,):
            inner = of(inner)
            return sp.sqrt(inner.dot(inner)) if _is_vector(inner) else sp.Abs(inner)
        case "call", (name, *arguments):
            return FUNCTIONS.get(name, sp.Function(name))(*map(of, arguments))
        case "integral", (low, high, body, over):
            return sp.Integral(of(body), (of(over), of(low), of(high)))
        case "sum over", (names, total, body):
            most = int(total.parts[0])
            counts = itertools.product(range(most + 1), repeat=len(names))
            chosen = [dict(zip(names, each, strict=True)) for each in counts if sum(each) == most]
            return sum(to_sympy(body, vectors, {**(bound or {}), **each}) for each in chosen)
    raise UnknownMath(f"No meaning for {node.kind}.")


def _letter(node, vectors, bound):
    accent = "" if node.kind == "symbol" else f"{node.kind} "
    name = accent + name_of(node if node.kind == "symbol" else node.parts[0], bound)
    if name in vectors:
        return sp.Matrix([sp.Symbol(f"{name}.{i}") for i in range(vectors[name])])
    if node.kind == "bold":
        raise UnknownMath(f"The vector {name} isn't known.")
    return sp.Symbol(name)


def _is_vector(value):
    return isinstance(value, sp.MatrixBase)


def _times(a, b, joint):
    if _is_vector(a) and _is_vector(b):
        if joint != "dot":
            raise UnknownMath("Two vectors side by side: write dot.")
        return a.dot(b)
    return a * b
