"""Plant faults in words, one at a time, and see whether the tests notice: `make words`.

A fault changes a verdict, the proof of a row, a sign in a displayed equation, "closer" of a record
into "farther", a number into another one of its notebook and unit, or an output in the README.
Which ones is drawn with a seed. Each is judged in a copy of the checkout, under build/words, by the
tests of its kind. The comparison of the PDFs with what they are made from judges nothing: it
compares a text with a copy of itself. The result is tests/audit/text_faults.csv, with the score of
each kind in its head.

What no test sees, and nobody plants here: another meaning of words that compare nothing, "at most"
for "at least" beside a number, a figure under the caption of another. text_faults_by_hand.csv has
such faults, planted in sentences by hand, and what in the document contradicts each.
"""

import argparse
import csv
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from report.tests.prose import NUMBER, sources
from report.tests.typst_math import tokens
from tests.audit.long import judged
from tests.audit.typeset_faults import faults as equation_faults

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "words"
TABLE = ROOT / "tests" / "audit" / "text_faults.csv"
REASONS = ROOT / "tests" / "audit" / "text_faults.toml"
COLUMNS = ["kind", "file", "before", "after", "noticed by"]
SEED = "tunneller"
EACH = 15  # faults of a kind

DOCUMENTS = ("tunneller", "line-cylinder", "cone-envelopes")
VERDICTS = ("holds", "imprecise", "corrected", "refuted", "ambiguous", "not reproduced")
ORDERS = {
    "closer": "farther", "shorter": "longer", "longer": "shorter", "fewer": "more", "more": "less",
    "less": "more", "smaller": "larger", "larger": "smaller", "better": "worse", "worse": "better",
    "best": "worst", "faster": "slower", "slower": "faster", "greater": "less",
    "most": "least", "least": "most", "farther": "closer", "never": "always",
}  # fmt: skip


@dataclass(frozen=True)
class Fault:
    """Words of a file put in the place of others; `tests` are pytest's arguments."""

    kind: str
    file: str
    before: str
    after: str
    text: str
    tests: tuple


def read(file):
    return (ROOT / file).read_text(encoding="utf-8")


def ledgers():
    return [f"report/ledger/{document}.toml" for document in DOCUMENTS]


def verdict_faults(rng):
    """Another verdict for a row, its neighbours' more often: softened or sharpened."""
    for file in rng.sample(ledgers() * EACH, EACH):
        text = read(file)
        name, row = rng.choice(sorted(tomllib.loads(text).items()))
        new = rng.choice([word for word in VERDICTS if word != row["verdict"]])
        place = text.index(f"[{name}]")
        start = text.index(f'verdict = "{row["verdict"]}"', place)
        old = f'verdict = "{row["verdict"]}"'
        changed = text[:start] + f'verdict = "{new}"' + text[start + len(old) :]
        yield Fault("verdict", file, f"{name}: {row['verdict']}", new, changed,
                    (row["proof"], "report/tests/test_ledger.py"))  # fmt: skip


def proof_faults(rng):
    """The proofs of two rows exchanged."""
    for file in rng.sample(ledgers() * EACH, EACH):
        text = read(file)
        rows = tomllib.loads(text)
        while True:
            one, other = rng.sample(sorted(rows), 2)
            first, second = rows[one]["proof"], rows[other]["proof"]
            if first != second and rows[one]["verdict"] == rows[other]["verdict"]:
                break
        changed = text.replace(f'"{first}"', '"@"').replace(f'"{second}"', f'"{first}"')
        yield Fault("proof", file, f"{one}: {first.partition('::')[2]}", second.partition("::")[2],
                    changed.replace('"@"', f'"{second}"'),
                    ("report/tests/test_ledger.py", *sorted([first, second])))  # fmt: skip


def equations(rng):
    """A sign, an index, an exponent or a coefficient of a displayed equation."""
    file = "report/equations.toml"
    text = read(file)
    entries = tomllib.loads(text)
    for name in rng.sample(sorted(entries), EACH):
        right = entries[name]["right"]
        kind, place, changed = rng.choice(equation_faults(right, rng))
        new = " ".join(token.text for token in changed)
        start = text.index(right, text.index(f"[{name}]"))
        yield Fault("equation", file, f"{name}: {tokens(right)[place].text} ({kind})", new,
                    text[:start] + new + text[start + len(right) :],
                    ("report/tests/test_typeset.py",))  # fmt: skip


USED = "report/tests/test_report.py::test_every_record_is_used_and_every_use_recorded"
COMPILED = "test_report_of_a_copy_has_the_same_bytes"


def around(text, span, width=30):
    return " ".join(text[max(0, span[0] - width) : span[1] + width].split())


def orders(rng):
    """The word that a comparison prints, beside the record that bears it out."""
    pattern = rf'#(?:than|compared)\((?:"[^"]+", )+"({"|".join(ORDERS)})"\)'
    texts = {path: path.read_text("utf-8") for path in sources()}
    found = [(path, match) for path in texts for match in re.finditer(pattern, texts[path])]
    for path, match in rng.sample(found, min(EACH, len(found))):
        text, new = texts[path], ORDERS[match[1]]
        changed = text[: match.start(1)] + new + text[match.end(1) :]
        yield Fault("order", str(path.relative_to(ROOT)), around(text, match.span(1)), new, changed,
                    (f"report/tests/test_report.py::{COMPILED}",))  # fmt: skip


def numbers(rng):
    """Another number of the same notebook and unit, by its record."""
    texts = {path: path.read_text("utf-8") for path in sources()}
    found = [(path, match) for path in texts for match in NUMBER.finditer(texts[path])]
    for path, match in rng.sample(found, len(found)):
        known = json.loads(read(f"report/numbers/{match[1]}.json"))["numbers"]
        own = known[match[2]]
        like = [name for name in sorted(known) if known[name]["unit"] == own["unit"]
                and known[name]["text"] != own["text"]]  # fmt: skip
        if like:
            text, new = texts[path], rng.choice(like)
            changed = text[: match.start(2)] + new + text[match.end(2) :]
            yield Fault("number", str(path.relative_to(ROOT)), match[2], new, changed,
                        ("report/tests/test_words.py", USED))  # fmt: skip


def readme(rng):
    """A digit of what the README's lines print."""
    text = read("README.md")
    [block] = re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S)
    found = [m for m in re.finditer(r"  # .*$", text, re.M)
             if block.start() < m.start() < block.end() and re.search(r"\d", m[0])]  # fmt: skip
    digits = [m.start() + d.start() for m in found for d in re.finditer(r"\d", m[0])]
    for place in rng.sample(digits, min(EACH, len(digits))):
        new = str((int(text[place]) + rng.randint(1, 9)) % 10)
        yield Fault("README", "README.md", around(text, (place, place + 1), 12), new,
                    text[:place] + new + text[place + 1 :],
                    ("report/tests/test_readme.py",))  # fmt: skip


KINDS = (verdict_faults, proof_faults, equations, orders, numbers, readme)


def draw(seed=SEED):
    """Return the faults of every kind."""
    found = []
    for kind in KINDS:
        rng = random.Random(f"{seed} {kind.__name__}")
        found += list(dict.fromkeys(kind(rng)))[:EACH]
    return found


def copy(place):
    """Make a copy of what is committed or new."""
    shutil.rmtree(place, ignore_errors=True)
    names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, text=True,
                           capture_output=True, check=True).stdout.splitlines()  # fmt: skip
    for name in names:
        if (ROOT / name).is_file():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, place / name)


def judge(fault, place):
    """Return the test that notices a fault in a copy, or nothing."""
    target = place / fault.file
    before = target.read_text(encoding="utf-8")
    try:
        target.write_text(fault.text, encoding="utf-8")
        done = run(fault.tests, place)
    finally:
        target.write_text(before, encoding="utf-8")
    if done.returncode == 0:
        return ""
    said = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.M)
    if not said:
        sys.exit(f"pytest could not be run at all.\n{done.stdout}{done.stderr}")
    return said[1]


def run(tests, place):
    environment = os.environ | {"PYTHONPATH": str(place)}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--tb=no", "-rfE",
               "-p", "no:cacheprovider", *tests]  # fmt: skip
    return subprocess.run(command, cwd=place, env=environment, text=True, capture_output=True)


def head(rows, seed, when):
    """Return what stands above the table: the seed, the score of all and of each kind, `when`."""

    def score(rows):
        noticed = sum(bool(row["noticed by"]) for row in rows)
        return f"{noticed} of {len(rows)}, {100 * noticed / len(rows):.1f} %"

    lines = [f"seed {seed}", f"all: {score(rows)}"]
    for kind in dict.fromkeys(row["kind"] for row in rows):
        lines.append(f"{kind}: {score([row for row in rows if row['kind'] == kind])}")
    return "".join(f"# {line}\n" for line in [*lines, when])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", default=SEED, help=f"of the draw, {SEED!r} unless told")
    parser.add_argument("--kind", default="", help="only faults of this kind")
    options = parser.parse_args()
    faults = [fault for fault in draw(options.seed) if options.kind in fault.kind]
    workers = len(os.sched_getaffinity(0))
    places = [BUILD / f"copy-{number}" for number in range(workers)]
    for place in places:
        copy(place)
    tests = dict.fromkeys(test for fault in faults for test in fault.tests)
    if (done := run(tests, places[0])).returncode:
        sys.exit(f"These must pass before a fault is planted.\n{done.stdout}")

    def every(number):
        rows = []
        for fault in faults[number::workers]:
            by = judge(fault, places[number])
            print(
                f"{fault.kind}: {fault.before} -> {fault.after}: {by or 'not noticed'}", flush=True
            )
            values = [fault.kind, fault.file, fault.before, fault.after, by]
            rows.append(dict(zip(COLUMNS, values, strict=True)))
        return rows

    with ThreadPoolExecutor(workers) as pool:
        shares = list(pool.map(every, range(workers)))
    rows = sorted((row for share in shares for row in share), key=lambda row: list(row.values()))
    above = head(rows, options.seed, judged())
    print(above)
    if not options.kind and options.seed == SEED:
        with TABLE.open("w", encoding="utf-8", newline="") as file:
            file.write(above)
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    for place in places:
        shutil.rmtree(place)


if __name__ == "__main__":
    main()
