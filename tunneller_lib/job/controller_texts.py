"""A `Program` of the controller written out: Structured Text, C99 with its header, PLCopen XML."""

import re
from html import escape

from ..arguments import checked
from ..motion.export import C_HEAD, C_MACROS, c99_code, c99_types, read_blocks, read_rows
from .controller import Program

C_USE = """
Once: static FB_Setpoints setpoints = FB_SETPOINTS_BEGIN;
      static FB_Tunneller tunneller = FB_TUNNELLER_BEGIN;
      static volatile T_Ring ring;
In the slow task: fb_setpoints(&setpoints, &ring);
In each scan: tunneller.nActualTheta = ...; tunneller.bEnable = ...;
      fb_tunneller(&tunneller, &ring);
      ... = tunneller.rValveTheta; ... = tunneller.rValvePhi;
"""
XML_SECTIONS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_EXTERNAL": "externalVars",
    "VAR": "localVars", "VAR CONSTANT": 'localVars constant="true"',
}  # fmt: skip
XML_HEAD = """<project xmlns="http://www.plcopen.org/xml/tc6_0201"
 xmlns:xhtml="http://www.w3.org/1999/xhtml">
<fileHeader creationDateTime="2000-01-01T00:00:00" companyName="" productName="tunneller_lib"
 productVersion="1"/>
<contentHeader name="Tunneller"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd>
<ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
"""


@checked
def c99_header(made: Program):
    """Return the header of a `Program` in C99: its contract, its types and what is called."""
    contract = made.text[2 : made.text.index("*)")]
    return (f"/*{contract}{C_USE}*/\n#ifndef CONTROLLER_H\n#define CONTROLLER_H\n"
            f"{C_HEAD}\n{c99_types(_blocks(made))}\n#endif\n")  # fmt: skip


@checked
def c99_text(made: Program):
    """Return a `Program` in C99, which includes its header as controller.h."""
    return f'#include "controller.h"\n{C_MACROS}\n{c99_code(_blocks(made))}'


def _blocks(made):
    """Return the structures and function blocks of a `Program`."""
    return [block for block in read_blocks(made.text) if block.kind != "PROGRAM"]


@checked
def plcopen_xml(made: Program):
    """Return a `Program` in PLCopen XML (TC6, 2.01): the same texts, their variables apart."""
    types, pous = [], []
    for block in read_blocks(made.text):
        if block.kind == "STRUCT":
            types += [f'<dataType name="{block.name}"><baseType><struct>',
                      *_variables(block.rows("VAR")),
                      "</struct></baseType></dataType>"]  # fmt: skip
            continue
        kind = "program" if block.kind == "PROGRAM" else "functionBlock"
        pous += [f'<pou name="{block.name}" pouType="{kind}">', "<interface>"]
        for section, rows in block.sections:
            name = XML_SECTIONS[section]
            pous += [f"<{name}>", *_variables(rows), f"</{name.partition(' ')[0]}>"]
        body = _words("\n".join(block.body))
        pous += ["</interface>", f"<body><ST>{body}</ST></body>", "</pou>"]
    tasks = [
        f'<task name="{name}" interval="{interval}" priority="{priority}">'
        f'<pouInstance name="{name}Task" typeName="PRG_{name}"/></task>'
        for name, interval, priority in re.findall(
            r"TASK (\w+)\(INTERVAL := (\S+), PRIORITY := (\d)\)", made.text
        )
    ]
    shared = made.text.partition("VAR_GLOBAL")[2].partition("END_VAR")[0]
    return "\n".join([
        XML_HEAD, "<types><dataTypes>", *types, "</dataTypes><pous>", *pous, "</pous></types>",
        '<instances><configurations><configuration name="Tunneller">',
        '<resource name="Controller">', *tasks, "</resource><globalVars>",
        *_variables(read_rows(shared)),
        "</globalVars></configuration></configurations></instances>", "</project>", "",
    ])  # fmt: skip


def _words(text):
    """Return a text as open readers look for it: as a paragraph, not in a division of text."""
    return f"<xhtml:p>{escape(text, quote=False)}</xhtml:p>"


def _variables(rows):
    """Yield variables with their types, values and comments, one a line."""
    for name, kind, begin, comment in rows:
        value = f'<simpleValue value="{begin}"/>'
        if kind.startswith("ARRAY"):
            values = re.findall(r"[^\s,\[\]]+", begin)
            value = "".join(f'<value><simpleValue value="{one}"/></value>' for one in values)
            value = f"<arrayValue>{value}</arrayValue>"
        value = f"<initialValue>{value}</initialValue>" if begin else ""
        about = f"<documentation>{_words(comment)}</documentation>" if comment else ""
        yield f'<variable name="{name}"><type>{_kind(kind)}</type>{value}{about}</variable>'


def _kind(of):
    """Return the type of a variable: a number, one that has a name, or an array of either."""
    array, last, kind = re.fullmatch(r"(ARRAY \[0\.\.(\d+)\] OF )?(\w+)", of).groups()
    one = f"<{kind}/>" if kind in ("BOOL", "DINT", "LREAL") else f'<derived name="{kind}"/>'
    if array:
        one = f'<dimension lower="0" upper="{last}"/><baseType>{one}</baseType>'
    return f"<array>{one}</array>" if array else one
