"""Tables of a job's TOML file: names, units and kinds of their values, and refusals in a sentence.

Metres, seconds, radians and what follows from them; the name of an angle may end in ``_deg``, and
its value is then in degrees.
"""

import re
import tomllib
from contextlib import contextmanager
from difflib import get_close_matches

import numpy as np

from ..arguments import shown
from ..terminal import fit

TEXT, WHOLE = "text", "whole number"
ANGULAR = "rad", "rad/s", "rad/s^2"  # whose names may end in _deg
# Beyond this a number is meant in another unit: the most, that unit, and what one of it is.
TOO_MUCH = {
    "m": (50.0, "mm", 1e-3), "m/s": (5.0, "mm/s", 1e-3), "m/s^2": (50.0, "mm/s^2", 1e-3),
    "m^3/s": (1.0, "l/min", 1e-3 / 60), "rad": (7.0, "degrees", np.pi / 180),
    "tick": (0.5, "ms", 1e-3), "tolerance": (0.3, "mm", 1e-3), "depth": (1.0, "mm", 1e-3),
}  # fmt: skip
# Tables that a job must have and that the other kind hasn't.
CUT, FLANK = ("section", "limits", "plan", "controller"), ("surface", "mill", "paths")
# The time that TOML's keys of many dots take grows with the square of their number.
MOST_BYTES, MOST_IN_A_LINE = 100_000, 4_000
LEAST_INTEGER, MOST_INTEGER = -(2**63), 2**63 - 1  # as TOML has them
# Numbers of a message.
IN_RADIANS = re.compile(r"-?\bpi(?:/2)?\b|-?\b\d+(?:\.\d+)?(?:e[+-]?\d+)?\b")


class WrongJob(ValueError):
    """A job, or a log, that can't be understood; the message says where and why."""


class Table(dict):
    """What a table says by its names, in SI units, and which of them it gave in `degrees`."""

    degrees = frozenset()


def parsed_toml(path):
    """Return what a file says in TOML, or raise WrongJob."""
    name = brief(str(path)) or "the file without a name"
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
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
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise WrongJob(f"{name}: isn't TOML; {brief(str(error).rstrip('.'))}.") from None
    except RecursionError:
        raise WrongJob(f"{name}: is nested too deeply for a job.") from None
    except ValueError:  # Python's own limit, of thousands of digits
        raise WrongJob(f"{name}: has a number with too many digits.") from None


def check_leaves(tables):
    """Raise WrongJob for characters that a terminal might obey, and for integers beyond 64 bits.

    Whatever a job says may be repeated in a message. Without recursion, for dotted keys nest as
    deeply as one likes.
    """
    left = [("", tables)]
    while left:
        where, value = left.pop()
        if isinstance(value, dict):
            for name in value:
                if not name.isprintable():
                    raise WrongJob(f"{brief(name)}: must be a name of printable characters.")
            # Where it is deep in a table that no job has, the beginning will do.
            left += [(f"{where}.{name}"[:100], inner) for name, inner in value.items()]
        elif isinstance(value, list):
            left += [(where, inner) for inner in value]
        elif isinstance(value, str) and not value.isprintable():
            raise WrongJob(
                f"{where[1:]}: must be a text of printable characters; got {shown(value)}."
            )
        elif isinstance(value, int) and not LEAST_INTEGER <= value <= MOST_INTEGER:
            raise WrongJob(f"{where[1:]}: must be a number of at most 64 bits.")


def brief(text):
    """Return a name or a text for a message, in 200 characters that no terminal obeys."""
    return fit(text, 200)


def read_table(table, given, units, needed=()):
    """Return a table's values by their names, in SI units.

    Parameters
    ----------
    table : str
        Its name, for messages.
    given : dict
        What it says.
    units : dict
        What it may hold: a unit, `TEXT` or `WHOLE` for each name.
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
        if name.endswith("_deg") and units.get(name[:-4]) in ANGULAR:
            key = name[:-4]
        if key not in units:
            raise WrongJob(f"{where}: isn't known{hint(name, units)}.")
        if key in values:
            raise WrongJob(f"[{table}] {key}: is given in radians and in degrees.")
        unit = units[key].replace("rad", "degrees") if key != name else units[key]
        kinds = {TEXT: str, WHOLE: int}.get(unit, (int, float))
        if isinstance(value, bool) or not isinstance(value, kinds):
            wanted = {TEXT: "a text", WHOLE: "a whole number", "1": "a plain number"}
            kind = wanted.get(unit, f"a number in {unit}")
            raise WrongJob(f"{where}: must be {kind}; got {shown(value)}.")
        if key == name and unit not in (TEXT, WHOLE):
            _check_unit(where, key, value, unit)
        values[key] = float(np.radians(value)) if key != name else value
        if key != name:
            degrees.add(key)
    for key in needed:
        if key not in values:
            unit = f"{units[key]}, or {key}_deg" if units[key] in ANGULAR else units[key]
            raise WrongJob(f"[{table}] {key}: is missing ({unit}).")
    values.degrees = frozenset(degrees)
    return values


def _check_unit(where, key, value, unit):
    """Raise WrongJob for a number that must be in another unit than it is said to be."""
    most, other, factor = TOO_MUCH.get(key, TOO_MUCH.get(unit, (np.inf, "", 1)))
    if not np.inf > abs(value) > most:
        return
    size = " in size" if value < 0 else ""
    if unit == "rad":
        raise WrongJob(
            f"{where}: must be at most {most:g} rad{size}; got {value:g}. In degrees its name "
            f"is {key}_deg."
        )
    raise WrongJob(
        f"{where}: must be at most {most:g} {unit}{size}; got {value:g}. "
        f"If that is in {other}, it is {value * factor:g} {unit}."
    )


@contextmanager
def said_of(table, given=None, *, remedy=""):
    """Begin a refusal with the `table` that it is about, and end it with a `remedy`.

    An angle is said in the unit in which it was `given`, a `Table`. What is said of the machine's
    body is about that table, wherever it is found.
    """
    try:
        yield
    except ValueError as error:
        said = f"[{table}] {_as_given(str(error), getattr(given, 'degrees', ()))}"
        if said.startswith(f"[{table}] body: "):
            said = said.replace(f"[{table}] body: ", "[body] ", 1)
        kind = WrongJob if isinstance(error, WrongJob) else ValueError
        raise kind(" ".join(filter(None, (said, remedy)))) from None


def _as_given(said, names):
    """Return a refusal in degrees if it is of an argument among `names`, which were given so.

    What came is in degrees then, and so is a rule that is in radians.
    """
    rule, got, came = said.partition("; got ")
    ours = set(re.findall(r"\b\w+_(?:min|max)\b", rule)) | {said.partition(":")[0]}
    if not ours <= set(names):  # one of a pair may be in radians: then both are
        return said
    if re.search(r"\b(rad|pi)\b", rule):
        rule = IN_RADIANS.sub(_degrees, rule).replace("rad", "degrees")
    rule = re.sub(rf"\b({'|'.join(names)})\b", r"\1_deg", rule)
    return rule + got + IN_RADIANS.sub(_degrees, came).replace("rad", "degrees")


def _degrees(number):
    """Return the text of a match of `IN_RADIANS` in degrees."""
    text = number[0].replace("pi/2", "90").replace("pi", "180")
    return text if text != number[0] else f"{np.degrees(float(text)):.5g}"


def check_kind(path, tables, own, others, command):
    """Refuse a job at `path` that has none of its `own` tables but some that `command` reads.

    `others` names those. A job with tables of both kinds is refused where they are read.
    """
    found = [name for name in others if name in tables]
    if found and not set(own) & set(tables):
        raise WrongJob(
            f"{brief(str(path))}: is a job for `{command}`, by its tables {', '.join(found)}."
        )


def one_of(where, word, words):
    """Refuse a word that isn't one of those known."""
    if not isinstance(word, str) or word not in words:
        *others, last = (f'"{each}"' for each in words)
        raise WrongJob(f"{where}: must be {', '.join(others)} or {last}; got {shown(word)}.")


def hint(name, known):
    """Return what a name may have been meant to be, as the end of a sentence."""
    close = get_close_matches(name, known, n=1) or get_close_matches(
        name.removesuffix("_deg"), known, n=1
    )
    return f"; {close[0]!r} is meant, perhaps" if close else f"; known are {', '.join(known)}"
