"""Write hard_lines_peers.csv: how public routines answer the lines of hard_lines.csv.gz.

    python -m tests.references.hard_lines_peers rays FOLDER     (in this environment)
    python hard_lines_peers.py python FOLDER                    (in one with the packages below)
    node hard_lines_peers.mjs FOLDER                            (where npm installed those)
    python -m tests.references.hard_lines_peers table FOLDER

Each routine gets the same rays, called as its package offers it, and says where each meets its
shape first. The packages are no part of this library's environment: mujoco, pybullet, open3d,
embreex, vtk and cadquery-ocp-novtk from PyPI, @dimforge/rapier3d-compat, jolt-physics and three
from npm.
"""

import csv
import gzip
import json
import sys
from collections import Counter, defaultdict
from contextlib import suppress
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
TABLE = HERE / "hard_lines_peers.csv"
DOUBLE, SINGLE = 2.0**-52, 2.0**-23
EVERY = "rod capsule frustum box"
SIDES = 64
CONFUSION = 1e-7  # Open CASCADE's own
# What each routine computes with; a mesh of 64 sides may be off by 0.005 of the size. To Open
# CASCADE, in doubles, places within 1e-7 are the same.
PRECISION = {
    "tunneller_lib": DOUBLE, "MuJoCo": DOUBLE, "PyBullet": DOUBLE, "VTK box": DOUBLE,
    "Open CASCADE": SINGLE, "Rapier": SINGLE, "Jolt": SINGLE, "three.js": DOUBLE,
    "Open3D, mesh": None, "embree, mesh": None, "VTK, mesh": None,
}  # fmt: skip
COLUMNS = ["routine", "version", "kind", "family", "lines", "holes", "ghosts", "displaced",
           "touches", "touches lost"]  # fmt: skip


def cases():
    """Return the table's rows."""
    with gzip.open(HERE / "hard_lines.csv.gz", "rt", newline="") as file:
        return list(csv.DictReader(file))


def asked(rows):
    """Return the rows that the routines are asked.

    At a size near 1 the other lengths of a needle of 1e-99 by 1e99 m are no lengths any more, and
    of a solid without thickness the routines are made for none.
    """
    return [row for row in rows if row["family"] not in ("sizes", "limits")]


def ray_of(row):
    """Return a row as a ray: its shape at a size near 1, scaled by a power of two, from outside."""
    shape = np.array([float(row[f"s{i}"]) for i in range(1, 13)])
    p, u = (np.array([float(row[v + axis]) for axis in "xyz"]) for v in "pu")
    if row["kind"] == "box":
        size = np.linalg.norm(shape[3:])
    else:
        size = shape[6:8].max() + np.linalg.norm(shape[3:6] - shape[:3])
    scale, speed = 2.0 ** -np.frexp(size)[1], 2.0 ** -np.frexp(np.abs(u).max())[1]
    shape, p, u, size = shape * scale, p * scale, u * speed, size * scale
    # From so far that the shape lies ahead, by a whole power of two of the direction.
    away = np.abs(p - shape[:3]).max() + 2 * size
    steps = 2.0 ** np.ceil(np.log2(2 * away / np.linalg.norm(u)))
    origin = p - steps * u
    along = scale / speed  # a parameter of the table in those of this ray
    return {
        "kind": row["kind"], "family": row["family"], "shape": shape.tolist(),
        "origin": origin.tolist(), "direction": u.tolist(), "reach": 2 * steps, "size": size,
        "enter": steps + float(row["enter"]) * along if row["enter"] != "inf" else None,
        "depth": float(row["depth"]) * scale,
        "give": float(row["give"]) * along, "give_single": float(row["give_single"]) * along,
    }  # fmt: skip


def write_rays(folder):
    """Write the rays for the others, and this library's own answers."""
    from tests.hard_lines import shape_of

    rays = [ray_of(row) for row in asked(cases())]
    (folder / "rays.json").write_text(json.dumps(rays))
    answers = []
    for ray in rays:
        shape = shape_of(ray["kind"], np.array(ray["shape"]))
        enter, leave = shape.meet_line(ray["origin"], ray["direction"])
        answers.append(float(enter) if enter <= leave else None)
    keep(folder, "tunneller_lib", "this", answers)


def keep(folder, routine, version, answers):
    """Write a routine's answers: a parameter, null for a miss, "none" for no such shape."""
    name = routine.split(",")[0].replace(" ", "_") + ("_mesh" if "mesh" in routine else "")
    answers = [float(x) if isinstance(x, (float, np.floating)) else x for x in answers]
    record = {"routine": routine, "version": version, "answers": answers}
    (folder / f"{name}.json").write_text(json.dumps(record))


def end_of(ray):
    """Return where a ray ends for those who ask about a segment."""
    return np.add(ray["origin"], np.multiply(ray["direction"], ray["reach"])).tolist()


def pose(ray):
    """Return centre, rotation matrix and half lengths of a shape; the axis is the matrix's z."""
    shape = np.array(ray["shape"])
    if ray["kind"] == "box":
        edges = shape[3:].reshape(3, 3)
        lengths = np.linalg.norm(edges, axis=-1)
        turn = (edges / lengths[:, None]).T
        if np.linalg.det(turn) < 0:
            turn[:, 0] *= -1
        return shape[:3] + edges.sum(axis=0) / 2, turn, lengths / 2
    a, b = shape[:3], shape[3:6]
    length = np.linalg.norm(b - a)
    z = (b - a) / length if length else np.array([0.0, 0, 1])
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return (a + b) / 2, np.stack([x, np.cross(z, x), z], axis=-1), np.array([length / 2])


def mesh(ray):
    """Return vertices and triangles of a shape, round ones with 64 sides."""
    centre, turn, half = pose(ray)
    if ray["kind"] == "box":
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        faces = [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
        return corners @ turn.T + centre, np.array(faces)
    start, end = ray["shape"][6:8]
    profile = [(start, -half[0]), (end, half[0])]  # radius, height
    tips = [-half[0], half[0]]
    if ray["kind"] == "capsule":
        angle = np.linspace(0, np.pi / 2, SIDES // 4 + 1)[:-1]
        low = [(start * np.cos(t), -half[0] - start * np.sin(t)) for t in angle[::-1]]
        profile = low + [(r, -z) for r, z in low[::-1]]
        tips = [-half[0] - start, half[0] + start]
    around = np.arange(SIDES) * 2 * np.pi / SIDES
    rings = [np.stack([r * np.cos(around), r * np.sin(around), np.full(SIDES, z)], -1)
             for r, z in profile]  # fmt: skip
    points = np.concatenate([*rings, [[0, 0, tips[0]], [0, 0, tips[1]]]])
    i, j, n = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES, len(points)
    faces = [np.stack([j, i, np.full(SIDES, n - 2)], -1)]
    for k in range(len(rings) - 1):
        low, high = k * SIDES, (k + 1) * SIDES
        faces += [np.stack([low + i, low + j, high + i], -1),
                  np.stack([low + j, high + j, high + i], -1)]  # fmt: skip
    top = (len(rings) - 1) * SIDES
    faces.append(np.stack([top + i, top + j, np.full(SIDES, n - 1)], -1))
    return points @ turn.T + centre, np.concatenate(faces)


def with_mujoco(ray):
    import mujoco

    kinds = {"rod": mujoco.mjtGeom.mjGEOM_CYLINDER, "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
             "box": mujoco.mjtGeom.mjGEOM_BOX}  # fmt: skip
    centre, turn, half = pose(ray)
    size = half if ray["kind"] == "box" else np.array([ray["shape"][6], half[0], 0])
    line = np.array(ray["origin"]), np.array(ray["direction"])
    found = mujoco.mju_rayGeom(centre, turn.ravel(), size, *line, kinds[ray["kind"]])
    return found if found >= 0 else None


def with_pybullet(ray):
    import pybullet

    if not pybullet.isConnected():
        pybullet.connect(pybullet.DIRECT)
    centre, turn, half = pose(ray)
    if ray["kind"] == "box":
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half.tolist())
    else:
        kind = pybullet.GEOM_CYLINDER if ray["kind"] == "rod" else pybullet.GEOM_CAPSULE
        shape = pybullet.createCollisionShape(kind, radius=ray["shape"][6], height=2 * half[0])
    if shape < 0:
        return None
    body = pybullet.createMultiBody(0, shape, -1, centre.tolist(), quaternion(turn))
    hit = pybullet.rayTest(ray["origin"], end_of(ray))[0]
    pybullet.removeBody(body)
    pybullet.removeCollisionShape(shape)
    return hit[2] * ray["reach"] if hit[0] >= 0 else None


def quaternion(turn):
    """Return a rotation matrix as a quaternion (x, y, z, w)."""
    square = np.array([
        1 + turn[0, 0] - turn[1, 1] - turn[2, 2], 1 - turn[0, 0] + turn[1, 1] - turn[2, 2],
        1 - turn[0, 0] - turn[1, 1] + turn[2, 2], 1 + turn.trace(),
    ])  # fmt: skip
    k = int(np.argmax(square))
    both, apart = turn + turn.T, turn - turn.T
    axial = [apart[2, 1], apart[0, 2], apart[1, 0]]
    q = np.array([*axial, square[3]]) if k == 3 else np.array([*both[k], axial[k]])
    if k != 3:
        q[k] = square[k]
    return (q / np.linalg.norm(q)).tolist()


def with_vtk_box(ray):
    import vtk

    t1, t2 = vtk.mutable(0.0), vtk.mutable(0.0)
    plane = vtk.mutable(0), vtk.mutable(0)
    centre, turn, half = pose(ray)
    start = (np.array(ray["origin"]) - centre) @ turn
    end = start + np.array(ray["direction"]) @ turn * ray["reach"]
    bounds = np.stack([-half, half], axis=-1).ravel().tolist()
    met = vtk.vtkBox.IntersectWithLine(bounds, start.tolist(), end.tolist(), t1, t2,
                                       [0] * 3, [0] * 3, *plane)  # fmt: skip
    return float(t1) * ray["reach"] if met else None


def with_vtk_mesh(ray):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    vertices, faces = mesh(ray)
    points, cells, body = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices), deep=True))
    rows = np.insert(faces, 0, 3, axis=-1).astype(np.int64).ravel()
    cells.SetCells(len(faces), numpy_to_vtkIdTypeArray(rows, deep=True))
    body.SetPoints(points)
    body.SetPolys(cells)
    tree, found = vtk.vtkOBBTree(), vtk.vtkPoints()
    tree.SetDataSet(body)
    tree.BuildLocator()
    tree.IntersectWithLine(ray["origin"], end_of(ray), found, None)
    if not found.GetNumberOfPoints():
        return None
    along = np.array(ray["direction"])
    return np.subtract(found.GetPoint(0), ray["origin"]) @ along / (along @ along)


def with_open3d(ray):
    import open3d

    vertices, faces = mesh(ray)
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(open3d.core.Tensor(vertices.astype(np.float32)),
                        open3d.core.Tensor(faces.astype(np.uint32)))  # fmt: skip
    one = np.array([[*ray["origin"], *ray["direction"]]], dtype=np.float32)
    found = scene.cast_rays(open3d.core.Tensor(one))["t_hit"].numpy()[0]
    return found if np.isfinite(found) else None


def with_embree(ray):
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    vertices, faces = mesh(ray)
    scene = EmbreeScene()
    TriangleMesh(scene, vertices[faces].astype(np.float32))
    one = [np.array([ray[name]], dtype=np.float32) for name in ("origin", "direction")]
    found = scene.run(*one, query="DISTANCE")
    return found[0] if found[0] < 1e30 else None


def with_open_cascade(ray):
    from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
    from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

    try:
        body = open_cascade_solid(ray)
    except Exception:  # Standard_Failure and what follows from it: sizes below its least
        return "none"
    speed = np.linalg.norm(ray["direction"])
    line = gp_Lin(gp_Pnt(*ray["origin"]), gp_Dir(*ray["direction"]))
    found = IntCurvesFace_ShapeIntersector()
    found.Load(body, CONFUSION)
    found.Perform(line, 0.0, ray["reach"] * speed)
    places = [found.WParameter(i + 1) for i in range(found.NbPnt())] if found.IsDone() else []
    return min(places) / speed if places else None


def open_cascade_solid(ray):
    """Return a shape of Open CASCADE, which raises an exception where it makes none."""
    from OCP import BRepPrimAPI
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt

    centre, turn, half = pose(ray)
    kind, (start, end) = ray["kind"], ray["shape"][6:8]
    low = centre - turn @ half if kind == "box" else centre - turn[:, 2] * half[0]
    frame = gp_Ax2(gp_Pnt(*low), gp_Dir(*turn[:, 2]), gp_Dir(*turn[:, 0]))
    if kind == "box":
        return BRepPrimAPI.BRepPrimAPI_MakeBox(frame, *(2 * half).tolist()).Solid()
    if kind == "rod" or (kind == "frustum" and start == end):
        return BRepPrimAPI.BRepPrimAPI_MakeCylinder(frame, start, 2 * half[0]).Solid()
    if kind == "frustum":
        return BRepPrimAPI.BRepPrimAPI_MakeCone(frame, start, end, 2 * half[0]).Solid()
    axis = gp_Ax1(gp_Pnt(*centre), gp_Dir(*turn[:, 2]))
    face = open_cascade_profile(start, centre, turn, half[0])
    return BRepPrimAPI.BRepPrimAPI_MakeRevol(face, axis).Shape()


def open_cascade_profile(radius, centre, turn, tall):
    """Return half of the section of a capsule, as a face of Open CASCADE."""
    from OCP import GC, BRepBuilderAPI
    from OCP.gp import gp_Pnt

    wire, diagonal = BRepBuilderAPI.BRepBuilderAPI_MakeWire(), radius / np.sqrt(2)
    pieces = [
        [(0, -tall - radius), (diagonal, -tall - diagonal), (radius, -tall)],
        [(radius, -tall), (radius, tall)],
        [(radius, tall), (diagonal, tall + diagonal), (0, tall + radius)],
        [(0, tall + radius), (0, -tall - radius)],
    ]
    for piece in pieces:
        if piece[0] == piece[-1]:
            continue
        places = [gp_Pnt(*(centre + turn[:, 0] * out + turn[:, 2] * up)) for out, up in piece]
        if len(places) == 3:
            places = [_made(GC.GC_MakeArcOfCircle(*places)).Value()]
        wire.Add(_made(BRepBuilderAPI.BRepBuilderAPI_MakeEdge(*places)).Edge())
    return _made(BRepBuilderAPI.BRepBuilderAPI_MakeFace(_made(wire).Wire())).Face()


def _made(builder):
    """Return a builder of Open CASCADE that could build; another's result may end the process."""
    if not builder.IsDone():
        raise ValueError("It can't be built.")
    return builder


# By routine: its package, the function of a ray, and the kinds of shapes that it has.
PYTHON = {
    "MuJoCo": ("mujoco", with_mujoco, "rod capsule box"),
    "PyBullet": ("pybullet", with_pybullet, "rod capsule box"),
    "VTK box": ("vtk", with_vtk_box, "box"),
    "Open CASCADE": ("cadquery-ocp-novtk", with_open_cascade, EVERY),
    "Open3D, mesh": ("open3d", with_open3d, EVERY),
    "embree, mesh": ("embreex", with_embree, EVERY),
    "VTK, mesh": ("vtk", with_vtk_mesh, EVERY),
}


def run_python(folder):
    """Let the routines of those Python packages answer that are installed."""
    from importlib.metadata import PackageNotFoundError, version

    rays = json.loads((folder / "rays.json").read_text())
    for routine, (package, answer, kinds) in PYTHON.items():
        with suppress(PackageNotFoundError):
            found = version(package)
            answers = [answer(ray) if ray["kind"] in kinds.split() else "none" for ray in rays]
            keep(folder, routine, found, answers)


def verdict(ray, found, precision):
    """Return how an answer is wrong, "touch", "touch lost", or "" where there is nothing to say."""
    # A box has one place, the others two ends.
    shape = np.array(ray["shape"][: 3 if ray["kind"] == "box" else 6])
    place = max(np.abs(shape).max(), np.abs(ray["origin"]).max())
    slack = 64 * precision * (ray["size"] + place) if precision else 0.005 * ray["size"]
    if abs(ray["depth"]) <= slack:
        if ray["depth"] < 0 or ray["enter"] is None:
            return ""
        return "touch" if found is not None else "touch lost"
    if found is None:
        return "hole" if ray["depth"] > 0 else ""
    if ray["depth"] < 0:
        return "ghost"
    if precision is None or place > 64 * ray["size"]:
        return ""
    give = ray["give"] if precision == DOUBLE else ray["give_single"]
    speed = np.linalg.norm(ray["direction"])
    off = abs(found - ray["enter"])
    return "displaced" if not off <= 100 * (give + slack / speed) else ""


def judged(folder):
    """Yield the rows of the table: all answers by routine, kind and family."""
    rays = json.loads((folder / "rays.json").read_text())
    records = [json.loads(path.read_text()) for path in folder.glob("*.json")
               if path.name != "rays.json"]  # fmt: skip
    for record in sorted(records, key=lambda r: list(PRECISION).index(r["routine"])):
        precision, groups = PRECISION[record["routine"]], defaultdict(Counter)
        for ray, found in zip(rays, record["answers"], strict=True):
            if found != "none":
                groups[ray["kind"], ray["family"]][verdict(ray, found, precision)] += 1
        for group, said in groups.items():
            yield [
                record["routine"], record["version"], *group, said.total(),
                said["hole"], said["ghost"], said["displaced"],
                said["touch"] + said["touch lost"], said["touch lost"],
            ]  # fmt: skip


def write_table(folder):
    from tests.references import tables

    tables.write(TABLE, COLUMNS, judged(folder))


if __name__ == "__main__":
    {"rays": write_rays, "python": run_python, "table": write_table}[sys.argv[1]](Path(sys.argv[2]))
