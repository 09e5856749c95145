"""The wall as a mesh for other programs: STL, in millimetres, since the format has no unit."""

import numpy as np

from ..ream.wall import standing

MM = 1000.0
BLOCK = 2**16  # faces that are written at once, to save memory
SCALAR = "overbreak / mm"
STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def wall_solid(wall):
    """Return the ground of a `DexelGrid` on rays as a closed body: points (n, 3), faces (k, 3).

    Points are in m. The faces are triangles by the numbers of their corners, anticlockwise as seen
    from outside: the wall, the back of the modelled ground, and the ends at the first and the last
    rays. Ground that the cutter has undercut is left out.
    """
    inner = standing(wall)
    back = wall.high.max(axis=0)
    outer = np.stack([inner[..., 0], back * wall.lines.cos, back * wall.lines.sin], axis=-1)
    k = np.arange(2 * back.size).reshape(2, *back.shape)
    # Seen from outside, the wall and the last end run the other way round than their numbers.
    sheets = [(k[0], -1), (k[1], 1), (k[:, 0], 1), (k[:, -1], -1)]
    faces = [_triangles(sheet)[:, ::side] for sheet, side in sheets]
    return np.concatenate([inner.reshape(-1, 3), outer.reshape(-1, 3)]), np.concatenate(faces)


def _triangles(sheet):
    """Return the triangles (k, 3) between the rows of a sheet of numbers, which close to rings."""
    near = sheet[:-1]
    far = sheet[1:]
    corners = [near, np.roll(near, -1, axis=1), np.roll(far, -1, axis=1), far]
    a, b, c, d = (corner.ravel() for corner in corners)
    return np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])


def stl(points, faces, stamp):
    """Yield the blocks of bytes of a binary STL file in mm; the triangles' points are in m."""
    yield f"in mm, {stamp}".encode("ascii", "replace")[:80].ljust(80)
    yield np.uint32(len(faces)).tobytes()
    for first in range(0, len(faces), BLOCK):
        corners = MM * points[faces[first : first + BLOCK]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=-1, keepdims=True)
        written = np.zeros(len(corners), STL)
        written["normal"] = normal / np.where(length > 0, length, 1)
        written["corners"] = corners
        yield written.tobytes()
