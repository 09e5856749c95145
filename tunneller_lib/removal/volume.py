"""What a ball removes along its path: Tunnelling robot, section 3.3.2."""

import numpy as np

from ..arguments import positive, real


def half_lens(radius, advance):
    """Return V_D, half of the lens that a ball and its image share (Eq. 12), in m^3.

    Parameters
    ----------
    radius : float
        R of the ball, in m.
    advance : (...) float
        c, from one centre to the other, in m, from 0 to 2R.

    Returns
    -------
    volume : (...) float
        In m^3.

    Examples
    --------
    >>> bool(np.isclose(half_lens(1, 0), 2 * np.pi / 3))
    True
    """
    R, c = positive("radius", radius), _between("advance", advance, 0, 2 * radius)
    # As the cap of height R - c/2; the printed sum cancels where the balls hardly overlap.
    height = R - c / 2
    return np.pi * height**2 * (3 * R - height) / 3


def bowl(radius, advance):
    """Return V_C = V_S - 2 V_D, what the advanced ball has beyond its first place, in m^3.

    `radius` and `advance` as for `half_lens`; written so that short advances keep their digits.
    """
    R, c = positive("radius", radius), _between("advance", advance, 0, 2 * radius)
    return np.pi * c * (R**2 - c**2 / 12)


def ring(radius, advance):
    """Return V_R = V_L + 2 V_D - V_S, the cusp between the two balls and their cylinder, in m^3.

    `radius` and `advance` as for `half_lens`. It is pi c^3 / 12 whatever the radius.
    """
    positive("radius", radius)
    return np.pi * _between("advance", advance, 0, 2 * radius) ** 3 / 12


def groove_area(radius, depth, *, pitch=None):
    """Return the section of a groove at a plane wall, in m^2.

    Parameters
    ----------
    radius : float
        R of the cutter, in m.
    depth : (...) float
        g, how far it cuts behind the wall, in m, from 0 to 2R.
    pitch : (...) float, optional
        Distance of the passes, in m: the part that the earlier of two passes hasn't taken. Needs
        a depth of at most R.

    Returns
    -------
    area : (...) float
        In m^2.

    Notes
    -----
    The document takes a sector 2 acos((R - g)/R) R^2 for this segment. With half angles beta of
    the groove and gamma of the pitch it's R^2 (gamma - sin gamma cos gamma + 2 sin gamma
    (cos gamma - cos beta)), of which no part cancels.

    Examples
    --------
    >>> bool(np.isclose(groove_area(0.2, 0.2), np.pi * 0.2**2 / 2))
    True
    """
    return _area_and_moment(radius, depth, pitch)[0]


def removed_volume(radius, advance, depth, *, wall=np.inf, pitch=None):
    """Return the volume that a ball removes while it cuts a groove (section 3.3.2), in m^3.

    Parameters
    ----------
    radius : float
        R of the cutter, in m.
    advance : (...) float
        c, the length of its centre's path, in m, not negative.
    depth : (...) float
        g, how far it cuts behind the wall, in m, from 0 to 2R.
    wall : (...) float
        Radius W of a concave wall, in m, along whose circle the cutter moves; plane if infinite.
        The cutter must fit: W > R - g.
    pitch : (...) float, optional
        Distance from the earlier pass, in m, see `groove_area`.

    Returns
    -------
    volume : (...) float
        In m^3: between two positions of a cutter that has come along the groove.

    Notes
    -----
    The printed 2 acos((R - g)/R) (V_C + V_R) lacks 1/(2 pi), and a sector stands for a segment.
    Here it's the segment's area times its centroid's way, by Pappus.

    Examples
    --------
    >>> round(1e6 * removed_volume(0.2, 0.01, 0.02))  # cm^3
    23
    """
    return real("advance", _not_below("advance", advance)) * _rate(radius, depth, wall, pitch)


def advance_for_volume(radius, volume, depth, *, wall=np.inf, pitch=None):
    """Return the advance, in m, that removes a volume, the inverse of `removed_volume`.

    Parameters
    ----------
    radius : float
        R of the cutter, in m.
    volume : (...) float
        Wanted, in m^3.
    depth : (...) float
        g, in m, above 0.
    wall, pitch : (...) float
        As for `removed_volume`.

    Returns
    -------
    advance : (...) float
        Length of the centre's path, in m.

    Notes
    -----
    The volume is proportional to the advance, so that the document's "single change" of a step
    is enough; it holds for the arc of the path, and not for the parameter of the chord.
    """
    volume, depth = _not_below("volume", volume), real("depth", depth)
    if np.any(depth == 0):
        raise ValueError("depth: must be above 0, or no advance removes anything; got 0.")
    return volume / _rate(radius, depth, wall, pitch)


def _rate(radius, depth, wall, pitch):
    """Return the volume per advance, in m^2."""
    area, moment = _area_and_moment(radius, depth, pitch)
    path = real("wall", wall) - radius + depth
    if not np.all(path > 0):
        raise ValueError("wall: must be above the cutter's radius less its depth, or the cutter "
                         f"doesn't fit; got {wall}.")  # fmt: skip
    return area + moment / path


def _area_and_moment(radius, depth, pitch):
    """Return the area of a groove's section, and its first moment about the cutter's centre."""
    R = positive("radius", radius)
    g = _between("depth", depth, 0, 2 * R)
    beta = 2 * np.arcsin(np.sqrt(np.minimum(g / (2 * R), 1)))
    gamma = beta
    if pitch is not None:
        if np.any(g > R):
            raise ValueError(f"depth: must be at most the radius {R:g} m for passes that overlap.")
        pitch = real("pitch", pitch)
        if not np.all(pitch > 0):
            raise ValueError(f"pitch: must be above 0; got {pitch}.")
        gamma = np.minimum(beta, np.arcsin(np.minimum(pitch / (2 * R), 1)))
    excess = 2 * np.sin((beta + gamma) / 2) * np.sin((beta - gamma) / 2)  # cos gamma - cos beta
    area = R**2 * (_less_sine(2 * gamma) / 2 + 2 * np.sin(gamma) * excess)
    return area, R**3 * np.sin(gamma) * (np.sin(beta) ** 2 - np.sin(gamma) ** 2 / 3)


def _less_sine(x):
    """Return x - sin(x), which cancels for small x, where its series doesn't."""
    series = np.zeros_like(x)
    for n in range(21, 2, -2):
        series = x * x / (n * (n - 1)) * (1 - series)
    return np.where(x < 1, x * series, x - np.sin(x))


def _between(name, value, low, high):
    array = real(name, value)
    if not np.all((low <= array) & (array <= high)):
        raise ValueError(f"{name}: must lie between {low:g} and {high:g} m; got {value}.")
    return array


def _not_below(name, value):
    array = real(name, value)
    if not np.all(np.isfinite(array) & (array >= 0)):
        raise ValueError(f"{name}: must be finite and not negative; got {value}.")
    return array
