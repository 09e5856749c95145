"""Typst math in spoken English, for those who hear the report; `typst_math` reads it.

`python -m report.tests.typst_words` writes the words of report/equations.toml anew.
"""

import re
import tomllib
from pathlib import Path

from report.tests.typst_math import parse

FILE = Path(__file__).parents[2] / "report" / "equations.toml"
SPOKEN = {
    "=": "equals", "<": "is less than", ">": "is greater than", "<=": "is at most",
    ">=": "is at least", "equiv": "is congruent to", "+": "plus", "-": "minus",
    "sin": "the sine", "cos": "the cosine", "tan": "the tangent", "arcsin": "the arcsine",
    "arccos": "the arccosine", "arctan": "the arctangent", "atan2": "the two-argument arctangent",
    "sqrt": "the square root", "floor": "the floor", "phi.alt": "phi",
}  # fmt: skip
ENDINGS = {"sqrt": "end root", "floor": "end floor"}
POWERS = {"2": "squared", "3": "cubed"}
FUNCTIONS = ("G", "rho")  # letters that may stand before an argument
SHORT = {"number", "symbol", "bold", "tilde", "pi", "imaginary", "group", "vector"}


def spoken(source, functions=()):
    """Return a display in words.

    Examples
    --------
    >>> spoken("V = pi R^2 - (x + 1)^3 / 2")
    'V equals pi R squared minus the fraction open paren x plus 1 close paren cubed over 2 end'
    """
    display = parse(source, functions)
    letters = set(re.findall(r"[A-Za-z]+", source))
    say = _Speaker({letter for letter in letters if letter.lower() in letters}).say
    parts = [_statement(statement, say) for statement in display.statements]
    joints = [f" {word} " for word in display.words] or ["; "] * (len(parts) - 1)
    return "".join(part + joint for part, joint in zip(parts, [*joints, ""], strict=True))


def _statement(statement, say):
    words = say(statement.sides[0])
    for relation, side in zip(statement.relations, statement.sides[1:], strict=True):
        words += f" {SPOKEN[relation]} {say(side)}"
    return words + (f" modulo {say(statement.modulus)}" if statement.modulus else "")


class _Speaker:
    """Says a node; `both` are the letters that occur small and great."""

    def __init__(self, both):
        self.both = both

    def letter(self, text):
        great = text in self.both and text != text.lower()
        text = SPOKEN.get(text, text)
        return f"capital {text.lower()}" if great else text

    def closed(self, node, ending):
        """Return a node's words, with a word where it ends if that can't be heard."""
        return self.say(node) + ("" if node.kind in SHORT else f" {ending}")

    def say(self, node):
        match node.kind, node.parts:
            case "number", (text,):
                return text
            case "pi", _:
                return "pi"
            case "imaginary", _:
                return "i"
            case "symbol", (name, index):
                name, prime, _ = name.partition("'")
                below = " sub " + " ".join(map(self.letter, index)) if index else ""
                return self.letter(name) + below + (" prime" if prime else "")
            case "bold", (inner,):
                return f"vector {self.say(inner)}"
            case "tilde", (inner,):
                return f"{self.say(inner)} tilde"
            case "gradient", (inner,):
                return f"the gradient of {self.say(inner)}"
            case "group", (inner,):
                return f"open paren {self.say(inner)} close paren"
            case "vector", items:
                return f"the vector with parts {', and '.join(map(self.say, items))} end vector"
            case "sum", ((sign, first), *rest):
                begin = "minus " if sign == "-" else ""
                more = [f" {SPOKEN[sign]} {self.say(term)}" for sign, term in rest]
                return begin + self.say(first) + "".join(more)
            case "product", (("", first), *rest):
                more = [f" {self.joint(joint, factor)}{self.say(factor)}" for joint, factor in rest]
                return self.say(first) + "".join(more)
            case "over", (above, below):
                said = f"{self.say(above)} over {self.say(below)}"
                plain = {above.kind, below.kind} <= {"number", "symbol"}
                return said if plain else f"the fraction {said} end"
            case "power", (base, exponent):
                power = exponent.parts[0] if exponent.kind == "number" else None
                said = POWERS.get(power) or f"to the power {self.closed(exponent, 'end')}"
                if base.kind == "call":
                    name, *arguments = base.parts
                    return f"{SPOKEN[name]} {said} of {self.arguments(arguments)}"
                return f"{self.say(base)} {said}"
            case "abs", (inner,):
                return f"the absolute value of {self.say(inner)} end"
            case "call", (name, *arguments):
                if name in ENDINGS:
                    return f"{SPOKEN[name]} of {self.closed(arguments[0], ENDINGS[name])}"
                return f"{SPOKEN.get(name, name)} of {self.arguments(arguments)}"
            case "integral", (low, high, body, over):
                ends = f"from {self.say(low)} to {self.say(high)}"
                return f"the integral {ends} of {self.say(body)} d {self.say(over)}"
            case "sum over", (names, total, body):
                where = f"{' plus '.join(names)} equals {self.say(total)}"
                return f"the sum over {where} of {self.say(body)}"

    def arguments(self, nodes):
        """Return what a function is of, in parentheses unless it's short."""
        said = " and ".join(map(self.say, nodes))
        short = len(nodes) == 1 and nodes[0].kind in SHORT | {"over"}
        return said if short else f"open paren {said} close paren"

    @staticmethod
    def joint(joint, factor):
        if not joint:
            return "times " if factor.kind in ("number", "over") else ""
        return "dot " if factor.kind in ("bold", "group") else "times "


def functions_in(source):
    """Return the letters that stand for functions in a display."""
    return tuple(name for name in FUNCTIONS if f"{name}(" in source)


def renewed(text):
    """Return equations.toml's text with the words of its forms written anew."""
    text = re.sub(r'(?m)^(\w+-)?words = ".*"\n', "", text)
    entries = tomllib.loads(text)
    parts = re.split(r"(?m)^(?=\[)", text)
    return parts[0] + "".join(_with_words(part, entries) for part in parts[1:])


def _with_words(part, entries):
    entry = entries[part[1 : part.index("]")]]
    forms = [form for form in ("right", "printed", "reads") if form in entry]
    lines = []
    for form in forms:
        said = spoken(entry[form], functions_in(entry[form]))
        lines.append(f'{"" if form == "right" else form + "-"}words = "{said}"\n')
    body = part.rstrip("\n")
    # What follows the entry, the comment before the next, stays behind the words.
    kept = re.search(r"\n\n(#[^\n]*\n*)*$", part)
    body, rest = (part[: kept.start()], part[kept.start() + 1 :]) if kept else (body, "")
    return body.rstrip("\n") + "\n" + "".join(lines) + rest


if __name__ == "__main__":
    FILE.write_text(renewed(FILE.read_text("utf-8")), "utf-8")
