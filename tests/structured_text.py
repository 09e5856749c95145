"""Structured Text, parsed by blark and executed on its syntax tree as a strict controller would.

Quotients of DINT are truncated, MOD has the dividend's sign, a DINT that overflows is an error, and
so are a variable that isn't declared, an index beyond its array, a sum of a DINT and an LREAL. An
LREAL that was never set is no number. What the study's exports don't use isn't understood.
"""

import math
import operator
import re
from functools import cache

from blark.parse import parse_source_code
from blark.transform import (
    ArrayTypeInitialization,
    AssignmentStatement,
    BinaryOperation,
    ForStatement,
    FunctionCall,
    IfStatement,
    Integer,
    MultiElementVariable,
    ParenthesizedExpression,
    Real,
    SimpleVariable,
    UnaryOperation,
)

LOW, HIGH = -(2**31), 2**31 - 1


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

    Whole numbers of the text, and those before the point, may stand for others, `instead`.
    """

    def __init__(self, text, instead=None):
        block = parsed(text)
        self.instead = instead or {}
        self.state = {}
        for declarations in block.declarations:
            for item in declarations.items:
                for declared in item.variables:
                    self.state[name(declared.variable)] = self.begin(item.init)
        self.run = self.sequence(block.body)

    def begin(self, init):
        begin = BEGIN[str(init.spec.type)]
        if isinstance(init, ArrayTypeInitialization):
            (bounds,) = init.spec.subranges
            assert str(bounds.start) == "0"
            return [begin] * (int(self.literal(bounds.stop)) + 1)
        return begin if init.value is None else self.expression(init.value)()

    def literal(self, written):
        whole, *behind = str(written).split(".")
        return ".".join([self.instead.get(whole, whole), *behind])

    def __call__(self, **inputs):
        for key, value in inputs.items():
            self.store(self.state, key, value)
        self.run()

    def store(self, where, key, value):
        if type(value) is not type(where[key]):  # also refuses what isn't declared
            raise TypeError(f"{key} := {value!r}")
        if type(value) is int and not LOW <= value <= HIGH:
            raise OverflowError(f"{key} := {value}")
        where[key] = value

    def sequence(self, part):
        statements = part.statements if part else []
        actions = [self.statement(one) for one in getattr(statements, "statements", statements)]

        def run():
            for action in actions:
                action()

        return run

    def statement(self, one):
        if isinstance(one, AssignmentStatement):
            (target,) = one.variables
            place, value = self.place(target), self.expression(one.expression)
            return lambda: self.store(*place(), value())
        if isinstance(one, IfStatement):
            branches = [(self.expression(branch.if_expression), self.sequence(branch))
                        for branch in (one, *one.else_ifs)]  # fmt: skip
            otherwise = self.sequence(one.else_clause)
            return lambda: next((then for true, then in branches if true()), otherwise)()
        if isinstance(one, ForStatement):
            key, body = self.declared(name(one.control)), self.sequence(one)
            first, last = self.expression(one.from_), self.expression(one.to)
            step = self.expression(one.step)() if one.step else 1

            def loop():
                for i in range(first(), last() + step, step):
                    self.store(self.state, key, i)
                    body()

            return loop
        raise NotImplementedError(str(one))

    def place(self, variable):
        """Return a function that tells where a variable is: in `state`, or in an array of it."""
        if isinstance(variable, SimpleVariable):
            where = self.state, self.declared(name(variable))
            return lambda: where
        (subscripts,) = variable.elements
        key = self.declared(name(variable.name))
        (index,) = map(self.expression, subscripts.subscripts)

        def element():
            at = index()
            if not 0 <= at < len(self.state[key]):
                raise IndexError(f"{key}[{at}]")
            return self.state[key], at

        return element

    def expression(self, one):
        if isinstance(one, Integer | Real):
            number = (int if isinstance(one, Integer) else float)(self.literal(one.value))
            return lambda: number
        if isinstance(one, SimpleVariable | MultiElementVariable):
            place = self.place(one)

            def read():
                where, key = place()
                return where[key]

            return read
        if isinstance(one, ParenthesizedExpression):
            return self.expression(one.expr)
        if isinstance(one, UnaryOperation | FunctionCall):
            call = isinstance(one, FunctionCall)
            operate = FUNCTIONS[name(one.name) if call else str(one.op)]
            given = [part.value for part in one.parameters] if call else [one.expr]
        elif isinstance(one, BinaryOperation):
            operate = OPERATORS[str(one.op)]
            given = [one.left, one.right]
        else:
            raise NotImplementedError(str(one))
        parts = [self.expression(part) for part in given]

        def value():
            numbers = [part() for part in parts]
            result = operate(*numbers)
            if len(set(map(type, numbers))) > 1:
                raise TypeError(str(one))
            if type(result) is int and not LOW <= result <= HIGH:
                raise OverflowError(str(one))
            return result

        return value

    def declared(self, key):
        if key not in self.state:
            raise NameError(key)
        return key


def name(variable):
    return str(variable.name)


def check_names(text):
    """Raise where a block's names are taken, too long, alike but for capitals, or never used."""
    declared = [name(one.variable) for part in parsed(text).declarations
                for item in part.items for one in item.variables]  # fmt: skip
    upper = {one.upper() for one in declared}
    assert len(upper) == len(declared)
    assert not upper & IEC_KEYWORDS
    assert max(map(len, declared)) <= 24  # what a PLC tells apart
    body = re.sub(r"\(\*.*?\*\)", "", text[text.rindex("END_VAR") :], flags=re.S)
    used = set(re.findall(r"(?<![\w.])[A-Za-z]\w*", body))
    assert {one for one in used if one.upper() not in IEC_KEYWORDS} == set(declared)
