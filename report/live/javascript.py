"""The library's loops over plain numbers as JavaScript, which a browser compiles as it runs them.

A page has no numba. What `compiled.call` is given uses little of Python: numbers, tuples and rows
by index, named fields, whole ranges, the mathematics of the C library. That is translated here,
statement by statement, in the same order. Sums, products, quotients and roots have the same bits.
Sines are those of `libm`, Python's own: the browsers' differ from each other.
"""

import ast
import inspect
import json
import textwrap
from types import FunctionType, ModuleType

import numpy as np

from tunneller_lib.kernels import compiled

# What Python's own functions are in JavaScript; a wrong argument raises an error there, too.
HELPERS = """\
const fail = (why) => { throw new RangeError(why); };
const ratio = (a, b) => (b === 0 ? fail("division by zero") : a / b);
const whole = (a, b) => Math.floor(ratio(a, b));
const remainder = (a, b) => a - b * Math.floor(ratio(a, b));
const root = (x) => (x < 0 ? fail("root of a negative number") : Math.sqrt(x));
const greater = (a, b) => (b > a ? b : a);
const lesser = (a, b) => (b < a ? b : a);
const signed = (x, y) => (y < 0 || Object.is(y, -0) ? -Math.abs(x) : Math.abs(x));
const size = (row) => row.length;
const same = (x) => x;
"""
PLAIN = {"abs": "Math.abs", "len": "size", "float": "same", "max": "greater", "min": "lesser"}
MATH = {"sqrt": "root", "copysign": "signed", "inf": "Infinity"}
MATH |= {name: f"libm.{name}" for name in ("sin", "cos", "tanh")} | {"floor": "Math.floor"}
MATH |= {"pi": "Math.PI", "atan2": "Math.atan2"}  # whose last bits no answer depends on
KNOWN = {compiled.root: "root"}
INFIX = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}
CALLED = {ast.Div: "ratio", ast.Mod: "remainder", ast.FloorDiv: "whole"}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "===", ast.NotEq: "!=="}


class Untranslated(Exception):
    """Something that a function does is none of what is translated."""


def script(function, **parts):
    """Return JavaScript that, as the body of a function, returns a function as its own.

    Parameters
    ----------
    function : function
        As `compiled.call` takes it. Tuples and rows become arrays, named tuples objects.
    **parts
        Functions to be called in place of those that have these names.

    Raises
    ------
    Untranslated
        If it, or a function that it calls, does something else.
    """
    made = {}
    name = _named(function, parts, made)
    texts = [text for _, text in made.values()]
    return "\n".join([HELPERS, *texts, f"return {name};\n"])


def take_back(array, flat):
    """Fill an array, of floats or of whole numbers, with a browser's flat copy of it."""
    array[...] = np.reshape(flat, array.shape)


def _named(function, parts, made):
    """Return the name that a function has in JavaScript; `made` keeps names and texts."""
    if function not in made:
        name = f"{function.__name__}_{len(made)}"
        made[function] = name, ""  # it may call itself
        made[function] = name, _Writer(function, parts, made).text(name)
    return made[function][0]


class _Writer:
    """Writes one function; `parts` and `made` are as of `_named`."""

    def __init__(self, function, parts, made):
        self.parts, self.made = parts, made
        self.globals = function.__globals__
        try:
            [self.tree] = ast.parse(textwrap.dedent(inspect.getsource(function))).body
        except (OSError, SyntaxError, ValueError) as error:
            raise Untranslated(str(error)) from None
        if not isinstance(self.tree, ast.FunctionDef):
            raise Untranslated(f"{function.__name__} isn't a function that has a name")
        self.arguments = [argument.arg for argument in self.tree.args.args]
        names = {n.id for n in ast.walk(self.tree) if isinstance(n, ast.Name) and _is_bound(n)}
        self.local = names | set(self.arguments)

    def text(self, name):
        """Return the whole function; its own names begin with $, ours and JavaScript's don't."""
        own = [f"${one}" for one in sorted(self.local - set(self.arguments))]
        head = f"function {name}({', '.join(f'${one}' for one in self.arguments)}) {{"
        lines = [head, f"let {', '.join([*own, 'found'])};", *self.block(self.tree.body), "}"]
        return "\n".join(lines)

    def block(self, statements):
        return [line for one in statements for line in self.statement(one)]

    def statement(self, node):
        """Return the lines of a statement."""
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                return []
            case ast.Expr(value=ast.Call() as call):
                return [f"{self.value(call)};"]
            case ast.Return(value=value):
                return [f"return {self.value(value)};"]
            case ast.Break():
                return ["break;"]
            case ast.Continue():
                return ["continue;"]
            case ast.Assign(targets=[target], value=value):
                return self.bound(target, self.value(value))
            case ast.AugAssign(target=target, op=op, value=value):
                return [f"{self.value(target)} = {self.joined(target, op, value)};"]
            case ast.If(test=test, body=body, orelse=other):
                rest = ["} else {", *self.block(other)] if other else []
                return [f"if ({self.value(test)}) {{", *self.block(body), *rest, "}"]
            case ast.While(test=test, body=body, orelse=[]):
                return [f"while ({self.value(test)}) {{", *self.block(body), "}"]
            case ast.For(
                target=ast.Name(id=name),
                iter=ast.Call(func=ast.Name(id="range"), args=[end]),
                body=body,
                orelse=[],
            ):
                # Python's name keeps its last number; a counter of its own goes on from it.
                count = f"for (let at = 0, end = {self.value(end)}; at < end; at++) {{"
                return [count, f"${name} = at;", *self.block(body), "}"]
        raise Untranslated(ast.unparse(node))

    def bound(self, target, value):
        """Return the lines that bind a name, a place or several of them to a value."""
        if not isinstance(target, ast.Tuple | ast.List):
            return [f"{self.value(target)} = {value};"]
        lines = [f"found = {value};"]
        for place, one in enumerate(target.elts):
            if isinstance(one, ast.Tuple | ast.List | ast.Starred):
                raise Untranslated(ast.unparse(target))
            lines.append(f"{self.value(one)} = found[{place}];")
        return lines

    def joined(self, left, op, right):
        """Return what an operator makes of two values."""
        one, other = self.value(left), self.value(right)
        if type(op) in INFIX:
            return f"({one} {INFIX[type(op)]} {other})"
        if type(op) in CALLED:
            return f"{CALLED[type(op)]}({one}, {other})"
        raise Untranslated(type(op).__name__)

    def value(self, node):
        """Return an expression."""
        match node:
            case ast.Constant(value=int() | float() as value):
                return json.dumps(value)
            case ast.Name(id=name):
                return self.name(name)
            case ast.Attribute(value=ast.Name(id="math"), attr=name) if name in MATH:
                return MATH[name]
            case ast.Attribute(value=value, attr=name):
                return f"{self.value(value)}.{name}"
            case ast.Subscript(value=value, slice=ast.Name() | ast.Constant() | ast.BinOp() as at):
                return f"{self.value(value)}[{self.value(at)}]"
            case ast.Tuple(elts=parts):
                return f"[{', '.join(map(self.value, parts))}]"
            case ast.Starred(value=value):
                return f"...{self.value(value)}"
            case ast.UnaryOp(op=ast.USub(), operand=value):
                return f"(-{self.value(value)})"
            case ast.UnaryOp(op=ast.Not(), operand=value):
                return f"!{self.value(value)}"
            case ast.BinOp(left=left, op=op, right=right):
                return self.joined(left, op, right)
            case ast.BoolOp(op=op, values=values):
                sign = " && " if isinstance(op, ast.And) else " || "
                return f"({sign.join(map(self.value, values))})"
            case ast.IfExp(test=test, body=yes, orelse=no):
                return f"({self.value(test)} ? {self.value(yes)} : {self.value(no)})"
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self.compared(left, ops, others)
            case ast.Call(func=ast.Name(id="max" | "min"), args=args) if len(args) != 2:
                raise Untranslated(ast.unparse(node))
            case ast.Call(func=function, args=args, keywords=[]):
                return f"{self.value(function)}({', '.join(map(self.value, args))})"
        raise Untranslated(ast.unparse(node))

    def compared(self, left, ops, others):
        """Return a comparison, or a chain of them, of which each value is named twice."""
        every = [left, *others]
        if any(isinstance(inner, ast.Call) for one in others[:-1] for inner in ast.walk(one)):
            raise Untranslated("a chain of comparisons with a call within")
        found = []
        for one, op, other in zip(every[:-1], ops, others, strict=True):
            if type(op) not in COMPARED:
                raise Untranslated(type(op).__name__)
            found.append(f"{self.value(one)} {COMPARED[type(op)]} {self.value(other)}")
        return f"({' && '.join(found)})"

    def name(self, name):
        """Return what a name stands for: of this function, its module, or of Python."""
        if name in self.local:
            return f"${name}"
        known = self.parts.get(name, self.globals.get(name))
        scalar = compiled.SCALARS.get(name)
        if scalar and known is getattr(compiled, name):
            known = scalar
        match known:
            case FunctionType() if known in KNOWN:
                return KNOWN[known]
            case FunctionType():
                return _named(known, self.parts, self.made)
            case int() | float() | tuple():
                return json.dumps(known)
            case None if name in PLAIN:
                return PLAIN[name]
            case ModuleType():
                raise Untranslated(f"the module {name}")
        raise Untranslated(name)


def _is_bound(node):
    return isinstance(node.ctx, ast.Store)
