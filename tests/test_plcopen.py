"""The PLCopen XML as open readers want it, and the numbers and names of the exported texts.

Beremiz' reader and OpenPLC's xml2st look for one paragraph of XHTML where text is, and refuse what
has no variables or no body. `make plc` tries both; here is what they need.
"""

import re
from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.controllers import random_jobs, with_program
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
KEYWORDS = set(
    """ACTION ARRAY AT BY CASE CONFIGURATION CONSTANT CONTINUE DO ELSE ELSIF EN END_ACTION END_CASE
    END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_PROGRAM END_REPEAT
    END_RESOURCE END_STEP END_STRUCT END_TRANSITION END_TYPE END_VAR END_WHILE ENO EXIT FALSE FINAL
    FOR FROM FUNCTION FUNCTION_BLOCK F_EDGE IF INITIAL_STEP INTERVAL NON_RETAIN NULL OF ON OVERRIDE
    PRIORITY PROGRAM READ_ONLY READ_WRITE REF REPEAT RESOURCE RETAIN RETURN R_EDGE SINGLE STEP
    STRUCT TASK THEN THIS TO TRANSITION TRUE TYPE UNTIL USING VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL
    VAR_GLOBAL VAR_INPUT VAR_IN_OUT VAR_OUTPUT VAR_TEMP WHILE WITH ANY ANY_NUM ANY_REAL ANY_INT BOOL
    BYTE CHAR DATE DATE_AND_TIME DINT DT DWORD INT LINT LREAL LTIME LWORD REAL SINT STRING TIME TOD
    UDINT UINT ULINT USINT WCHAR WORD WSTRING ABS ACOS ADD AND ASIN ATAN ATAN2 CONCAT COS DELETE DIV
    EQ EXP EXPT FIND GE GT INSERT LE LEFT LEN LIMIT LN LOG LT MAX MID MIN MOD MOVE MUL MUX NE NOT OR
    REPLACE RIGHT ROL ROR SEL SHL SHR SIN SQRT SUB TAN TRUNC XOR CTD CTU CTUD F_TRIG RS RTC R_TRIG
    SEMA SR TOF TON TP ANDN CAL CALC CALCN JMP JMPC JMPCN LD LDN ORN R RET RETC RETCN S ST STN
    XORN""".split()
)
JOBS = ("the reference job", "oil, corrected chords, two laps", "random 1", "random 2", "random 3")


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
    return random_programs()[int(name[-1]) - 1]


@cache
def random_programs():
    def kept():
        for wanted in random_jobs(21):
            with suppress(ValueError):
                yield with_program(wanted)

    return list(islice(kept(), 3))


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
def test_any_float_is_a_legal_literal_and_the_same_number(value):
    text = number(value)
    assert re.fullmatch(REAL, text)
    assert float(text).hex() == value.hex()


@pytest.mark.parametrize("value", [5e-05, -5e-05, 1e22, -1e22, 5e-324, 1.7976931348623157e308, -0.0,
                                   0.1, 1e16, 123456789012345680.0])  # fmt: skip
def test_floats_whose_shortest_form_has_no_point_are_legal_literals(value):
    assert re.fullmatch(REAL, number(value)) and float(number(value)).hex() == value.hex()


@given(st.integers(-(2**31), 2**31 - 1))
def test_any_whole_number_is_a_legal_literal_and_the_same_number(value):
    assert re.fullmatch(WHOLE, number(value)) and int(number(value)) == value


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


def test_branches_and_loops_are_balanced_and_indented_as_they_are_nested(texts):
    _, text = texts
    ends = {"END_IF;": "IF", "END_WHILE;": "WHILE"}
    for name, _, body in units(text):
        lines = without_comments(body).splitlines()
        assert body.count("(*") == body.count("*)")
        stack, seen, begun = [], 0, ""
        for line in lines:
            word = line.strip().partition(" ")[0]
            if not word:
                continue
            if begun:  # a statement goes on
                assert len(line) - len(line.lstrip()) == 4 * len(stack) + 4, (name, line)
            elif word in ends:
                assert stack.pop() == ends[word], (name, line)
            elif word in ("ELSE", "ELSIF"):
                assert stack[-1] == "IF", (name, line)
            if not begun:
                depth = len(stack) - (word in ("ELSE", "ELSIF"))
                assert len(line) - len(line.lstrip()) == 4 * depth, (name, line)
            begun = f"{begun} {line.strip()}".strip()
            if re.search(r"(;| THEN| DO|^ELSE)$", begun):
                assert begun.count("(") == begun.count(")"), (name, begun)
                assert begun.count("[") == begun.count("]"), (name, begun)
                if re.match(r"(IF|WHILE)\b", begun):
                    stack.append(begun.split()[0])
                    seen += 1
                begun = ""
        assert not stack and not begun, name
        counted = {end: len(re.findall(rf"\b{end}\b", without_comments(body)))
                   for end in ("IF", "END_IF", "WHILE", "END_WHILE", "FOR")}  # fmt: skip
        assert counted["IF"] == counted["END_IF"] and counted["WHILE"] == counted["END_WHILE"]
        assert seen == counted["IF"] + counted["WHILE"]
        assert counted["FOR"] == 0  # one compiler runs no call of it where its bounds are equal


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
        assert not set(upper) & KEYWORDS
        for name in names:
            assert re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) and len(name) <= 24
