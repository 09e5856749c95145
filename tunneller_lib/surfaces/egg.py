"""The egg-shaped sewer section, four blended arcs, and its inward offset: Fig. 4."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Finite, Length, checked
from .section import Arc, Profile, Section

WALL = np.arctan2(3, 4)  # angle of a wall arc: the centres make a 3-4-5 triangle


@dataclass(frozen=True)
@checked
class Egg(Section):
    """The standard sewer section, in the plane of y (left) and z (up).

    Parameters
    ----------
    a : float
        Radius of the roof, in m; the walls have 3a, the invert a/2. The section fills a box of
        2a by 3a.

    Raises
    ------
    ValueError
        If a isn't one number from 1e-100 to 1e100.

    Notes
    -----
    Tunnelling robot, section 2 and Fig. 4. Origin in the roof's centre; arc length begins at
    the left springing (a, 0) and runs over the crown. Walls about (-+2a, 0) over atan(3/4) each,
    invert about (0, -1.5a) over the rest.

    Examples
    --------
    >>> Egg(0.5).point(0.5 * np.pi / 2).round(12)
    array([0. , 0.5])
    """

    a: Length

    @property
    def arcs(self):
        """Return the four arcs: roof, right wall, invert and left wall."""
        return self.offset(0).arcs

    @checked
    def offset(self, d: Finite):
        """Return the curve at a distance d inside the section.

        Parameters
        ----------
        d : float
            In m; for the centre of a cutter its radius less the depth of cut. Negative: outside.

        Returns
        -------
        profile : Profile
            Arcs with the same centres and with radii less by d. From d = a/2 on the invert's arc is
            gone, and the walls meet in a corner at (0, -sqrt((3a - d)^2 - 4a^2)). To offset it
            further, offset the egg by the sum.

        Raises
        ------
        ValueError
            If d >= a, where nothing of the section is left.

        Examples
        --------
        >>> Egg(0.5).offset(0.5)  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ValueError: d: must be below the roof's radius a = 0.5 m, or nothing of the ...
        """
        a = self.a
        if d >= a:
            raise ValueError(
                f"d: must be below the roof's radius a = {a:g} m, or nothing of the section is "
                f"left; got {d:g} m."
            )
        # Where the invert's arc has shrunk away the walls run on until they meet.
        sweep = WALL if d < a / 2 else np.arccos(2 * a / (3 * a - d))
        roof = Arc(0.0, 0.0, a - d, 0.0, np.pi)
        right = Arc(2 * a, 0.0, 3 * a - d, np.pi, sweep)
        invert = Arc(0.0, -1.5 * a, a / 2 - d, np.pi + WALL, np.pi - 2 * WALL)
        left = Arc(-2 * a, 0.0, 3 * a - d, 2 * np.pi - sweep, sweep)
        return Profile((roof, right, invert, left) if d < a / 2 else (roof, right, left))
