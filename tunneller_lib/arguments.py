"""Arguments as float arrays, or a ValueError of one sentence: which, the rule, what came."""

import numpy as np

LEAST, MOST = 1e-100, 1e100  # lengths whose squares, and products of three, are sound floats


def real(name, value):
    """Return `value` as a float array of any shape, or say why it can't be one.

    Parameters
    ----------
    name : str
        The argument's name, for the message.
    value : array_like
        Whole or floating-point numbers; NaN and infinity pass.

    Returns
    -------
    array : (...) float
        A new array, or `value` itself where it is one already; nobody writes to it.

    Raises
    ------
    ValueError
        If `value` isn't an array of real numbers.

    Examples
    --------
    >>> real("theta", [1, 2])
    array([1., 2.])
    """
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray(None)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name}: must hold real numbers in a regular array; got {value!r}.")
    return np.asarray(array, dtype=float)


def positive(name, value):
    """Return `value` as a float, which must be one finite number above zero."""
    number = real(name, value)
    if number.ndim or not (np.isfinite(number) and number > 0):
        raise ValueError(f"{name}: must be one finite number above zero; got {value!r}.")
    return float(number)


def finite(name, value):
    """Return `value` as a float, which must be one finite number."""
    number = real(name, value)
    if number.ndim or not np.isfinite(number):
        raise ValueError(f"{name}: must be one finite number; got {value!r}.")
    return float(number)


def whole(name, value, low, high):
    """Return `value` as an int64 array of any shape with low <= value <= high.

    The argument's name is for the message.
    """
    try:
        array = np.asarray(value)
    except (ValueError, OverflowError):
        array = np.asarray(None)
    # Two passes that keep nothing are twice as fast as comparisons of every number.
    within = array.dtype.kind in "iu" and (
        not array.size or (low <= array.min() and array.max() <= high)
    )
    if not within:
        raise ValueError(f"{name}: must hold whole numbers from {low} to {high}; got {value!r}.")
    return array.astype(np.int64)


def not_negative(name, value):
    """Return `value` as a float, which must be one finite number, zero or above."""
    number = real(name, value)
    if number.ndim or not (np.isfinite(number) and number >= 0):
        raise ValueError(f"{name}: must be one finite number, not below zero; got {value!r}.")
    return float(number)


def instance(name, value, kind):
    """Return `value`, which must be an instance of the class `kind`."""
    if not isinstance(value, kind):
        raise ValueError(f"{name}: must be of class {kind.__name__}; got {value!r}.")
    return value


def points(name, value):
    """Return `value` as a float array (..., 3) of points."""
    return _last_axis(name, value, 3, "x, y, z")


def finite_points(name, value):
    """Return `value` as a float array (..., 3) of points, none of them NaN or infinite."""
    array = points(name, value)
    sound = np.isfinite(array)
    if not sound.all():
        raise ValueError(f"{name}: must hold finite numbers; got {array[~sound][0]}.")
    return array


def near_points(name, value):
    """Return `value` as `finite_points`, none further than 1e100 along any axis."""
    array = finite_points(name, value)
    far = np.abs(array) > MOST
    if far.any():
        raise ValueError(f"{name}: must hold numbers of at most {MOST:g} in size; got "
                         f"{array[far][0]:g}.")  # fmt: skip
    return array


def sizes(name, value):
    """Return `value`, an array (...) of lengths, each zero or from 1e-100 to 1e100 in size."""
    array = np.abs(value)
    wrong = ~((array == 0) | (array >= LEAST) & (array <= MOST))
    if wrong.any():
        raise ValueError(f"{name}: must be zero or from {LEAST:g} to {MOST:g} in size, whose "
                         f"square is a number; got {array[wrong][0]:g}.")  # fmt: skip
    return value


def directions(name, value):
    """Return `value` as vectors (..., 3) of `sizes` that have squares, none of them zero."""
    array = finite_points(name, value)
    if not np.all(np.any(array != 0, axis=-1)):
        raise ValueError(f"{name}: must not be zero; got (0, 0, 0).")
    sizes(name, np.abs(array).max(axis=-1))
    return array


def point(name, value):
    """Return `value` as a tuple of three floats: one finite point."""
    array = finite_points(name, value)
    if array.ndim != 1:
        raise ValueError(f"{name}: must be one point (3,); got {array.shape}.")
    return tuple(array.tolist())


def positions(name, value):
    """Return `value` as a float array (..., 2) of joint positions."""
    return _last_axis(name, value, 2, "theta, phi")


def _last_axis(name, value, size, axes):
    array = real(name, value)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(
            f"{name}: the last axis must hold {axes}, so its shape must be (..., {size}); "
            f"got {array.shape}."
        )
    return array
