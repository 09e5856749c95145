"""Structured Text, parsed by blark and executed on its syntax tree as a strict controller would.

Quotients of DINT are truncated, MOD has the dividend's sign, a DINT that overflows is an error, and
so are a variable that isn't declared, an index beyond its array, a sum of a DINT and an LREAL. An
LREAL that was never set is no number. What the study's exports don't use isn't understood.
"""

import math
import operator
from functools import cache

from blark import transform as tree
from blark.parse import parse_source_code


def truncated(a, b):
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


OPERATORS = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": lambda a, b: a / b if isinstance(a, float) else truncated(a, b),
    "MOD": lambda a, b: a - b * truncated(a, b),
    "<": operator.lt,
    ">": operator.gt,
    ">=": operator.ge,
}
FUNCTIONS = {
    "-": operator.neg,  # before a number
    "SQRT": math.sqrt,
    "SIN": math.sin,
    "COS": math.cos,
    "ATAN2": math.atan2,
}
# Of the standard's third edition, its functions and blocks, and of Instruction List.
IEC_KEYWORDS = set(
    """ABSTRACT ACTION ARRAY AT BY CASE CLASS CONFIGURATION CONSTANT CONTINUE DO ELSE ELSIF EN
    END_ACTION END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF
    END_INTERFACE END_METHOD END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT
    END_TRANSITION END_TYPE END_VAR END_WHILE ENO EXIT EXTENDS FALSE FINAL FOR FROM FUNCTION
    FUNCTION_BLOCK F_EDGE IF IMPLEMENTS INITIAL_STEP INTERFACE INTERNAL INTERVAL METHOD NAMESPACE
    NON_RETAIN NULL OF ON OVERLAP OVERRIDE PRIORITY PRIVATE PROGRAM PROTECTED PUBLIC READ_ONLY
    READ_WRITE REF REF_TO REPEAT RESOURCE RETAIN RETURN R_EDGE SINGLE STEP STRUCT SUPER TASK THEN
    THIS TO TRANSITION TRUE TYPE UNTIL USING VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL
    VAR_INPUT VAR_IN_OUT VAR_OUTPUT VAR_TEMP WHILE WITH
    ANY ANY_BIT ANY_DATE ANY_DERIVED ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE ANY_NUM ANY_REAL
    ANY_STRING BOOL BYTE CHAR DATE DATE_AND_TIME DINT DT DWORD INT LDATE LDT LINT LREAL LTIME LTOD
    LWORD REAL SINT STRING TIME TIME_OF_DAY TOD UDINT UINT ULINT USINT WCHAR WORD WSTRING
    ABS ACOS ADD AND ASIN ATAN ATAN2 CONCAT COS DELETE DIV EQ EXP EXPT FIND GE GT INSERT LE LEFT LEN
    LIMIT LN LOG LT MAX MID MIN MOD MOVE MUL MUX NE NOT OR REPLACE RIGHT ROL ROR SEL SHL SHR SIN
    SQRT SUB TAN TRUNC XOR
    CTD CTU CTUD F_TRIG RS RTC R_TRIG SEMA SR TOF TON TP
    ANDN CAL CALC CALCN JMP JMPC JMPCN LD LDN ORN R RET RETC RETCN S ST STN XORN""".split()
)
BEGIN = {"DINT": 0, "BOOL": False, "LREAL": math.nan}


@cache
def parsed(text):
    """Return the function block that a text declares, as a syntax tree; nobody writes to it."""
    (block,) = parse_source_code(text).transform().items
    return block


class FunctionBlock:
    """An instance of the function block that a text declares; its variables are in `state`.

    It runs as the Python that its statements say. Whole numbers of the text, and those before the
    point, may stand for others, `instead`.
    """

    def __init__(self, text, instead=None):
        block = parsed(text)
        self.instead = instead or {}
        self.state = {}
        for declarations in block.declarations:
            for item in declarations.items:
                for declared in item.variables:
                    self.state[name(declared.variable)] = self.begin(item.init)
        lines = ["def run(s):", *self.lines(block.body, " ")]
        exec("\n".join(lines), globals(), made := {})
        self.run = made["run"]

    def begin(self, init):
        begin = BEGIN[str(init.spec.type)]
        if isinstance(init, tree.ArrayTypeInitialization):
            (bounds,) = init.spec.subranges
            assert str(bounds.start) == "0"
            return [begin] * (int(self.literal(bounds.stop)) + 1)
        return begin if init.value is None else eval(self.value(init.value))

    def literal(self, written):
        whole, *behind = str(written).split(".")
        return ".".join([self.instead.get(whole, whole), *behind])

    def __call__(self, **inputs):
        for key, value in inputs.items():
            store(self.state, key, value)
        self.run(self.state)

    def lines(self, part, indent):
        """Yield the lines of Python of a list of statements."""
        statements = part.statements if part else []
        yield f"{indent}pass"
        for one in getattr(statements, "statements", statements):
            if isinstance(one, tree.AssignmentStatement):
                (target,) = one.variables
                where, key = self.place(target)
                yield f"{indent}store({where}, {key}, {self.value(one.expression)})"
            elif isinstance(one, tree.IfStatement):
                for word, branch in zip(["if", *["elif"] * len(one.else_ifs)],
                                        [one, *one.else_ifs], strict=True):  # fmt: skip
                    yield f"{indent}{word} {self.value(branch.if_expression)}:"
                    yield from self.lines(branch, f"{indent} ")
                yield f"{indent}else:"
                yield from self.lines(one.else_clause, f"{indent} ")
            elif isinstance(one, tree.ForStatement):
                step = eval(self.value(one.step)) if one.step else 1
                first, last = self.value(one.from_), self.value(one.to)
                yield f"{indent}for i in range({first}, {last} + {step}, {step}):"
                yield f"{indent} store(s, {name(one.control)!r}, i)"
                yield from self.lines(one, f"{indent} ")
            else:
                raise NotImplementedError(str(one))

    def place(self, variable):
        """Return where a variable is, in `state` or in an array of it, and its key there."""
        if isinstance(variable, tree.SimpleVariable):
            return "s", repr(name(variable))
        (subscripts,) = variable.elements
        (index,) = map(self.value, subscripts.subscripts)
        where = f"s[{name(variable.name)!r}]"
        return where, f"within({where}, {index})"

    def value(self, one):
        """Return an expression in Python."""
        if isinstance(one, tree.Integer | tree.Real):
            return self.literal(one.value)
        if isinstance(one, tree.SimpleVariable | tree.MultiElementVariable):
            return "{}[{}]".format(*self.place(one))
        if isinstance(one, tree.ParenthesizedExpression):
            return self.value(one.expr)
        if isinstance(one, tree.FunctionCall):
            given = [part.value for part in one.parameters]
            table, operation = "FUNCTIONS", name(one.name)
        elif isinstance(one, tree.UnaryOperation):
            table, operation, given = "FUNCTIONS", str(one.op), [one.expr]
        elif isinstance(one, tree.BinaryOperation):
            table, operation, given = "OPERATORS", str(one.op), [one.left, one.right]
        else:
            raise NotImplementedError(str(one))
        return f"done({table}[{operation!r}], {', '.join(map(self.value, given))})"


def store(where, key, value):
    if type(value) is not type(where[key]):  # also refuses what isn't declared
        raise TypeError(f"{key} := {value!r}")
    where[key] = value


def within(array, at):
    if not 0 <= at < len(array):
        raise IndexError(at)
    return at


def done(operate, *numbers):
    result = operate(*numbers)
    if len(set(map(type, numbers))) > 1:
        raise TypeError(str(numbers))
    if type(result) is int and not -(2**31) <= result < 2**31:
        raise OverflowError(str(numbers))
    return result


def name(variable):
    return str(variable.name)
