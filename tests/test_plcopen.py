"""The PLCopen XML as open readers want it, and the numbers and names of the exported texts.

Beremiz' reader and OpenPLC's xml2st look for one paragraph of XHTML where text is, and refuse what
has no variables or no body. `make plc` tries both; here is what they need.
"""

import re
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.controllers import random_jobs, with_program
from tests.structured_text import IEC_KEYWORDS
from tunneller_lib.job import read_job
from tunneller_lib.job.controller_texts import plcopen_xml
from tunneller_lib.motion.export import _number as number

READS = ["tests/references/reference_job.toml", "tunneller_lib/job/*", "tunneller_lib/motion/*"]

REFERENCE_JOB = Path(__file__).parent / "references" / "reference_job.toml"
PLC, XHTML = "{http://www.plcopen.org/xml/tc6_0201}", "{http://www.w3.org/1999/xhtml}"
# IEC 61131-3, B.1.2.1: digits on both sides of the point, an exponent only behind them.
WHOLE = r"-?\d+"
REAL = r"-?\d+\.\d+(?:[eE][-+]?\d+)?"
SECTIONS = {
    "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_EXTERNAL": "externalVars",
    "VAR": "localVars", "VAR CONSTANT": "localVars",
}  # fmt: skip
JOBS = ("the reference job", "oil, corrected chords, two laps", "a random job")


@cache
def made(name):
    """Return the `Program` of a job of that name."""
    whole = read_job(REFERENCE_JOB)
    if name == JOBS[0]:
        return with_program(whole)
    if name == JOBS[1]:
        controller = {**whole.controller, "plant": "T3"}
        plan = {**whole.plan, "path": "corrected chord", "laps": 2}
        return with_program(replace(whole, controller=controller, plan=plan))
    for wanted in random_jobs(21):
        with suppress(ValueError):
            return with_program(wanted)


@pytest.fixture(params=JOBS)
def texts(request):
    """The XML's root and the Structured Text of a job."""
    found = made(request.param)
    return Xml.fromstring(plcopen_xml(found)), found.text


def local(element):
    return element.tag.removeprefix(PLC)


def without_comments(text):
    return re.sub(r"\(\*.*?\*\)", "", text, flags=re.S)


def units(text):
    """Yield name, sections and body of each block and program of a text."""
    for found in re.finditer(r"^(FUNCTION_BLOCK|PROGRAM) (\w+)\n(.*?)\nEND_\1$", text, re.M | re.S):
        head, _, body = found[3].rpartition("\nEND_VAR\n")
        yield found[2], f"{head}\nEND_VAR\n", body


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
        assert (local(span), local(of)) == ("dimension", "baseType")
        return f"ARRAY [{span.get('lower')}..{span.get('upper')}] OF {kind_of(of)}"
    return inner.get("name") if local(inner) == "derived" else local(inner)


def value_of(variable):
    """Return an initial value of the XML as the Structured Text has it."""
    initial = variable.find(f"{PLC}initialValue")
    if initial is None:
        return ""
    (inner,) = initial
    if local(inner) == "simpleValue":
        return inner.get("value")
    rows = [value[0].get("value") for value in inner]
    return f"[{', '.join(rows)}]"


def test_text_is_one_paragraph_in_each_st_and_documentation_and_nowhere_else(texts):
    root, _ = texts
    parents = {id(child): parent for parent in root.iter() for child in parent}
    foreign = [one for one in root.iter() if not one.tag.startswith(PLC)]
    assert foreign and {one.tag for one in foreign} == {f"{XHTML}p"}
    holders = [parents[id(one)] for one in foreign]
    assert {local(one) for one in holders} == {"ST", "documentation"}
    with_text = [one for one in root.iter() if local(one) in ("ST", "documentation")]
    assert len(holders) == len(with_text)
    for one in with_text:
        (paragraph,) = one
        assert paragraph.text.strip() and len(paragraph) == 0 and not paragraph.attrib
        assert not (one.text or "").strip() and not (paragraph.tail or "").strip()
    # Nothing but these has text of its own.
    assert not [one for one in root.iter() if one not in foreign and (one.text or "").strip()]


def test_every_unit_has_variables_and_a_body_and_they_come_in_the_schemes_order(texts):
    root, _ = texts
    assert [local(one) for one in root] == ["fileHeader", "contentHeader", "types", "instances"]
    pous = list(root.iter(f"{PLC}pou"))
    assert len(pous) == 6
    for pou in pous:
        assert [local(one) for one in pou] == ["interface", "body"]
        (body,) = pou.find(f"{PLC}body")
        assert local(body) == "ST" and ";" in body[0].text
        for section in pou.find(f"{PLC}interface"):
            assert len(section) > 0
    order = ["type", "initialValue", "documentation"]
    for variable in root.iter(f"{PLC}variable"):
        parts = [local(one) for one in variable]
        assert parts == [one for one in order if one in parts] and parts[0] == "type"
    (configuration,) = root.iter(f"{PLC}configuration")
    assert [local(one) for one in configuration] == ["resource", "globalVars"]


def test_types_are_elementary_or_declared_before(texts):
    root, _ = texts
    (types,) = root.iter(f"{PLC}types")
    assert [local(one) for one in types] == ["dataTypes", "pous"]
    known = {"BOOL", "DINT", "LREAL"}
    for structure in root.iter(f"{PLC}dataType"):
        for kind in map(kind_of, structure.iter(f"{PLC}type")):
            assert re.sub(r"^ARRAY \[0\.\.\d+\] OF ", "", kind) in known, kind
        known.add(structure.get("name"))
    for pou in root.iter(f"{PLC}pou"):
        for kind in map(kind_of, pou.iter(f"{PLC}type")):
            assert re.sub(r"^ARRAY \[0\.\.\d+\] OF ", "", kind) in known, kind
        if pou.get("pouType") == "functionBlock":
            known.add(pou.get("name"))
    # Instances are derived types, not elements of a name that no scheme has.
    instances = {"FB_Line", "FB_Loop", "FB_Setpoints", "FB_Tunneller"}
    structures = {"T_Setpoint", "T_Ring"}
    assert {one.get("name") for one in root.iter(f"{PLC}derived")} == instances | structures


def test_xml_has_the_texts_and_variables_of_the_structured_text(texts):
    root, text = texts
    for structure in root.iter(f"{PLC}dataType"):
        head = f"\n    {structure.get('name')} : STRUCT\n"
        rows = text[text.index(head) + len(head) :].partition("    END_STRUCT;\n")[0]
        assert [("VAR", one.get("name"), kind_of(one[0]), value_of(one))
                for one in structure.iter(f"{PLC}variable")] == (
            declared(f"VAR\n{rows}END_VAR"))  # fmt: skip
    pous = {pou.get("name"): pou for pou in root.iter(f"{PLC}pou")}
    found = list(units(text))
    assert [name for name, *_ in found] == list(pous) and len(found) == 6
    for name, head, body in found:
        pou = pous[name]
        assert next(pou.iter(f"{XHTML}p")) is not None
        assert pou.find(f"{PLC}body/{PLC}ST/{XHTML}p").text == body
        rows = []
        for section in pou.find(f"{PLC}interface"):
            rows += [(local(section), section.get("constant") == "true", one.get("name"),
                      kind_of(one[0]), value_of(one)) for one in section]  # fmt: skip
        assert rows == [(SECTIONS[section], section.endswith("CONSTANT"), *row)
                        for section, *row in declared(head)]  # fmt: skip
    configuration = text[text.index("\nCONFIGURATION ") :]
    (shared,) = root.iter(f"{PLC}globalVars")
    assert [("VAR_GLOBAL", one.get("name"), kind_of(one[0]), value_of(one)) for one in shared] == (
        declared(configuration)
    )
    tasks = [(one.get("name"), one.get("interval"), one.get("priority"), one[0].get("name"),
              one[0].get("typeName")) for one in root.iter(f"{PLC}task")]  # fmt: skip
    assert [name for name, *_ in tasks] == ["Fast", "Slow"]
    for name, interval, priority, instance, kind in tasks:
        assert f"TASK {name}(INTERVAL := {interval}, PRIORITY := {priority});" in configuration
        assert f"PROGRAM {instance} WITH {name} : {kind};" in configuration


def test_external_variables_are_the_globals_one_a_line(texts):
    # The grammar has a list of names for VAR and VAR_GLOBAL, and one name for VAR_EXTERNAL.
    _, text = texts
    shared = {row[1:] for row in declared(text[text.index("\nCONFIGURATION ") :])}
    rows = re.findall(r"^VAR_EXTERNAL\n(.*?)END_VAR$", text, re.M | re.S)
    assert len(rows) == 2
    for line in "".join(rows).splitlines():
        name, kind = re.fullmatch(r" {4}(\w+) : (\w+);(?: \(\*.*\*\))?", line).groups()
        assert (name, kind, "") in shared


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(-5e-05)
@example(1e22)
@example(-0.0)
def test_any_float_is_a_legal_literal_and_the_same_number(value):
    text = number(value)
    assert re.fullmatch(REAL, text)
    assert float(text).hex() == value.hex()


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=40))
def test_a_list_is_its_numbers_in_order(values):
    text = number(values)
    assert text[0] == "[" and text[-1] == "]"
    rows = [one.strip() for one in text[1:-1].split(",")]
    assert all(re.fullmatch(REAL, one) for one in rows)
    assert [float(one).hex() for one in rows] == [value.hex() for value in values]


def test_every_number_of_the_texts_is_legal_and_of_its_variables_type(texts):
    root, text = texts
    plain = re.sub(r"\bT#\S+ms\b", "", without_comments(text)).replace("..", " .. ")
    numbers = re.findall(r"(?<![\w.])\.?\d[\w.]*(?:(?<=[eE])[-+]\d+)?", plain)
    assert len(numbers) > 100
    wrong = [one for one in numbers if not re.fullmatch(f"{WHOLE}|{REAL}", one)]
    assert not wrong
    assert all(int(one) < 2**31 for one in numbers if re.fullmatch(WHOLE, one))
    for variable in root.iter(f"{PLC}variable"):
        kind = kind_of(variable[0]).split()[-1]
        for value in variable.iter(f"{PLC}simpleValue"):
            assert re.fullmatch(
                {"DINT": WHOLE, "LREAL": REAL, "BOOL": "TRUE|FALSE"}[kind], value.get("value")
            )
    for length, values in re.findall(r"ARRAY \[0\.\.(\d+)\] OF \w+ := \[([^]]*)\]", text):
        assert values.count(",") == int(length)


@pytest.mark.parametrize("tick", [1e-3, 7e-4, 1e-3 / 3, 2.5e-3, 4.1e-3, 4.7e-3, 12.3e-3])
def test_intervals_are_the_ticks_even_where_they_are_read_in_single_precision(tick):
    """As iec2c does, and truncates to ns; one ns off, and the tasks have no tick in common."""
    whole = read_job(REFERENCE_JOB)
    controller = {**whole.controller, "operations": 1e9, "trip": 0.1}
    plan = {**whole.plan, "tick": tick}
    found = with_program(replace(whole, controller=controller, plan=plan))
    texts = re.findall(r"INTERVAL := T#(\d+(?:\.\d+)?)ms,", found.text)
    wanted = [many * round(1e9 * tick) for many in (1, found.slow)]
    for read in (np.float32, np.float64):
        assert [int(float(read(text)) * 1e6) for text in texts] == wanted
    assert [round(1e6 * float(text)) for text in texts] == wanted


def test_branches_and_loops_are_closed_by_their_own_ends(texts):
    for name, _, body in units(texts[1]):
        statements, open_ = without_comments(body), []
        for end, word in re.findall(r"\b(END_)?(IF|WHILE|FOR)\b", statements):
            assert open_.pop() == word if end else not open_.append(word), name
        assert not open_
        heads = len(re.findall(r"\b(?:ELS)?IF\b", statements))
        assert len(re.findall(r"\bTHEN$", statements, re.M)) == heads
        assert (
            "FOR " not in statements
        )  # one compiler runs no call of it where its bounds are equal


def test_names_are_short_free_and_unique_within_a_block_whatever_their_case(texts):
    root, _ = texts
    own = [one.get("name") for kind in ("pou", "dataType", "configuration", "resource", "task",
           "pouInstance") for one in root.iter(f"{PLC}{kind}")]  # fmt: skip
    blocks = [own]
    for one in (*root.iter(f"{PLC}pou"), *root.iter(f"{PLC}dataType")):
        blocks.append([row.get("name") for row in one.iter(f"{PLC}variable")])
    (shared,) = root.iter(f"{PLC}globalVars")
    blocks.append([one.get("name") for one in shared])
    for names in blocks:
        upper = [name.upper() for name in names]
        assert len(set(upper)) == len(upper), names
        assert not set(upper) & IEC_KEYWORDS
        for name in names:
            assert re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) and len(name) <= 24
