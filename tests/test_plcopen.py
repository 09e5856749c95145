"""The PLCopen XML as open readers want it, and the numbers and names of the exported texts.

Beremiz' reader and OpenPLC's xml2st look for one paragraph of XHTML where text is, and refuse what
has no variables or no body. `make plc` tries both; here is what they need.
"""

import re
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.controllers import job_with, with_program
from tests.structured_text import IEC_KEYWORDS
from tunneller_lib.job.controller_texts import plcopen_xml
from tunneller_lib.motion.export import _number

READS = ["tests/references/reference_job.toml", "tunneller_lib/job/*", "tunneller_lib/motion/*"]

PLC, XHTML = "{http://www.plcopen.org/xml/tc6_0201}", "{http://www.w3.org/1999/xhtml}"
# IEC 61131-3, B.1.2.1: digits on both sides of the point, an exponent only behind them.
LEGAL = {"DINT": r"-?\d+", "LREAL": r"-?\d+\.\d+(?:[eE][-+]?\d+)?", "BOOL": "TRUE|FALSE"}
SECTIONS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_EXTERNAL": "externalVars",
    "VAR": "localVars", "VAR CONSTANT": "localVars", "VAR_GLOBAL": "globalVars",
}  # fmt: skip
JOBS = {
    "the reference job": {},
    "oil, corrected chords, two laps": {
        "controller": {"plant": "T3"}, "plan": {"path": "corrected chord", "laps": 2}
    },
}  # fmt: skip


@pytest.fixture(scope="module", params=JOBS)
def texts(request):
    """The XML's root and the whole Structured Text of a job."""
    made = with_program(job_with(**JOBS[request.param]))
    include = '{#include "blocks.st"}\n'
    assert made.text.count(include) == 1
    return Xml.fromstring(plcopen_xml(made)), made.text.replace(include, made.blocks)


def local(element):
    return element.tag.removeprefix(PLC)


def without_comments(text):
    return re.sub(r"\(\*.*?\*\)", "", text, flags=re.S)


def units(text):
    """Yield name, variables and body of each block and program of a text."""
    for found in re.finditer(r"^(FUNCTION_BLOCK|PROGRAM) (\w+)\n(.*?)\nEND_\1$", text, re.M | re.S):
        head, _, body = found[3].rpartition("\nEND_VAR\n")
        yield found[2], declared(f"{head}\nEND_VAR\n"), body


def declared(head):
    """Return section, name, type and value of each variable of a block's head."""
    found = []
    for section, rows in re.findall(r"^(VAR[^\n]*)\n(.*?)END_VAR$", head, re.M | re.S):
        for names, kind, begin in re.findall(r"([\w, ]+) : ([^:;]+?)(?: := ([^;]+))?;",
                                             without_comments(rows)):  # fmt: skip
            found += [(section, name, kind, " ".join(begin.split()))
                      for name in names.strip().split(", ")]  # fmt: skip
    return found


def kind_of(parent):
    """Return a type of the XML as the Structured Text has it."""
    (inner,) = parent
    if local(inner) == "array":
        span, of = inner
        return f"ARRAY [{span.get('lower')}..{span.get('upper')}] OF {kind_of(of)}"
    return inner.get("name") if local(inner) == "derived" else local(inner)


def value_of(variable):
    """Return an initial value of the XML as the Structured Text has it, or nothing."""
    initial = variable.find(f"{PLC}initialValue")
    if initial is None:
        return ""
    (inner,) = initial
    if local(inner) == "simpleValue":
        return inner.get("value")
    return f"[{', '.join(value[0].get('value') for value in inner)}]"


def listed(variables):
    """Return name, type and value of variables of the XML."""
    return [(one.get("name"), kind_of(one[0]), value_of(one)) for one in variables]


def test_text_is_one_paragraph_in_each_st_and_documentation_and_nowhere_else(texts):
    root, _ = texts
    with_text = [one for one in root.iter() if local(one) in ("ST", "documentation")]
    paragraphs = [one for one in root.iter() if not one.tag.startswith(PLC)]
    assert {one.tag for one in paragraphs} == {f"{XHTML}p"}
    assert [[*one] for one in with_text] == [[one] for one in paragraphs]
    assert all(one.text.strip() and not len(one) and not one.attrib for one in paragraphs)
    others = [one.text for one in root.iter() if one not in paragraphs]
    assert not "".join([*filter(None, others), *(one.tail or "" for one in root.iter())]).strip()


def test_every_unit_has_variables_and_a_body_and_they_come_in_the_schemes_order(texts):
    root, _ = texts
    assert [local(one) for one in root] == ["fileHeader", "contentHeader", "types", "instances"]
    for pou in root.iter(f"{PLC}pou"):
        assert [local(one) for one in pou] == ["interface", "body"]
        assert all(len(section) > 0 for section in pou[0])
        assert local(pou[1][0]) == "ST" and ";" in pou[1][0][0].text
    order = ["type", "initialValue", "documentation"]
    for variable in root.iter(f"{PLC}variable"):
        parts = [local(one) for one in variable]
        assert parts == [one for one in order if one in parts] and parts[0] == "type"
    (configuration,) = root.iter(f"{PLC}configuration")
    assert [local(one) for one in configuration] == ["resource", "globalVars"]


def test_xml_has_the_texts_and_variables_of_the_structured_text(texts):
    root, text = texts
    for structure in root.iter(f"{PLC}dataType"):
        rows = text.partition(f"\n    {structure.get('name')} : STRUCT\n")[2]
        rows = declared(f"VAR\n{rows.partition('    END_STRUCT;')[0]}END_VAR")
        assert listed(structure.iter(f"{PLC}variable")) == [row[1:] for row in rows]
    pous = {pou.get("name"): pou for pou in root.iter(f"{PLC}pou")}
    found = list(units(text))
    assert [name for name, *_ in found] == list(pous) and len(found) == 6
    for name, variables, body in found:
        assert pous[name].find(f"{PLC}body/{PLC}ST/{XHTML}p").text == body
        rows = [(local(section), section.get("constant") == "true", *row)
                for section in pous[name][0] for row in listed(section)]  # fmt: skip
        assert rows == [(SECTIONS[section], section.endswith("CONSTANT"), *row)
                        for section, *row in variables]  # fmt: skip
    configuration = text[text.index("\nCONFIGURATION ") :]
    (shared,) = root.iter(f"{PLC}globalVars")
    assert listed(shared) == [row[1:] for row in declared(configuration)]
    tasks = list(root.iter(f"{PLC}task"))
    assert [one.get("name") for one in tasks] == ["Fast", "Slow"]
    assert [one.get("priority") for one in tasks] == ["0", "1"]  # 0 is the most urgent
    for one in tasks:
        name, interval, priority = map(one.get, ("name", "interval", "priority"))
        assert f"TASK {name}(INTERVAL := {interval}, PRIORITY := {priority});" in configuration
        instance, kind = one[0].get("name"), one[0].get("typeName")
        assert f"PROGRAM {instance} WITH {name} : {kind};" in configuration


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=40))
@example([-5e-05, 1e22, -0.0])
def test_any_floats_are_legal_literals_and_the_same_numbers(values):
    rows = [one.strip() for one in _number(values).strip("[]").split(",")]
    assert all(re.fullmatch(LEGAL["LREAL"], one) for one in rows)
    assert [float(one).hex() for one in rows] == [value.hex() for value in values]


def test_every_number_of_the_texts_is_legal_and_of_its_variables_type(texts):
    root, text = texts
    plain = re.sub(r"\bT#\S+ms\b", "", without_comments(text)).replace("..", " .. ")
    numbers = re.findall(r"(?<![\w.])\.?\d[\w.]*(?:(?<=[eE])[-+]\d+)?", plain)
    assert len(numbers) > 100
    for one in numbers:
        assert re.fullmatch(f"{LEGAL['DINT']}|{LEGAL['LREAL']}", one)
        assert not one.isdigit() or int(one) < 2**31
    for variable in root.iter(f"{PLC}variable"):
        kind = kind_of(variable[0]).split()[-1]
        for value in variable.iter(f"{PLC}simpleValue"):
            assert re.fullmatch(LEGAL[kind], value.get("value"))
    for length, values in re.findall(r"ARRAY \[0\.\.(\d+)\] OF \w+ := \[([^]]*)\]", text):
        assert values.count(",") == int(length)


@pytest.mark.parametrize("tick", [1e-3, 7e-4, 1e-3 / 3, 2.5e-3, 4.1e-3, 4.7e-3, 12.3e-3])
def test_intervals_are_the_ticks_even_where_they_are_read_in_single_precision(tick):
    """As iec2c does, and truncates to ns; one ns off, and the tasks have no tick in common."""
    controller = {"plant": "T0", "operations": 1e9, "trip": 0.1}
    fast = {"feed": 0.3, "acceleration": 3.0}
    found = with_program(job_with(controller=controller, limits=fast, plan={"tick": tick}))
    texts = re.findall(r"INTERVAL := T#(\d+(?:\.\d+)?)ms,", found.text)
    wanted = [many * round(1e9 * tick) for many in (1, found.slow)]
    for read in (np.float32, np.float64):
        assert [int(float(read(text)) * 1e6) for text in texts] == wanted
    assert [round(1e6 * float(text)) for text in texts] == wanted


def test_names_are_short_free_and_unique_within_a_block_whatever_their_case(texts):
    root, _ = texts
    named = "pou", "dataType", "configuration", "resource", "task", "pouInstance"
    scopes = [[one for kind in named for one in root.iter(f"{PLC}{kind}")]]
    scopes += [list(one.iter(f"{PLC}variable")) for kind in ("pou", "dataType", "globalVars")
               for one in root.iter(f"{PLC}{kind}")]  # fmt: skip
    for scope in scopes:
        names = [one.get("name") for one in scope]
        upper = {name.upper() for name in names}
        assert len(upper) == len(names) and not upper & IEC_KEYWORDS
        for name in names:
            assert re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) and len(name) <= 24
