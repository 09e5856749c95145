"""Function blocks for other controllers, in Structured Text (IEC 61131-3) and in C99.

Each text is written once, in Structured Text with one statement a line. For C, words are replaced
one by one, and what both languages share is copied. A job's numbers are the fields of one structure
in Structured Text, and constants in C.
"""

import re
import textwrap
from collections import namedtuple
from importlib.resources import files

import numpy as np

from ..arguments import Whole, checked

KINDS = {"BOOL": "bool", "DINT": "int32_t", "LREAL": "double"}
# Patterns of Structured Text and their C. Statements come first: they are told by their words.
WORDS = [
    (r"\bELSIF\b", "} else IF"), (r"\bELSE\b", "} else {"), (r"\bEND_(IF|FOR|WHILE);", "}"),
    (r"\bIF ((?s:.*?)) THEN$", r"if (\1) {"), (r"\bWHILE ((?s:.*?)) DO$", r"while (\1) {"),
    (r"\bFOR (\S+) := (.*) TO (.*) BY -1 DO", r"for (\1 := \2; \1 >= \3; --\1) {"),
    (r"\bFOR (\S+) := (.*) TO (.*) DO", r"for (\1 := \2; \1 <= \3; ++\1) {"),
    (r"<>", "!="), (r"(?<![<>:!=])=(?!=)", "=="), (r":=", "="), (r"\bAND\b", "&&"),
    (r"\bOR\b", "||"), (r"\bNOT ", "!"), (r"\b(TRUE|FALSE)\b", lambda m: m[0].lower()),
    (r"\bMOD\b", "%"), (r"\bDINT_TO_LREAL\(", "(double)("), (r"\bTRUNC\(", "(int32_t)("),
    (r"\b(SQRT|SIN|COS|ATAN2?)\(", lambda m: m[0].lower()), (r"\bABS\(", "fabs("),
    (r"\bjob\.", ""),
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
ROW = r"^ +([\w, ]+) : (?:ARRAY \[0\.\.(\d+)\] OF )?(\w+)(?: := ([^;]+))?;(?: \(\* (.*) \*\))?$"
COMMENT = r"(\(\*.*?\*\))"
# An operation; the sign of a number isn't one.
COUNTED = r"\s[-+*/]\s|(?<=[\s(])-(?=[A-Za-z(])| MOD |\b(?:SQRT|SIN|COS|ATAN2?)\("


# A variable: its name, the last index of an array that begins at 0 (empty for one value), the type
# of one value as Structured Text has it, its initial value and comment (empty where there is none).
Row = namedtuple("Row", "name last kind begin comment")


class Block(namedtuple("Block", "kind name sections body")):
    """A function block, a program or a structure in Structured Text.

    Its kind is "FUNCTION_BLOCK", "PROGRAM" or "STRUCT", its sections are pairs such as
    ("VAR_INPUT", list of `Row`), and its body has one statement a line.
    """

    def rows(self, *kinds):
        """Return the variables of some sections."""
        return [row for kind, rows in self.sections if kind in kinds for row in rows]


def read_rows(text):
    """Return the `Row` list of a section or structure."""
    return [
        Row(name, *about)
        for names, *about in re.findall(ROW, text, re.M)
        for name in names.split(", ")
    ]


def read_blocks(text):
    """Return the `Block` list of a text, its structures first.

    A structure whose fields all have values holds constants.
    """
    blocks = []
    for name, fields in re.findall(STRUCT, text, re.S):
        rows = read_rows(fields)
        section = "VAR CONSTANT" if all(row.begin for row in rows) else "VAR"
        blocks.append(Block("STRUCT", name, [(section, rows)], ""))
    for kind, name, variables, body in re.findall(BLOCK, text, re.S):
        sections = re.findall(r"(VAR.*)\n((?s:.*?))END_VAR\n", variables)
        rows = [(section, read_rows(rows)) for section, rows in sections]
        blocks.append(Block(kind, name, rows, body))
    return blocks


def constant_rows(constants):
    """Return the declarations of a dict of numbers, and of arrays of numbers, by their names."""
    rows = []
    for key, value in constants.items():
        values = np.asarray(value)
        size = f"ARRAY [0..{len(values) - 1}] OF " if values.ndim else ""
        kind = "LREAL" if values.dtype == float else "DINT"
        rows.append(f"        {key} : {size}{kind} := {_number(values.tolist())};\n")
    return "".join(rows)


def _number(value):
    """Return a number, or a list of numbers in rows, as both languages write it."""
    if isinstance(value, list):
        texts = list(map(_number, value))
        rows = [", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8)]
        return "[" + ",\n            ".join(rows) + "]"
    # Structured Text requires a point before an exponent: 5e-05 isn't legal.
    return re.sub(r"^(-?\d+)e", r"\1.0e", repr(value))


def operations(block):
    """Return how many operations a `Block` takes if each of its statements is executed once.

    Operations on indices and comparisons don't count.
    """
    return len(re.findall(COUNTED, re.sub(rf"{COMMENT}|\[[^][]*\]", "", block.body, flags=re.S)))


def c99_types(blocks):
    """Return structures, initial values and prototypes of a list of `Block` in C99."""
    texts = []
    for block in blocks:
        rows = block.rows("VAR_INPUT", "VAR_OUTPUT", "VAR")
        fields = [f"    {_declared(row)};{row.comment and f' /* {row.comment} */'}" for row in rows]
        texts += ["typedef struct {", *fields, f"}} {block.name};"] if rows else []
        if begun := [f".{row.name} = {row.begin.lower()}" for row in rows if row.begin]:
            texts.append(f"#define {block.name.upper()}_BEGIN {{{', '.join(begun)}}}")
        texts += [f"{_head(block)};", ""] if block.body else [""]
    return "\n".join(texts)


def c99_code(blocks):
    """Return the constants and functions of a list of `Block` in C99."""
    constants = {row.name: row for block in blocks for row in block.rows("VAR CONSTANT")}
    texts = [
        f"static const {_declared(row)} = {row.begin.replace('[', '{').replace(']', '}')};\n"
        for row in constants.values()
    ]
    texts += [f"\n{_head(block)}\n{{\n{_c_body(block)}}}\n" for block in blocks if block.body]
    return "".join(texts)


def _declared(row):
    """Return the declaration of a `Row` in C."""
    size = f"[{int(row.last) + 1}]" if row.last else ""
    return f"{KINDS.get(row.kind, row.kind)} {row.name}{size}"


def _head(block):
    """Return the head of the C function that a call of a block becomes.

    Externals are volatile, since another task writes them. The job isn't passed: its numbers are
    constants in C.
    """
    shared = (f", volatile {row.kind} *{row.name}" for row in block.rows("VAR_EXTERNAL")
              if row.name != "job")  # fmt: skip
    return f"void {block.name.lower()}({block.name} *c{''.join(shared)})"


def _c_body(block):
    """Return the statements of a block in C."""
    kinds = {row.name: row.kind for row in block.rows("VAR_INPUT", "VAR_OUTPUT", "VAR")}

    def call(found):
        pad, name, given = found.groups()
        inputs = (f"{pad}{name}.{one};\n" for one in re.split(r",\s+", given))
        return f"{''.join(inputs)}{pad}{kinds[name].lower()}(&{name});"

    words = [(rf"^( *)({'|'.join(kinds)})\(((?s:.*?))\);$", call), *WORDS]
    words += [(rf"(?<![.\w])({'|'.join(kinds)})\b", r"c->\1")]
    words += [(rf"\b{row.name}\.", f"{row.name}->") for row in block.rows("VAR_EXTERNAL")]
    # Comments stand between the parts with statements.
    parts = re.split(COMMENT, block.body, flags=re.S)
    for pattern, to in words:
        parts[::2] = [re.sub(pattern, to, part, flags=re.M) for part in parts[::2]]
    parts[1::2] = [f"/*{comment[2:-2]}*/" for comment in parts[1::2]]
    return textwrap.indent("".join(parts), "    ")


@checked
def line_text(*, parts: Whole(1, 2**16)):
    """Return the integer line of one axis, with `parts` of a count, in Structured Text."""
    text = files(__package__).joinpath("line.st").read_text(encoding="utf-8")
    return text.replace("@PARTS", str(parts))


@checked
def line_c99(*, parts: Whole(1, 2**16) = 1):
    """Return the integer line of one axis, with `parts` of a count, in C99."""
    blocks = read_blocks(line_text(parts=parts))
    return "\n".join([C_HEAD, c99_types(blocks), c99_code(blocks)])
