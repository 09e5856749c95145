"""Whether a displayed equation holds, at values that `typeset_worlds` gives for its letters."""

import numpy as np
import sympy as sp

from report.tests.typst_math import parse
from report.tests.typst_values import to_sympy

NUMPY = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "atan2": np.arctan2, "Abs": np.abs, "floor": np.floor,
    "cot": lambda x: 1 / np.tan(x),  # what sympy makes of tan(pi/4 - x)
}  # fmt: skip
TOLERANCE = 1e-9
COMPARED = {"<": np.less, ">": np.greater, "<=": np.less_equal, ">=": np.greater_equal}


class UnknownLetter(LookupError):
    """A letter that the world of an equation doesn't have."""


def measured(expression, world):
    """Return an expression's value, and the size of what was added up for it."""
    match expression:
        case sp.Symbol():
            if expression.name not in world:
                raise UnknownLetter(expression.name)
            value = world[expression.name]
        case sp.Add() | sp.Mul():
            parts = [measured(part, world) for part in expression.args]
            join = sum if expression.is_Add else np.prod
            return join([part[0] for part in parts]), join([part[1] for part in parts])
        case sp.Pow():
            (base, size), (power, _) = (measured(part, world) for part in expression.args)
            value = base**power
            return value, size**power if power > 0 else abs(value)
        case sp.Integral():
            over, low, high = expression.limits[0]
            ends = [measured(end, world)[0] for end in (low, high)]
            value = 0.0
            for node, weight in zip(*np.polynomial.legendre.leggauss(40), strict=True):
                at = {**world, over.name: (ends[0] + ends[1] + node * (ends[1] - ends[0])) / 2}
                value += weight * measured(expression.function, at)[0] * (ends[1] - ends[0]) / 2
        case sp.Function():
            name = expression.func.__name__
            value = NUMPY.get(name, world.get(name))(
                *(measured(part, world)[0] for part in expression.args)
            )
        case _:
            value = complex(expression) if expression.has(sp.I) else float(expression)
    return value, abs(value)


def scattered(world):
    """Return a world with the components of its vectors as letters, and the vectors' lengths."""
    vectors = {name: len(v) for name, v in world.items() if isinstance(v, np.ndarray)}
    parts = {f"{name}.{i}": world[name][i] for name, n in vectors.items() for i in range(n)}
    return {**world, **parts}, vectors


class Check:
    """A form of an equation against worlds; `holds` tells whether it's true in one."""

    def __init__(self, source, worlds):
        self.worlds, (vectors, *_) = zip(*map(scattered, worlds), strict=True)
        functions = tuple(name for name, value in worlds[0].items() if callable(value))
        display = parse(source, functions)
        self.either = "or" in display.words
        self.statements = [
            ([_parts(to_sympy(side, vectors)) for side in statement.sides], statement.relations,
             statement.modulus and to_sympy(statement.modulus))
            for statement in display.statements
        ]  # fmt: skip
        self.letters = sorted({
            letter.name for sides, _, _ in self.statements for side in sides for part in side
            for letter in part.free_symbols
        })  # fmt: skip

    def holds(self, world):
        """Tell whether the display is true where the letters have these values."""
        with np.errstate(all="ignore"):
            world = self._with_definitions(world)
            values = iter(world.get("values", ()))
            found = [self._true(statement, world, values) for statement in self.statements]
        return any(found) == world["truth"] if self.either else all(found)

    def right(self):
        """Tell whether the display is true in all worlds, and false wherever it must be."""
        return all(map(self.holds, self.worlds)) and not any(
            self.holds({**world, **change})
            for world in self.worlds
            for change in world.get("outside", ())
        )

    def blind(self):
        """Return the letters whose values don't matter in any world: there must be none."""
        return [
            letter
            for letter in self.letters
            if letter not in self.worlds[0].get("defined", ())
            and all(self.holds({**w, letter: _other(w[letter])}) for w in self.worlds)
        ]

    def _with_definitions(self, world):
        world = dict(world)
        for sides, _, _ in self.statements:
            if (name := str(sides[0][0])) in world.get("defined", ()):
                world[name] = measured(sides[1][0], world)[0]
        return world

    def _true(self, statement, world, values):
        sides, relations, modulus = statement
        sides = [[measured(part, world) for part in side] for side in sides]
        if not relations:
            sides.append([(v, abs(v)) for v in np.atleast_1d(next(values))])
            relations = ("=",)
        for relation, a, b in zip(relations, sides, sides[1:], strict=False):
            if len(a) == 1 < len(b) or len(b) == 1 < len(a):
                return False
            for (left, size), (right, other) in zip(a, b, strict=True):
                if relation == "=":
                    within = world.get("tolerance", TOLERANCE) * (size + other)
                    true = abs(left - right) <= within
                elif relation == "equiv":
                    true = (left - right) % measured(modulus, world)[0] == 0
                else:
                    true = COMPARED[relation](left, right)
                if not true:
                    return False
        return True


def _parts(side):
    return list(side) if isinstance(side, sp.MatrixBase) else [side]


def _other(value):
    """Return another value of a letter, whole if it is."""
    return value + 1 if isinstance(value, int) else value * 1.07 + 0.03
