"""Plane drawings of the machine on the Axes `ax`: its sizes, and its joint limits."""

import numpy as np
from matplotlib.patches import Arc, Circle

from kit.style import COLOURS

from .plot import equal


def draw_side_view(ax, machine, egg, theta):
    """Draw the machine from its right side at phi = 0, with its sizes and its place in the tunnel.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    machine : Machine
        Its sizes, in m.
    egg : Egg
        The tunnel's section, of which crown, roof centre and invert are seen.
    theta : float
        Angle of the horizontal joint, in rad.
    """
    tip = machine.torus.point(theta, 0.0)[[0, 2]]
    hinge = tip * machine.r / (machine.r + machine.R)
    centre = np.array([0.0, machine.height])
    for level, name in [(egg.a, "crown"), (0.0, "roof's centre"), (-2 * egg.a, "invert")]:
        style = "--" if level == 0 else "-"
        ax.axhline(level, color=COLOURS["tunnel"], ls=style, lw=1 if level == 0 else 3, zorder=0)
        ax.annotate(name, (-0.52, level), (0, 3), textcoords="offset points", fontsize=7)
    ax.plot(*np.transpose([centre, centre + hinge]), color=COLOURS["cutter"], lw=5)
    ax.plot(*np.transpose([centre + hinge, centre + tip]), color=COLOURS["machine"], lw=4)
    ax.plot(*np.transpose([centre, centre + hinge]), "o", color=COLOURS["chord"], ms=4)
    ax.add_patch(Circle(centre + tip, machine.cutter_radius, color=COLOURS["cutter"], alpha=0.5))
    ax.plot(*(centre + tip), "o", color=COLOURS["tangent sphere"])
    ax.plot([0, 0.45], [machine.height] * 2, color=COLOURS["chord"], lw=0.6)
    ax.add_patch(Arc((0, machine.height), 0.7, 0.7, theta1=0, theta2=-np.degrees(theta), lw=0.8))
    arrow = {"arrowstyle": "<->", "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (-0.15, 0.0), (-0.15, machine.height), arrowprops=arrow)
    beside = {"xytext": (-3, 0), "textcoords": "offset points", "ha": "right", "va": "center"}
    ax.annotate("$-z_c$", (-0.15, machine.height / 2), **beside)
    across = 0.06 * np.array([-tip[1], tip[0]]) / np.hypot(*tip)
    ax.annotate("$r$", centre + hinge / 2 + 2 * across, ha="center", va="center")
    ax.annotate("$R$", centre + (hinge + tip) / 2 + across, ha="center", va="center")
    ax.annotate("$-\\theta$", (0.38, machine.height + 0.07))
    equal(ax, "x / m (forwards)", "z / m (up)")


def draw_plan_view(ax, machine, phi):
    """Draw the machine from above at theta = 0, with the angle of its arm.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    machine : Machine
        Its sizes, in m.
    phi : float
        Angle of the tangential joint, in rad.
    """
    hinge = np.array([machine.r, 0.0])
    tip = machine.torus.point(0.0, phi)[:2]
    ax.axhline(0, color=COLOURS["chord"], lw=0.6)
    ax.plot([0, machine.r], [0, 0], color=COLOURS["cutter"], lw=5)
    ax.plot(*np.transpose([hinge, tip]), color=COLOURS["machine"], lw=4)
    ax.plot([0, machine.r], [0, 0], "o", color=COLOURS["chord"], ms=4)
    ax.add_patch(Circle(tip, machine.cutter_radius, color=COLOURS["cutter"], alpha=0.5))
    ax.plot(*tip, "o", color=COLOURS["tangent sphere"])
    ax.add_patch(Arc(hinge, 0.7, 0.7, theta1=0, theta2=np.degrees(phi), lw=0.8))
    ax.annotate(r"$\varphi$", (machine.r + 0.38, 0.05))
    ax.annotate("$r$", (machine.r / 2, -0.08), ha="center", va="center")
    ax.annotate("$R$", (hinge + tip) / 2 + [-0.05, 0.06], ha="center", va="center")
    equal(ax, "x / m (forwards)", "y / m (left)")


def draw_limits(ax, machine):
    """Draw the joint limits of a machine, phi against theta, in degrees; return the rectangle."""
    theta = np.degrees([machine.theta_min, machine.theta_max])
    phi = np.degrees([machine.phi_min, machine.phi_max])
    lines = ax.plot(theta[[0, 1, 1, 0, 0]], phi[[0, 0, 1, 1, 0]], color=COLOURS["machine"], lw=2)
    ax.set(xlabel=r"$\theta$ / deg", ylabel=r"$\varphi$ / deg")
    return lines
