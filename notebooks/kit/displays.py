"""A recorded table as a notebook shows it, below its headings."""

import re

# Typst's words in the headings and cells of recorded tables, and what they look like.
SIGNS = {
    r"\/": "/", "<=": "≤", "phi.alt": "ϕ", "phi": "φ", "theta": "θ", "nu": "ν", "pi": "π", "-": "−",
}  # fmt: skip
RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class RecordedTable(list):
    """The cells of a table as printed, which a notebook shows below their headings.

    Parameters
    ----------
    columns : list of str
        Headings, perhaps with Typst's markup.
    cells : list of list of str
        The rows.

    Examples
    --------
    >>> print(RecordedTable(["path", "$l$ / m"], [["chord", "0.5"]])._repr_markdown_())
    | path | l / m |
    |-|-|
    | chord | 0.5 |
    """

    def __init__(self, columns, cells):
        super().__init__(cells)
        self.columns = columns

    def _repr_markdown_(self):
        lines = [self.columns, *self]
        lines = [f"| {' | '.join(map(_markdown, line))} |" for line in lines]
        return "\n".join([lines[0], "|" + "-|" * len(self.columns), *lines[1:]])


def _markdown(cell):
    """Return a table's cell with Typst's few words in it as signs."""
    text = re.sub(r"#super\[(.*?)\]", lambda m: m[1].translate(RAISED), cell)
    text = re.sub(r"\$(.*?)\$", lambda m: _signs(m[1]), text)
    return text.replace("|", r"\|")


def _signs(formula):
    text = re.sub(r"\^\(?(-?\d+)\)?", lambda m: m[1].translate(RAISED), formula)
    text = re.sub(r"bold\((\w+)\)", r"\1", text)
    text = re.sub(r"abs\((\w+)\)", r"|\1|", text)
    for word, sign in SIGNS.items():
        text = text.replace(word, sign)
    return text
