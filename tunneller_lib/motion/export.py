"""The integer line for other controllers: Structured Text and C99 from one description, and CSV.

The description is a list of statements: (variable, expression) assigns, ("IF", condition, then,
otherwise) branches. Expressions are those that both languages share; a quotient is truncated and
a remainder has the dividend's sign in both.
"""

import re

from ..arguments import whole
from .interpolate import HIGH, LOW, TIES

INPUTS = ("nStart", "nStop", "nTicks")
STATE = ("nSet", "nLeft", "nQuot", "nRem", "nRest", "nComp")
HALF = {"up": "nTicks / 2", "down": "(nTicks - 1) / 2"}
TICK = [
    ("IF", "nLeft > 0", [
        ("nLeft", "nLeft - 1"),
        # In one step: a floored quotient alone may lead below the least number.
        ("IF", "nRest >= nComp",
            [("nRest", "nRest - nComp"), ("nSet", "nSet + (nQuot + 1)")],
            [("nRest", "nRest + nRem"), ("nSet", "nSet + nQuot")]),
    ], []),
]  # fmt: skip


def load(tie):
    """Return the statements that begin a move, with ties "up" or "down".

    A number of ticks below 1 is no move: the set-value stays.
    """
    if tie not in tuple(TIES):
        raise ValueError(f'tie: must be "up" or "down"; got {tie!r}.')
    return [
        ("nLeft", "0"),
        ("IF", "nTicks > 0", [
            ("nSet", "nStart"),
            ("nLeft", "nTicks"),
            ("nQuot", "(nStop - nStart) / nTicks"),
            ("nRem", "(nStop - nStart) MOD nTicks"),
            ("IF", "nRem < 0", [("nRem", "nRem + nTicks"), ("nQuot", "nQuot - 1")], []),
            ("nRest", HALF[tie]),
            ("nComp", "nTicks - nRem"),
        ], []),
    ]  # fmt: skip


def structured_text(*, tie="up", name="FB_TimeLine"):
    """Return the line of one axis as a function block in Structured Text (IEC 61131-3).

    Parameters
    ----------
    tie : {"up", "down"}
        As for `time_bresenham`.
    name : str
        Name of the function block.

    Returns
    -------
    text : str
        A call with bLoad begins a move, each further call is a tick; nSet is the set-value. The
        caller keeps nStop - nStart within DINT.

    Raises
    ------
    ValueError
        If `tie` is another word or the name can't be one.
    """
    body = ["IF bLoad THEN", *_st(load(tie), 1), "ELSE", *_st(TICK, 1), "END_IF;"]
    return "\n".join([
        f"FUNCTION_BLOCK {_identifier(name)}",
        "VAR_INPUT", "    bLoad : BOOL;", f"    {', '.join(INPUTS)} : DINT;", "END_VAR",
        "VAR_OUTPUT", f"    {', '.join(STATE[:2])} : DINT;", "END_VAR",
        "VAR", f"    {', '.join(STATE[2:])} : DINT;", "END_VAR",
        *body, "END_FUNCTION_BLOCK", "",
    ])  # fmt: skip


def c99(*, tie="up", name="time_line"):
    """Return the line of one axis in C99.

    Parameters
    ----------
    tie : {"up", "down"}
        As for `time_bresenham`.
    name : str
        Name of the structure, and beginning of the functions' names.

    Returns
    -------
    text : str
        ``name_load`` begins a move, ``name_tick`` makes a tick, ``name_fill`` writes all
        nTicks + 1 set-values. The caller keeps nStop - nStart within 32 bits.

    Raises
    ------
    ValueError
        If `tie` is another word or the name can't be one.
    """
    _identifier(name)
    moves = ", ".join(f"int32_t {variable}" for variable in INPUTS)
    return "\n".join([
        "#include <stdint.h>", "",
        "typedef struct {", f"    int32_t {', '.join(STATE)};", f"}} {name};", "",
        f"void {name}_load({name} *line, {moves})", "{", *_c(load(tie), 1), "}", "",
        f"void {name}_tick({name} *line)", "{", *_c(TICK, 1), "}", "",
        f"void {name}_fill(int32_t *setvalues, {moves})", "{",
        f"    {name} line = {{0}};",
        f"    {name}_load(&line, {', '.join(INPUTS)});",
        "    *setvalues = line.nSet;",
        "    while (line.nLeft > 0) {",
        f"        {name}_tick(&line);",
        "        *++setvalues = line.nSet;",
        "    }", "}", "",
    ])  # fmt: skip


def csv(setvalues, names):
    """Return set-values as a table of whole numbers, columns set apart by blanks.

    Parameters
    ----------
    setvalues : (ticks + 1, n) int
        As from `polyline`, in counts.
    names : sequence of str
        Heading of each axis.

    Returns
    -------
    text : str
        A heading, then a line a tick: the tick and the set-values.

    Raises
    ------
    ValueError
        If the set-values aren't such an array within 32 bits, or a name is missing.

    Examples
    --------
    >>> print(csv([[0, 0], [3, -2]], ["theta", "phi"]), end="")
    tick theta phi
    0 0 0
    1 3 -2
    """
    values = whole("setvalues", setvalues, LOW, HIGH)
    if values.ndim != 2 or values.shape[1] != len(names):
        raise ValueError(f"setvalues: must have a column for each of {len(names)} names; "
                         f"got shape {values.shape}.")  # fmt: skip
    heading = " ".join(["tick", *map(_identifier, names)])
    lines = (" ".join(map(str, [i, *row])) for i, row in enumerate(values.tolist()))
    return "\n".join([heading, *lines, ""])


def _st(statements, depth):
    """Return statements as indented lines of Structured Text."""
    pad = "    " * depth
    for first, *rest in statements:
        if first != "IF":
            yield f"{pad}{first} := {rest[0]};"
            continue
        condition, then, otherwise = rest
        yield f"{pad}IF {condition} THEN"
        yield from _st(then, depth + 1)
        if otherwise:
            yield f"{pad}ELSE"
            yield from _st(otherwise, depth + 1)
        yield f"{pad}END_IF;"


def _c(statements, depth):
    """Return statements as indented lines of C."""
    pad = "    " * depth
    for first, *rest in statements:
        if first != "IF":
            yield f"{pad}{_c_expression(first)} = {_c_expression(rest[0])};"
            continue
        condition, then, otherwise = rest
        yield f"{pad}if ({_c_expression(condition)}) {{"
        yield from _c(then, depth + 1)
        if otherwise:
            yield f"{pad}}} else {{"
            yield from _c(otherwise, depth + 1)
        yield f"{pad}}}"


def _c_expression(text):
    """Return an expression in C: the state lives in a structure."""
    text = text.replace("MOD", "%")
    return re.sub(r"\b(" + "|".join(STATE) + r")\b", r"line->\1", text)


def _identifier(name):
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z]\w*", name):
        raise ValueError(f"name: must be a letter, then letters, digits and _; got {name!r}.")
    return name
