"""Read this study's displayed equations, Typst math, as trees of their parts.

Only what report/equations.toml uses is known; anything else is refused with a sentence. Blanks are
read as Typst sets them: `a/b c` is (a/b) c, `arcsin y / R` is the arcsine of a fraction, `sin(x)/2`
half of a sine. Of `a b \\/ c`, a slash on the line, all before the slash is above it.

A display is a list of statements, parted by commas, `quad` or words, as `"or"`. A statement is a
chain of sides, `a = b <= c`. `mended(..)`, the red marks, changes nothing; within it a quoted
parenthesis is a parenthesis.
"""

import re
from typing import NamedTuple

LETTERS = {
    *"alpha beta chi delta epsilon theta kappa lambda mu nu rho sigma tau phi phi.alt psi".split(),
    *"omega zeta".split(),
    *"Theta Phi".split(),
}
PLAIN = set("sin cos tan arcsin arccos arctan".split())  # may stand without parentheses
COUNTS = {"sqrt": 1, "floor": 1, "atan2": 2}  # of arguments, in parentheses
RELATIONS = {"=", "<", ">", "<=", ">=", "equiv"}
NO_MEANING = {"&", "\\", "thin", "thick", "space"}  # only where things stand
CLOSING = {"(": ")", "[": "]"}
OPENING = {*CLOSING, "|"}
TOKEN = re.compile(
    r'(?P<blank>\s+)|(?P<text>"[^"]*")|(?P<number>\d+(?:\.\d+)?)|(?P<word>[A-Za-z]+(?:\.[a-z]+)*)'
    r"|(?P<sign>\\/|\\(?=\s)|<=|>=|[-+=<>/^_()\[\]|,.&'])"
)


class UnknownMath(ValueError):
    """A source that this reader doesn't know; the message says what and where."""


class Token(NamedTuple):
    """One sign of a source: its kind, whether a blank stands before it, whether it's marked."""

    kind: str
    text: str
    spaced: bool = True
    marked: bool = False


class Node(NamedTuple):
    """A part of an expression: what it is and what it is made of."""

    kind: str
    parts: tuple


class Statement(NamedTuple):
    """A chain of sides with the relations between them, and what it is taken modulo of."""

    sides: tuple
    relations: tuple = ()
    modulus: Node | None = None


class Display(NamedTuple):
    """Statements in order, and the words that stand between them."""

    statements: tuple
    words: tuple


def tokens(source):
    """Return the signs of a source, `mended` taken off and noted."""
    found, at, spaced = [], 0, True
    while at < len(source):
        match = TOKEN.match(source, at)
        if not match:
            raise UnknownMath(f"Unknown sign {source[at]!r} in: {source[at : at + 30]}")
        if match.lastgroup == "blank":
            spaced = True
        else:
            found.append(Token(match.lastgroup, match[0], spaced))
            spaced = False
        at = match.end()
    return _unmarked(found)


def _unmarked(found):
    result = []
    while found:
        token, *found = found
        if token.text != "mended":
            result.append(token)
            continue
        end = closing(found, 0)
        inner = [
            Token("sign" if t.kind == "text" else t.kind, t.text.strip('"'), t.spaced, True)
            for t in found[1:end]
        ]
        if result and result[-1].text in ("_", "^"):  # f_mended(x y) is f_(x y)
            inner = [Token("sign", "(", False), *inner, Token("sign", ")", False)]
        result += inner
        found = found[end + 1 :]
    return result


def closing(found, at):
    """Return where the parenthesis closes that opens at a place."""
    depth = 0
    for place in range(at, len(found)):
        depth += (found[place].text == "(") - (found[place].text == ")")
        if depth == 0:
            return place
    raise UnknownMath("A parenthesis isn't closed.")


def parse(source, functions=()):
    """Return the `Display` of a source.

    Parameters
    ----------
    source : str or list of Token
        Typst math, without dollar signs.
    functions : tuple of str
        Letters that stand for functions, as the G in `G(s)`.

    Raises
    ------
    UnknownMath
        If something in it isn't known, or can be read in two ways.

    Examples
    --------
    >>> parse("A = pi R^2").statements[0].sides[0]
    Node(kind='symbol', parts=('A', ()))
    """
    given = tokens(source) if isinstance(source, str) else list(source)
    return _Parser(given, functions).display()


class _Parser:
    """Recursive descent, a method a level of binding; `next` is the token to be read."""

    def __init__(self, given, functions):
        while given and given[-1].text in (",", "."):
            given = given[:-1]  # the sentence's
        self.rest = [t for t in given if t.kind == "text" or t.text not in NO_MEANING]
        self.functions = functions
        self.in_bars = False

    @property
    def next(self):
        return self.rest[0] if self.rest else Token("end", "")

    def take(self, *texts):
        token = self.next
        if texts and token.text not in texts:
            near = " ".join(t.text for t in self.rest[:6]) or "the end"
            raise UnknownMath(f"Expected {' or '.join(texts)}, found: {near}")
        self.rest = self.rest[1:]
        return token

    def display(self):
        statements, words = [self.statement()], []
        while self.next.kind != "end":
            self.take(",", "quad")
            if self.next.kind == "text" and self.rest[1:2] and self.rest[1].text == "quad":
                words.append(self.take().text.strip('"'))
            elif self.next.text != "quad":
                statements.append(self.statement())
        return Display(tuple(statements), tuple(words))

    def statement(self):
        sides, relations, modulus = [self.sum()], [], None
        while self.next.text in RELATIONS:
            relations.append(self.take().text)
            sides.append(self.sum(until="mod" if relations[-1] == "equiv" else None))
        if "equiv" in relations:
            self.take("(")
            self.take("mod")
            modulus = self.sum()
            self.take(")")
        return Statement(tuple(sides), tuple(relations), modulus)

    def sum(self, until=None):
        terms, sign = [], "+"
        if self.next.text in ("+", "-"):
            sign = self.take().text
        while True:
            terms.append((sign, self.term(until)))
            if self.next.text not in ("+", "-"):
                return terms[0][1] if terms == [("+", terms[0][1])] else Node("sum", tuple(terms))
            sign = self.take().text

    def term(self, until=None):
        above = self.product(until)
        if self.next.text != "\\/":
            return above
        self.take()
        below = self.attached()
        if self.begins_factor():
            raise UnknownMath(f"What is below the slash, before {self.next.text}? Write (..).")
        return Node("over", (above, below))

    def begins_factor(self, until=None):
        token = self.next
        if until and len(self.rest) > 1 and self.rest[1].text == until:
            return False
        if token.kind == "word":
            return token.text not in RELATIONS | {"quad", "dot", "dif", "mod"}
        return token.kind in ("number", "text") or token.text in OPENING - {"|" * self.in_bars}

    def product(self, until=None):
        factors = [("", self.fraction())]
        while self.next.text == "dot" or self.begins_factor(until):
            joint = self.take().text if self.next.text == "dot" else ""
            factors.append((joint, self.fraction()))
        return factors[0][1] if len(factors) == 1 else Node("product", tuple(factors))

    def fraction(self):
        above = self.attached()
        while self.next.text == "/":
            self.take()
            above = Node("over", (_bare(above), _bare(self.attached())))
        return above

    def attached(self):
        base = self.atom()
        if self.next.text == "^":
            base = Node("power", (base, self.exponent()))
        if self.next.text in ("^", "_"):
            raise UnknownMath(f"Write the index before the power, and one of each: {base}")
        return base

    def exponent(self):
        self.take("^")
        if self.next.text == "(":
            return _bare(self.group())
        return self.number() if self.next.kind == "number" else self.atom()

    def number(self):
        return Node("number", (self.take().text,))

    def atom(self):
        token = self.next
        if token.kind == "number":
            return self.number()
        if token.text in CLOSING:
            return self.group()
        if token.text == "|":
            return self.between_bars()
        if token.kind not in ("word", "text"):
            self.take("a number", "a letter", "a parenthesis")
        return getattr(self, f"word_{token.text}", self.named)()

    def group(self):
        opening = self.take("(", "[").text
        outer, self.in_bars = self.in_bars, False
        items = [self.sum()]
        while self.next.text == ",":
            self.take()
            items.append(self.sum())
        self.take(CLOSING[opening])
        self.in_bars = outer
        return Node("group" if len(items) == 1 else "vector", tuple(items))

    def opens(self):
        """Tell whether a parenthesis opens right behind, without a blank."""
        return self.next.text == "(" and not self.next.spaced

    def arguments(self, count=None):
        """Return what stands in parentheses right behind a name."""
        if not self.opens():
            self.take("( right behind it")
        items = self.group().parts
        if count and len(items) != count:
            raise UnknownMath(f"Expected {count} arguments, found {len(items)}.")
        return items

    def between_bars(self):
        self.take("|")
        outer, self.in_bars = self.in_bars, True
        inner = self.sum()
        self.take("|")
        self.in_bars = outer
        return Node("abs", (inner,))

    def named(self):
        """Read a function or a letter with its index."""
        token = self.take()
        name = token.text.strip('"')
        if name in PLAIN:
            power = (self.exponent(),) if self.next.text == "^" else ()
            argument = self.arguments(1)[0] if self.opens() else _bare(self.fraction())
            applied = Node("call", (name, argument))
            return Node("power", (applied, *power)) if power else applied
        if name in COUNTS or name in self.functions:
            return Node("call", (name, *self.arguments(COUNTS.get(name, 1))))
        if token.kind == "word" and len(name) > 1 and name not in LETTERS:
            raise UnknownMath(f"Unknown word {name!r}.")
        index = self.index()
        if self.opens():  # Typst would take it along into a fraction
            raise UnknownMath(f"{name}(: a function or a product? Write a blank for a product.")
        if self.next.text == "'" and self.take():
            name += "'"
        return Node("symbol", (name, index))

    def index(self):
        if self.next.text != "_":
            return ()
        self.take()
        if self.next.text != "(":
            parts = [self.take()]
        else:
            end = closing(self.rest, 0)
            parts, self.rest = self.rest[1:end], self.rest[end + 1 :]
        if not parts or any(part.kind not in ("word", "number") for part in parts):
            raise UnknownMath("An index must be made of letters and numbers.")
        return tuple(part.text for part in parts)

    def word_abs(self):
        self.take()
        return Node("abs", self.arguments(1))

    def word_vec(self):
        self.take()
        return Node("vector", self.arguments())

    def word_pi(self):
        self.take()
        return Node("pi", ())

    def word_upright(self):
        self.take()
        if self.arguments(1) != (Node("symbol", ("i", ())),):
            raise UnknownMath("Upright is the imaginary unit only.")
        return Node("imaginary", ())

    def _accented(self, kind):
        self.take()
        [inner] = self.arguments(1)
        if inner.kind != "symbol":
            raise UnknownMath(f"{kind} must hold one letter.")
        return Node(kind, (inner,))

    def word_bold(self):
        return self._accented("bold")

    def word_tilde(self):
        return self._accented("tilde")

    def word_gradient(self):
        self.take()
        return Node("gradient", (self.named(),))

    def word_integral(self):
        self.take()
        self.take("_")
        low = self.atom()
        high = self.exponent()
        body = self.product()
        self.take("dif")
        return Node("integral", (low, high, body, self.named()))

    def word_sum(self):
        """Read a sum over whole numbers of a given total, as sum_(i+j=3)."""
        self.take()
        self.take("_")
        self.take("(")
        names = [self.take().text]
        while self.next.text == "+":
            self.take()
            names.append(self.take().text)
        self.take("=")
        total = self.number()
        self.take(")")
        return Node("sum over", (tuple(names), total, self.product()))


def _bare(node):
    """Return a node without the parentheses that a fraction or an exponent swallows."""
    return node.parts[0] if node.kind == "group" else node
