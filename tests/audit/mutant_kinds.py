"""What `make mutants` alters: places in a module's source, each of a kind, and what stands there.

Formulas: a sign, a factor, an exponent, an index, a constant, a branch. What holds around them: a
tolerance a thousand times wider or tighter, the default of an argument, the bounds that a guard
compares with, a guard itself, the rule of an argument's annotation, the words of a message.
"""

import ast
import io
import re
import tokenize
from itertools import pairwise

FORMULAS = {"sign", "factor", "exponent", "index", "constant", "branch"}
KINDS = FORMULAS | {"tolerance", "default", "range", "guard", "rule", "message"}
# Of a module that draws: what isn't a matter of taste.
LOGIC = {"branch", "range", "guard", "rule", "message"}

TINY = 1e-9
OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "==", "and": "or",
            "or": "and", "+": "-", "-": "+", "+=": "-=", "-=": "+="}  # fmt: skip
BOUNDARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "and": "or",
            "or": "and"}  # fmt: skip
WORDS = {"must": "need not", "needs": "excludes", "got": "wanted", "least": "most",
         "most": "least", "above": "below", "below": "above", "between": "beyond", "from": "below",
         "positive": "negative", "finite": "infinite", "whole": "broken", "zero": "one",
         "no": "one", "not": "only", "isn't": "is", "doesn't": "does", "can't": "can",
         "before": "after", "after": "before", "ascending": "descending", "first": "last",
         "last": "first"}  # fmt: skip
CHECKS = re.compile(r"_?(check|refuse|require)")  # functions that only look
# How arrays lie, how often a loop may run, and how long.
LAYOUT = "reshape moveaxis expand_dims swapaxes range lru_cache expect".split()
# Constants that choose how much is done at a time, or which form: the bits are the same.
ONLY_TIME = re.compile(r"BLOCK|EACH|LONG|MOVE|POSES|SECONDS|TRIES|PLAIN_\w+")


def rules_in(source):
    """Return what the annotations that a module defines say and check: {name: (says, check)}.

    Of those which say the same, one may stand for another.
    """
    found = {}
    for node in ast.parse(source).body:
        made = getattr(node, "value", None)
        if isinstance(node, ast.Assign) and ast.unparse(made).startswith("Annotated["):
            rule = made.slice.elts[1]
            found[node.targets[0].id] = rule.args[0].value, ast.unparse(rule.args[1])
        elif isinstance(made, ast.Call) and ast.unparse(made.func) in ("Number", "Array"):
            several = ast.unparse(made.func) == "Array"
            says = made.args[0].value if several else "float"
            checks = [] if several else made.args[:2]  # then comes the unit
            checks = [*checks, *(one for one in made.keywords if one.arg != "unit")]
            found[node.targets[0].id] = says, ", ".join(map(ast.unparse, checks))
    return found


def draws(source):
    """Tell whether a module makes pictures or scenes."""
    return bool(re.search(r"\b(matplotlib|pyvista|PIL)\b", source))


def more(number):
    """Return a constant with its last printed digit one greater."""
    digits = int(number.replace(".", "").replace("_", "")) + 1
    decimals = len(number.partition(".")[2])
    text = str(digits).zfill(decimals + 1)
    return f"{text[:-decimals]}.{text[-decimals:]}" if decimals else text


class Places(ast.NodeVisitor):
    """Collect what can be altered in a module: `found` as (line, column, kind, old, new).

    `idle` are those of them whose change isn't a fault.
    """

    def __init__(self, source, rules=None):
        # Columns of the syntax tree count bytes, those of tokens characters.
        source = re.sub(r"[^\x00-\x7f]", "?", source)
        tokens = tokenize.generate_tokens(io.StringIO(source).readline)
        words = tokenize.OP, tokenize.NAME, tokenize.NUMBER
        self.tokens = [(token.start, token.string) for token in tokens if token.type in words]
        self.lines = source.splitlines()
        self.found, self.idle = [], []
        tree = ast.parse(source)
        taken = {
            alias.asname or alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
        self.rules = {name: rule for name, rule in (rules or {}).items() if name in taken}
        self.visit(tree)

    # ---- how places are noted ----

    def add(self, kind, start, end, change):
        """Take the one token between two places of the source that `change` has a word for."""
        for place, old in self.tokens:
            if start <= place < end and (new := change(old)) is not None:
                self.found.append((*place, kind, old, new))
                return

    def text(self, node):
        """Return the text of a node that stands on one line, or None."""
        if node.lineno == node.end_lineno:
            return self.lines[node.lineno - 1][node.col_offset : node.end_col_offset]
        return None

    def replace(self, kind, node, *news):
        """Note other texts for a node that stands on one line."""
        if old := self.text(node):
            self.found += [(*start_of(node), kind, old, new) for new in news if new != old]

    def leave_out(self, start, end):
        """Note places whose change isn't a fault in a formula."""
        self.idle += [place for place in self.found if start <= place[:2] < end]

    def between(self, kind, left, right, change):
        self.add(kind, end_of(left), start_of(right), change)

    def number(self, kind, node, change):
        if isinstance(node, ast.UnaryOp):
            node, change = node.operand, more  # -1 becomes -2, and not 0
        if is_number(node):
            self.add(kind, start_of(node), end_of(node), change)

    # ---- formulas ----

    def visit_BinOp(self, node):
        kinds = {ast.Add: "sign", ast.Sub: "sign", ast.Mult: "factor", ast.Div: "factor"}
        kind = kinds.get(type(node.op))
        if kind == "sign" and not (joins(node.left) or joins(node.right)):
            self.between(kind, node.left, node.right, OPPOSITE.get)
        if kind == "factor" and not (joins(node.left) or joins(node.right)):
            twice = {"*": "* 2 *", "/": "/ 2 /"}
            self.between("factor", node.left, node.right, twice.get)
            self.between("exponent", node.left, node.right, {"*": "/", "/": "*"}.get)
        if isinstance(node.op, ast.Pow):
            self.power(node)
        else:
            self.generic_visit(node)
        if guards(node.left) or guards(node.right):  # what is added to a divisor that may be 0
            self.leave_out(end_of(node.left), end_of(node))

    def power(self, node):
        """Take an exponent; where it makes a small power of two, that is a tolerance."""
        negative = isinstance(node.right, ast.UnaryOp) and is_number(node.right.operand)
        if negative and ast.unparse(node.left) in ("2", "2.0"):
            bits = node.right.operand
            if isinstance(bits.value, int) and bits.value >= 12:
                self.replace("tolerance", bits, str(bits.value - 10), str(bits.value + 10))
            return
        self.number("exponent", node.right, lambda n: str(int(n) + 1) if n.isdigit() else None)
        self.visit(node.left)

    def visit_AugAssign(self, node):
        self.between("sign", node.target, node.value, {"+=": "-=", "-=": "+="}.get)
        self.visit(node.value)

    def visit_UnaryOp(self, node):
        if isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
            self.add("sign", start_of(node), end_of(node), {"-": "+"}.get)
        self.generic_visit(node)

    def visit_Compare(self, node):
        if len(node.ops) == 1:
            self.between("branch", node.left, node.comparators[0], OPPOSITE.get)
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        self.between("branch", *node.values[:2], OPPOSITE.get)
        self.generic_visit(node)

    def visit_Subscript(self, node):
        inside = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        for index in inside:
            ends = [index.lower, index.upper] if isinstance(index, ast.Slice) else [index]
            for end in ends:
                self.number("index", end, lambda n: str(int(n) - 1) if n > "0" else "1")
        self.visit(node.value)

    def visit_Constant(self, node):
        if not is_number(node):
            return
        if small := re.fullmatch(r"([\d.]+)e-0*(\d+)", self.text(node) or ""):
            mantissa, power = small[1], int(small[2])
            wider, tighter = (f"{mantissa}e{-power + by}" for by in (3, -3))
            self.replace("tolerance", node, wider, tighter)
        else:
            self.number("constant", node, lambda n: None if "e" in n.lower() else more(n))

    def visit_Attribute(self, node):
        if node.attr == "eps" and "finfo" in ast.unparse(node.value):
            self.rounding(node)
        else:
            self.generic_visit(node)

    def visit_Name(self, node):
        if re.fullmatch(r"_?(EPS|EPSILON)", node.id) and isinstance(node.ctx, ast.Load):
            self.rounding(node)

    def rounding(self, node):
        self.replace("tolerance", node, *(f"({by} * {self.text(node)})" for by in ("1e3", "1e-3")))

    def visit_Assign(self, node):
        if not ONLY_TIME.match(ast.unparse(node.targets[0]).strip("(")):
            self.visit(node.value)

    def visit_keyword(self, node):
        if node.arg not in ("axis", "ndim", "shape", "stacklevel", "decimals", "initial"):
            self.visit(node.value)

    def visit_Call(self, node):
        name = ast.unparse(node.func).rpartition(".")[2]
        if name in LAYOUT:
            return
        self.generic_visit(node)
        if name in ("maximum", "clip", "where"):  # what keeps a divisor from being 0
            for argument in node.args[1:]:
                if is_number(argument) and 0 < argument.value <= TINY:
                    self.leave_out(start_of(argument), end_of(argument))

    def visit_JoinedStr(self, node):
        """What is printed stays; messages are words in `raise`."""

    # ---- what holds around formulas ----

    def visit_If(self, node):
        if any(isinstance(statement, ast.Raise) for statement in node.body):
            self.bounds(node.test)
        else:
            self.visit(node.test)
        for statement in [*node.body, *node.orelse]:
            self.visit(statement)

    def bounds(self, test):
        """Take what a guard compares, and with what."""
        for node in ast.walk(test):
            if isinstance(node, ast.Compare):
                sides = [node.left, *node.comparators]
                for left, right in pairwise(sides):
                    self.between("range", left, right, BOUNDARY.get)
                for side in sides:
                    inner = side.operand if isinstance(side, ast.UnaryOp) else side
                    if is_number(inner) and "e" not in (self.text(inner) or "e").lower():
                        self.number("range", inner, more)
                    elif is_number(inner):
                        self.visit(inner)  # a tolerance
            if isinstance(node, ast.BoolOp):
                self.between("range", *node.values[:2], BOUNDARY.get)

    def visit_Raise(self, node):
        if not isinstance(node.exc, ast.Call):
            return
        if node.cause is None:
            self.found.append((*start_of(node), "guard", "raise ", ""))
        for number in range(node.lineno, node.end_lineno + 1):
            self.message(number)

    def message(self, number):
        """Take the words of a message on a line, and the argument's name that begins it."""
        line = self.lines[number - 1]
        for literal in re.finditer(r'"(?:[^"\\]|\\.)*"', line):
            # Not what is put in by its value.
            text = re.sub(r"\{[^{}]*\}", lambda put: " " * len(put[0]), literal[0])
            for word in re.finditer(r"[A-Za-z']+", text):
                if new := WORDS.get(word[0]):
                    place = number, literal.start() + word.start()
                    self.found.append((*place, "message", word[0], new))
            if name := re.match(r'"([a-z_]\w*)\b(?=[^"]*: )', text):
                place = number, literal.start() + 1
                self.found.append((*place, "message", name[1], "argument"))

    def visit_Expr(self, node):
        call = node.value
        if isinstance(call, ast.Call):
            if CHECKS.match(ast.unparse(call.func).rpartition(".")[2]):
                self.found.append((*start_of(node), "guard", "", "0 and "))
        self.visit(call)

    def visit_AnnAssign(self, node):
        if node.value:
            self.visit(node.value)

    def visit_ClassDef(self, node):
        for statement in node.body:
            if isinstance(statement, ast.AnnAssign):
                self.argument(statement, statement.annotation, statement.value, is_checked(node))
            else:
                self.visit(statement)

    def visit_FunctionDef(self, node):
        every = [*node.args.posonlyargs, *node.args.args]
        given = [None] * (len(every) - len(node.args.defaults)) + node.args.defaults
        pairs = [*zip(every, given, strict=True)]
        pairs += zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
        for argument, default in pairs:
            self.argument(argument, argument.annotation, default, is_checked(node))
        for statement in node.body:
            self.visit(statement)

    def argument(self, node, annotation, default, checked):
        if checked and annotation is not None:
            self.rule(annotation)
        if default is not None:
            self.default(annotation, default)

    def default(self, annotation, node):
        """Take the value of an argument that isn't given."""
        text = self.text(node)
        if isinstance(node, ast.Constant) and isinstance(node.value, bool):
            self.replace("default", node, str(not node.value))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            words = [n for n in ast.walk(annotation or node) if isinstance(n, ast.Constant)]
            words = [n.value for n in words if isinstance(n.value, str) and n.value != node.value]
            self.replace("default", node, *(f'"{word}"' for word in words))
        elif is_number(node) and not node.value:
            self.replace("default", node, "1" if isinstance(node.value, int) else "1.0")
        elif is_number(node) and "e-" in text:
            self.visit(node)  # a tolerance
        elif is_number(node) or isinstance(node, ast.BinOp | ast.UnaryOp):
            self.replace("default", node, f"2 * {text}" if is_number(node) else f"2 * ({text})")

    def rule(self, node):
        """Take the rule of an annotation: another that says the same, a wider one, or none."""
        text = self.text(node)
        if isinstance(node, ast.BinOp) and text and text.endswith(" | None"):
            self.replace("rule", node, text.removesuffix(" | None"))
            self.rule(node.left)
        elif isinstance(node, ast.Name | ast.Attribute):
            says, check = self.rules.get(text, ("", ""))
            alike = [name for name, rule in self.rules.items() if rule[0] == says != ""]
            self.replace("rule", node, *(n for n in alike if self.rules[n][1] != check), "object")
        elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
            words = [f'"{n.value}"' for n in node.slice.elts if isinstance(n, ast.Constant)]
            if ast.unparse(node.value).endswith("Literal") and len(words) > 1:
                self.replace("rule", node, f"Literal[{', '.join(words[:-1])}]")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).startswith("Whole"):
            low, high = node.args[-2:]
            self.replace("rule", low, f"{self.text(low)} - 1", f"{self.text(low)} + 1")
            self.replace("rule", high, f"2 * {self.text(high)}")


def start_of(node):
    return node.lineno, node.col_offset


def end_of(node):
    return node.end_lineno, node.end_col_offset


def is_number(node):
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def is_checked(node):
    return any(ast.unparse(decorator) == "checked" for decorator in node.decorator_list)


def joins(node):
    """Tell whether + and * join or repeat it, as with text, lists and shapes."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str)
    if isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp)):
        return True
    return bool(re.search(r"\bshape\b|Path|folder|root\b.*\bname|suffix", ast.unparse(node)))


def guards(node):
    return isinstance(node, ast.Compare) or "finfo" in ast.unparse(node)
