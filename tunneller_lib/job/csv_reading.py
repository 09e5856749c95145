"""Tables of numbers in CSV: lines that say what they are, a heading, rows."""

import numpy as np

from ..arguments import Whole, checked, shown


@checked
def read_csv(text: str, *, most: Whole(1, 2**31) = 2**31):
    """Return what a table says, such as those that `csv_tables` writes.

    Parameters
    ----------
    text : str
        Lines of ``# name = value``, a heading, rows of numbers. Blank lines don't count.
    most : int
        Of lines, for each takes many times its length.

    Returns
    -------
    about : dict of str to float
        What the head says: ``tick_s``, ``count_rad``, ``laps``, ``advance_m``.
    columns : dict of str to (n,) int or float
        By their names.

    Raises
    ------
    ValueError
        If there are too many lines or no heading, its names aren't separated by commas, a name
        stands twice in it, a line has another length, or something is no number.
    """
    count = text.count("\n")
    if count > most:
        raise ValueError(f"text: must have at most {most} lines; got {count}.")
    head = [line[2:].split(" = ") for line in text.splitlines() if line.startswith("# ")]
    about = {name: _number(name, value) for name, value in (p for p in head if len(p) == 2)}
    lines = {
        number: line.split(",")
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.startswith("#")
    }
    if not lines:
        raise ValueError("text: must have a heading; got none.")
    names = lines.pop(min(lines))
    names = [name.strip() for name in names]
    if any(mark in name for name in names for mark in ";\t"):
        raise ValueError(
            "text: its columns must be separated by commas, decimals by points; got the heading "
            f"{shown(','.join(names))}."
        )
    if len(set(names)) < len(names):
        raise ValueError(f"text: must name each column once; got {shown(names)}.")
    for number, row in lines.items():
        if len(row) != len(names):
            raise ValueError(
                f"text: line {number} must have {len(names)} numbers, one under each name; "
                f"got {len(row)}."
            )
    columns = zip(names, *lines.values(), strict=True)
    return about, {name: _numbers(name, cells) for name, *cells in columns}


def _number(name, cell):
    """Return what the head says of a name as a number."""
    try:
        return float(cell)
    except ValueError:
        raise ValueError(f"text: {shown(name)} must be a number; got {shown(cell)}.") from None


def _numbers(name, cells):
    """Return the cells of a column as whole numbers, or else as numbers."""
    for kind in (np.int64, np.float64):
        try:
            return np.array(cells, dtype=str).astype(kind)
        except (ValueError, OverflowError):
            continue
    raise ValueError(f"text: column {shown(name)} must hold numbers; got {shown(cells[:3])}.")
