"""A model of the machine in space, its parts posed by the two joint angles (Fig. 1).

A substitute for the document's photograph: the joints' places are the torus' radii and the
machine's own sizes, as are box and holder where it has a body; every other shape (frame, tandem
cylinders, picks) is the study's invention.
"""

import numpy as np
import pyvista

from kit.scene import curve, surface
from kit.style import COLOURS

PICKS = 90  # carbide teeth drawn on the cutter
SOLID = {"smooth_shading": True, "split_sharp_edges": True}
BODY = {"color": COLOURS["machine"], **SOLID}
DARK = {"color": COLOURS["cutter"], **SOLID}
OIL = {"color": COLOURS["tangent sphere"], **SOLID}
STEEL = {"color": "#B8BFC6", **SOLID}
CASE = {"color": COLOURS["machine"], "opacity": 0.35}  # joints and cylinders show through it
THIN = {"color": COLOURS["chord"]}


def machine_model(machine, theta, phi):
    """Return the parts of the machine in its own frame, origin on the horizontal joint.

    Parameters
    ----------
    machine : Machine
        Its sizes; the box of its `body`, if it has one, takes the place of the drawn frame.
    theta, phi : float
        Joint angles in rad.

    Returns
    -------
    parts : list of (mesh, dict)
        Each mesh with the arguments for ``Plotter.add_mesh``; lengths in m.
    """
    r = machine.r
    R = machine.R
    ball = machine.cutter_radius
    t = 0.13 * R  # thickness of the limbs
    crank, arm, tip = _joints(machine, theta, phi)
    head = pyvista.Sphere(radius=0.9 * ball, theta_resolution=48, phi_resolution=48)
    parts = [
        *_base(machine, t),
        (_rod((0, -1.8 * t, 0), (0, 1.8 * t, 0), 0.35 * t), DARK),
        (crank.apply(_box((-0.45 * t, 0.45 * t), (-0.8 * t, 0.8 * t), (-2.5 * t, 0.6 * t))), STEEL),
        (crank.apply(_box((0, r), (-0.8 * t, 0.8 * t), (-0.6 * t, 0.6 * t))), STEEL),
        (crank.apply(_rod((r, 0, -t), (r, 0, t), 0.35 * t)), DARK),
        (arm.apply(_rod((0, 0, 0), (R - 0.6 * ball, 0, 0), 0.45 * t)), BODY),
        (arm.apply(_box((0.4 * R, 0.48 * R), (-1.1 * t, 1.1 * t), (-0.3 * t, 0.3 * t))), BODY),
        (tip.apply(head), DARK),
        (tip.apply(_picks(ball)), STEEL),
    ]
    if machine.body is not None and machine.body.has_holder:
        holder = machine.body.holder
        parts.append((tip.apply(_rod(holder.a, holder.b, holder.radius)), STEEL))
    # The base cylinder turns the bell crank by its lower leg; the tandem pair swings the arm.
    parts += _cylinder((-0.85 * R, 0, -1.9 * t), crank.apply((0, 0, -2.2 * t)), t)
    for side in (-t, t):
        foot = crank.apply((-0.2 * t, 0.95 * side, 0))
        parts += _cylinder(foot, arm.apply((0.44 * R, 0.95 * side, 0)), 0.7 * t)
    return parts


def _base(machine, t):
    """Return what doesn't move, with limbs t thick: the forks, and beams, or the body's box."""
    sides = -1.5 * t, t
    forks = [_box((-0.6 * t, 0.6 * t), (y, y + 0.5 * t), (-2.9 * t, 0.6 * t)) for y in sides]
    if (body := machine.body) is not None:
        box = _box((-body.length, 0), (-body.width / 2, body.width / 2), (body.low, body.high))
        return [(pyvista.merge(forks), BODY), (box, CASE)]
    back = -1.5 * machine.R
    beams = [_box((back, 0.6 * t), (y, y + 0.5 * t), (-2.9 * t, -2.1 * t)) for y in sides]
    block = _box((back, -0.85 * machine.R), (-1.5 * t, 1.5 * t), (-2.1 * t, 0.9 * t))
    return [(pyvista.merge(beams + forks), BODY), (block, BODY)]


def machine_letters(machine, theta, phi):
    """Return both axes and both angles of a posed machine, and what its parts are called.

    Parameters
    ----------
    machine : Machine
        Its sizes.
    theta, phi : float
        Joint angles in rad.

    Returns
    -------
    parts : list of (mesh, dict)
        Lines to add to those of `machine_model`: the axes, and each angle as an arc between the
        arm and where it would be with that angle zero.
    letters : dict of str to (point, away)
        For `shoot`.
    """
    R = machine.R
    crank, arm, tip = _joints(machine, theta, phi)
    out = 0.55 * R  # of the arcs, from their axes
    half = 0.32 * R  # of an axis
    high = 0.6 * half  # of the arc of phi, above the arm
    share = np.linspace(0, 1, 30)
    lifted = [_joints(machine, theta * one, phi)[0].apply((out, 0, 0)) for one in share]
    swung = [_joints(machine, theta, phi * one)[1].apply((out, 0, high)) for one in share]
    lines = [
        [(0, -half, 0), (0, half, 0)],
        [arm.apply((0, 0, -half)), arm.apply((0, 0, half))],
        [(0, 0, 0), lifted[0]],
        lifted,
        [swung[0], arm.apply((0, 0, high)), swung[-1]],
        swung,
    ]
    letters = {
        r"axis of $\theta$": ((0, -half, 0), (-0.5, -4.3)),
        r"axis of $\varphi$": (arm.apply((0, 0, half)), (0, 0.8)),
        r"$\theta$": (lifted[10], (0.8, 0.0)),
        r"$\varphi$": (swung[15], (0.7, 0.3)),
        r"cylinder of $\theta$": ((-0.5 * R, 0, -0.26 * R), (-2, -4)),
        r"tandem cylinders of $\varphi$": (arm.apply((0.2 * R, -0.1 * R, 0)), (6, -5.5)),
        "frame": ((-1.2 * R, 0, 0), (0, 0)),
        "bell crank": (crank.apply((0, 0, -0.3 * R)), (2, -3)),
        "arm": (arm.apply((0.7 * R, 0, 0)), (1.5, -3)),
        "cutter": (tip.apply((0, 0, -machine.cutter_radius)), (1, -1)),
    }
    return [(curve(np.array(line), 0.007 * R), THIN) for line in lines], letters


def machine_in_tunnel(machine, section, theta, phi):
    """Return the parts of the machine where it stands in a tunnel, and the tunnel's far wall.

    Parameters
    ----------
    machine : Machine
        Its sizes and its height.
    section : Section
        The tunnel's.
    theta, phi : float
        Joint angles in rad.

    Returns
    -------
    parts : list of (mesh, dict)
        As `machine_model` gives them, in the frame of the tunnel, lengths in m.
    """
    outline = section.point(np.linspace(0, section.perimeter, 360, endpoint=False))
    kept = outline[:, 0] > -0.2 * machine.R  # opened on the right, to look inside
    start = -np.argmin(kept)  # so that what is kept isn't cut in two
    outline = np.roll(outline, start, axis=0)[np.roll(kept, start)]
    along = np.array([-1.6, 1.5])[:, None] * machine.R
    wall = surface(np.stack(np.broadcast_arrays(along, *outline.T[:, None]), axis=-1))
    height = (0.0, 0.0, machine.height)
    posed = [(mesh.translate(height), look) for mesh, look in machine_model(machine, theta, phi)]
    return [(wall, {"color": COLOURS["tunnel"], "opacity": 0.7}), *posed]


def _joints(machine, theta, phi):
    """Return the frames of the bell crank, arm and cutter, as transforms to the base's."""
    crank = pyvista.Transform().rotate_y(np.degrees(theta))
    arm = pyvista.Transform().rotate_z(np.degrees(phi)).translate((machine.r, 0, 0)).compose(crank)
    tip = pyvista.Transform().translate((machine.R, 0, 0)).compose(arm)
    return crank, arm, tip


def _box(x, y, z):
    return pyvista.Box(bounds=(*x, *y, *z))


def _rod(a, b, radius):
    a, b = np.array([a, b], dtype=float)
    size = {"radius": radius, "height": np.linalg.norm(b - a), "resolution": 40}
    return pyvista.Cylinder(center=(a + b) / 2, direction=b - a, **size)


def _cylinder(a, b, width):
    """Return a hydraulic cylinder and its piston rod between two points."""
    middle = a + 0.6 * (b - a)
    return [(_rod(a, middle, 0.3 * width), OIL), (_rod(middle, b, 0.16 * width), STEEL)]


def _picks(radius):
    """Return conical teeth on a sphere, evenly spread by the golden angle."""
    index = np.arange(PICKS)
    x = 1 - (2 * index + 1) / PICKS
    turn = index * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - x * x)
    out = np.stack([x, ring * np.cos(turn), ring * np.sin(turn)], axis=-1)[x > -0.8]
    height = 0.2 * radius
    size = {"height": height, "radius": 0.4 * height, "resolution": 16}
    middle = radius - height / 2
    teeth = [pyvista.Cone(center=middle * axis, direction=axis, **size) for axis in out]
    return pyvista.merge(teeth)
