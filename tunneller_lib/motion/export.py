"""Function blocks for other controllers: Structured Text (IEC 61131-3), and the C99 of it.

A text is written once, in Structured Text with a statement a line. What both languages share is
copied, the rest is replaced word by word; numbers come from tables of constants.
"""

import re
from importlib.resources import files
from typing import NamedTuple

from ..arguments import Whole, checked

KINDS = {"BOOL": "bool", "DINT": "int32_t", "LREAL": "double"}
# Structured Text against C: what is a whole line, and words.
WORDS = [
    (r"^IF (.*) THEN$", r"if (\1) {"), (r"^ELSIF (.*) THEN$", r"} else if (\1) {"),
    (r"^ELSE$", "} else {"), (r"^END_(IF|FOR|WHILE);$", "}"),
    (r"^WHILE (.*) DO$", r"while (\1) {"),
    (r"^FOR (\S+) := (.*) TO (.*) BY -1 DO$", r"for (\1 := \2; \1 >= \3; --\1) {"),
    (r"^FOR (\S+) := (.*) TO (.*) DO$", r"for (\1 := \2; \1 <= \3; ++\1) {"),
    (r"<>", "!="), (r"(?<![<>:!=])=(?!=)", "=="), (r":=", "="), (r"\bAND\b", "&&"),
    (r"\bOR\b", "||"), (r"\bNOT ", "!"), (r"\bTRUE\b", "true"), (r"\bFALSE\b", "false"),
    (r"\bMOD\b", "%"), (r"\bDINT_TO_LREAL\(", "(double)("), (r"\bTRUNC\(", "(int32_t)("),
    (r"\b(SQRT|SIN|COS|ATAN2?)\(", lambda found: found[0].lower()), (r"\bABS\(", "fabs("),
]  # fmt: skip
C_HEAD = """#include <math.h>
#include <stdbool.h>
#include <stdint.h>
"""
C_MACROS = """
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define MAX(a, b) ((a) > (b) ? (a) : (b))
"""
STRUCT = r"(\w+) : STRUCT\n(.*?) +END_STRUCT"
BLOCK = r"(FUNCTION_BLOCK|PROGRAM) (\w+)\n((?:VAR.*?END_VAR\n)*)(.*?)END_\1\n"
ROW = r"^ +([\w, ]+) : ([^:;]+?)(?: := ([^;]+))?;(?: \(\* (.*) \*\))?$"
# Operations; a sign of a number is a part of it.
COUNTED = r"\s[-+*/]\s|(?<=[\s(])-(?=[A-Za-z(])| MOD |\b(?:SQRT|SIN|COS|ATAN2?)\("


class Row(NamedTuple):
    """A variable.

    Parameters
    ----------
    name, kind : str
        Its type as Structured Text has it.
    begin, comment : str
        Empty where there is none.
    """

    name: str
    kind: str
    begin: str
    comment: str


class Block(NamedTuple):
    """A function block, a program or a structure in Structured Text.

    Parameters
    ----------
    kind, name : str
        "FUNCTION_BLOCK", "PROGRAM" or "STRUCT".
    sections : list of (str, list of Row)
        Such as ("VAR_INPUT", rows).
    body : list of str
        Statements, one a line.
    """

    kind: str
    name: str
    sections: list
    body: list

    def rows(self, *kinds):
        """Return the variables of some sections."""
        return [row for kind, rows in self.sections if kind in kinds for row in rows]


def read_rows(text):
    """Return the `Row` list of a section or structure."""
    return [
        Row(name, kind, begin, comment)
        for names, kind, begin, comment in re.findall(ROW, text, re.M)
        for name in names.split(", ")
    ]


def read_blocks(text):
    """Return the `Block` list of a text, its structures first."""
    found = re.findall(STRUCT, text, re.S)
    blocks = [Block("STRUCT", name, [("VAR", read_rows(rows))], []) for name, rows in found]
    for kind, name, variables, body in re.findall(BLOCK, text, re.S):
        sections = re.findall(r"(VAR.*)\n((?s:.*?))END_VAR\n", variables)
        rows = [(section, read_rows(rows)) for section, rows in sections]
        blocks.append(Block(kind, name, rows, body.splitlines()))
    return blocks


def with_constants(text, constants):
    """Return a text each of whose blocks has those `constants` that it uses.

    They are a dict of numbers and of lists of numbers, by their names.
    """

    def filled(found):
        kind, name, variables, body = found.groups()
        used = [
            f"    {key} : {_iec_kind(value)} := {_number(value)};\n"
            for key, value in constants.items()
            if re.search(rf"\b{key}\b", body)
        ]
        own = f"VAR CONSTANT\n{''.join(used)}END_VAR\n" if used else ""
        return f"{kind} {name}\n{variables}{own}{body}END_{kind}\n"

    return re.sub(BLOCK, filled, text, flags=re.S)


def _iec_kind(value):
    """Return the type of a number, or of a list of them."""
    if isinstance(value, list):
        return f"ARRAY [0..{len(value) - 1}] OF {_iec_kind(value[0])}"
    return "LREAL" if isinstance(value, float) else "DINT"


def _number(value):
    """Return a number, or a list of them in rows, as both languages take it."""
    if isinstance(value, list):
        texts = list(map(_number, value))
        rows = [", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8)]
        return "[" + ",\n        ".join(rows) + "]"
    text = repr(value)
    # A point is needed before an exponent: 5e-05 is none of Structured Text.
    return re.sub(r"^(-?\d+)e", r"\1.0e", text)


def operations(block):
    """Return how many operations a round of a `Block` takes at most, each statement done once.

    Neither indices nor comparisons count.
    """
    text = re.sub(r"\(\*.*?\*\)|\[[^][]*\]", "", "\n".join(block.body), flags=re.S)
    return len(re.findall(COUNTED, text))


def c99_types(blocks):
    """Return the structures of a list of `Block` in C99, how they begin, and what is called."""
    texts = []
    for block in blocks:
        rows = block.rows("VAR_INPUT", "VAR_OUTPUT", "VAR")
        texts += ["typedef struct {", *map(_field, rows), f"}} {block.name};"]
        if begun := [f".{row.name} = {row.begin.lower()}" for row in rows if row.begin]:
            texts.append(f"#define {block.name.upper()}_BEGIN {{{', '.join(begun)}}}")
        texts += [f"{_head(block)};", ""] if block.body else [""]
    return "\n".join(texts)


def c99_code(blocks):
    """Return the constants and functions of a list of `Block` in C99."""
    constants = {row.name: row for block in blocks for row in block.rows("VAR CONSTANT")}
    texts = [
        f"static const {_declared(row)} = {row.begin.replace('[', '{').replace(']', '}')};"
        for row in constants.values()
    ]
    for block in blocks:
        if block.body:
            texts += ["", _head(block), "{", *_c_lines(block), "}"]
    return "\n".join(texts) + "\n"


def _field(row):
    """Return a `Row` as a line of a structure in C."""
    return f"    {_declared(row)};{f' /* {row.comment} */' if row.comment else ''}"


def _declared(row):
    """Return the declaration of a `Row` in C."""
    array, last, kind = re.fullmatch(r"(ARRAY \[0\.\.(\d+)\] OF )?(\w+)", row.kind).groups()
    size = f"[{int(last) + 1}]" if array else ""
    return f"{KINDS.get(kind, kind)} {row.name}{size}"


def _head(block):
    """Return the head of the function that is a call of a block; other tasks write externals."""
    shared = (f", volatile {row.kind} *{row.name}" for row in block.rows("VAR_EXTERNAL"))
    return f"void {block.name.lower()}({block.name} *c{''.join(shared)})"


def _statements(lines):
    """Yield lines of which each is whole: of a comment, a statement, or a branch."""
    comment = False
    begun = ""
    for line in lines:
        comment = comment or line.strip().startswith("(*")
        begun = f"{begun} {line.strip()}" if begun else line
        if comment or re.search(r"(;|THEN|DO|ELSE)$", begun):
            yield begun
            begun = ""
        comment = comment and not line.endswith("*)")


def _c_lines(block):
    """Yield the statements of a block in C."""
    kinds = {row.name: row.kind for row in block.rows("VAR_INPUT", "VAR_OUTPUT", "VAR")}
    words = [(rf"(?<![.\w])({'|'.join(kinds)})\b", r"c->\1"), *WORDS]
    words += [(rf"\b{row.name}\.", f"{row.name}->") for row in block.rows("VAR_EXTERNAL")]

    def written(text):
        for pattern, to in words:
            text = re.sub(pattern, to, text)
        return text

    for line in _statements(block.body):
        pad = "    " + line[: len(line) - len(line.lstrip())]
        text = line.strip()
        called = re.fullmatch(r"(\w+)\((.*)\);", text)
        if text.startswith("(*") or not re.search(r"(;|THEN|DO|ELSE)$", text):
            yield pad + text.replace("(*", "/*").replace("*)", "*/")
        elif called and called[1] in kinds:
            for given in called[2].split(", "):
                name, value = given.split(" := ")
                yield f"{pad}c->{called[1]}.{name} = {written(value)};"
            yield f"{pad}{kinds[called[1]].lower()}(&c->{called[1]});"
        else:
            yield pad + written(text)


@checked
def line_text(*, parts: Whole(1, 2**16) | None = None):
    """Return the integer line of one axis in Structured Text.

    With `parts` of a count, or without its constant, for a text that has others, too.
    """
    text = files(__package__).joinpath("line.st").read_text(encoding="utf-8")
    return with_constants(text, {} if parts is None else {"nParts": parts})


@checked
def line_c99(*, parts: Whole(1, 2**16) = 1):
    """Return the integer line of one axis, with `parts` of a count, in C99."""
    blocks = read_blocks(line_text(parts=parts))
    return "\n".join([C_HEAD, c99_types(blocks), c99_code(blocks)])
