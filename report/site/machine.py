"""The picture of the first page: the robot at work in a sewer of bricks, cut open lengthwise."""

import numpy as np

from tunneller_lib.paths import cutting_circuit
from tunneller_lib.surfaces import REFERENCE_MACHINE, Egg

SECONDS = 16  # for the circuit
PLACES = 64  # at which the moving machine is drawn
# Directions of the picture's right and of its up, seen from behind, from the left and from above.
TURN, TILT = np.radians([-62.0, 20.0])
RIGHT = np.array([np.sin(TURN), -np.cos(TURN), 0.0])
UP = np.array([np.cos(TURN) * np.sin(TILT), np.sin(TURN) * np.sin(TILT), np.cos(TILT)])
SCALE = 300  # units of the drawing in a metre
MACHINE, SECTION = REFERENCE_MACHINE, Egg(0.5)
BACK, FRONT = -1.45, 1.3  # m along the tunnel, its ends in the picture
COURSES, BRICKS = 22, 12  # of bricks from the crown to the invert, and bricks in one
THICK = 0.09  # m, the wall
WATER = 0.09  # m over the invert
PIPE = (0.2, -0.49, 0.4), 0.15  # m, the mouth of another: middle and radius
TEETH = 15
YELLOW, DARK, BRICK, BLUE = "#f0c83c", "#333333", "#b5664a", "#6fa8c8"
SAID = (
    "A robot on wheels in a sewer of bricks, with water at the bottom and the mouth of a pipe in "
    "the wall, moves its cutter, a ball with teeth, along the wall."
)


def seen(points):
    """Return where points (..., 3), in m, are in the drawing, to a tenth of its units."""
    points = np.asarray(points, dtype=float)
    return np.stack([SCALE * points @ RIGHT, -SCALE * points @ UP], axis=-1).round(1)


def moving_machine():
    """Return a file of SVG in which the reference machine follows its circuit."""
    circuit = cutting_circuit(MACHINE, SECTION)
    theta, phi = circuit.position(np.linspace(0, circuit.profile.perimeter, PLACES)).T
    joint = np.stack([MACHINE.r * np.cos(theta), 0 * theta, -MACHINE.r * np.sin(theta)], axis=-1)
    arms = seen(np.stack([0 * joint, joint, MACHINE.torus.point(theta, phi)], axis=1))
    balls = arms[:, -1]
    parts = [
        *_tunnel(),
        *_body(),
        f'<polyline points="{_text(balls)}" fill="none" stroke="white" stroke-width="2.5" '
        'stroke-dasharray="7 6"/>',
        f'<polyline class="arm" points="{_text(arms[0])}" fill="none" stroke="{YELLOW}" '
        f'stroke-width="26" stroke-linejoin="round"><animate attributeName="points" '
        f"{_values(arms)}/></polyline>",
        _disc((0, 0.09, 0), 0.05, DARK),
        '<g class="cutter"><animateTransform attributeName="transform" type="translate" '
        f"{_values(balls[:, None])}/>{_ball()}</g>",
    ]
    ends = seen([(x, *place) for x in (BACK, FRONT) for place in np.concatenate(_profiles())])
    corner, size = (
        " ".join(f"{n:.0f}" for n in one) for one in (ends.min(axis=0), np.ptp(ends, axis=0))
    )
    width, height = size.split()
    form = f'xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
    about = f'id="moving" role="img" aria-label="{SAID}" {form} viewBox="{corner} {size}"'
    return f"<svg {about}>{''.join(parts)}</svg>\n"


def _tunnel():
    """Return the half of the tunnel that is farther away: its wall, a pipe, its water."""
    inside, outside = _profiles()
    bricks, length = inside[::2], (FRONT - BACK) / BRICKS
    courses = [[(x, *place) for x in (BACK, FRONT)] for place in bricks]
    joints = [
        [(BACK + length * (n + 0.5 * (row % 2)), *place) for place in bricks[row : row + 2]]
        for row in range(COURSES)
        for n in range(BRICKS)
    ]
    level = inside[-1, 1] + WATER
    edge = inside[inside[:, 1] < level][0]
    return [
        _face([(FRONT, *place) for place in inside], "#26262a"),
        _swept(inside, BRICK),
        f'<path d="{_lines(courses + joints)}" stroke="#dcb09c"/>',
        _disc(*PIPE, "#26262a", stroke="#dcb09c"),
        _swept([inside[-1], (0, level), edge], BLUE),
        *(_swept([inside[end], outside[end]], "#8a4a35") for end in (0, -1)),
        _face([(BACK, *place) for place in (*inside, *outside[::-1])], "#8a4a35"),
    ]


def _profiles():
    """Return (y, z) of the wall's inside and of its outside about the machine, in m."""
    along = np.pi / 2 * SECTION.a + np.linspace(0, SECTION.perimeter / 2, 2 * COURSES + 1)
    inside = SECTION.point(along) - [0, MACHINE.height]
    return inside, inside + THICK * SECTION.normal(along)


def _body():
    """Return what of the robot doesn't move: its cable, wheels, box and fork."""
    far, near = (
        [
            _disc((x, y, -0.41), radius, fill)
            for x in (-1.0, -0.4)
            for radius, fill in ((0.12, DARK), (0.05, "#b8bfc6"))
        ]
        for y in (-0.16, 0.16)
    )
    cable = [(-1.1, 0, -0.1), (-1.3, 0, -0.3), (BACK, 0, -0.42)]
    return [
        *far,
        f'<path d="{_lines([cable])}" fill="none" stroke="{DARK}" stroke-width="9"/>',
        *_box((-1.15, -0.3), 0.15, (-0.38, 0.02)),
        *_box((-0.3, 0.07), 0.08, (-0.3, 0.06)),
        *near,
    ]


def _box(along, half, high):
    """Return the three faces of a box that are seen."""
    (back, front), (low, top) = along, high
    left, behind, above = (
        [(back, half, low), (front, half, low), (front, half, top), (back, half, top)],
        [(back, half, low), (back, -half, low), (back, -half, top), (back, half, top)],
        [(back, half, top), (front, half, top), (front, -half, top), (back, -half, top)],
    )
    return [_face(left, "#d9b22f"), _face(behind, "#a98a20"), _face(above, YELLOW)]


def _ball():
    """Return the cutter about the place 0, 0; it turns."""
    radius = SCALE * MACHINE.cutter_radius
    high = np.where(np.arange(2 * TEETH) % 2, 0.88, 1.06)
    star = _text((radius * high[:, None] * _round(2 * TEETH)).round(1))
    teeth = "".join(
        f'<circle r="4" cx="{x:.0f}" cy="{y:.0f}" fill="#dddddd"/>'
        for x, y in radius * np.concatenate([0.35 * _round(5), 0.68 * _round(10)])
    )
    return (
        f'<g><animateTransform attributeName="transform" type="rotate" to="360" dur="3s" '
        f'repeatCount="indefinite"/><polygon points="{star}" fill="{DARK}" stroke="#b8bfc6" '
        f'stroke-width="2"/>{teeth}</g>'
    )


def _disc(middle, radius, fill, **more):
    """Return a disc that stands along the tunnel."""
    across, up = radius * _round(24).T
    return _face(np.asarray(middle) + np.stack([across, 0 * up, up], axis=-1), fill, **more)


def _round(count):
    """Return so many directions (n, 2), all round."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([np.cos(turn), np.sin(turn)], axis=-1)


def _swept(places, fill):
    """Return the surface that a line of (y, z) leaves from one end of the tunnel to the other."""
    ends = [[(x, *place) for place in places] for x in (BACK, FRONT)]
    return _face([*ends[0], *ends[1][::-1]], fill)


def _face(points, fill, stroke="none"):
    edge = "" if stroke == "none" else f' stroke="{stroke}" stroke-width="8"'
    return f'<polygon points="{_text(seen(points))}" fill="{fill}"{edge}/>'


def _lines(many):
    return "".join(f"M{_text(seen(points))}" for points in many)


def _text(places):
    return " ".join(f"{x:g},{y:g}" for x, y in places)


def _values(rows):
    """Return what makes an attribute go through values, again and again."""
    return f'dur="{SECONDS}s" repeatCount="indefinite" values="{";".join(map(_text, rows))}"'
