"""Tables of a job's TOML file: names, units and kinds of their values, and refusals in a sentence.

Metres, seconds, radians and what follows from them; the name of an angle may end in ``_deg``, and
its value is then in degrees.
"""

import hashlib
import re
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
ANGULAR = "rad", "rad/s", "rad/s^2"  # whose names may end in _deg
# Units in which people give what is wanted in another, and what one of each is.
OTHERS = {
    "m": {"mm": 1e-3},
    "m/s": {"mm/s": 1e-3, "m/min": 1 / 60},
    "m/s^2": {"mm/s^2": 1e-3},
    "m^3": {"l": 1e-3, "cm^3": 1e-6},
    "m^3/s": {"l/min": 1e-3 / 60, "m^3/h": 1 / 3600},
    "m^3/s/Pa": {"l/min/bar": 1e-3 / 60 / 1e5},
    "s": {"ms": 1e-3},
    "Hz": {"1/min": 1 / 60},
    "kg": {"t": 1e3},
    "N m": {"kN m": 1e3},
    "Pa": {"bar": 1e5, "MPa": 1e6, "GPa": 1e9},
    "W": {"kW": 1e3},
    "J/m^3": {"MJ/m^3": 1e6, "kWh/m^3": 3.6e6},
    "1": {"%": 1e-2},
}
NEEDED = "machine", "section", "limits", "plan", "controller"  # tables that a job must have
# The time that TOML's keys of many dots take grows with the square of their number.
MOST_BYTES, MOST_IN_A_LINE = 100_000, 4_000
NAMED = 20  # letters of a job's name, so that all fits a header of 80 bytes
LEAST_INTEGER, MOST_INTEGER = -(2**63), 2**63 - 1  # as TOML has them
# Numbers of a message.
IN_RADIANS = re.compile(r"-?\bpi(?:/2)?\b|-?\b\d+(?:\.\d+)?(?:e[+-]?\d+)?\b")


class WrongJob(ValueError):
    """Raised where a job can't be read: no file, no TOML, unknown or missing names.

    A value that is refused raises a plain ValueError. Each message says where and why.
    """


class Size(NamedTuple):
    """What a number of a job may be: its `unit`, and plausible sizes from `least` to `most`.

    Zero passes, and so does a number below zero where there is a least size: these are checked
    where the number is used. `others` are further units in which people give it: pairs of a name
    and of what one of it is, or of a function of the number.
    """

    unit: str
    least: float = 0.0
    most: float = np.inf
    others: tuple | None = None


class Table(dict):
    """The values of a table by name, in SI units; `degrees` has the names given in degrees."""

    degrees = frozenset()


def parsed_toml(path):
    """Return what a file, or standard input for ``-``, says in TOML, and its `stamp_of`."""
    stdin = str(path) == "-"
    name = "standard input" if stdin else brief(str(path)) or "the file without a name"
    try:
        with nullcontext(sys.stdin.buffer) if stdin else open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)  # a file may be endless
    except OSError as error:
        raise WrongJob(f"{name}: can't be read; {error.strerror}.") from None
    except ValueError:  # of a zero byte, or of half a pair of UTF-16
        raise WrongJob(f"{name}: can't be read; it isn't the name of a file.") from None
    if len(content) > MOST_BYTES:
        raise WrongJob(f"{name}: is larger than a job may be, {MOST_BYTES} bytes.")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise WrongJob(f"{name}: is no text in UTF-8.") from None
    if max(map(len, text.split("\n"))) > MOST_IN_A_LINE:
        raise WrongJob(f"{name}: has a line of more than {MOST_IN_A_LINE} characters.")
    try:
        return tomllib.loads(text), stamp_of("stdin" if stdin else Path(path).name, content)
    except tomllib.TOMLDecodeError as error:
        raise WrongJob(f"{name}: isn't TOML; {brief(str(error).rstrip('.'))}.") from None
    except RecursionError:
        raise WrongJob(f"{name}: is nested too deeply for a job.") from None
    except ValueError:  # Python's own limit, of thousands of digits
        raise WrongJob(f"{name}: has a number with too many digits.") from None


def stamp_of(name, content):
    """Return what files say of their job: its name, its text's digest, the version.

    There is no date in it, so that the same job gives the same bytes, and no letter that could end
    a comment.
    """
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "._") else "_" for c in name)
    digest = hashlib.sha256(content).hexdigest()[:16]
    return f"tunneller_lib {__version__}, job {plain[:NAMED]}, sha256 {digest}"


def check_leaves(tables):
    """Raise ValueError for characters that a terminal might obey, and integers beyond 64 bits.

    Messages repeat what a job says. Dotted keys may nest deeper than Python's recursion goes.
    """
    left = [("", tables)]
    while left:
        where, value = left.pop()
        if isinstance(value, dict):
            for name in value:
                if not name.isprintable():
                    raise WrongJob(f"{brief(name)}: must be a name of printable characters.")
            # Deep in a table that no job has, the beginning of its name will do.
            left += [(f"{where}.{name}"[:100], inner) for name, inner in value.items()]
        elif isinstance(value, list):
            left += [(where, inner) for inner in value]
        elif isinstance(value, str) and not value.isprintable():
            raise ValueError(
                f"{where[1:]}: must be a text of printable characters; got {shown(value)}."
            )
        elif isinstance(value, int) and not LEAST_INTEGER <= value <= MOST_INTEGER:
            raise ValueError(f"{where[1:]}: must be a number of at most 64 bits.")


def brief(text):
    """Return a name or a text for a message: at most 200 characters, none that a terminal obeys."""
    return fit(text, 200)


def read_table(table, given, sizes, needed=()):
    """Return a table's values by their names, in SI units.

    Parameters
    ----------
    table : str
        Its name, for messages.
    given : dict
        What it says.
    sizes : dict
        What it may hold: a `Size`, `TEXT` or `WHOLE` for each name.
    needed : iterable of str
        Names that must be there.

    Returns
    -------
    values : Table
        Angles in rad.
    """
    values = Table()
    degrees = set()
    for name, value in given.items():
        key = name
        where = f"[{table}] {brief(name)}"
        if name.endswith("_deg") and _is_angle(sizes.get(name[:-4])):
            key = name[:-4]
        if key not in sizes:
            angles = [f"{key}_deg" for key, size in sizes.items() if _is_angle(size)]
            raise WrongJob(f"{where}: isn't known{hint(name, sizes, angles)}.")
        if key in values:
            raise WrongJob(f"[{table}] {key}: is given in radians and in degrees.")
        size = sizes[key]
        kinds = {TEXT: str, WHOLE: int}.get(size, (int, float))
        if isinstance(value, bool) or not isinstance(value, kinds):
            wanted = {TEXT: "a text", WHOLE: "a whole number", "1": "a plain number"}
            unit = _unit(size, key != name)
            kind = wanted.get(unit, f"a number in {unit}")
            raise ValueError(f"{where}: must be {kind}; got {shown(value)}.")
        if isinstance(size, Size):
            _check_size(where, key, value, size, key != name)
        values[key] = float(np.radians(value)) if key != name else value
        if key != name:
            degrees.add(key)
    for key in needed:
        if key not in values:
            degrees = f", or {key}_deg" if _is_angle(sizes[key]) else ""
            raise WrongJob(f"[{table}] {key}: is missing ({_unit(sizes[key])}{degrees}).")
    values.degrees = frozenset(degrees)
    return values


def _is_angle(size):
    return isinstance(size, Size) and size.unit in ANGULAR


def _unit(size, in_degrees=False):
    """Return the unit of what a name may hold, in degrees if it was given so."""
    unit = size.unit if isinstance(size, Size) else size
    return unit.replace("rad", "degrees") if in_degrees else unit


def _check_size(where, key, value, size, in_degrees):
    """Raise ValueError for an implausible number, and say in which unit it may be meant."""
    one = np.pi / 180 if in_degrees else 1.0  # in SI units
    if not 0 < abs(value) < np.inf or (value < 0 and size.least):
        return
    if size.least <= abs(value * one) <= size.most:
        return
    unit = _unit(size, in_degrees)
    least, most = size.least / one, size.most / one
    said = f"from {least:g} to {most:g}" if size.least else f"at most {most:g}"
    sign = " in size" if value < 0 else ""
    said = f"{where}: must be {said} {unit}{sign}; got {value:g}."
    if size.unit == "rad" and not in_degrees and abs(np.radians(value)) <= size.most:
        raise ValueError(f"{said} In degrees its name is {key}_deg.")
    others = OTHERS.get(size.unit, {}).items() if size.others is None else size.others
    meant = []
    for other, factor in others:
        found = factor(value) if callable(factor) else factor * value
        if size.least <= abs(found) <= size.most:
            that = "it is " if not meant else ""
            meant.append(f"in {other}, {that}{found / one:.6g} {unit}")
    raise ValueError(f"{said} If that is {'; if '.join(meant)}." if meant else said)


@contextmanager
def said_of(table, given=None, *, remedy="", instead=None):
    """Have a refusal begin with the `table` that it is about, and end with a `remedy`.

    Angles are told in the unit in which they were `given`, a `Table`. A refusal of a machine's body
    is always about that table. With a pair `instead`, of an argument and of what a job calls it,
    refusals of other arguments pass unchanged.
    """
    try:
        yield
    except ValueError as error:
        if instead:
            argument, _, rest = str(error).partition(": ")
            if argument != instead[0]:
                raise
            raise ValueError(f"[{table}] {instead[1]}: {rest}") from None
        said = f"[{table}] {_as_given(str(error), getattr(given, 'degrees', ()))}"
        if said.startswith(f"[{table}] body: "):
            said = said.replace(f"[{table}] body: ", "[body] ", 1)
        kind = WrongJob if isinstance(error, WrongJob) else ValueError
        raise kind(" ".join(filter(None, (said, remedy)))) from None


def _as_given(said, names):
    """Return a refusal with its angles in degrees if its argument is among `names`.

    Those were given in degrees; both the rule and what came are then told so.
    """
    rule, got, came = said.partition("; got ")
    ours = set(re.findall(r"\b\w+_(?:min|max)\b", rule)) | {said.partition(":")[0]}
    if not ours <= set(names):  # if one of a pair is in radians, both are told so
        return said
    if re.search(r"\b(rad|pi)\b", rule):
        rule = IN_RADIANS.sub(_degrees, rule).replace("rad", "degrees")
    rule = re.sub(rf"\b({'|'.join(names)})\b", r"\1_deg", rule)
    return rule + got + IN_RADIANS.sub(_degrees, came).replace("rad", "degrees")


def _degrees(number):
    """Return the text of a match of `IN_RADIANS` in degrees."""
    text = number[0].replace("pi/2", "90").replace("pi", "180")
    return text if text != number[0] else f"{np.degrees(float(text)):.5g}"


def one_of(where, word, words):
    """Raise ValueError if a word isn't one of those known, and WrongJob if it is missing."""
    *others, last = (f'"{each}"' for each in words)
    known = f"{', '.join(others)} or {last}"
    if word is None:
        raise WrongJob(f"{where}: is missing ({known}).")
    if not isinstance(word, str) or word not in words:
        raise ValueError(f"{where}: must be {known}; got {shown(word)}.")


def hint(name, known, more=()):
    """Return the end of a sentence that says which of the names `known`, or of `more`, was meant.

    If none is near, it lists those that are known.
    """
    close = get_close_matches(name, [*known, *more], n=1) or get_close_matches(
        name.removesuffix("_deg"), known, n=1
    )
    return f"; {close[0]!r} is meant, perhaps" if close else f"; known are {', '.join(known)}"
