"""A `Program` of the controller written out: C99, Structured Text (IEC 61131-3), PLCopen XML."""

import re
from xml.etree import ElementTree as Xml

from ..arguments import checked
from ..motion.export import c99, structured_text
from .controller import INPUTS, OUTPUTS, RING, RING_ARRAYS, RING_STATE, SLOW_STATE, STATE, Program

# Begins that aren't zero.
BEGIN = {
    "nFraction": "nFull", "nFromTheta": "nBeginTheta", "nFromPhi": "nBeginPhi",
    "nSetTheta": "nBeginTheta", "nSetPhi": "nBeginPhi", "nPartsTheta": "nFirstTheta",
    "nPartsPhi": "nFirstPhi", "nOverride": "nFull",
}  # fmt: skip
C_WORDS = [
    (r"\(\*(.*)\*\)", r"/*\1*/"), (r"<>", "!="), (r"(?<![<>:!])=(?!=)", "=="), (r":=", "="),
    (r"\bAND\b", "&&"), (r"\bOR\b", "||"), (r"\bNOT\b", "!"), (r"\bTRUE\b", "1"),
    (r"\bFALSE\b", "0"), (r"\bDINT_TO_LREAL\(", "(double)("), (r"\bTRUNC\(", "(int32_t)("),
    (r"\bSQRT\(", "sqrt("), (r"\bSIN\(", "sin("), (r"\bCOS\(", "cos("), (r"\bATAN\(", "atan("),
    (r"\bNABS\(", "abs("), (r"\bABS\(", "fabs("),
]  # fmt: skip
C_LINES = [
    (r"IF (.*) THEN", r"if (\1) {"), (r"ELSIF (.*) THEN", r"} else if (\1) {"),
    (r"ELSE", "} else {"), (r"END_IF;", "}"),
    (r"line(\w+)\(bLoad := TRUE, nStart := (.*), nStop := (.*), nTicks := (.*)\);",
     r"time_line_load(&line\1, \2, \3, \4);"),
    (r"line(\w+)\(bLoad := FALSE\);", r"time_line_tick(&line\1);"),
]  # fmt: skip
DECLARED = {"BOOL": "int32_t", "DINT": "int32_t", "LREAL": "double"}
FIELDS = [*INPUTS, *OUTPUTS, *STATE, *RING_STATE]
C_HEAD = """/* Controller of a tunnelling robot: setpoints ahead, integer lines, position loops.
 *
 * Units: counts, rad, m, s. Once:            tunneller_init(&c);
 * in a slow task, or between two scans:      tunneller_slow(&c);   as often as there is time
 * in each scan, every {tick:g} s:
 *     c.nActualTheta = ...; c.nActualPhi = ...; c.bRun = 1;
 *     tunneller_fast(&c);
 *     ... = c.rValveTheta; ... = c.rValvePhi;
 * Inputs: bRun, bHold, bRetract, bReset, nOverride (256 is 100 %).
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
"""


@checked
def c99_text(controller: Program):
    """Return a `Program` in C99, tables and line included, with comments and an example of use."""
    declared = [
        f"    {DECLARED[kind]} {name};{f' /* {what} */' if what else ''}"
        for name, kind, what in _once(FIELDS + SLOW_STATE)
    ]
    names = [name for name, _, _ in FIELDS + SLOW_STATE] + [
        "lineTheta",
        "linePhi",
        *RING_ARRAYS,
        "nNext",
    ]
    begin = [f"    c->{name} = {value};" for name, value in BEGIN.items()]
    begin += ["    c->lineTheta.nSet = nBeginTheta;", "    c->linePhi.nSet = nBeginPhi;"]
    return "\n".join([
        C_HEAD.format(tick=controller.tick),
        *(f"static const {_c_kind(value)} {name} = {_number(value)};"
          for name, value in controller.constants.items()),
        *(f"static const {_c_kind(values[0])} {name}[{len(values)}] = {{\n{_rows(values)}}};"
          for name, values in controller.tables.items()),
        "", c99(parts=controller.parts).replace("#include <stdint.h>\n\n", ""),
        "typedef struct {", *declared, "    int32_t nNext;",
        *(f"    int32_t {name}[{RING}];" for name in RING_ARRAYS),
        "    time_line lineTheta, linePhi;", "} tunneller;", "",
        "void tunneller_init(tunneller *c)", "{",
        "    static const tunneller zero;", "    *c = zero;", *begin, "}", "",
        "void tunneller_slow(tunneller *c)", "{", *_c_lines(controller.slow, names), "}", "",
        "void tunneller_fast(tunneller *c)", "{", *_c_lines(controller.fast, names), "}", "",
    ])  # fmt: skip


def _once(fields):
    """Return fields without those of a name that was there before."""
    return list({name: (name, kind, what) for name, kind, what in reversed(fields)}.values())[::-1]


def _c_kind(value):
    return "int32_t" if isinstance(value, int) else "double"


def _number(value):
    return str(value) if isinstance(value, int) else repr(float(value))


def _rows(values):
    """Return numbers of a table, eight in a row."""
    texts = list(map(_number, values))
    return "".join(f"    {', '.join(texts[i : i + 8])},\n" for i in range(0, len(texts), 8))


def _c_lines(lines, names):
    """Yield the lines of C99 that lines of Structured Text say."""
    fields = re.compile(r"\b(" + "|".join(sorted(names, key=len, reverse=True)) + r")\b")
    for line in lines:
        pad = "    " + line[: len(line) - len(line.lstrip())]
        text = line.strip()
        if text.startswith("(*"):
            yield pad + re.sub(*C_WORDS[0], text)
            continue
        for pattern, to in C_LINES:
            if re.fullmatch(pattern, text):
                text = re.sub(pattern, to, text)
                break
        for pattern, to in C_WORDS:
            text = re.sub(pattern, to, text)
        yield pad + fields.sub(r"c->\1", text)


ST_HEAD = """(* Controller of a tunnelling robot: setpoints ahead, integer lines, position loops.

   Units: counts, rad, m, s. One call of PRG_Fast is one scan, every {tick:g} s; PRG_Slow prepares
   setpoints ahead in a ring of {ring} and may be interrupted by it. The configuration at the end is
   an example of use: connect nActualTheta, nActualPhi with the encoders, rValveTheta, rValvePhi
   with the valves, and set bRun. Inputs of PRG_Fast: bRun, bHold, bRetract, bReset, nOverride
   (256 is 100 %). *)
"""
SHARED = [field for field in RING_STATE if field[0] in ("nHead", "nTail", "bEnd")]
OWN = [field for field in RING_STATE if field not in SHARED]
# Of one name in both tasks: arrays that are only alike are of different types.
RING_TYPE = "T_Ring"
RING_ARRAY = f"ARRAY [0..{RING - 1}] OF DINT"
NEXT = ("nNext", "DINT", "the ring's place behind nTail")


@checked
def structured_text_of(controller: Program):
    """Return a `Program` as two programs, the line's function block and a configuration."""
    units = _units(controller)
    texts = [ST_HEAD.format(tick=controller.tick, ring=RING)]
    texts.append(f"TYPE\n    {RING_TYPE} : {RING_ARRAY};\nEND_TYPE\n")
    texts.append(structured_text(parts=controller.parts))
    for name, sections, body in units:
        declared = [_declared(kind, rows) for kind, rows in sections if rows]
        texts.append("\n".join([f"PROGRAM {name}", *declared, *body, "END_PROGRAM", ""]))
    fast, slow = _periods(controller)
    texts.append("\n".join([
        "CONFIGURATION Tunneller", _declared("VAR_GLOBAL", _globals()),
        "RESOURCE Controller ON PLC",
        f"    TASK Fast(INTERVAL := {fast}, PRIORITY := 0);",
        f"    TASK Slow(INTERVAL := {slow}, PRIORITY := 1);",
        "    PROGRAM FastTask WITH Fast : PRG_Fast;", "    PROGRAM SlowTask WITH Slow : PRG_Slow;",
        "END_RESOURCE", "END_CONFIGURATION", "",
    ]))  # fmt: skip
    return "\n".join(texts)


@checked
def plcopen_xml(controller: Program):
    """Return a `Program` in PLCopen XML (TC6, 2.01): the same texts, their variables apart."""
    space = "http://www.plcopen.org/xml/tc6_0201"
    when = "2000-01-01T00:00:00"  # the same text whenever it is made
    project = Xml.Element("project", xmlns=space)
    Xml.SubElement(
        project,
        "fileHeader",
        companyName="",
        productName="tunneller_lib",
        productVersion="1",
        creationDateTime=when,
    )
    content = Xml.SubElement(project, "contentHeader", name="Tunneller")
    coordinates = Xml.SubElement(content, "coordinateInfo")
    for kind in ("fbd", "ld", "sfc"):
        Xml.SubElement(Xml.SubElement(coordinates, kind), "scaling", x="1", y="1")
    types = Xml.SubElement(project, "types")
    ring = Xml.SubElement(Xml.SubElement(types, "dataTypes"), "dataType", name=RING_TYPE)
    _kind(Xml.SubElement(ring, "baseType"), RING_ARRAY)
    pous = Xml.SubElement(types, "pous")
    line = structured_text(parts=controller.parts).splitlines()
    begin = line.index("IF bLoad THEN")
    wanted = [("nStart", "DINT", ""), ("nStop", "DINT", ""), ("nTicks", "DINT", "")]
    kept = [(name, "DINT", "") for name in ("nQuot", "nRem", "nRest", "nComp")]
    sections = [
        ("VAR_INPUT", [("bLoad", "BOOL", ""), *wanted]),
        ("VAR_OUTPUT", [("nSet", "DINT", ""), ("nLeft", "DINT", "")]),
        ("VAR", kept),
    ]
    _pou(pous, "FB_TimeLine", "functionBlock", sections, line[begin:-1])
    for name, rows, body in _units(controller):
        _pou(pous, name, "program", rows, body)
    instances = Xml.SubElement(Xml.SubElement(project, "instances"), "configurations")
    configuration = Xml.SubElement(instances, "configuration", name="Tunneller")
    resource = Xml.SubElement(configuration, "resource", name="Controller")
    for name, period, priority in zip(("Fast", "Slow"), _periods(controller), "01", strict=True):
        task = Xml.SubElement(resource, "task", name=name, interval=period, priority=priority)
        Xml.SubElement(task, "pouInstance", name=f"{name}Task", typeName=f"PRG_{name}")
    _variables(configuration, "globalVars", _globals())
    Xml.indent(project)
    return Xml.tostring(project, encoding="unicode", xml_declaration=False) + "\n"


def _units(controller):
    """Return (name, sections of variables, body) of both programs."""
    constants = [
        (n, "LREAL" if isinstance(v, float) else "DINT", "", _number(v))
        for n, v in controller.constants.items()
    ]
    tables = [
        (
            n,
            f"ARRAY [0..{len(v) - 1}] OF {'LREAL' if isinstance(v[0], float) else 'DINT'}",
            "",
            _list(v),
        )
        for n, v in controller.tables.items()
    ]
    ring = _globals()

    def used(rows, lines):
        text = "\n".join(lines)
        return [row for row in rows if re.search(rf"\b{row[0]}\b", text)]

    external = [row[:3] for row in ring]
    fast = [line.replace("NABS(", "ABS(") for line in controller.fast]
    begun = [
        (n, kind, what, *([_number(controller.constants[BEGIN[n]])] if n in BEGIN else []))
        for n, kind, what in [*INPUTS, *OUTPUTS, *STATE]
    ]
    inputs, outputs = begun[: len(INPUTS)], begun[len(INPUTS) : len(INPUTS) + len(OUTPUTS)]
    state = begun[len(INPUTS) + len(OUTPUTS) :]
    lines = [("lineTheta", "FB_TimeLine", "integer line of theta"), ("linePhi", "FB_TimeLine", "")]
    first = ["IF NOT bBegun THEN", "    bBegun := TRUE;"]
    for axis in ("Theta", "Phi"):
        ends = f"nStart := nFirst{axis}, nStop := nFirst{axis}, nTicks := 1"
        first += [f"    line{axis}(bLoad := TRUE, {ends});", f"    line{axis}(bLoad := FALSE);"]
    first.append("END_IF;")
    slow = controller.slow
    own = [*used(state, fast), *lines, ("bBegun", "BOOL", "the lines stand at their begin")]
    of_slow = [
        ("VAR_EXTERNAL", used(external, slow)),
        ("VAR CONSTANT", used(constants + tables, slow)),
        ("VAR", used([*OWN, NEXT, *SLOW_STATE], slow)),
    ]
    of_fast = [
        ("VAR_INPUT", inputs),
        ("VAR_OUTPUT", outputs),
        ("VAR_EXTERNAL", used(external, fast)),
        ("VAR CONSTANT", used(constants, fast)),
        ("VAR", own),
    ]
    return [("PRG_Slow", of_slow, slow), ("PRG_Fast", of_fast, [*first, *fast])]


def _globals():
    """Return what both tasks share."""
    return [*SHARED, *((name, RING_TYPE, "") for name in RING_ARRAYS)]


def _periods(controller):
    """Return the intervals of the fast and of the slow task, in ms as all editions write them."""
    return [f"T#{round(1e6 * ticks * controller.tick) / 1000:g}ms" for ticks in (1, 2)]


def _list(values):
    """Return an array's begin in Structured Text."""
    return f"[\n{_rows(values).rstrip().rstrip(',')}]"


def _declared(kind, rows):
    """Return a section of variables: rows of name, type, comment and, perhaps, begin."""
    lines = [kind]
    for name, of, what, *begin in rows:
        value = f" := {begin[0]}" if begin else ""
        comment = f" (* {what} *)" if what else ""
        lines.append(f"    {name} : {of}{value};{comment}")
    return "\n".join([*lines, "END_VAR"])


XML_SECTIONS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_EXTERNAL": "externalVars",
    "VAR": "localVars", "VAR CONSTANT": "localVars",
}  # fmt: skip


def _pou(pous, name, kind, sections, body):
    """Add a program or function block."""
    pou = Xml.SubElement(pous, "pou", name=name, pouType=kind)
    interface = Xml.SubElement(pou, "interface")
    for section, rows in sections:
        if rows:
            found = _variables(interface, XML_SECTIONS[section], rows)
            if section.endswith("CONSTANT"):
                found.set("constant", "true")
    text = Xml.SubElement(Xml.SubElement(Xml.SubElement(pou, "body"), "ST"), "xhtml")
    text.set("xmlns", "http://www.w3.org/1999/xhtml")
    text.text = "\n".join(body)


def _variables(parent, section, rows):
    """Add a section of variables, and return it."""
    found = Xml.SubElement(parent, section)
    for name, of, what, *begin in rows:
        variable = Xml.SubElement(found, "variable", name=name)
        _kind(Xml.SubElement(variable, "type"), of)
        if begin:
            initial = Xml.SubElement(variable, "initialValue")
            if of.startswith("ARRAY"):
                values = Xml.SubElement(initial, "arrayValue")
                for value in re.findall(r"[^\s,\[\]]+", begin[0]):
                    Xml.SubElement(Xml.SubElement(values, "value"), "simpleValue", value=value)
            else:
                Xml.SubElement(initial, "simpleValue", value=begin[0])
        if what:
            text = Xml.SubElement(Xml.SubElement(variable, "documentation"), "xhtml")
            text.set("xmlns", "http://www.w3.org/1999/xhtml")
            text.text = what
    return found


def _kind(parent, of):
    """Add the type of a variable: of a number, an array of numbers, or one that has a name."""
    array = re.fullmatch(r"ARRAY \[0\.\.(\d+)\] OF (\w+)", of)
    if array:
        field = Xml.SubElement(parent, "array")
        Xml.SubElement(field, "dimension", lower="0", upper=array[1])
        Xml.SubElement(Xml.SubElement(field, "baseType"), array[2])
    elif of in ("BOOL", "DINT", "LREAL"):
        Xml.SubElement(parent, of)
    else:
        Xml.SubElement(parent, "derived", name=of)
