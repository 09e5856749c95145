"""Arguments to float arrays or a plain sentence, and the arithmetic that keeps digits.

The error-free transformations are those of Dekker (1971) and Knuth (1969), the difference of
products is Kahan's.
"""

import numpy as np

_SPLITTER = 2.0**27 + 1.0
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


def dot(a, b):
    """Return the scalar products of vectors along the last axis."""
    return np.einsum("...i,...i->...", a, b)


def norm(a):
    """Return the lengths of vectors along the last axis."""
    return np.sqrt(dot(a, a))


def two_product(a, b):
    """Return a * b rounded, and exactly what the rounding lost."""
    product = a * b
    a_high, b_high = _high(a), _high(b)
    a_low, b_low = a - a_high, b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def two_sum(a, b):
    """Return a + b rounded, and exactly what the rounding lost."""
    total = a + b
    shadow = total - a
    return total, (a - (total - shadow)) + (b - shadow)


def difference_of_products(a, b, c, d):
    """Return a * b - c * d to the last digits, however much of it cancels."""
    first, first_error = two_product(a, b)
    second, second_error = two_product(c, d)
    difference, error = two_sum(first, -second)
    return difference + (error + (first_error - second_error))


def cross(a, b):
    """Return the vector products along the last axis, each component to its last digits."""
    ax, ay, az = np.moveaxis(a, -1, 0)
    bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            difference_of_products(ay, bz, az, by),
            difference_of_products(az, bx, ax, bz),
            difference_of_products(ax, by, ay, bx),
        ],
        axis=-1,
    )


def radius_and_excess(x, z, r):
    """Return rho = hypot(x, z) and rho - r, the latter to 1e-23 of r.

    Each number is split at one fixed bit, 25 below r's first: the squares of the leading parts
    are whole multiples of one unit and sum exactly where rho is near r, the only place where
    digits could be lost. Correct while no square over- or underflows.
    """
    grid = 1.5 * 2.0 ** (np.frexp(r)[1] + 27)  # adding and subtracting it rounds to 2^-25 of r
    x_lead, z_lead, r_lead = (x + grid) - grid, (z + grid) - grid, (r + grid) - grid
    lead = x_lead * x_lead + z_lead * z_lead - r_lead * r_lead
    rest = (x - x_lead) * (x + x_lead) + (z - z_lead) * (z + z_lead)
    rest -= (r - r_lead) * (r + r_lead)
    rho = np.sqrt(x * x + z * z)
    return rho, (lead + rest) / (rho + r)


def in_blocks(function, rows, block=8192):
    """Return `function` of an array (..., n), called on blocks of rows that fit the cache.

    `function` maps (k, n) to (k, n). Numpy's intermediate arrays would otherwise travel to
    memory and back, which costs more than the arithmetic.
    """
    flat = rows.reshape(-1, rows.shape[-1])
    out = np.empty_like(flat)
    for start in range(0, len(flat), block):
        out[start : start + block] = function(flat[start : start + block])
    return out.reshape(rows.shape)


def _high(a):
    scaled = _SPLITTER * a
    return scaled - (scaled - a)
