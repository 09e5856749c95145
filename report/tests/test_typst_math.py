"""The reader of Typst math: what it reads and what it refuses."""

import pytest

from report.tests.typeset_marks import changed, marked, visible
from report.tests.typst_math import Token, UnknownMath, parse, tokens
from report.tests.typst_values import to_sympy

VECTORS = {"bold v": 2, "bold q": 2}


def value(source, **options):
    """Return the one side of a source by sympy, as text."""
    [statement] = parse(source, options.pop("functions", ())).statements
    [side] = statement.sides
    return str(to_sympy(side, VECTORS))


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("a - b - c", "a - b - c"),
        ("a / b c", "a*c/b"),
        ("a b\\/c d", None),
        ("pi s\\/N", "pi*s/N"),
        ("(a + b) / (c d)", "(a + b)/(c*d)"),
        ("x^2 y^(3 \\/ 2)", "x**2*y**(3/2)"),
        ("m_(0 1)^2", "m_01**2"),
        ("f_(x x y) R_12", "R_12*f_xxy"),
        ("sqrt(x) floor(y)", "sqrt(x)*floor(y)"),
        ("abs(x) |y|", "Abs(x)*Abs(y)"),
        ("|a (|b| - 1)|", "Abs(a*(Abs(b) - 1))"),
        ("cos phi sin phi", "sin(phi)*cos(phi)"),
        ("cos a b", "b*cos(a)"),
        ("arcsin y / R", "asin(y/R)"),
        ("arccos (R - g) / R", "acos((R - g)/R)"),
        ("tan^2 alpha dot x", "x*tan(alpha)**2"),
        ('"atan2"(y, x)', "atan2(y, x)"),
        ('"LN" + p\'', "LN + p'"),
        ("bold(v) dot bold(q)", "bold q.0*bold v.0 + bold q.1*bold v.1"),
        ("|bold(v)|", "sqrt(bold v.0**2 + bold v.1**2)"),
        ("2 vec(x, y)", "Matrix([[2*x], [2*y]])"),
        ("sum_(i+j=1) k_(i j) x^i", "k_01 + k_10*x"),
        ("integral_0^sqrt(a) y dif y", "Integral(y, (y, 0, sqrt(a)))"),
    ],
)
def test_what_is_read(source, expected):
    if expected is None:
        with pytest.raises(UnknownMath, match="below the slash"):
            value(source)
    else:
        assert value(source) == expected


def test_statements_and_words():
    display = parse('a &= b <= 2, quad \\ c &= 1 quad "or" quad s r equiv k space (mod N) .')
    assert [statement.relations for statement in display.statements] == [
        ("=", "<="), ("=",), ("equiv",)]  # fmt: skip
    assert display.words == ("or",)
    assert str(to_sympy(display.statements[2].modulus)) == "N"


def test_marks_change_nothing():
    assert value("f_mended(x y) + t^mended(2) mended(-) mended(4) a") == value(
        "f_(x y) + t^2 - 4 a"
    )
    assert value('mended("(") a + b mended(")") c') == value("(a + b) c")
    assert [token for token in tokens("a mended(-) b") if token.marked] == [
        Token("sign", "-", False, True)]  # fmt: skip


def test_what_is_seen_and_what_differs():
    assert visible("(a + b) / (c d)") == [(t, False) for t in ("a", "+", "b", "/", "c", "d")]
    assert visible("sin(a) / (c)^2")[1] == ("(", False)
    right, printed = "a f_mended(x y) + t^mended(2)", "a f_x + t"
    assert marked(right) == changed(right, printed) == {1: "f_xy", 4: "^2"}
    assert changed("a + b", "a - b") == {1: "+"}
    assert changed("a + b", "a + b + c") == {}  # what is too much can't be marked
