"""The way of the cutter's centre through its knots, with rounded corners, by its own length."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array, Length0, Lengths, Positions, Whole, checked, rule_of, shown
from ..paths import corrected_chord, project_chord
from ..paths.circuit import Circuit

SAMPLES = 17  # points of the way between two knots, through which a cubic spline goes
ROUNDED = 3 / 16  # distance of a rounded corner from its knot over turn times half width

WAYS = {
    "projected chord": partial(project_chord, spacing="arc"),
    "corrected chord": corrected_chord,
}


_RISING = "rise from 0", lambda knots: knots[:1].tolist() == [0] and np.all(np.diff(knots) > 0)
Knots = Array("(n,) float", "m", also=_RISING)


@dataclass(frozen=True, eq=False)
class Route:
    """A lap's way in joint space, as a function of the cutter's length of way l, in m.

    `route_through` makes one.

    Parameters
    ----------
    ends : (n + 1,) float
        Lengths of way at the n knots and at the lap's end, in m.
    places : (n + 1,) float
        Arc lengths of the same along the offset section, in m.
    splines : (4, 16, n, 2) float
        Cubic pieces of each of the n ways between knots, over shares of it, highest power first.
    kinks : (n + 1, 2) float
        Change of the slope dq/dl at each of them, in rad/m; zero where the lap begins and ends.
    halves : (n + 1,) float
        Half widths over which these corners are rounded, in m.
    """

    ends: np.ndarray
    places: np.ndarray
    splines: np.ndarray
    kinks: np.ndarray
    halves: np.ndarray

    @property
    def length(self):
        """Return the length of the lap, in m."""
        return float(self.ends[-1])

    @checked
    def at(self, length: Lengths, *, order: Whole(0, 2) = 0):
        """Return joint positions, or a derivative of them by the length of way.

        Parameters
        ----------
        length : (...) float
            Lengths of way from the lap's begin, in m.
        order : int
            Of the derivative, 0 to 2.

        Returns
        -------
        position : (..., 2) float
            In rad/m^order.

        Notes
        -----
        A kink of the slope by J at l = 0 is J |l| / 2. It is replaced by J h c(l / h) over the
        half width h, with c(x) = 3/16 + 3 x^2/8 - x^4/16, which agrees with |x| / 2 at x = 1 and -1
        up to the second derivative. The way misses the corner by 3/16 |J| h.
        """
        k, corner, bump = self.rounding(length, order=order)
        lengths = np.diff(self.ends)
        u = (length - self.ends[k]) / lengths[k]
        pieces = self.splines.shape[1]
        i = np.clip(np.floor(u * pieces), 0, pieces - 1).astype(int)
        found = _power(self.splines[:, i, k], (u - i / pieces)[..., None], order)
        found = found / (lengths[k] ** order)[..., None]
        return found + self.kinks[corner] * bump[..., None]

    def rounding(self, length, *, order=0):
        """Return the way's and the corner's number, and the factor of its kink, at each length.

        The kink times that factor is added to the sharp way, or to its derivative of an `order`.
        """
        k = np.clip(np.searchsorted(self.ends, length, side="right") - 1, 0, len(self.ends) - 2)
        u = (length - self.ends[k]) / np.diff(self.ends)[k]
        first = u < 0.5
        corner = np.where(first, k, k + 1)
        h = self.halves[corner]
        # Far from any knot there is no kink; clipped there, x has finite powers.
        x = np.clip((length - self.ends[corner]) / np.where(h > 0, h, 1), -1, 1)
        bump = np.where((h > 0) & (np.abs(x) < 1), _bump(x, np.where(first, 1.0, -1.0), order), 0)
        return k, corner, bump * np.where(h > 0, h, 1) ** (1.0 - order)

    @checked
    def place(self, length: Lengths):
        """Return the arc lengths (...) along the offset section, in m, at lengths of way."""
        return np.interp(length, self.ends, self.places)


def path_points(torus, path):
    """Return the function (p, q, points) -> (k, points, 2) of a path, in equal arcs."""
    return partial(WAYS[path], torus)


@checked
def route_through(
    circuit: Circuit,
    knots: Knots,
    *,
    way: Callable[[ArrayLike, ArrayLike, int], object] | None = None,
    blend: Length0 = 0.0,
):
    """Return the `Route` through knots and back to the first.

    Parameters
    ----------
    circuit : Circuit
        The circuit on which the knots are.
    knots : (n,) float
        Arc lengths of the knots along the offset section, in m, rising from 0.
    way : function, optional
        (p, q, count) -> (n, count, 2): positions in equal arcs from knots p to knots q (n, 2);
        projected chords by default.
    blend : float
        Distance by which a rounded corner may miss its knot, in m; 0 leaves all corners sharp. Two
        corners share the way between them.

    Returns
    -------
    route : Route
        The route, without a corner where it begins and ends.

    Raises
    ------
    ValueError
        If `way` doesn't return such positions.

    Examples
    --------
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> route_through(circuit, [0.0, 1.0], way=lambda p, q, count: (0, 0))
    Traceback (most recent call last):
    ValueError: way: must return positions (2, 17, 2); got array([0., 0.]).
    """
    torus = circuit.machine.torus
    places = np.append(knots, circuit.profile.perimeter)
    at = circuit.position(places)
    at[-1] = at[0]  # not off by a rounding
    way = way or path_points(torus, "projected chord")
    path = rule_of(Positions).check("way", way(at[:-1], at[1:], SAMPLES))
    if path.shape != (shape := (len(knots), SAMPLES, 2)):
        raise ValueError(f"way: must return positions {shape}; got {shown(path)}.")
    splines = _splines(np.moveaxis(path, 1, 0))
    # The arcs are equal, so any mean of the speed over the shares is the length.
    middle = _power(splines, 0.5 / (SAMPLES - 1), 0), _power(splines, 0.5 / (SAMPLES - 1), 1)
    lengths = np.mean(np.linalg.norm(torus.velocity(*middle), axis=-1), axis=0)
    before = _power(splines[:, -1], 1 / (SAMPLES - 1), 1) / lengths[:, None]
    after = splines[2, 0] / lengths[:, None]
    kinks = np.zeros_like(at)
    kinks[1:-1] = after[1:] - before[:-1]
    turn = np.linalg.norm(torus.velocity(at, kinks), axis=-1)
    room = np.zeros(len(at))
    room[1:-1] = np.minimum(lengths[1:], lengths[:-1]) / 2
    widest = np.divide(blend, ROUNDED * turn, out=np.full_like(turn, np.inf), where=turn > 0)
    return Route(
        ends=np.concatenate([[0], np.cumsum(lengths)]),
        places=places,
        splines=splines,
        kinks=kinks,
        halves=np.minimum(room, widest),
    )


def _splines(samples):
    """Return cubic pieces (4, m, ...) through samples (m + 1, ...) at equal shares from 0 to 1.

    Their first two derivatives are continuous, and at the first and the last sample between two
    pieces the third as well ("not a knot").
    """
    last = len(samples) - 1
    system = np.diag(np.full(last, 1.0), -1) + np.diag(np.full(last, 1.0), 1) + 4 * np.eye(last + 1)
    system[0, :2] = system[-1, :-3:-1] = 1, 2
    right = np.empty_like(samples)
    right[1:-1] = 3 * (samples[2:] - samples[:-2])
    right[0] = (-5 * samples[0] + 4 * samples[1] + samples[2]) / 2
    right[-1] = (5 * samples[-1] - 4 * samples[-2] - samples[-3]) / 2
    slopes = np.linalg.solve(system, right.reshape(last + 1, -1)).reshape(samples.shape)
    rise = np.diff(samples, axis=0)
    curved = 3 * rise - 2 * slopes[:-1] - slopes[1:]
    cubic = slopes[:-1] + slopes[1:] - 2 * rise
    # So far each piece had the length 1.
    return np.stack([cubic * last**3, curved * last**2, slopes[:-1] * last, samples[:-1]])


def _power(coefficients, x, order):
    """Return a derivative of cubics with coefficients (4, ...), the highest power first."""
    a, b, c, d = coefficients
    if order == 0:
        return ((a * x + b) * x + c) * x + d
    if order == 1:
        return (3 * a * x + 2 * b) * x + c
    return 6 * a * x + 2 * b


def _bump(x, sign, order):
    """Return a derivative of c(x) - |x| / 2, with the `sign` of x, which decides at zero."""
    if order == 0:
        return 3 / 16 + 3 * x**2 / 8 - x**4 / 16 - sign * x / 2
    if order == 1:
        return 3 * x / 4 - x**3 / 4 - sign / 2
    return 3 * (1 - x**2) / 4
