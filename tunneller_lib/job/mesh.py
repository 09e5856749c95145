"""The wall as a mesh for other programs: STL in millimetres, as it has no unit, VTK in metres."""

import numpy as np

from ..ream.wall import overbreak, standing

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
    n, m = wall.low.shape[1:]
    inner = standing(wall)
    back = wall.high.max(axis=0)
    outer = np.stack([inner[..., 0], back * wall.lines.cos, back * wall.lines.sin], axis=-1)
    k = _numbered(2, n, m)
    sheets = [(k[0], -1), (k[1], 1), (k[:, 0], 1), (k[:, -1], -1)]
    halves = [(sheet, side, half) for sheet, side in sheets for half in ((0, 1, 2), (0, 2, 3))]
    ends = np.cumsum([0, *(sheet[1:].size for sheet, _, _ in halves)])
    faces = np.empty((ends[-1], 3), k.dtype)  # filled part by part, to save memory
    for (sheet, side, half), first, last in zip(halves, ends[:-1], ends[1:], strict=True):
        corners = _around(sheet)
        for column, which in enumerate(half[::side]):
            faces[first:last, column] = corners[which].ravel()
    return np.concatenate([inner.reshape(-1, 3), outer.reshape(-1, 3)]), faces


def _numbered(*shape):
    """Return the numbers of points in an array of this shape."""
    count = np.prod(shape)
    return np.arange(count, dtype=np.min_scalar_type(count)).reshape(shape)


def _around(sheet):
    """Return the four corners of a sheet's quadrilaterals, whose rows close to rings."""
    near = sheet[:-1]
    far = sheet[1:]
    return near, np.roll(near, -1, axis=1), np.roll(far, -1, axis=1), far


def stl(points, faces, stamp):
    """Yield blocks of bytes that make triangles, whose points are in m, a binary STL file in mm."""
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


def vtk(wall, circuit, stamp):
    """Yield blocks of bytes that make a wall on rays a file of VTK in its legacy format, in m.

    Each ray is a point. Its overbreak over the wanted wall of a `Circuit` is in mm, and minus the
    depth of cut where nothing is cut.
    """
    points = standing(wall)
    sheet = _numbered(*points.shape[:2])
    faces = np.stack([np.full_like(sheet[:-1], 4), *_around(sheet)], axis=-1)
    count = faces[..., 0].size
    yield f"# vtk DataFile Version 3.0\nin m, {stamp}\nBINARY\nDATASET POLYDATA\n".encode()
    yield f"POINTS {sheet.size} double\n".encode()
    yield points.astype(">f8").tobytes()
    yield f"\nPOLYGONS {count} {faces.size}\n".encode()
    yield faces.astype(">i4").tobytes()
    yield f"\nPOINT_DATA {sheet.size}\nSCALARS overbreak_mm double\n".encode()
    yield b"LOOKUP_TABLE default\n"
    yield (MM * overbreak(wall, circuit)).astype(">f8").tobytes()
