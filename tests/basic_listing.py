"""The appendix' BASIC listing, run as printed, each faulty line with a repair to switch on."""

import math
import re
import tomllib

from report.sources import ROOT

READS = ["report/listings.toml"]

LISTING = tomllib.loads((ROOT / "report" / "listings.toml").read_text(encoding="utf-8"))["basic"]
PRINTED = {int(number): line for number, line in LISTING["printed"].items()}
REPAIRS = {int(number): line for number, line in LISTING["repaired"].items()}

FUNCTIONS = {"SQR": math.sqrt, "ATN": math.atan, "SIN": math.sin, "COS": math.cos, "TAN": math.tan}


def run(R, HH, H, F, J, *, repaired=(), fold_case=True):
    """Return the rows that the listing prints for its five inputs.

    Parameters
    ----------
    R, HH, H, F, J : float
        Radius and depth of P's circle, depth of Q, fraction of a turn, number of steps.
    repaired : iterable of int
        Line numbers to take from `REPAIRS`.
    fold_case : bool
        Whether r and R are one variable, as in most BASICs.

    Returns
    -------
    rows : list of list of float
        What line 240 prints.
    """
    lines = PRINTED | {number: REPAIRS[number] for number in repaired}
    order = sorted(lines)
    memory = dict(zip(("R", "HH", "H", "F", "J"), (R, HH, H, F, J), strict=True))
    rows, here, loop = [], 0, None

    def value(expression):
        return eval(expression.replace("^", "**"), FUNCTIONS, memory)

    while here < len(order):
        text = lines[order[here]].upper() if fold_case else lines[order[here]]
        for statement in map(str.strip, text.split(":")):
            if condition := re.fullmatch(r"IF (.+) THEN (.+)", statement):
                if not value(condition[1]):
                    break
                statement = condition[2]
            if statement == "STOP":
                return rows
            if statement.startswith("FOR"):
                name, first, last = re.fullmatch(r"FOR (\w+)=(.+) TO (.+)", statement).groups()
                memory[name], loop = value(first), (here, name, last)
            elif statement.startswith("NEXT"):
                start, name, last = loop
                memory[name] += 1
                if memory[name] <= value(last):
                    here = start
            elif statement.startswith("LPRINT U"):
                rows.append([value(column) for column in statement[6:].split(",")])
            elif not statement.startswith(("INPUT", "LPRINT")):
                name, expression = statement.split("=", 1)
                memory[name] = value(expression)
        here += 1
    return rows
