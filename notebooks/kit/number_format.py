"""Numbers as they are stored and printed: checked, rounded, with the digits that are meant."""

import math
import numbers
import re

import numpy as np

from tunneller_lib.arguments import shown

MORE = 3  # decimals that are stored beyond those that are printed


def number(name, value):
    """Return a finite number as Python's own int or float.

    Parameters
    ----------
    name : str
        What the number is, for the error.
    value : int or float, of Python or numpy
        The number.

    Raises
    ------
    ValueError
        If it isn't one number, or isn't finite.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    real = isinstance(value, numbers.Real) and not isinstance(value, bool)
    if not real or not math.isfinite(value):
        raise ValueError(f"{name}: must be one finite number; got {shown(value)}.")
    return int(value) if isinstance(value, numbers.Integral) else float(value)


def steady(value, decimals):
    """Return a number as it's stored, three decimals behind the last one that is printed.

    The digits behind that depend on the processor, and files should not.

    Parameters
    ----------
    value : int or float
        The number; an integer is stored whole.
    decimals : int
        Decimals that are printed.

    Examples
    --------
    >>> steady(0.12345678, 2), steady(12345.678, -2), steady(7, 0)
    (0.12346, 12345.7, 7)
    """
    return value if isinstance(value, int) else round(value, decimals + MORE) + 0.0


def decimals_of(value, digits):
    """Return the decimals that significant digits come to: -2 for 12345.678 with three."""
    if digits is None or value == 0:
        return 0
    return digits - 1 - math.floor(math.log10(abs(value)))


def significant(name, value, digits):
    """Return a number as printed with significant digits.

    Parameters
    ----------
    name : str
        What the number is, for the error.
    value : int or float
        The number.
    digits : int or None
        Significant digits, 1 to 12; None for an integer that's printed whole.

    Raises
    ------
    ValueError
        If the digits are missing or not such an integer.

    Examples
    --------
    >>> significant("length", 1.0987, 3), significant("gap", 5.6e-4, 2)
    ('1.10', '5.6e-4')
    """
    if digits is None:
        if isinstance(value, int):
            return str(value)
        raise ValueError(f"{name}: digits must say how many of {value} are meant.")
    if isinstance(digits, bool) or not isinstance(digits, int) or not 1 <= digits <= 12:
        raise ValueError(f"{name}: digits must be an integer from 1 to 12; got {shown(digits)}.")
    scientific = f"{value:.{digits - 1}e}"
    if value == 0 or -3 <= int(scientific.partition("e")[2]) < digits:
        return f"{float(scientific) + 0.0:#.{digits}g}".removesuffix(".")
    return exponent(scientific)


def exponent(text):
    """Return ``5.6e-4`` for ``5.6e-04``."""
    return re.sub(r"e([+-]?)0*(\d+)", lambda m: f"e{m[1].strip('+')}{m[2]}", text)


def cell(name, value, decimals):
    """Return a table's cell as printed.

    Parameters
    ----------
    name : str
        The table's name, for the error.
    value : int, float or str
        What the cell holds; text is left as it is.
    decimals : int or None
        Decimals of a float.

    Raises
    ------
    ValueError
        If a number isn't finite, or a float has no decimals.
    """
    if isinstance(value, str):
        return value
    value = number(name, value)
    if isinstance(value, int):
        return str(value)
    if decimals is None:
        raise ValueError(f"{name}: decimals must say how many of {value} are meant.")
    return f"{round(value, decimals) + 0.0:.{decimals}f}"  # adding 0.0 turns -0.0 into 0.0


def in_words(number):
    """Return a whole number from zero to twelve as a word, a greater one in digits.

    Examples
    --------
    >>> in_words(5), in_words(40)
    ('five', '40')
    """
    words = "zero one two three four five six seven eight nine ten eleven twelve".split()
    return words[number] if number < len(words) else str(number)
