"""Tables of a job's TOML file: names, units and kinds of their values, refused in a sentence.

Values are in metres, seconds, radians and the units that follow from them; the name of an angle may
end in ``_deg``, and its value is then in degrees.
"""

import hashlib
import sys
import tomllib
from contextlib import contextmanager, nullcontext
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import __version__
from ..arguments import shown
from ..terminal import fit

TEXT, WHOLE = "text", "whole number"
NEEDED = "machine", "section", "limits", "plan", "controller"  # tables that a job must have
# tomllib's time grows with the square of the number of dots in a key: no line may be too long.
MOST_BYTES, MOST_IN_A_LINE = 100_000, 4_000
NAMED = 20  # letters of a job's name, so that its stamp fits a header of 80 bytes


class WrongJob(ValueError):
    """Raised where a job can't be read: no file, no TOML, unknown or missing names.

    A value that is refused raises a plain ValueError. Each message says where and why.
    """


class Size(NamedTuple):
    """What a number of a job may be: its `unit`, "" for none, and from `least` to `most`.

    Parameters
    ----------
    unit : str
        As messages write it; "" for a ratio.
    least, most : float
        The sizes that make sense, and that a job is served with.
    zero : bool
        Whether zero, too, passes a `least` above it.
    signed : bool
        Whether negative numbers of these sizes pass as well.
    why : str
        What a message says after the range.
    """

    unit: str = ""
    least: float = 0.0
    most: float = np.inf
    zero: bool = False
    signed: bool = False
    why: str = ""

    def holds(self, value):
        """Return whether a number passes; NaN doesn't."""
        size = abs(value) if self.signed else value
        return self.least <= size <= self.most or (self.zero and value == 0)

    def __str__(self):
        """Return the range in words."""
        of = f" {self.unit}".rstrip()
        if self.signed:
            return f"at most {self.most:g}{of} in size"
        return f"{'0 or ' if self.zero else ''}from {self.least:g} to {self.most:g}{of}"


def parsed_toml(path):
    """Return what a file, or standard input for ``-``, says in TOML, and its `stamp_of`."""
    stdin = str(path) == "-"
    name = "standard input" if stdin else brief(str(path)) or "the file without a name"
    try:
        with nullcontext(sys.stdin.buffer) if stdin else open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)  # a file may be endless
    except (OSError, ValueError) as error:  # a name with a zero byte is a ValueError
        raise WrongJob(f"{name}: can't be read; {getattr(error, 'strerror', error)}.") from None
    if len(content) > MOST_BYTES:
        raise WrongJob(f"{name}: is larger than a job may be, {MOST_BYTES} bytes.")
    if max(map(len, content.split(b"\n"))) > MOST_IN_A_LINE:
        raise WrongJob(f"{name}: has a line of more than {MOST_IN_A_LINE} bytes.")
    try:
        tables = tomllib.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:  # also no UTF-8, thousands of digits or brackets
        raise WrongJob(f"{name}: isn't TOML; {brief(str(error).rstrip('.'))}.") from None
    return tables, stamp_of("stdin" if stdin else Path(path).name, content)


def stamp_of(name, content):
    """Return what files say of their job: its name, its text's digest, the version.

    There is no date in it, so that the same job gives the same bytes, and no character that could
    end a comment.
    """
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "._") else "_" for c in name)
    digest = hashlib.sha256(content).hexdigest()[:16]
    return f"tunneller_lib {__version__}, job {plain[:NAMED]}, sha256 {digest}"


def brief(text):
    """Return a text as part of a message: at most 200 characters, none that a terminal obeys."""
    return fit(text, 200)


def read_table(table, given, sizes, needed=()):
    """Return a table's values by their names, in SI units.

    Parameters
    ----------
    table : str
        Its name, for messages.
    given : dict
        What the file says.
    sizes : dict
        What the table may hold: a `Size`, `TEXT` or `WHOLE` for each name.
    needed : iterable of str
        Names that must be given.

    Returns
    -------
    values : dict
        Angles in rad.
    """
    values = {}
    angles = {f"{key}_deg": key for key, size in sizes.items() if _unit(size) == "rad"}
    for name, value in given.items():
        where = f"[{table}] {brief(name)}"
        key = angles.get(name, name)
        if key not in sizes:
            raise WrongJob(f"{where}: isn't known{hint(name, sizes, angles)}.")
        if key in values:
            raise WrongJob(f"[{table}] {key}: is given in radians and in degrees.")
        values[key] = _value(where, value, sizes[key], name in angles)
    for key in needed:
        if key not in values:
            degrees = f", or {key}_deg" if f"{key}_deg" in angles else ""
            raise WrongJob(f"[{table}] {key}: is missing ({_unit(sizes[key])}{degrees}).")
    return values


def _unit(size):
    return size.unit if isinstance(size, Size) else size


def _value(where, value, size, in_degrees):
    """Return a number in SI units, or a text; raise ValueError if its kind or size is wrong."""
    unit = "degrees" if in_degrees else _unit(size)
    kinds = {TEXT: str, WHOLE: int}.get(size, (int, float))
    if isinstance(value, bool) or not isinstance(value, kinds):
        wanted = {TEXT: "a text", WHOLE: "a whole number", "": "a plain number"}
        kind = wanted.get(unit, f"a number in {unit}")
        raise ValueError(f"{where}: must be {kind}; got {shown(value)}.")
    if not isinstance(size, Size):
        return value
    one = np.pi / 180 if in_degrees else 1.0
    asked = size._replace(unit=unit, least=size.least / one, most=size.most / one)
    if not asked.holds(value):
        too_large = unit == "rad" and abs(value) > size.most
        suffixed = " In degrees its name ends in _deg." if too_large else ""
        raise ValueError(f"{where}: must be {asked}{size.why}; got {shown(value)}.{suffixed}")
    return float(np.radians(value)) if in_degrees else value


@contextmanager
def said_of(table):
    """Make a refusal begin with the `table` that it is about."""
    try:
        yield
    except ValueError as error:
        raise type(error)(f"[{table}] {error}".replace(f"[{table}] body: ", "[body] ")) from None


def one_of(where, word, words):
    """Raise ValueError if a word isn't one of those known, and WrongJob if it is missing."""
    *others, last = (f'"{each}"' for each in words)
    known = f"{', '.join(others)} or {last}"
    if word is None:
        raise WrongJob(f"{where}: is missing ({known}).")
    if not isinstance(word, str) or word not in words:
        raise ValueError(f"{where}: must be {known}; got {shown(word)}.")


def hint(name, known, more=()):
    """Return the end of a sentence that suggests the nearest of the names `known` and `more`.

    If none is near, it lists those that are known.
    """
    close = get_close_matches(name, [*known, *more], n=1)
    return f"; {close[0]!r} is meant, perhaps" if close else f"; known are {', '.join(known)}"
