"""The integer line for other controllers, in Structured Text and C99, and tables of set-values.

Both programs come from one description, a list of statements: (variable, expression) assigns,
("IF", condition, then, otherwise) branches. Expressions are those that both languages share; a
quotient is truncated and a remainder has the dividend's sign in both.
"""

import re
from typing import Annotated

from ..arguments import Rule, Wholes, checked, shown
from .interpolate import HIGH, LOW, Parts, Tie

INPUTS = ("nStart", "nStop", "nTicks")
STATE = ("nSet", "nLeft", "nQuot", "nRem", "nRest", "nComp")
OWN = {"bLoad", "line", "setvalues", *INPUTS, *STATE}  # names that the programs use themselves
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


# C99, 5.2.4.1: 31 characters of an external name are significant; "_load" takes five of them.
C99_LENGTH = 31 - len("_load")
C99_KEYWORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile while""".split()
)
# IEC 61131-3 promises six characters and sets no limit. Of the systems that MathWorks' PLC Coder
# writes for, by its page on the longest identifiers, Siemens' take the least: 24.
IEC_LENGTH = 24
# Statements, declarations, types, standard functions and blocks, and the instruction list's
# operators; upper or lower case doesn't matter.
IEC_KEYWORDS = frozenset(
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


def _identifier(name, value):
    if not isinstance(value, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", value):
        raise ValueError(
            f"{name}: must be a letter, then letters, digits and _; got {shown(value)}."
        )
    return value


def _unreserved(name, value, most, reserved, language):
    if len(value) > most:
        raise ValueError(
            f"{name}: must have at most {most} characters, as {language} may take no "
            f"more; got {len(value)}."
        )
    if reserved:
        raise ValueError(f"{name}: must be free in {language}; got {value}, which is taken.")
    return value


def _c99_name(name, value):
    value = _identifier(name, value)
    # <stdint.h> may define what looks like its types and limits: 7.26.8.
    taken = re.fullmatch(r"u?int\w*_t|U?INT\w*_(MAX|MIN|C)", value)
    return _unreserved(name, value, C99_LENGTH, taken or value in C99_KEYWORDS | OWN, "C99")


def _iec_name(name, value):
    value = _identifier(name, value)
    if "__" in value or value.endswith("_"):
        raise ValueError(
            f"{name}: must have no two _ in a row, and none at its end; got {shown(value)}."
        )
    upper = value.upper()
    taken = upper in IEC_KEYWORDS | {own.upper() for own in OWN} or "_TO_" in upper
    return _unreserved(name, value, IEC_LENGTH, taken, "IEC 61131-3")


def _headings(name, value):
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{name}: must be a list of names; got {shown(value)}.")
    return tuple(_identifier(f"{name}[{i}]", one) for i, one in enumerate(value))


C99Name = Annotated[str, Rule("str", _c99_name)]
IecName = Annotated[str, Rule("str", _iec_name)]
Headings = Annotated[list, Rule("list of str", _headings)]


def _loading(tie, parts):
    """Return the statements that begin a move, with ties "up" or "down".

    A number of ticks below 1 is no move: the set-value stays. Ends are in parts of a count: the
    first accumulator also holds the start's share of a count.
    """
    if parts == 1:
        begin = [("nSet", "nStart"), ("nRest", HALF[tie]), ("nComp", "nTicks")]
    else:
        half = HALF[tie].replace("nTicks", "nComp")
        begin = [
            ("nComp", f"nTicks * {parts}"),
            ("nSet", f"nStart / {parts}"),
            ("nRest", f"nStart MOD {parts}"),
            ("IF", "nRest < 0", [("nRest", f"nRest + {parts}"), ("nSet", "nSet - 1")], []),
            ("nRest", f"nRest * nTicks + {half}"),
            ("IF", "nRest >= nComp", [("nRest", "nRest - nComp"), ("nSet", "nSet + 1")], []),
        ]  # fmt: skip
    return [
        ("nLeft", "0"),
        ("IF", "nTicks > 0", [
            ("nLeft", "nTicks"),
            *begin,
            ("nQuot", "(nStop - nStart) / nComp"),
            ("nRem", "(nStop - nStart) MOD nComp"),
            ("IF", "nRem < 0", [("nRem", "nRem + nComp"), ("nQuot", "nQuot - 1")], []),
            ("nComp", "nComp - nRem"),
        ], []),
    ]  # fmt: skip


@checked
def structured_text(*, tie: Tie = "up", name: IecName = "FB_TimeLine", parts: Parts = 1):
    """Return the line of one axis as a function block in Structured Text (IEC 61131-3).

    Parameters
    ----------
    tie : {"up", "down"}
        As for `time_bresenham`.
    name : str
        Name of the function block: of at most 24 letters, digits and single _, and neither a
        keyword nor a standard function or block of IEC 61131-3.
    parts : int
        Into how many parts a count is divided in nStart and nStop, see `polyline`. The caller keeps
        nTicks times parts at most 2^30, if there is more than one.

    Returns
    -------
    text : str
        A call with bLoad begins a move, each further call is a tick; nSet is the set-value. A scan
        that begins a move calls twice, with bLoad and without, lest the place between two moves
        last two ticks. The caller keeps nStop - nStart within DINT.

    Raises
    ------
    ValueError
        If `tie` is another word or the name can't be one.
    """
    body = ["IF bLoad THEN", *_st(_loading(tie, parts), 1), "ELSE", *_st(TICK, 1), "END_IF;"]
    return "\n".join([
        f"FUNCTION_BLOCK {name}",
        "VAR_INPUT", "    bLoad : BOOL;", f"    {', '.join(INPUTS)} : DINT;", "END_VAR",
        "VAR_OUTPUT", f"    {', '.join(STATE[:2])} : DINT;", "END_VAR",
        "VAR", f"    {', '.join(STATE[2:])} : DINT;", "END_VAR",
        *body, "END_FUNCTION_BLOCK", "",
    ])  # fmt: skip


@checked
def c99(*, tie: Tie = "up", name: C99Name = "time_line", parts: Parts = 1):
    """Return the line of one axis in C99.

    Parameters
    ----------
    tie : {"up", "down"}
        As for `time_bresenham`.
    name : str
        Name of the structure, and beginning of the functions' names: of at most 26 letters,
        digits and _, and no keyword of C99.
    parts : int
        Into how many parts a count is divided in nStart and nStop, see `polyline`. The caller keeps
        nTicks times parts at most 2^30, if there is more than one.

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
    moves = ", ".join(f"int32_t {variable}" for variable in INPUTS)
    return "\n".join([
        "#include <stdint.h>", "",
        "typedef struct {", f"    int32_t {', '.join(STATE)};", f"}} {name};", "",
        f"void {name}_load({name} *line, {moves})", "{", *_c(_loading(tie, parts), 1), "}", "",
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


@checked
def setvalue_table(setvalues: Wholes("(ticks + 1, n) int", LOW, HIGH), names: Headings):
    """Return set-values as a table of whole numbers, columns set apart by blanks.

    Parameters
    ----------
    setvalues : (ticks + 1, n) int
        As from `polyline`, in counts.
    names : list of str
        Heading of each axis: a letter, then letters, digits and _.

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
    >>> print(setvalue_table([[0, 0], [3, -2]], ["theta", "phi"]), end="")
    tick theta phi
    0 0 0
    1 3 -2
    """
    if setvalues.ndim != 2 or setvalues.shape[1] != len(names):
        raise ValueError(
            f"setvalues: must have a column for each of {len(names)} names; "
            f"got shape {setvalues.shape}."
        )
    heading = " ".join(["tick", *names])
    lines = (" ".join(map(str, [i, *row])) for i, row in enumerate(setvalues.tolist()))
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
