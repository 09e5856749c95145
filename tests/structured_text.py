"""Structured Text, parsed by blark and executed on its syntax tree as a strict controller would.

Quotients are truncated, MOD has the dividend's sign, a DINT that overflows is an error, and so is
a variable that isn't declared. What the study's exports don't use isn't understood.
"""

import operator
from functools import cache

from blark.parse import parse_source_code
from blark.transform import (
    AssignmentStatement,
    BinaryOperation,
    IfStatement,
    Integer,
    ParenthesizedExpression,
    SimpleVariable,
)

LOW, HIGH = -(2**31), 2**31 - 1


def truncated(a, b):
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


OPERATORS = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": truncated,
    "MOD": lambda a, b: a - b * truncated(a, b),
    "<": operator.lt,
    ">": operator.gt,
    ">=": operator.ge,
}


@cache
def parsed(text):
    """Return the function block that a text declares, as a syntax tree; nobody writes to it."""
    (block,) = parse_source_code(text).transform().items
    return block


class FunctionBlock:
    """An instance of the function block that a text declares; its variables are in `state`."""

    def __init__(self, text):
        block = parsed(text)
        self.state = {}
        for declarations in block.declarations:
            for item in declarations.items:
                kind = str(item.init.spec.type)
                for declared in item.variables:
                    self.state[name(declared.variable)] = {"DINT": 0, "BOOL": False}[kind]
        self.run = self.sequence(block.body.statements)

    def __call__(self, **inputs):
        for key, value in inputs.items():
            self.store(key, value)
        self.run()

    def store(self, key, value):
        if type(value) is not type(self.state[key]):  # also refuses what isn't declared
            raise TypeError(f"{key} := {value!r}")
        if not LOW <= value <= HIGH:
            raise OverflowError(f"{key} := {value}")
        self.state[key] = value

    def sequence(self, statements):
        actions = [self.statement(one) for one in statements]

        def run():
            for action in actions:
                action()

        return run

    def statement(self, one):
        if isinstance(one, AssignmentStatement):
            (target,) = one.variables
            key, value = self.declared(name(target)), self.expression(one.expression)
            return lambda: self.store(key, value())
        if isinstance(one, IfStatement) and not one.else_ifs:
            condition, then = self.expression(one.if_expression), self.sequence(self.body(one))
            otherwise = self.sequence(self.body(one.else_clause))
            return lambda: then() if condition() else otherwise()
        raise NotImplementedError(str(one))

    @staticmethod
    def body(part):
        return part.statements.statements if part and part.statements else []

    def expression(self, one):
        if isinstance(one, Integer):
            number = int(one.value)
            return lambda: number
        if isinstance(one, SimpleVariable):
            key = self.declared(name(one))
            return lambda: self.state[key]
        if isinstance(one, ParenthesizedExpression):
            return self.expression(one.expr)
        if isinstance(one, BinaryOperation):
            left, right = self.expression(one.left), self.expression(one.right)
            operate = OPERATORS[str(one.op)]

            def value():
                result = operate(left(), right())
                if not LOW <= result <= HIGH:
                    raise OverflowError(str(one))
                return result

            return value
        raise NotImplementedError(str(one))

    def declared(self, key):
        if key not in self.state:
            raise NameError(key)
        return key


def name(variable):
    return str(variable.name)
