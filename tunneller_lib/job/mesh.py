"""Meshes for others: STL in millimetres, which carries no unit, and VTP in metres."""

import base64
from dataclasses import dataclass, field
from html import escape
from itertools import chain

import numpy as np

from ..arguments import checked
from ..paths.circuit import Circuit
from ..ream.wall import overbreak, standing
from ..removal import DexelGrid

MM = 1000.0
SCALAR = "overbreak / mm"
BLOCK = 2**16  # numbers or faces that are written at once
STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, eq=False)
class Mesh:
    """Polygons of as many corners each.

    Parameters
    ----------
    points : (n, 3) float
        Corners, in m.
    faces : (k, 3) or (k, 4) int
        Which of them make a face, anticlockwise as seen from outside.
    values : dict of str to (n,) float, optional
        Scalars of the corners, by name.
    """

    points: np.ndarray
    faces: np.ndarray
    values: dict = field(default_factory=dict)


@checked
def wall_surface(wall: DexelGrid, circuit: Circuit):
    """Return the standing wall with its overbreak.

    Parameters
    ----------
    wall : DexelGrid
        The ground round a tunnel, on rays.
    circuit : Circuit
        Its section and its machine's depth of cut give the wanted wall.

    Returns
    -------
    mesh : Mesh
        One point a ray, in quadrilaterals, with the values `SCALAR`; minus the depth of cut where
        nothing is cut.
    """
    _check_rays(wall)
    n, m = wall.low.shape[1:]
    corners = _numbered(n, m)
    faces = np.stack(_around(corners), axis=-1).reshape(-1, 4)
    over = MM * overbreak(wall, circuit)
    return Mesh(standing(wall).reshape(-1, 3), faces, {SCALAR: over.ravel()})


@checked
def wall_solid(wall: DexelGrid):
    """Return the ground that stands as a closed body, for a printer or a CAD program.

    Parameters
    ----------
    wall : DexelGrid
        The ground round a tunnel, on rays, not cut through.

    Returns
    -------
    mesh : Mesh
        Triangles facing outwards: wall, back of the modelled ground, ends at the first and the
        last rays. Ground that the cutter has undercut is left out.
    """
    _check_rays(wall)
    n, m = wall.low.shape[1:]
    inner = standing(wall)
    back = wall.high.max(axis=0)
    outer = np.stack([inner[..., 0], back * wall.lines.cos, back * wall.lines.sin], axis=-1)
    k = _numbered(2, n, m)
    sheets = [(k[0], -1), (k[1], 1), (k[:, 0], 1), (k[:, -1], -1)]
    halves = [(sheet, side, half) for sheet, side in sheets for half in ((0, 1, 2), (0, 2, 3))]
    ends = np.cumsum([0, *(sheet[1:].size for sheet, _, _ in halves)])
    faces = np.empty((ends[-1], 3), k.dtype)  # one by one into their places, to save memory
    for (sheet, side, half), first, last in zip(halves, ends[:-1], ends[1:], strict=True):
        corners = _around(sheet)
        for column, which in enumerate(half[::side]):
            faces[first:last, column] = corners[which].ravel()
    points = np.concatenate([inner.reshape(-1, 3), outer.reshape(-1, 3)])
    return Mesh(points, faces)


def _numbered(*shape):
    """Return the numbers of points in an array of this shape, in 32 bits where these do."""
    count = int(np.prod(shape))
    return np.arange(count, dtype=np.int32 if count < 2**31 else np.int64).reshape(shape)


def _around(sheet):
    """Return the corners of a sheet's quadrilaterals, whose rows close to rings."""
    near = sheet[:-1]
    far = sheet[1:]
    return near, np.roll(near, -1, axis=1), np.roll(far, -1, axis=1), far


def _check_rays(wall):
    """Raise ValueError where a grid isn't one of rays, at least two places by three angles."""
    n, m = wall.low.shape[1:]
    if not wall.lines.rays or n < 2 or m < 3:
        kind = "rays" if wall.lines.rays else "parallel lines"
        raise ValueError(f"wall: must be on at least 2 by 3 rays; got {n} by {m} {kind}.")


@checked
def stl(mesh: Mesh, stamp: str = "tunneller_lib"):
    """Return a `mesh` of triangles as binary STL, in mm, whose header has a `stamp`."""
    return b"".join(stl_blocks(mesh, stamp))


@checked
def stl_blocks(mesh: Mesh, stamp: str):
    """Return blocks of bytes that make a file of a `mesh` with a `stamp`, as of `stl`."""
    if mesh.faces.shape[1] != 3:
        raise ValueError(f"mesh: must be of triangles; got {mesh.faces.shape[1]} corners a face.")
    head = f"in mm, {stamp}".encode("ascii", "replace")[:80].ljust(80)
    count = np.uint32(len(mesh.faces)).tobytes()
    return chain([head, count], (_stl_faces(mesh.points[some]) for some in _blocks(mesh.faces)))


def _stl_faces(corners):
    """Return triangles, whose corners (k, 3, 3) are in m, as binary STL has them."""
    corners = MM * corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    faces = np.zeros(len(corners), STL)
    faces["normal"] = normal / np.where(length > 0, length, 1)
    faces["corners"] = corners
    return faces.tobytes()


def _blocks(rows):
    """Yield the rows of an array in blocks."""
    return (rows[first : first + BLOCK] for first in range(0, len(rows), BLOCK))


@checked
def vtp(mesh: Mesh, stamp: str = "tunneller_lib"):
    """Return a `mesh` as VTK's polygonal data in XML, in m, with a `stamp` in a comment."""
    return b"".join(vtp_blocks(mesh, stamp))


@checked
def vtp_blocks(mesh: Mesh, stamp: str):
    """Yield blocks of bytes that make a file of a `mesh` with a `stamp`, as of `vtp`."""
    count, corners = mesh.faces.shape
    yield f"""<?xml version="1.0"?>
<!-- {escape(stamp).replace("--", "__")} -->
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData><Piece NumberOfPoints="{len(mesh.points)}" NumberOfPolys="{count}">
<PointData>""".encode("ascii", "xmlcharrefreplace")
    for name, of in mesh.values.items():
        yield from _data_array(name, of)
    yield b"</PointData>\n<Points>"
    yield from _data_array("Points", mesh.points)
    yield b"</Points>\n<Polys>"
    yield from _data_array("connectivity", mesh.faces.ravel())
    yield from _data_array("offsets", corners * np.arange(1, count + 1))
    yield b"</Polys>\n</Piece></PolyData>\n</VTKFile>\n"


def _data_array(name, numbers):
    """Yield numbers as an element: base64 of their bytes after the count of these."""
    kind, dtype = ("Int64", "<i8") if numbers.dtype.kind == "i" else ("Float64", "<f8")
    columns = numbers.shape[1] if numbers.ndim > 1 else 1
    about = f'type="{kind}" Name="{escape(name)}" NumberOfComponents="{columns}" format="binary"'
    yield f"<DataArray {about}>".encode()
    rest = np.uint64(8 * numbers.size).astype("<u8").tobytes()
    for some in _blocks(numbers):
        rest += some.astype(dtype).tobytes()
        whole = len(rest) - len(rest) % 3
        yield base64.b64encode(rest[:whole])
        rest = rest[whole:]
    yield base64.b64encode(rest) + b"</DataArray>"
