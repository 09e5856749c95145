"""Plane drawings of paths and lines on the torus, each on the Axes `ax` it is given."""

from itertools import cycle

import numpy as np

from kit.style import COLOURS
from tunneller_lib.paths import (
    CHORD_PATHS,
    ChordLaw,
    competing_geodesics,
    geodesic_inverse,
    path_length,
)

from .plot import equal


def path_style(name):
    """Return how the chord path of this name is drawn, as options of matplotlib's plot."""
    path = CHORD_PATHS[name]
    return {"color": COLOURS[path.colour], "ls": path.line, "label": name}


def draw_ways(ax, torus, p, q):
    """Draw the geodesic and its stand-ins between two positions in the plane of the joint angles.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface.
    p, q : (2,) float
        Joint positions (theta, phi) of the ends, in rad.
    """
    geodesic = geodesic_inverse(torus, p, q)
    theta, phi = np.degrees(geodesic.points(201).position.T)
    label = f"geodesic, {geodesic.length:.3f} m"
    ax.plot(theta, phi, color=COLOURS["geodesic"], label=label)
    t = np.linspace(0, 1, 201)
    for name in ("projected chord", "joint space"):
        path = CHORD_PATHS[name]
        theta, phi = np.degrees(path(torus, p, q, t).T)
        excess = 1e6 * (path_length(torus, path, p, q) / geodesic.length - 1)
        told = f"longer by {float(f'{excess:.3g}'):g} ppm"  # three digits, no exponent
        style = path_style(name) | {"label": f"{name}, {told}"}
        ax.plot(theta, phi, **style)
    ax.set(xlabel=r"$\theta$ / deg", ylabel=r"$\varphi$ / deg")
    ax.legend()


def draw_competing(ax, torus, p, q):
    """Draw the geodesics that may be the shortest on a ring, unrolled.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, with r > R.
    p, q : (2,) float
        Joint positions (theta, phi) of the ends, in rad.
    """
    found = competing_geodesics(torus, p, q)
    shortest = {"color": COLOURS["geodesic"], "lw": 2}
    longer = {"color": "0.55", "lw": 1}
    box = {"fc": "w", "ec": "none", "pad": 0.8}
    middle = {"fontsize": 8, "ha": "center", "va": "center"}
    for k, way in enumerate(found.points(201).position):
        theta, phi = np.degrees(way.T)
        ax.plot(theta, phi, **(shortest if k == 0 else longer))
        at = 155 if found.kind[k] == "inner" else 100
        ax.annotate(f"{found.length[k]:.2f} m", (theta[at], phi[at]), bbox=box, **middle)
    (theta, phi), (theta1, phi1) = np.degrees([p, q])
    for turn in (0, -360):
        ax.plot(theta1 + np.array([turn, turn]), phi1 + np.array([0, 360]), "k.")
        ax.annotate("Q", (theta1 + turn, phi1 - 30), ha="center")
    ax.plot(theta, phi, "k.")
    ax.annotate("P", (theta, phi - 32), ha="center")
    ax.set(xlabel=r"$\theta$ / deg", ylabel=r"$\varphi$ / deg", xlim=(-190, 190))
    ax.set_xticks(range(-180, 181, 60))


def draw_deviations(ax, torus, p, q, *, rules):
    """Draw how far stand-ins for the geodesic lie beside it.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface.
    p, q : (2,) float
        Joint positions (theta, phi) of the ends, in rad.
    rules : list of str
        Names in `CHORD_PATHS`.
    """
    samples = geodesic_inverse(torus, p, q).points(513)
    t = np.linspace(0, 1, 65)
    chord = np.linalg.norm(np.diff(torus.point(*np.transpose([p, q])), axis=0))
    for name in rules:
        off = samples.deviation(CHORD_PATHS[name](torus, p, q, t))
        ax.plot((t - 0.5) * chord, 1000 * off, **path_style(name))
    ax.axhline(0, color=COLOURS["geodesic"], lw=0.8)
    ax.set(xlabel="place along the chord / m", ylabel="beside the geodesic / mm")


def draw_gap(ax, tori, p, q):
    """Draw the law of the projected chord's gap beside the geodesic, and the gap on some tori.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    tori : list of Torus
        The surfaces on which the gap is measured.
    p, q : (2,) float
        Joint positions (theta, phi) of the ends, in rad.
    """
    law = ChordLaw(p, q)
    u = np.linspace(0, 1, 129)
    ax.plot(np.degrees(u * law.angle), law.gap(u), color=COLOURS["chord"], label="law")
    t = np.linspace(0, 1, 25)
    half = law.angle / 2
    turned = half + np.arctan((2 * t - 1) * np.tan(half))  # of the chord's points, as on a sphere
    for torus, marker in zip(tori, cycle("^ox"), strict=False):
        way = CHORD_PATHS["projected chord"](torus, p, q, t)
        off = geodesic_inverse(torus, p, q).points(513).deviation(way)
        label = f"$R/r$ = {torus.R / torus.r:.3g}"
        look = {"ls": "", "marker": marker, "ms": 4, "color": "0.45"}
        ax.plot(np.degrees(turned), off / torus.r, **look, label=label)
    ax.set(xlabel=r"angle $s$ along the way / °", ylabel=r"gap $\delta$ beside the geodesic / $r$")


def draw_ruling(ax, torus, y, z):
    """Draw a ruling of the tunnel, and the circles in which its plane y cuts the torus.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    torus : Torus
        The surface, in m.
    y, z : float
        Place of the ruling, which is parallel to x, in m.
    """
    half = np.sqrt(max(torus.R**2 - y**2, 0))
    turn = np.linspace(0, 2 * np.pi, 361)
    for radius, sheet in ((torus.r + half, "torus"), (torus.r - half, "inner sheet")):
        ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=COLOURS[sheet], lw=2)
    reach = 1.1 * (torus.r + torus.R)
    ax.plot([-reach, reach], [z, z], color=COLOURS["chord"], lw=1)
    t = torus.meet_line((0.0, y, z), (1.0, y, z))
    t = t[np.isfinite(t)]
    ax.plot(t, np.full_like(t, z), "o", color=COLOURS["chord"])
    ax.plot(t[-1:], t[-1:] * 0 + z, "o", color=COLOURS["tangent sphere"], ms=8)
    equal(ax, "x / m (forwards)", "z / m (up)")
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach))
