"""A `Program` of the controller written out: Structured Text, C99 with its header, PLCopen XML."""

import re
from xml.etree import ElementTree as Xml

from ..arguments import checked
from ..motion.export import C_HEAD, C_MACROS, c99_code, c99_types, read_blocks, read_rows
from .controller import Program

C_USE = """
Once: FB_Setpoints setpoints; FB_Tunneller tunneller; static T_Shared shared;
      fb_setpoints_init(&setpoints); fb_tunneller_init(&tunneller);
In the slow task: fb_setpoints(&setpoints, &shared);
In each scan: tunneller.nActualTheta = ...; tunneller.bEnable = ...;
      fb_tunneller(&tunneller, &shared);
      ... = tunneller.rValveTheta; ... = tunneller.rValvePhi;
"""
XML_SECTIONS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_IN_OUT": "inOutVars",
    "VAR_EXTERNAL": "externalVars", "VAR": "localVars", "VAR CONSTANT": "localVars",
}  # fmt: skip


@checked
def c99_header(made: Program):
    """Return the header of a `Program` in C99: its contract, its types and what is called."""
    shared = next(one for one in _blocks(made) if one.rows("VAR_EXTERNAL")).rows("VAR_EXTERNAL")
    ring = "".join(
        f"    volatile int32_t {row.name}{f'[{made.ring}]' if row.kind != 'DINT' else ''};"
        f"{f' /* {row.comment} */' if row.comment else ''}\n"
        for row in shared
    )
    types = c99_types(_blocks(made))
    contract = made.text[2 : made.text.index("*)")]
    return (f"/*{contract}{C_USE}*/\n#ifndef CONTROLLER_H\n#define CONTROLLER_H\n"
            f"{C_HEAD}\ntypedef struct {{\n{ring}}} T_Shared;\n\n{types}\n#endif\n")  # fmt: skip


@checked
def c99_text(made: Program):
    """Return a `Program` in C99, which includes its header as controller.h."""
    return f'#include "controller.h"\n{C_MACROS}\n{c99_code(_blocks(made))}'


def _blocks(made):
    """Return the function blocks of a `Program`."""
    return [block for block in read_blocks(made.text) if block.kind == "FUNCTION_BLOCK"]


@checked
def plcopen_xml(made: Program):
    """Return a `Program` in PLCopen XML (TC6, 2.01): the same texts, their variables apart."""
    space = "http://www.plcopen.org/xml/tc6_0201"
    when = "2000-01-01T00:00:00"  # the same text whenever it is made
    Xml.register_namespace("xhtml", XHTML)
    project = Xml.Element("project", xmlns=space)
    about = dict(companyName="", productName="tunneller_lib", productVersion="1")
    Xml.SubElement(project, "fileHeader", creationDateTime=when, **about)
    content = Xml.SubElement(project, "contentHeader", name="Tunneller")
    coordinates = Xml.SubElement(content, "coordinateInfo")
    for kind in ("fbd", "ld", "sfc"):
        Xml.SubElement(Xml.SubElement(coordinates, kind), "scaling", x="1", y="1")
    types = Xml.SubElement(project, "types")
    ring = Xml.SubElement(Xml.SubElement(types, "dataTypes"), "dataType", name="T_Ring")
    _kind(Xml.SubElement(ring, "baseType"), f"ARRAY [0..{made.ring - 1}] OF DINT")
    pous = Xml.SubElement(types, "pous")
    for block in read_blocks(made.text):
        kind = "program" if block.kind == "PROGRAM" else "functionBlock"
        pou = Xml.SubElement(pous, "pou", name=block.name, pouType=kind)
        interface = Xml.SubElement(pou, "interface")
        for section, rows in block.sections:
            found = _variables(interface, XML_SECTIONS[section], rows)
            if section.endswith("CONSTANT"):
                found.set("constant", "true")
        _words(Xml.SubElement(Xml.SubElement(pou, "body"), "ST"), "\n".join(block.body))
    instances = Xml.SubElement(Xml.SubElement(project, "instances"), "configurations")
    configuration = Xml.SubElement(instances, "configuration", name="Tunneller")
    resource = Xml.SubElement(configuration, "resource", name="Controller")
    tasks = re.findall(r"TASK (\w+)\(INTERVAL := (\S+), PRIORITY := (\d)\)", made.text)
    for name, interval, priority in tasks:
        task = Xml.SubElement(resource, "task", name=name, interval=interval, priority=priority)
        Xml.SubElement(task, "pouInstance", name=f"{name}Task", typeName=f"PRG_{name}")
    whole = made.text[made.text.index("VAR_GLOBAL") :]
    _variables(configuration, "globalVars", read_rows(whole[: whole.index("END_VAR")]))
    Xml.indent(project)
    return Xml.tostring(project, encoding="unicode", xml_declaration=False) + "\n"


XHTML = "http://www.w3.org/1999/xhtml"


def _words(parent, text):
    """Add a text: open readers look for a paragraph, and find none in a division of text."""
    Xml.SubElement(parent, f"{{{XHTML}}}p").text = text


def _variables(parent, section, rows):
    """Add a section of variables, and return it."""
    found = Xml.SubElement(parent, section)
    for row in rows:
        variable = Xml.SubElement(found, "variable", name=row.name)
        _kind(Xml.SubElement(variable, "type"), row.kind)
        if row.begin:
            initial = Xml.SubElement(variable, "initialValue")
            if row.kind.startswith("ARRAY"):
                values = Xml.SubElement(initial, "arrayValue")
                for value in re.findall(r"[^\s,\[\]]+", row.begin):
                    Xml.SubElement(Xml.SubElement(values, "value"), "simpleValue", value=value)
            else:
                Xml.SubElement(initial, "simpleValue", value=row.begin)
        if row.comment:
            _words(Xml.SubElement(variable, "documentation"), row.comment)
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
