"""Why a geodesic is the shortest way: plane drawings, each on the Axes `ax` it is given."""

import numpy as np

from kit.style import COLOURS
from tunneller_lib.paths import competing_geodesics, geodesic_direct

FAN = np.radians(np.linspace(178, 33, 500))  # azimuths, from straight down to steeply up


def draw_half_swings(ax, tori):
    """Draw the angle of half a swing over Clairaut's constant, a curve for each torus.

    The constant is a share of the outer equator's radius, where the curve ends in a dot.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    tori : list of Torus
        At most three, which differ by the line's style.
    """
    for torus, line in zip(tori, ("-", "--", ":"), strict=False):
        gap, wide = torus.r - torus.R, torus.r + torus.R
        c = max(gap, 0.0) + min(2 * torus.R, wide) * np.linspace(0.002, 1, 300)
        # T(c) of the proof: on a periodic integrand equal steps are as good as any rule.
        x = (np.arange(4000) + 0.5) * np.pi / 8000
        rho = 1 / np.hypot(np.cos(x) / c[:, None], np.sin(x) / wide)
        turned = 180 * torus.R / wide * np.sqrt(1 + 2 * torus.r / (rho - gap)).mean(axis=1)
        label = f"r/R = {torus.r / torus.R:g}"
        ax.plot(c / wide, turned, line, color=COLOURS["geodesic"], label=label)
        ax.plot(1, turned[-1], "k.")
    ax.set(xlabel="c / (r + R)", ylabel="half a swing / deg", ylim=(60, 360))
    ax.legend(fontsize=7)


def draw_arrivals(ax, torus, begin, level):
    """Draw how far geodesics in a fan of directions have turned when they meet a parallel.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, with r > R.
    begin : (2,) float
        Where they leave: theta and phi in rad.
    level : float
        The parallel's phi, in rad.

    Returns
    -------
    lines : list of matplotlib.lines.Line2D
        First and second arrivals, in deg over the azimuth in deg.
    """
    fan = geodesic_direct(torus, begin, FAN, 16.0 * torus.R, 4001)
    turns, heights = np.moveaxis(fan.position, -1, 0)
    met = np.diff(np.sign(heights - level), axis=1) != 0
    count = np.cumsum(met, axis=1) * met
    lines = []
    for number, line, words in ((1, "-", "first arrival"), (2, "--", "second arrival")):
        which, place = np.nonzero(count == number)
        arrived = np.degrees(FAN[which]), np.degrees(turns[which, place])
        lines += ax.plot(*arrived, line, color=COLOURS["geodesic"], label=words)
    ax.set(xlabel="azimuth at P / deg", ylabel="turned at Q's parallel / deg")
    ax.set(xlim=(180, 30), ylim=(0, 360))
    ax.legend(fontsize=7)
    return lines


def draw_mirrored(ax, torus, begin, end):
    """Draw a geodesic that turns backwards by more than half a turn, and its mirror image.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, with r > R.
    begin, end : (2,) float
        Its ends: theta and phi in rad; theta is 0 at the one, between 0 and pi at the other.
    """
    ways = competing_geodesics(torus, begin, end)
    backwards = np.flatnonzero((np.sin(ways.azimuth1) < 0) & (ways.kind == "outer"))
    theta, phi = ways.points(401).position[backwards[0]].T
    told = f"turns by {abs(np.degrees(theta[-1] - theta[0])):.0f} deg"
    ax.plot(np.degrees(theta), np.degrees(phi), color="0.55", label=told)
    near = theta > -np.pi
    mirrored = np.degrees(np.where(near, -theta, theta + 2 * np.pi))
    ax.plot(mirrored, np.degrees(phi), color=COLOURS["geodesic"], label="mirrored")
    for at in (-180, 180):
        ax.axvline(at, color="0.8", lw=0.8)
    ax.plot(*np.degrees(begin), "k.")
    ax.annotate("P", np.degrees(begin) + np.array([8, 3]))
    for lap in (0, -360):
        place = np.degrees(end) + np.array([lap, 0])
        ax.plot(*place, "k.")
        ax.annotate("Q", place + np.array([8, 3]))
    ax.set(xlabel="theta / deg", ylabel="phi / deg", xlim=(-230, 230))
    ax.set(xticks=range(-180, 181, 90), ylim=(-30, 230))
    ax.legend(fontsize=7, loc="upper center")
