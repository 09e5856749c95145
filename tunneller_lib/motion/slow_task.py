"""The slow task for other controllers: waypoints of a corrected chord, in Structured Text and C99.

It needs the two ends of a chord alone, for a controller that gets its knots as it goes. That of a
job (`tunneller_lib.job`) gets a table of where on each chord its setpoints are.

Both programs come from one description, a list of statements: (variable, expression) assigns,
("IF", condition, then, otherwise) branches, ("FOR", first, last, body) counts i upwards and
("DOWN", first, last, body) downwards. Expressions are those that both languages, and Python, share.
"""

import ast
from typing import NamedTuple

from ..arguments import Whole, checked
from .export import C99Name, IecName

LEAST, MOST = 3, 1_000  # waypoints of a segment
GIVEN = ("ring", "tube", "thetaP", "phiP", "thetaQ", "phiQ")
FOUND = ("theta", "phi")
FUNCTIONS = ("sqrt", "sin", "cos", "atan2")

# Structured Text doesn't tell r from R. Points of the torus are tube n + ring e: n the outward
# normal, u at P and v at Q, and e horizontal, away from the axis.
ENDS = [
    ("ex", "cos(thetaP)"), ("ez", "-sin(thetaP)"), ("fx", "cos(thetaQ)"), ("fz", "-sin(thetaQ)"),
    ("ux", "cos(phiP) * ex"), ("uy", "sin(phiP)"), ("uz", "cos(phiP) * ez"),
    ("vx", "cos(phiQ) * fx"), ("vy", "sin(phiQ)"), ("vz", "cos(phiQ) * fz"),
    ("xP", "tube * ux + ring * ex"), ("yP", "tube * uy"), ("zP", "tube * uz + ring * ez"),
    ("dx", "tube * vx + ring * fx - xP"), ("dy", "tube * vy - yP"),
    ("dz", "tube * vz + ring * fz - zP"),
]  # fmt: skip
# The great circle of the normals: its pole and its angle.
CIRCLE = [
    ("px", "uy * vz - uz * vy"), ("py", "uz * vx - ux * vz"), ("pz", "ux * vy - uy * vx"),
    ("sine", "sqrt(px * px + py * py + pz * pz)"),
    ("angle", "atan2(sine, ux * vx + uy * vy + uz * vz)"),
]  # fmt: skip
PLAIN = [
    ("along[0]", "0.0"), ("moved[0]", "0.0"),
    ("FOR", "1", "{last}", [("along[i]", "along[i - 1] + 1.0 / {last}.0"), ("moved[i]", "0.0")]),
]  # fmt: skip
# The normal in the middle has the height `middle`, its direction towards Q has `rise`.
PREPARED = [
    ("px", "px / sine"), ("py", "py / sine"), ("pz", "pz / sine"), ("up", "pz * ux - px * uz"),
    ("cosHalf", "cos(angle / 2.0)"), ("sinHalf", "sin(angle / 2.0)"),
    ("middle", "uy * cosHalf + up * sinHalf"), ("rise", "up * cosHalf - uy * sinHalf"),
    ("part", "angle / {last}.0"), ("cosPart", "cos(part)"), ("sinPart", "sin(part)"),
    ("scale", "0.5 / sinHalf"), ("cosine", "cosHalf"), ("sine", "-sinHalf"),
]  # fmt: skip
# psi, the factor of the shift and the chord's share, at equal angles from the middle.
PUSHED = [
    ("FOR", "0", "{last}", [
        ("height", "middle * cosine + rise * sine"),
        ("psi[i]", "-py * height / sqrt(1.0 - height * height)"),
        ("lift[i]", "cosHalf / cosine"),
        ("along[i]", "0.5 + sine * lift[i] * scale"),
        ("turned", "cosine * cosPart - sine * sinPart"),
        ("sine", "sine * cosPart + cosine * sinPart"),
        ("cosine", "turned"),
    ]),
]  # fmt: skip
# w'' + w = psi, w = 0 at both ends, vy Numerov: a tridiagonal system of constant coefficients.
SWUNG = [
    ("square", "part * part"),
    ("diagonal", "(24.0 - 10.0 * square) / (12.0 + square)"),
    ("weight", "square / (12.0 + square)"),
    ("pivot[0]", "0.0"), ("swing[0]", "0.0"), ("swing[{last}]", "0.0"),
    ("FOR", "1", "{last} - 1", [
        ("pivot[i]", "1.0 / (diagonal - pivot[i - 1])"),
        ("pull", "weight * (psi[i - 1] + 10.0 * psi[i] + psi[i + 1])"),
        ("swing[i]", "(swing[i - 1] - pull) * pivot[i]"),
    ]),
    ("DOWN", "{last} - 1", "1", [("swing[i]", "swing[i] + pivot[i] * swing[i + 1]")]),
    ("px", "ring * px"), ("py", "ring * py"), ("pz", "ring * pz"),
    ("FOR", "0", "{last}", [("moved[i]", "psi[i] * (lift[i] - 1.0) - swing[i] * lift[i]")]),
]  # fmt: skip
PROJECTED = [
    ("FOR", "0", "{last}", [
        ("x", "xP + along[i] * dx - moved[i] * px"),
        ("y", "yP + along[i] * dy - moved[i] * py"),
        ("z", "zP + along[i] * dz - moved[i] * pz"),
        ("theta[i]", "atan2(-z, x)"),
        ("phi[i]", "atan2(y, sqrt(x * x + z * z) - ring)"),
    ]),
]  # fmt: skip
PROGRAM = [
    *ENDS,
    *CIRCLE,
    ("IF", "angle > 0.00001", [*PREPARED, *PUSHED, *SWUNG], PLAIN),
    *PROJECTED,
]


class Operations(NamedTuple):
    """How many operations a program takes.

    Parameters
    ----------
    simple, divisions, functions : int
        Sums and products; quotients; roots, sines and the like.
    """

    simple: int
    divisions: int
    functions: int


@checked
def waypoints_st(points: Whole(LEAST, MOST), *, name: IecName = "FB_Waypoints"):
    """Return the slow task's waypoints as a function block in Structured Text (IEC 61131-3).

    Parameters
    ----------
    points : int
        Waypoints of a segment, both ends included.
    name : str
        Name of the function block, as for `export.structured_text`.

    Returns
    -------
    text : str
        A call with the sizes of the torus, r as ring and R as tube, and the ends' joint positions,
        in m and rad, fills theta and phi, in rad. It needs LREAL, and ATAN2 of the standard's
        third edition.

    Notes
    -----
    The corrected chord of `tunneller_lib.paths`, without iteration; the swing of the geodesic
    comes from Numerov's method on the waypoints themselves. From 5 waypoints on the angles agree
    with the library's to a tenth of a count of 2^16 a turn, on the reference machine's torus
    within its joint limits; the difference falls with the fourth power of their number.
    """
    _check_name(name)
    last = points - 1
    reals = [v for v in _variables() if "[" not in v]
    arrays = [v.removesuffix("[]") for v in _variables() if "[" in v]
    bounds = f"ARRAY[0..{last}] OF LREAL"
    return "\n".join([
        f"FUNCTION_BLOCK {name}",
        "VAR_INPUT", f"    {', '.join(GIVEN)} : LREAL;", "END_VAR",
        "VAR_OUTPUT", f"    {', '.join(FOUND)} : {bounds};", "END_VAR",
        "VAR", "    i : DINT;", f"    {', '.join(arrays)} : {bounds};",
        *(f"    {', '.join(reals[k : k + 10])} : LREAL;" for k in range(0, len(reals), 10)),
        "END_VAR",
        *_st(PROGRAM, 0, last), "END_FUNCTION_BLOCK", "",
    ])  # fmt: skip


@checked
def waypoints_c99(points: Whole(LEAST, MOST), *, name: C99Name = "waypoints"):
    """Return the slow task's waypoints in C99.

    Parameters
    ----------
    points : int
        Waypoints of a segment, both ends included.
    name : str
        Name of the function, as for `export.c99`.

    Returns
    -------
    text : str
        A function of the same arguments as the block of `waypoints_st`, the arrays at the end.
    """
    _check_name(name)
    last = points - 1
    reals = [v for v in _variables() if "[" not in v]
    arrays = [v.replace("[]", f"[{points}]") for v in _variables() if "[" in v]
    given = ", ".join(f"double {v}" for v in GIVEN)
    found = ", ".join(f"double {v}[{points}]" for v in FOUND)
    return "\n".join([
        "#include <math.h>", "",
        f"void {name}({given},", f"    {found})", "{",
        f"    double {', '.join(arrays)};",
        *(f"    double {', '.join(reals[k : k + 10])};" for k in range(0, len(reals), 10)),
        *_c(PROGRAM, 1, last), "}", "",
    ])  # fmt: skip


@checked
def waypoint_operations(points: Whole(LEAST, MOST)):
    """Return the `Operations` of the slow task for a segment of so many points, correction and all.

    Counted from the same description as the programs; indices and loops aren't counted.
    """
    return Operations(*_counted(PROGRAM, points - 1))


def _check_name(name):
    """Raise ValueError where the program itself uses a name, in either case."""
    own = {v.removesuffix("[]").upper() for v in (*GIVEN, *FOUND, *_variables(), "i")}
    if name.upper() in own:
        raise ValueError(f"name: must be free in the program; got {name}, which is taken.")


def _counted(statements, last):
    total = [0, 0, 0]
    for first, *rest in statements:
        if first in ("FOR", "DOWN"):
            start, stop, body = rest
            times = 1 + abs(_index(stop, last) - _index(start, last))
            parts = [times * number for number in _counted(body, last)]
        elif first == "IF":
            parts = _counted(rest[1], last)
        else:
            parts = _of_expression(rest[0].format(last=last))
        total = [a + b for a, b in zip(total, parts, strict=True)]
    return total


def _index(text, last):
    start, _, less = text.format(last=last).partition(" - ")
    return int(start) - int(less or 0)


def _of_expression(text):
    tree = ast.parse(text, mode="eval")
    indices = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript)
        for inner in ast.walk(node.slice)
    }
    nodes = [node for node in ast.walk(tree) if id(node) not in indices]
    divisions = sum(isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div) for node in nodes)
    functions = sum(isinstance(node, ast.Call) for node in nodes)
    operators = sum(isinstance(node, (ast.BinOp, ast.UnaryOp)) for node in nodes)
    return operators - divisions, divisions, functions


def _variables():
    """Return the program's own variables, arrays with [], in order of their first use."""
    names = {}

    def look(statements):
        for first, *rest in statements:
            if first in ("IF", "FOR", "DOWN"):
                for part in rest:
                    look(part if isinstance(part, list) else [])
            else:
                name, bracket, _ = first.partition("[")
                if name not in FOUND:
                    names[name + ("[]" if bracket else "")] = None

    look(PROGRAM)
    return list(names)


def _st(statements, depth, last):
    """Return statements as indented lines of Structured Text."""
    pad = "    " * depth
    for first, *rest in statements:
        if first in ("FOR", "DOWN"):
            start, stop, body = rest
            by = " BY -1" if first == "DOWN" else ""
            yield f"{pad}FOR i := {start} TO {stop}{by} DO".format(last=last)
            yield from _st(body, depth + 1, last)
            yield f"{pad}END_FOR;"
        elif first == "IF":
            condition, then, otherwise = rest
            yield f"{pad}IF {condition} THEN"
            yield from _st(then, depth + 1, last)
            yield f"{pad}ELSE"
            yield from _st(otherwise, depth + 1, last)
            yield f"{pad}END_IF;"
        else:
            yield f"{pad}{first} := {_capitals(rest[0])};".format(last=last)


def _capitals(text):
    for function in FUNCTIONS:
        text = text.replace(f"{function}(", f"{function.upper()}(")
    return text


def _c(statements, depth, last):
    """Return statements as indented lines of C."""
    pad = "    " * depth
    for first, *rest in statements:
        if first in ("FOR", "DOWN"):
            start, stop, body = rest
            sign, step = ("<=", "++i") if first == "FOR" else (">=", "--i")
            head = f"for (int i = {start}; i {sign} {stop}; {step})".format(last=last)
            yield f"{pad}{head} {{"
            yield from _c(body, depth + 1, last)
            yield f"{pad}}}"
        elif first == "IF":
            condition, then, otherwise = rest
            yield f"{pad}if ({condition}) {{"
            yield from _c(then, depth + 1, last)
            yield f"{pad}}} else {{"
            yield from _c(otherwise, depth + 1, last)
            yield f"{pad}}}"
        else:
            yield f"{pad}{first} = {rest[0]};".format(last=last)
