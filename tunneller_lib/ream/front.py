"""The ground that the front of a moving ball removes, and its push on both joints."""

import numpy as np
from numpy.polynomial.legendre import leggauss

from ..kernels.exact import norm
from ..removal.volume import removed_volume
from .moves import levers
from .outward import gradient

NODES, WEIGHTS = leggauss(6)  # for slices of the ball on each side of the earlier groove's edge
SIDE_NODES, SIDE_WEIGHTS = leggauss(200)  # for the ball's radii, from -90 to 90 degrees
HALVINGS = 20  # of the range in which a slice's front leaves the ground
STRIDE = 1e-4  # m along the section, for the lean of the circuit out of its plane


def groove_areas(circuit, s, advance=0.0):
    """Return the volume removed per metre of the offset section of a `circuit` at s, in m^2.

    s are arc lengths in m. The groove lies beside an earlier pass, an `advance` in m away, or is a
    whole one for 0. The cutter is taken to move on a circle with the bend at its centre.
    """
    machine = circuit.machine
    with np.errstate(divide="ignore"):
        wall = 1 / circuit.profile.curvature(s) + machine.offset
    return _groove(machine, wall, advance)


def _groove(machine, wall, pitch):
    """Return the volume removed per metre of a path behind a wall of some radius, in m^2."""
    pitch = None if np.all(pitch == 0) else pitch
    return removed_volume(machine.cutter_radius, 1.0, machine.depth, wall=wall, pitch=pitch)


def engaged_areas(circuit, s, advance=0.0):
    """Return the volume (n,) removed per metre of a `circuit` at arc lengths s in m, in m^2.

    The groove lies beside an earlier pass, an `advance` in m away, or is a whole one for 0. Where
    the front meets a bend before the centre does it is `front_areas`, elsewhere `groove_areas`,
    corrected for a circuit that leans out of the section's plane: by Euler's theorem the wall's
    bend counts along the way by cos^2 of the lean, and across it, where it widens the groove, by
    sin^2. The error left is 1 % in whole grooves, and 6 % beside an earlier pass, whose groove is
    no circle about this one.
    """
    machine = circuit.machine
    blends = circuit.profile.blends
    begins = np.mod(s, circuit.profile.perimeter)
    # A blend within half of the ball's chord ahead is felt by the front already.
    half = _half_widths(machine, 0.0)
    ahead = [np.searchsorted(blends, begins + way, side="right") for way in (0.0, half)]
    bends = ahead[0] != ahead[1]
    areas = groove_areas(circuit, s, advance)
    areas[bends] = front_areas(circuit, s[bends], advance)

    straight = _straight(circuit, s)
    flat = _groove(machine, np.inf, advance)
    bent = areas - flat
    # The bend of the circle on which as much is removed, in proportion to one of a metre.
    bend = _at_wall(machine, bent / (_groove(machine, 1 + machine.offset, advance) - flat))
    # Across the way the wall's bend widens the groove; an earlier pass that leans is nearer.
    wider = _half_widths(machine, bend * (1 - straight)) / half
    nearer = _groove(machine, np.inf, advance * np.sqrt(straight)) / flat
    return (flat + bent * straight) * wider * nearer


def _straight(circuit, s):
    """Return cos^2 (n,) of the lean out of the section's plane at arc lengths s in m."""
    near = s[..., None] + [-STRIDE / 2, STRIDE / 2]
    return (STRIDE / norm(np.diff(circuit.point(near), axis=-2)[..., 0, :])) ** 2


def _at_wall(machine, bend):
    """Return the wall's curvature where the offset section has the curvature `bend`, in 1/m."""
    return bend / (1 + bend * machine.offset)


def _half_widths(machine, bend):
    """Return half the chord that a wall of curvature `bend` cuts off a ball in a groove, in m."""
    radius = machine.cutter_radius
    offset = machine.offset
    # The distance from the ball's centre to the line through both circles' meeting points.
    middle = (offset - bend * (offset**2 + radius**2) / 2) / (1 - bend * offset)
    return np.sqrt(radius**2 - middle**2)


def front_areas(circuit, s, advance=0.0):
    """Return the area (n,) of the plane across the way that the ball's front in the ground covers.

    It is in m^2, the volume removed per metre of the offset section at arc lengths s (n,) in m of a
    `circuit`, with an `advance` as in `engaged_areas`. Planes across the tunnel cut the ball into
    circles of radii rho. The front of each is in the ground from the wall's normal up to the angle
    at which it leaves it, and covers rho (1 - cos angle).
    """
    machine = circuit.machine
    profile = circuit.profile
    half = _half_widths(machine, 0.0)
    pitch = min(advance or np.inf, 2 * half)
    # The earlier groove reaches to pitch - half, and is as deep as this one at pitch/2.
    edges = np.array([-half, pitch - half, pitch / 2])
    lengths = np.diff(edges)[:, None] / 2
    x = (edges[:-1, None] + lengths * (1 + NODES)).ravel()
    rho = np.sqrt(machine.cutter_radius**2 - x**2)
    earlier = np.sqrt(np.maximum(machine.cutter_radius**2 - (pitch - x) ** 2, 0.0))
    cleared = np.maximum(machine.offset, earlier)  # distance from the offset section to ground
    centre = profile.point(s)[:, None]
    normal = profile.normal(s)[:, None]
    forward = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
    # By bisection, since a section's depth has no inverse.
    low = np.full((len(s), len(x)), -1.0)
    high = np.ones_like(low)  # of the angle's cosine: where the front is in the ground
    for _ in range(HALVINGS):
        cos = (low + high) / 2
        sin = np.sqrt(1 - cos**2)
        on_front = centre + rho[:, None] * (cos[..., None] * normal + sin[..., None] * forward)
        in_ground = -profile.depth(on_front[..., 0], on_front[..., 1]) > cleared
        low = np.where(in_ground, low, cos)
        high = np.where(in_ground, cos, high)
    return (rho * (1 - high)) @ (lengths * WEIGHTS).ravel()


def facing_areas(circuit, s):
    """Return the area (n,) of the ball's front that faces the wall at arc lengths s in m, in m^2.

    It is the volume removed per metre that the ball moves out of a whole groove: half of the
    ellipse that the wall cuts off the ball of a `circuit`, with the wall's bend at the centre.
    """
    straight = _straight(circuit, s)
    bends = _at_wall(circuit.machine, circuit.profile.curvature(s)) * [straight, 1 - straight]
    return np.pi / 2 * np.prod(_half_widths(circuit.machine, bends), axis=0)


def side_area(circuit, s):
    """Return the area of the section's plane that the ball covers in the ground, in m^2.

    It is the greatest volume in the way per metre of a step along the tunnel, which the machine
    takes while the ball of a `circuit` stands in its groove at the arc length s in m.
    """
    radius = circuit.machine.cutter_radius
    angles = np.pi / 2 * SIDE_NODES
    centre = circuit.profile.point(s)
    normal = circuit.profile.normal(s)
    forward = np.array([-normal[1], normal[0]])
    out = np.cos(angles)[:, None] * normal + np.sin(angles)[:, None] * forward
    low = np.zeros(len(angles))  # of the ball's radii: where they meet the ground
    high = np.full(len(angles), radius)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        points = centre + middle[:, None] * out
        in_ground = -circuit.profile.depth(points[:, 0], points[:, 1]) > circuit.machine.offset
        low = np.where(in_ground, low, middle)
        high = np.where(in_ground, middle, high)
    return float(np.pi / 4 * SIDE_WEIGHTS @ (radius**2 - high**2))


def push_levers(circuit, ground, s, positions, slopes):
    """Return the levers (n, 2) of the ground's force: torque per newton against the feed, in m.

    They hold on a `circuit` in a `ground` at `positions` (n, 2) in rad, at places s (n,) in m, with
    the `slopes` (n, 2) of the positions by the length of way in rad/m. The force out of the wall is
    in proportion to that against the feed.
    """
    along = levers(circuit.machine.torus, positions) ** 2 * slopes
    return along + ground.normal * gradient(circuit, s, positions)
