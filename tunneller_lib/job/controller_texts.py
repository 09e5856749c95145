"""A `Program` of the controller written out: Structured Text, C99 with its header, PLCopen XML."""

import re
from html import escape

from ..arguments import checked
from ..motion.export import C_HEAD, C_MACROS, KINDS, c99_code, c99_types, read_blocks, read_rows
from .controller import Program

C_USE = """
Once: static FB_Setpoints setpoints; static FB_Tunneller tunneller = FB_TUNNELLER_BEGIN;
      static volatile T_Ring ring;
Slow task: fb_setpoints(&setpoints, &ring);
Each scan: tunneller.bEnable = ...; fb_tunneller(&tunneller, &ring); ... = tunneller.rValveTheta;
"""
XML_WORDS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_EXTERNAL": "externalVars",
    "VAR": "localVars", "VAR CONSTANT": 'localVars constant="true"',
    "PROGRAM": "program", "FUNCTION_BLOCK": "functionBlock",
}  # fmt: skip
XML_ROOT = """project xmlns="http://www.plcopen.org/xml/tc6_0201"
 xmlns:xhtml="http://www.w3.org/1999/xhtml\""""
XML_HEAD = """
<fileHeader creationDateTime="2000-01-01T00:00:00" companyName="" productName="tunneller_lib"
 productVersion="1"/>
<contentHeader name="Tunneller"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd>
<ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
"""


@checked
def c99_header(made: Program):
    """Return the header of a `Program` in C99: contract, types and prototypes.

    Examples
    --------
    >>> made = Program("(* What the valves need. *)", "", slow=4, trip=0.01)
    >>> c99_header(made).splitlines()[0]
    '/* What the valves need. '
    """
    contract = made.text[2 : made.text.index("*)")]
    return (f"/*{contract}{C_USE}*/\n#ifndef CONTROLLER_H\n#define CONTROLLER_H\n"
            f"{C_HEAD}\n{c99_types(_blocks(made))}\n#endif\n")  # fmt: skip


@checked
def c99_text(made: Program):
    """Return a `Program` in C99, which includes its header as controller.h."""
    return f'#include "controller.h"\n{C_MACROS}\n{c99_code(_blocks(made))}'


def _blocks(made):
    """Return the structures and function blocks of a `Program`."""
    return [block for block in read_blocks(made.blocks + made.text) if block.kind != "PROGRAM"]


@checked
def plcopen_xml(made: Program):
    """Return a `Program` in PLCopen XML (TC6, 2.01): the same texts, their variables apart."""
    types, pous = [], []
    for block in read_blocks(made.blocks + made.text):
        if block.kind == "STRUCT":
            fields = _tag("struct", *_variables(block.rows("VAR", "VAR CONSTANT")))
            types.append(_tag("dataType", _tag("baseType", fields), name=block.name))
            continue
        parts = (_tag(XML_WORDS[kind], *_variables(rows)) for kind, rows in block.sections)
        body = _tag("ST", _words(block.body.rstrip("\n")))
        pous.append(_tag("pou", _tag("interface", *parts), _tag("body", body),
                         name=block.name, pouType=XML_WORDS[block.kind]))  # fmt: skip
    tasks = [
        _tag("task", _tag("pouInstance", name=f"{name}Task", typeName=f"PRG_{name}"),
             name=name, interval=interval, priority=priority)
        for name, interval, priority in re.findall(
            r"TASK (\w+)\(INTERVAL := (\S+), PRIORITY := (\d)\)", made.text)
    ]  # fmt: skip
    shared = read_rows(made.text.partition("VAR_GLOBAL")[2].partition("END_VAR")[0])
    configuration = _tag(
        "configuration", _tag("resource", *tasks, name="Controller"),
        _tag("globalVars", *_variables(shared)), name="Tunneller",
    )  # fmt: skip
    return _tag(
        XML_ROOT, XML_HEAD, _tag("types", _tag("dataTypes", *types), _tag("pous", *pous)),
        _tag("instances", _tag("configurations", configuration)),
    )  # fmt: skip


def _tag(name, /, *inside, **attributes):
    """Return an XML element; its name may bring attributes along."""
    given = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"<{name}{given}>{''.join(inside)}</{name.split()[0]}>\n"


def _words(text):
    """Return a text as open readers want it: one paragraph without a division around it."""
    return _tag("xhtml:p", escape(text, quote=False)).rstrip()


def _variables(rows):
    """Yield variables with their types, values and comments."""
    for name, last, kind, begin, comment in rows:
        values = [_tag("simpleValue", value=one) for one in re.findall(r"[^\s,\[\]]+", begin)]
        type_ = _tag(kind) if kind in KINDS else _tag("derived", name=kind)
        if last:
            values = [_tag("arrayValue", *(_tag("value", one) for one in values))]
            size = _tag("dimension", lower=0, upper=last)
            type_ = _tag("array", size, _tag("baseType", type_))
        parts = [_tag("type", type_)]
        parts += [_tag("initialValue", *values)] if begin else []
        parts += [_tag("documentation", _words(comment))] if comment else []
        yield _tag("variable", *parts, name=name)
