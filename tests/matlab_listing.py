"""The MATLAB listing of section 4.3, run as printed, with repairs to switch on."""

import math
import re
import tomllib
from types import SimpleNamespace

from report.sources import ROOT

READS = ["report/listings.toml"]

LISTING = tomllib.loads((ROOT / "report" / "listings.toml").read_text(encoding="utf-8"))["matlab"]
PRINTED = LISTING["printed"]
REPAIRS = LISTING["repairs"]  # what each finds, and what it puts in its place


class Array(list):
    """A column that counts from 1 and grows where it is written beyond its end."""

    def __call__(self, index):
        return self[int(index) - 1]

    def put(self, index, value):
        self.extend([0] * (int(index) - len(self)))
        self[int(index) - 1] = value

    def head(self, count):
        return self[: int(count)]


def run(*, repaired=("continuation",), number=float, division=math.floor, **given):
    """Return the listing's variables, and its calls of graphics as `drawn`.

    Parameters
    ----------
    repaired : iterable of str
        Names of `REPAIRS`.
    number : type
        Arithmetic of its numbers: float as in MATLAB, or Fraction.
    division : function
        What stands for its ``floor``.
    given : numbers
        What takes the place of the listing's own t1, t2, y1, y2 and T.

    Raises
    ------
    SyntaxError
        Where a line breaks off inside brackets without three dots.
    """
    text = PRINTED
    for name in repaired:
        text = text.replace(*REPAIRS[name])
    drawn = []

    def graphics(name):
        return lambda *arguments: drawn.append((name, *arguments))

    def colon(first, step, last):
        return [first + i * step for i in range(math.floor((last - first) / step) + 1)]

    memory = {n: graphics(n) for n in "plot rectangle xlabel ylabel axis hold grid".split()}
    memory |= {"number": number, "floor": lambda x: number(division(x)), "colon": colon}
    memory |= {"zeros": lambda rows, _: Array([0] * int(rows)), "y_ref": Array(), "drawn": drawn}
    for name, value in given.items():
        text = re.sub(rf"\b{name} = [^;]*;", f"{name} = {value};", text)
    exec(in_python(text), memory)
    return SimpleNamespace(**memory)


def in_python(text):
    """Return the listing as Python, as far as it needs."""
    depth, lines = 0, []
    for line in text.replace("...\n", "").splitlines():
        code = line.partition("%")[0].strip()
        if code.count("(") != code.count(")"):
            raise SyntaxError(f"a line ends inside brackets: {code}")
        if loop := re.fullmatch(r"for (\w+)=(\w+): (\w+): (\w+),", code):
            lines.append("    " * depth + "for {} in colon({}, {}, {}):".format(*loop.groups()))
            depth += 1
        elif code.startswith("if "):
            lines.append("    " * depth + expression(code) + ":")
            depth += 1
        elif code == "end":
            depth -= 1
        else:
            for statement in filter(None, map(str.strip, code.split(";"))):
                lines.append("    " * depth + in_words(statement))
    return "\n".join(lines)


def in_words(statement):
    if switch := re.fullmatch(r"(\w+) (on|off)", statement):
        return "{}({!r})".format(*switch.groups())
    if entry := re.fullmatch(r"(\w+)\((\w+)\) = (.*)", statement):
        return f"{entry[1]}.put({entry[2]}, {expression(entry[3])})"
    return expression(statement)


def expression(text):
    """Return an expression: rows of a matrix with commas, heads of arrays, numbers of the type."""
    parts = re.split(r"('[^']*')", text)
    for i in range(0, len(parts), 2):
        part = re.sub(r"\[(.*?)\]", lambda row: f"[{', '.join(row[1].split())}]", parts[i])
        part = re.sub(r"(\w+)\(1:(.*?)\)", r"\1.head(\2)", part)
        parts[i] = re.sub(r"(?<![\w.])(\d+(?:[./]\d+)?)(?!\w)", r"number('\1')", part)
    return "".join(parts)
