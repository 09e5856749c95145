"""The wall of a tunnel on rays from its axis: the standing ground, and its overbreak."""

import numpy as np

from ..arguments import Coordinate, Length, Lengths, checked
from ..kernels.exact import norm
from ..paths.circuit import Circuit
from ..removal import DexelGrid
from ..removal.dexel import Shape


@checked
def intact_wall(
    circuit: Circuit, start: Coordinate, stop: Coordinate, shape: Shape, *, thickness: Length = 0.1
):
    """Return the uncut ground behind a section.

    Parameters
    ----------
    circuit : Circuit
        The circuit, whose section must hold the origin of its plane.
    start, stop : float
        Ends of the ground along the tunnel's x, in m.
    shape : (2,) int
        Numbers of rays along x and around it.
    thickness : float
        Thickness of the modelled ground along the rays, in m.

    Returns
    -------
    wall : DexelGrid
        The ground.
    """
    angle = (np.arange(shape[1]) + 0.5) * 2 * np.pi / shape[1]
    inner = circuit.section.ray(angle)
    return DexelGrid.radial(start, stop, inner, inner + thickness, shape)


@checked
def standing(wall: DexelGrid):
    """Return the point on each ray at which the standing ground begins.

    Parameters
    ----------
    wall : DexelGrid
        The ground, on rays.

    Returns
    -------
    points : (n, m, 3) float
        The inner end of each ray's outermost piece, in m: undercut ground counts as gone.

    Raises
    ------
    ValueError
        If a ray is cut through, or the grid's lines are no rays.
    """
    if not wall.lines.rays:
        raise ValueError("wall: must be on rays; got parallel lines.")
    distance = np.where(wall.high > wall.low, wall.low, -np.inf).max(axis=0)
    if not np.all(np.isfinite(distance)):
        raise ValueError("wall: is cut through; the modelled ground must be thicker.")
    x = np.broadcast_to(wall.lines.x[:, None], distance.shape)
    return np.stack([x, distance * wall.lines.cos, distance * wall.lines.sin], axis=-1)


@checked
def overbreak(wall: DexelGrid, circuit: Circuit):
    """Return how far (n, m) the standing ground is beyond the wanted wall, in m.

    Parameters
    ----------
    wall : DexelGrid
        The ground.
    circuit : Circuit
        The circuit, whose section and depth of cut give the wanted wall.

    Returns
    -------
    overbreak : (n, m) float
        Distance along the section's normal, in m, negative for underbreak; minus the depth of cut
        where nothing is cut.

    Raises
    ------
    ValueError
        As by `standing`.
    """
    points = standing(wall)
    return -circuit.section.depth(points[..., 1], points[..., 2]) - circuit.machine.depth


@checked
def scallop_height(radius: Length, pitch: Lengths):
    """Return the height of the cusps between passes of a ball, in m.

    Parameters
    ----------
    radius : float
        Radius of the cutter, in m.
    pitch : (...) float
        Distance of the passes across their direction, in m, at most twice the radius.

    Returns
    -------
    height : (...) float
        R - sqrt(R^2 - pitch^2/4), in m.

    Examples
    --------
    >>> float(scallop_height(0.2, 0.04).round(6))
    0.001003
    """
    wrong = (pitch < 0) | (pitch > 2 * radius)
    if np.any(wrong):
        raise ValueError(
            f"pitch: must lie between 0 and twice the radius {radius:g} m; "
            f"got {pitch[wrong].flat[0]:g} m."
        )
    # R - sqrt(..) would cancel for small pitches.
    return pitch**2 / 4 / (radius + np.sqrt(radius**2 - pitch**2 / 4))


@checked
def pass_distance(circuit: Circuit, s: Lengths, advance: Length):
    """Return the distance (...) of passes across their direction, in m, that makes their cusps.

    Parameters
    ----------
    circuit : Circuit
        The circuit of the cutter's centre.
    s : (...) float
        Arc lengths, in m.
    advance : float
        Step of the machine between laps, in m.

    Returns
    -------
    pitch : (...) float
        advance / sqrt(1 + tan^2(lean) rho / (rho + R)) with the lean of the circuit out of the
        section's plane, the radius rho of the offset section and R of the cutter: on a straight
        wall advance cos(lean), but the ball also reaches round the bend.

    Notes
    -----
    The wall has one bend as far as the ball reaches round it from the middle of a ridge, about
    advance/2 tan(lean) along the section. Nearer to a jump of the bend the ridge passes smoothly
    from one height to the other, and so isn't as low as the lower of both formulas says.
    """
    profile = circuit.profile
    h = 1e-5 * profile.perimeter
    s = np.where(np.abs(s) > profile.perimeter, np.mod(s, profile.perimeter), s)  # lest h be lost
    move = circuit.in_tunnel(circuit.point(s + h)) - circuit.in_tunnel(circuit.point(s - h))
    tan = move[..., 0] / norm(move[..., 1:])
    bent = profile.curvature(s) * circuit.machine.cutter_radius
    return advance / np.sqrt(1 + tan**2 / (1 + bent))


@checked
def lap_volume(circuit: Circuit, advance: Length):
    """Return the volume that a lap removes behind earlier ones, in m^3.

    Parameters
    ----------
    circuit : Circuit
        The circuit of the cutter's centre.
    advance : float
        Step of the machine between laps, in m, small against the cutter.

    Returns
    -------
    volume : float
        The layer between section and wanted wall over the advance, less the cusps between passes,
        whose centroids are taken at the wanted wall.

    Raises
    ------
    ValueError
        If the cusps are as high as the cut is deep.

    Examples
    --------
    >>> from tunneller_lib.paths import cutting_circuit
    >>> from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg
    >>> circuit = cutting_circuit(REFERENCE_MACHINE, Egg(0.5))
    >>> round(lap_volume(circuit, 0.05), 5)
    0.00393

    Passes farther apart than the cutter is thick leave cusps as high as its radius:

    >>> lap_volume(circuit, 0.5)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: advance: must leave cusps below ...; got 0.5 m, which leaves 0.2 m.
    """
    profile = circuit.profile
    radius = circuit.machine.cutter_radius
    g = circuit.machine.depth
    layer = circuit.section.perimeter * g + np.pi * g**2  # Steiner
    ends = np.linspace(0, profile.perimeter, 4001)
    s = (ends[1:] + ends[:-1]) / 2
    half = pass_distance(circuit, s, advance) / 2
    tallest = np.max(scallop_height(radius, np.minimum(2 * half, 2 * radius)))
    if g <= tallest:
        raise ValueError(
            f"advance: must leave cusps below the depth of cut {g:g} m, or ground between them "
            f"isn't touched; got {advance:g} m, which leaves {tallest:.3g} m."
        )
    # A cusp is the strip down to the bottoms less two sectors and a triangle that the passes take.
    sectors = radius**2 * np.arcsin(half / radius)
    triangle = half * np.sqrt((radius - half) * (radius + half))
    cusp = 2 * half * radius - sectors - triangle
    bent = 1 + radius * profile.curvature(s)
    return float(advance * (layer - np.sum(cusp / (2 * half) * bent * np.diff(ends))))
