"""Points along geodesics of given starts and directions, by quadrature, however long they are.

Along an orbit (geodesic_orbit) arc length and turned angle are tabulated as series; the arc length
is solved for its place, which tells the rest. `follow_each` is the loop over geodesics for
`compiled.call`; arrays do the same, with the same bits.
"""

import math

import numpy as np

from ..arguments import Lengths, checked
from ..kernels import compiled
from ..kernels.compiled import loop
from ..kernels.elementwise import NUMBERS, divided, smaller, where
from ..surfaces import Torus
from .bounds import check_ratio
from .geodesic_orbit import (
    MOST_PANELS,
    TERMS,
    Orbit,
    Start,
    headed,
    nearer,
    orbit_of,
    panel_place,
    panel_rule,
    point_at,
    rates,
    series_sum,
    whole_part,
)

ROUNDS = 30  # Newton's method takes about four
BLOCK = 8192  # points at a time: they need the same room however many there are
EACH, POINT = 1.1e-4, 1.2e-5  # s in plain Python for a geodesic, and for each of its points
SOON = 1e-3  # s, about what arrays take at least
FASTER = 15  # so many times as fast as plain Python are arrays where they are large
KIND = "points of geodesics"  # of work, for `compiled`
LATE = 0.9  # of the angle that half of a swing turns, past which what is left of it is counted
ROOM = (2, TERMS), (3, MOST_PANELS + 1), (2, MOST_PANELS, TERMS + 1)


@checked
def half_swing(torus: Torus, clairaut: Lengths):
    """Return what geodesics turn, and how long they are, from one turning point to the next.

    Parameters
    ----------
    torus : Torus
        The surface, r / R from 1e-100 to 1e100.
    clairaut : (...) float
        rho at the turning points, in m, above zero and above r - R, and at most r + R.

    Returns
    -------
    turned, length : (...) float
        In rad and m.

    Raises
    ------
    ValueError
        If such a geodesic doesn't swing, or r / R is out of proportion.

    Notes
    -----
    The turned angle, which the report calls T(c), falls as c grows, from infinity, or from
    pi / sqrt(1 - (r / R)^2) on a spindle, to pi / sqrt(1 + r / R) on the outer equator.

    Examples
    --------
    >>> turned, length = half_swing(Torus(3, 1), 4)
    >>> round(float(turned / np.pi), 12), round(float(length / np.pi), 12)
    (0.5, 2.0)
    """
    check_ratio(torus)
    narrow = max(torus.r - torus.R, 0)
    wide = torus.r + torus.R
    if np.any((clairaut <= narrow) | (clairaut > wide)):
        raise ValueError(
            f"clairaut: must be above {narrow:g} m and at most r + R = {wide:g} m, or nothing "
            f"swings; got {clairaut.min():g} to {clairaut.max():g} m."
        )
    sine = clairaut.ravel() / wide
    cosine = np.sqrt((1 - sine) * (1 + sine))
    orbit, _ = _orbits(torus.r / torus.R, np.zeros_like(sine), sine, cosine)
    half = np.empty((2, sine.size))
    for same in _alike(orbit):
        half[:, same] = _tabulated(Orbit(*(one[same] for one in orbit)))[0][:2, -1]
    length, turned = 2 * half.reshape(2, *clairaut.shape)
    return turned, torus.R * length


def trace(r, given, s):
    """Return points of geodesics.

    Parameters
    ----------
    r : float
        r / R.
    given : (3, n) float
        phi and azimuths at the starts, in rad, from -pi to pi, and the sines of the azimuths, zero
        along a meridian. What isn't finite has no answer.
    s : (n, p) float
        Arc lengths from the starts, over the radius of the tube.

    Returns
    -------
    found : (3, n, p) float
        What theta gained, phi and azimuths, in rad, each counted on; NaN where there is no answer.
    """
    found = np.empty((3, *s.shape))
    plain = EACH * len(s) + POINT * s.size
    compiled.expect(plain if plain < SOON else plain / FASTER, KIND)
    ready = compiled.ready(KIND)

    def follow(block):
        if ready or plain < SOON:
            found[:, block] = _one_by_one(r, given[:, block], s[block], ready)
        else:
            found[:, block] = _by_arrays(r, given[:, block], s[block].T).swapaxes(1, 2)

    compiled.each_block(follow, len(s), max(BLOCK // s.shape[1], 1), KIND)
    return found


def _one_by_one(r, given, s, ready):
    """Return what `trace` does, by a loop over geodesics; where it is `ready`, compiled."""
    # Copies, which may be written to and are of one order: one compiled form serves all.
    arguments = r, np.array(given, order="C"), np.array(s, order="C"), *panel_rule()
    room = [np.empty(shape) for shape in ROOM]
    found = np.empty((3, *s.shape))
    if ready:
        compiled.call(follow_each, *arguments, *room, found, **{**NUMBERS, "ratio": divided})
    else:
        lists = [one.tolist() for one in room]
        compiled.call_plain(follow_each, *arguments, *lists, found)
    return found


@loop(inlined=("growth", "two_to_bits", "rates", "series_sum", "nearer", "_tabulate"))
def follow_each(r, given, s, shares, integral, values, edges, series, found):
    """Write down points of geodesics.

    Parameters
    ----------
    r, given, s
        As of `trace`.
    shares, integral
        The `panel_rule`.
    values, edges, series
        Room of the shapes `ROOM`: for what nodes add to both integrals, what both are where panels
        begin and what is left of the second, and what they gain from there, as series.
    found : (3, n, p) float
        Filled with what theta gained, phi and azimuths.
    """
    for i in range(len(s)):
        phi = given[0][i]
        azimuth = given[1][i]
        sine = given[2][i]
        ways = s[i]
        heading = headed(r, phi, azimuth)
        whither = azimuth + ways[len(ways) - 1]
        sound = heading.on_sheet and whither - whither == 0
        if not sound:
            for k in range(len(ways)):
                found[0][i][k] = found[1][i][k] = found[2][i][k] = math.nan
        elif sine == 0:
            for k in range(len(ways)):
                found[0][i][k] = 0.0
                found[1][i][k] = phi + heading.rising * ways[k]
                found[2][i][k] = azimuth
        else:
            side = where(sine < 0, -1.0, 1.0)
            on_orbit = orbit_of(r, phi, side * sine, heading.cosine)
            _follow(on_orbit, side, ways, shares, integral, values, edges, series, i, found)


def _follow(on_orbit, side, ways, shares, integral, values, edges, series, i, found):
    """Write down points of geodesic i, which leaves the meridian to a side."""
    orbit, start = on_orbit
    count = int(orbit.panels)
    _tabulate(orbit, count, shares, integral, values, edges, series)
    y = panel_place(orbit, abs(start.t))
    panel = min(int(y), count - 1)
    x = 2 * (y - panel) - 1
    sign = where(start.t < 0, -1.0, 1.0)
    before = sign * (edges[0][panel] + series_sum(x, series[0][panel]))
    gained = series_sum(x, series[1][panel])
    turned = sign * (edges[1][panel] + gained)
    late = abs(turned) > LATE * edges[1][count]
    left = sign * (edges[2][panel] - gained)
    crossing = sign / 2  # the next of the outer equator, in swings
    whole = 2 * edges[0][count]  # of half a swing, or of a round
    turn = 2 * edges[1][count]
    for k in range(len(ways)):
        rest = ways[k] + before
        swings = whole_part(rest / whole)
        rest -= swings * whole
        sign = where(rest < 0, -1.0, 1.0)
        size = smaller(abs(rest), edges[0][count])
        panel = 0
        while panel + 1 < count and edges[0][panel + 1] <= size:
            panel += 1
        wanted = size - edges[0][panel]
        x = 2 * wanted / (edges[0][panel + 1] - edges[0][panel]) - 1
        for _ in range(ROUNDS):
            x, last = nearer(x, wanted, series[0][panel])
            if last:
                break
        gained = series_sum(x, series[1][panel])
        beyond = sign * (edges[1][panel] + gained) - turned + swings * turn
        # Where both are great and nearly the same, as by the node of a horn, what is left of them
        # to the outer equator isn't.
        if late and swings + sign / 2 == crossing:
            beyond = left - sign * (edges[2][panel] - gained)
        y = orbit.step * (panel + (1 + x) / 2)
        place, azimuth = point_at(orbit, start, swings + start.begun, y, sign)
        found[0][i][k] = side * beyond
        found[1][i][k] = place
        found[2][i][k] = side * azimuth


def _tabulate(orbit, count, shares, integral, values, edges, series):
    """Fill in what both integrals are where panels begin and end, and their series."""
    edges[0][0] = edges[1][0] = 0.0
    for panel in range(count):
        for k in range(TERMS):
            values[0][k], values[1][k] = rates(orbit, orbit.step * (panel + shares[k]))
        for one in range(2):
            terms = series[one][panel]
            for j in range(TERMS + 1):
                terms[j] = integral[0][j] * values[one][0]
            for k in range(1, TERMS):
                for j in range(TERMS + 1):
                    terms[j] += integral[k][j] * values[one][k]
            edges[one][panel + 1] = edges[one][panel] + series_sum(1.0, terms)
    edges[2][count] = 0.0
    for panel in range(count - 1, -1, -1):
        edges[2][panel] = edges[2][panel + 1] + series_sum(1.0, series[1][panel])


# ---- the same by arrays ----------------------------------------------------


def _by_arrays(r, given, s):
    """Return points (3, p, n) of geodesics whose arc lengths s are (p, n)."""
    phi, azimuth, sine = given
    heading = headed(r, phi, azimuth)
    whither = azimuth + s[-1]
    sound = heading.on_sheet & (whither - whither == 0)
    meridian = sound & (sine == 0)
    found = np.full((3, *s.shape), np.nan)
    found[0, :, meridian] = 0.0
    found[1, :, meridian] = (phi + heading.rising * s)[:, meridian].T
    found[2, :, meridian] = azimuth[meridian, None]
    other = np.flatnonzero(sound & ~meridian)
    side = np.where(sine < 0, -1.0, 1.0)[other]
    leaving = phi[other], side * sine[other], heading.cosine[other]
    orbit, start = _orbits(r, *leaving)
    for same in _alike(orbit):
        alike = Orbit(*(one[same] for one in orbit)), Start(*(one[same] for one in start))
        turned, place, direction = _on_orbits(*alike, s[:, other[same]])
        found[:, :, other[same]] = side[same] * turned, place, side[same] * direction
    return found


@np.errstate(divide="ignore")
def _orbits(r, phi, sine, cosine):
    """Return what `orbit_of` does, of arrays."""
    return orbit_of(r, phi, sine, cosine)


def _alike(orbit):
    """Yield which orbits (n,) have the same number of panels."""
    for count in np.unique(orbit.panels):
        yield np.flatnonzero(orbit.panels == count)


def _on_orbits(orbit, start, s):
    """Return the turned angle, phi and the azimuth (p, n) on orbits with the same panels."""
    edges, series = _tabulated(orbit)
    count = edges.shape[1] - 1
    column = np.arange(s.shape[1])
    y = panel_place(orbit, abs(start.t))
    panel = np.minimum(y.astype(int), count - 1)
    x = 2 * (y - panel) - 1
    sign = np.where(start.t < 0, -1.0, 1.0)
    gained = [series_sum(x, terms) for terms in series[:, :, panel, column]]
    before, turned = sign * (edges[:2, panel, column] + gained)
    late = abs(turned) > LATE * edges[1, count]
    left = sign * (edges[2, panel, column] - gained[1])
    crossing = sign / 2
    whole, turn = 2 * edges[:2, count]
    rest = s + before
    swings = whole_part(rest / whole)
    rest -= swings * whole
    sign = np.where(rest < 0, -1.0, 1.0)
    size = np.minimum(abs(rest), edges[0, count])
    panel = np.sum(edges[0, 1:count, None] <= size, axis=0)
    begin = edges[:, panel, column]
    terms = series[:, :, panel, column]
    wanted = size - begin[0]
    x = 2 * wanted / (edges[0, panel + 1, column] - begin[0]) - 1
    done = np.zeros(x.shape, dtype=bool)
    for _ in range(ROUNDS):
        moved, last = nearer(x, wanted, terms[0])
        x = np.where(done, x, moved)
        done |= last
        if np.all(done):
            break
    gained = series_sum(x, terms[1])
    beyond = sign * (begin[1] + gained) - turned + swings * turn
    same = late & (swings + sign / 2 == crossing)
    beyond = np.where(same, left - sign * (begin[2] - gained), beyond)
    y = orbit.step * (panel + (1 + x) / 2)
    return beyond, *point_at(orbit, start, swings + start.begun, y, sign)


def _tabulated(orbit):
    """Return what `_tabulate` fills in, (3, panels + 1, n) and (2, TERMS + 1, panels, n)."""
    shares, integral = panel_rule()
    count = int(orbit.panels.max(initial=1))
    edges = np.zeros((3, count + 1, orbit.c.size))
    series = np.empty((2, TERMS + 1, count, orbit.c.size))
    for panel in range(count):
        values = rates(orbit, orbit.step * (panel + shares[:, None]))
        for one in range(2):
            terms = integral[0, :, None] * values[one][0]
            for k in range(1, TERMS):
                terms += integral[k, :, None] * values[one][k]
            series[one, :, panel] = terms
            edges[one, panel + 1] = edges[one, panel] + series_sum(1.0, terms)
    for panel in range(count - 1, -1, -1):
        edges[2, panel] = edges[2, panel + 1] + series_sum(1.0, series[1, :, panel])
    return edges, series
