"""What people read in a terminal: a line that it can't obey, and of a length that they can read.

Needs Python alone, for what is said where a package is missing.
"""

LONGEST = 1000  # characters of a line that is told


def fit(text, most=LONGEST):
    """Return a text as one line for a terminal, its middle left out beyond so many characters.

    Characters that a terminal might obey, as one that moves the cursor, are spelled out.

    Examples
    --------
    >>> fit("a\\x1b[2Jb")
    'a\\\\x1b[2Jb'
    >>> fit("0123456789" * 9, 23)
    '0123456789...0123456789'
    """
    if len(text) > most:  # before all of it is looked at
        half = (most - 3) // 2
        text = f"{text[: most - 3 - half]}...{text[-half:]}"
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return line if len(line) <= most else fit(line, most)
