"""The wall of a tunnel on rays from its axis: what stands, and how far from the wanted one."""

import numpy as np

from ..arrays import instance, positive
from ..paths.circuit import Circuit
from ..removal import DexelGrid


def intact_wall(circuit, start, stop, shape, *, thickness=0.1, memory=None):
    """Return the ground behind a section before it is cut.

    Parameters
    ----------
    circuit : Circuit
        With the section; the origin of its plane must be inside.
    start, stop : float
        Ends of the ground along the tunnel's x, in m.
    shape : (int, int)
        Rays along x and round.
    thickness : float
        Of the modelled ground, in m, along the rays.
    memory : float, optional
        Bytes that it may take; half of the computer's unless told.

    Returns
    -------
    wall : DexelGrid
        The ground.
    """
    section = instance("circuit", circuit, Circuit).section
    angle = (np.arange(shape[1]) + 0.5) * 2 * np.pi / shape[1]
    inner = section.ray(angle)
    outer = inner + positive("thickness", thickness)
    return DexelGrid.radial(start, stop, inner, outer, shape, memory=memory)


def standing(wall):
    """Return the points (n, m, 3), in m, where the ground begins that stands after the cuts.

    On each ray that of the outermost piece: what the cutter has undercut is counted as gone.

    Raises
    ------
    ValueError
        If a ray is cut through.
    """
    low, high = instance("wall", wall, DexelGrid).low, wall.high
    distance = np.where(high > low, low, -np.inf).max(axis=0)
    if not np.all(np.isfinite(distance)):
        raise ValueError("wall: is cut through; the modelled ground must be thicker.")
    x = np.broadcast_to(wall.lines.x[:, None], distance.shape)
    return np.stack([x, distance * wall.lines.cos, distance * wall.lines.sin], axis=-1)


def overbreak(wall, circuit):
    """Return how far (n, m) the standing ground is beyond the wanted wall, in m.

    Parameters
    ----------
    wall : DexelGrid
        The ground.
    circuit : Circuit
        Its section and its machine's depth of cut give the wanted wall.

    Returns
    -------
    overbreak : (n, m) float
        Along the section's normal: positive over-break, negative under-break; minus the depth
        of cut where the section is as it was.
    """
    points = standing(wall)
    return -circuit.section.depth(points[..., 1], points[..., 2]) - circuit.machine.depth


def scallop_height(radius, pitch):
    """Return the height of the cusps between passes of a ball, in m.

    Parameters
    ----------
    radius : float
        Of the cutter, in m.
    pitch : (...) float
        Distance of the passes across their direction, in m, at most 2 radius.

    Returns
    -------
    height : (...) float
        R - sqrt(R^2 - pitch^2/4), written without its cancellation.

    Examples
    --------
    >>> float(scallop_height(0.2, 0.04).round(6))
    0.001003
    """
    radius, pitch = positive("radius", radius), np.asarray(pitch, dtype=float)
    if not np.all(np.abs(pitch) <= 2 * radius):
        raise ValueError(f"pitch: must be at most twice the radius {radius:g} m; got {pitch}.")
    return pitch**2 / 4 / (radius + np.sqrt(radius**2 - pitch**2 / 4))
