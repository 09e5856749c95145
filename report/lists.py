"""Lists beside the report: its figures, its records, its verdicts, and what the README shows."""

import csv
import io
import re
import tomllib
from collections import Counter, defaultdict

from report.sources import ROOT, notebooks, records

FIGURE_LIST = ROOT / "figures" / "README.md"
RECORD_LIST = ROOT / "report" / "records.csv"
VERDICT_LIST = ROOT / "report" / "verdicts.csv"
README = ROOT / "README.md"
DOCUMENTS = "report", "supplement", "corrigenda"
PDFS = {name: ROOT / "report" / f"{name}.pdf" for name in DOCUMENTS}
MOVING = ROOT / "report" / "guide" / "machine.svg"

USE = re.compile(r'\b(num|count|than|tabular|fig|picture)\(\s*"([^"]+)",\s*"([^"]+)"')
# How the README goes on after the number of claims with a verdict.
VERDICTS = {
    "holds": "hold", "imprecise": "are imprecise", "corrected": "hold once they are corrected",
    "refuted": "are wrong", "not reproduced": "couldn't be reproduced",
    "ambiguous": "are ambiguous",
}  # fmt: skip
KINDS = {
    "num": "numbers",
    "count": "numbers",
    "than": "orders",
    "tabular": "tables",
    "fig": "figures",
    "picture": "figures",
}


def figure_list():
    """Return figures/README.md: where each figure comes from and what it shows."""
    lines = ["# Figures", "", "Made by `make report`; each by one notebook.", ""]
    lines += ["| figure | notebook | what it shows |", "| --- | --- | --- |"]
    for notebook in notebooks():
        for _, figure in sorted(records(notebook)[1].get("figures", {}).items()):
            link = f"[{notebook.name}](../notebooks/{notebook.name})"
            lines.append(f"| [{figure['file']}]({figure['file']}) | {link} | {figure['alt']} |")
    return "\n".join(lines) + "\n"


def uses():
    """Return where the report shows a record: {(notebook, kind, name): names of files}."""
    found = defaultdict(set)
    for path in sorted((ROOT / "report").rglob("*.typ")):
        for call, notebook, name in USE.findall(path.read_text(encoding="utf-8")):
            found[notebook, KINDS[call], name].add(path.name)
    return found


def record_list():
    """Return report/records.csv: each record with its notebook, code cell and place of use."""
    used, rows = uses(), []
    for notebook in notebooks():
        for kind, entries in sorted(records(notebook)[1].items()):
            for name, entry in sorted(entries.items()):
                where = " ".join(sorted(used.get((notebook.stem, kind, name), [])))
                row = [notebook.stem, kind, name, _printed(kind, entry), entry.get("unit", "")]
                rows.append([*row, entry["cell"], where])
    return _table(["notebook", "kind", "record", "printed", "unit", "code cell", "used in"], rows)


def verdict_list():
    """Return report/verdicts.csv: each claim with its verdict, what is right, and its test."""
    columns = ["where", "claim", "verdict", "severity", "says", "effect", "origin", "proof"]
    rows = []
    for path in sorted((ROOT / "report" / "ledger").glob("*.toml")):
        for name, row in tomllib.loads(path.read_text(encoding="utf-8")).items():
            rows.append([path.stem, name, *(row.get(column, "") for column in columns)])
    return _table(["document", "row", *columns], rows)


def with_findings(text):
    """Return the README's text with the count of verdicts and what surprised us made anew."""
    from kit.chapters import filled  # `make bench` has no IPython

    contents = tomllib.loads((ROOT / "notebooks" / "contents.toml").read_text(encoding="utf-8"))
    lines = [
        f"- {filled(stem, sentence)} [Chapter {stem[:2]}](notebooks/{stem}.ipynb)"
        for stem, sentence in contents["surprises"].items()
    ]
    return with_block(with_block(text, "judged", judged()), "found", "\n".join(lines))


def judged():
    """Return a sentence on how many claims got which verdict."""
    rows = csv.DictReader(io.StringIO(verdict_list()))
    count = Counter(row["verdict"] for row in rows)
    told = ", ".join(f"{count[word]} {said}" for word, said in VERDICTS.items())
    if unsaid := count.keys() - VERDICTS.keys():
        raise ValueError(f"VERDICTS: must say each verdict; got {sorted(unsaid)}.")
    return (
        f"**The verdicts.** Of {count.total()} claims {told}: "
        "[all of them](report/verdicts.csv), each with its test."
    )


def with_block(text, name, block):
    """Return a text with another block between the marks of a name, which are comments."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->\n"
    before, begun, rest = text.partition(begin)
    _, ended, after = rest.partition(end)
    if not begun or not ended:
        raise ValueError(f"text: must have the lines {begin.strip()} and {end.strip()} in it.")
    return f"{before}{begin}\n{block}\n\n{end}{after}"


def _table(columns, rows):
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows(rows)
    return text.getvalue()


def _printed(kind, entry):
    if kind == "numbers":
        return f"at most {entry['text']}" if "bound" in entry else entry["text"]
    return {"figures": entry.get("file"), "orders": entry.get("order")}.get(kind, "")
