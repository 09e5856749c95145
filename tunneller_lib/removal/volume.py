"""The volume that a ball removes along its path: Tunnelling robot, section 3.3.2."""

import numpy as np

from ..arguments import MOST, Array, Length, Lengths, checked

_RADII = (
    f"hold radii above zero, of at most {MOST:g} m or infinite",
    lambda wall: np.all((wall > 0) & ((wall <= MOST) | np.isinf(wall))),
)
Walls = Array("(...) float", "m", loose=True, also=_RADII)


@checked
def half_lens(radius: Length, advance: Lengths):
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
    R = radius
    c = _between("advance", advance, 2 * R)
    # As the cap of height R - c/2; the printed sum cancels where the balls hardly overlap.
    height = R - c / 2
    return np.pi * height**2 * (3 * R - height) / 3


@checked
def bowl(radius: Length, advance: Lengths):
    """Return V_C = V_S - 2 V_D, what the advanced ball has beyond its first place.

    Parameters
    ----------
    radius : float
        R of the ball, in m.
    advance : (...) float
        c, from one centre to the other, in m, from 0 to 2R.

    Returns
    -------
    volume : (...) float
        In m^3; the difference of V_S and 2 V_D would lose the digits of a short advance.
    """
    R = radius
    c = _between("advance", advance, 2 * R)
    return np.pi * c * (R**2 - c**2 / 12)


@checked
def ring(radius: Length, advance: Lengths):
    """Return V_R = V_L + 2 V_D - V_S, the cusp between the two balls and their cylinder.

    Parameters
    ----------
    radius : float
        R of the balls, in m.
    advance : (...) float
        c, from one centre to the other, in m, from 0 to 2R.

    Returns
    -------
    volume : (...) float
        In m^3; it is pi c^3 / 12 whatever the radius.
    """
    return np.pi * _between("advance", advance, 2 * radius) ** 3 / 12


@checked
def groove_area(radius: Length, depth: Lengths, *, pitch: Lengths | None = None):
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


@checked
def removed_volume(
    radius: Length,
    advance: Array("(...) float", "m", low=0.0),
    depth: Lengths,
    *,
    wall: Walls = np.inf,
    pitch: Lengths | None = None,
):
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
    return advance * _rate(radius, depth, wall, pitch)


@checked
def advance_for_volume(
    radius: Length,
    volume: Array("(...) float", low=0.0),
    depth: Lengths,
    *,
    wall: Walls = np.inf,
    pitch: Lengths | None = None,
):
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

    Raises
    ------
    ValueError
        If a depth is 0, or so small that an advance would be longer than 1e100 m.

    Notes
    -----
    The volume is proportional to the advance, so that the document's "single change" of a step
    is enough; it holds for the arc of the path, and not for the parameter of the chord.
    """
    if np.any(depth == 0):
        raise ValueError("depth: must be above 0, or no advance removes anything; got 0.")
    rate = _rate(radius, depth, wall, pitch)
    with np.errstate(all="ignore"):
        advance = volume / rate
    if not np.all(advance <= MOST):
        raise ValueError(
            f"volume: must be removed by an advance of at most {MOST:g} m; got one that needs more."
        )
    return advance


def _rate(radius, depth, wall, pitch):
    """Return the volume per advance, in m^2."""
    area, moment = _area_and_moment(radius, depth, pitch)
    path = wall - radius + depth  # the centre's distance from the axis of the wall
    if not np.all(path > 0):
        raise ValueError(
            "wall: must be above the cutter's radius less its depth, or the cutter doesn't fit; "
            f"got {np.min(wall):g} m."
        )
    return area + moment / path


def _area_and_moment(radius, depth, pitch):
    """Return the area of a groove's section, and its first moment about the cutter's centre."""
    R = radius
    g = _between("depth", depth, 2 * R)
    # Not acos((R - g)/R), which has half of its digits left where the groove is shallow.
    beta = 2 * np.arcsin(np.sqrt(np.minimum(g / (2 * R), 1)))
    gamma = beta
    if pitch is not None:
        if np.any(g > R):
            raise ValueError(
                f"depth: must be at most the radius {R:g} m for passes that overlap; "
                f"got {np.max(g):g} m."
            )
        if not np.all(pitch > 0):
            raise ValueError(f"pitch: must be above 0; got {np.min(pitch):g}.")
        # Passes farther apart than the groove is wide don't meet: then the whole groove is new.
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


def _between(name, array, high):
    """Return an array of lengths, in m, which must lie between 0 and the highest."""
    wrong = (array < 0) | (array > high)
    if np.any(wrong):
        raise ValueError(
            f"{name}: must lie between 0 and {high:g} m; got {array[wrong].flat[0]:g}."
        )
    return array
