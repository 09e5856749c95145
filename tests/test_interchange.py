"""Files for other programs, written and read back."""

from dataclasses import replace
from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
import pyvista

from exhibits.tunnel_scene import wall_mesh
from tunneller_lib.job.atomic_write import replacement
from tunneller_lib.job.csv_tables import knots_csv, read_csv, setpoints_csv, setvalues_csv
from tunneller_lib.job.drawing import dxf
from tunneller_lib.job.mesh import MM, SCALAR, STL, stl, vtp, wall_solid, wall_surface
from tunneller_lib.motion import polyline
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, carve, plan
from tunneller_lib.ream.wall import standing
from tunneller_lib.removal import DexelGrid
from tunneller_lib.surfaces import REFERENCE_MACHINE, Arc, Egg, Line, closed_profile

EGG = Egg(0.5)
SQUARE = closed_profile([
    Line(y, z, k * np.pi / 2, 1.0)
    for k, (y, z) in enumerate([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
])  # fmt: skip
CIRCLE = closed_profile([Arc(0.1, -0.2, 0.6, 0.3, 2 * np.pi)])
JOB = plan(cutting_circuit(REFERENCE_MACHINE, EGG), Limits(feed=0.2, acceleration=0.5),
           tolerance=1e-3, step=1e-2, rest=0.2, laps=2, advance=0.04)  # fmt: skip


@pytest.fixture(scope="module")
def cut():
    return carve(JOB, JOB.setvalues, shape=(80, 120))


# Tables


def test_setvalues_come_back_bit_for_bit():
    about, columns = read_csv(setvalues_csv(JOB))
    counts = np.stack([columns["theta"], columns["phi"]], axis=-1)
    assert counts.dtype == np.int64
    np.testing.assert_array_equal(about["count_rad"] * counts, JOB.setvalues)
    np.testing.assert_array_equal(columns["tick"], np.arange(len(counts)))
    np.testing.assert_allclose(columns["time_s"], JOB.tick * columns["tick"], atol=1e-9)
    slopes = np.stack([columns["theta_slope_rad_s"], columns["phi_slope_rad_s"]], axis=-1)
    np.testing.assert_array_equal(slopes[:-1], JOB.slopes)
    assert about == {"tick_s": JOB.tick, "count_rad": JOB.count, "laps": 2, "advance_m": 0.04}


def test_setpoints_make_the_setvalues():
    about, columns = read_csv(setpoints_csv(JOB))
    counts = np.stack([columns["theta"], columns["phi"]], axis=-1)
    assert columns["ticks"][0] == 0 and columns["ticks"].sum() == len(JOB.setvalues) - 1
    made = polyline(counts, columns["ticks"][1:], parts=int(about["parts"]))
    np.testing.assert_array_equal(about["count_rad"] * made, JOB.setvalues)
    np.testing.assert_array_equal(columns["feed_m_s"], JOB.feed)
    np.testing.assert_allclose(columns["time_s"], JOB.tick * np.cumsum(columns["ticks"]), atol=1e-9)


def test_knots_come_back_bit_for_bit():
    about, columns = read_csv(knots_csv(JOB))
    np.testing.assert_array_equal(columns["s"], JOB.knots)
    at = about["count_rad"] * np.stack([columns["theta"], columns["phi"]], axis=-1)
    assert np.max(np.abs(at - JOB.circuit.position(JOB.knots))) <= JOB.count / 2


def test_tables_refuse_what_is_no_plan_and_rows_that_lack_numbers():
    for table in (knots_csv, setpoints_csv, setvalues_csv):
        with pytest.raises(ValueError, match=r"^plan: must be of class Plan; got None\.$"):
            table(None)
    for text in ("", "tick,theta\n0\n", "tick,theta\n0,left\n", "# tick_s = soon\ntick\n0\n"):
        with pytest.raises(ValueError, match=r"^text: must be a table as of `knots_csv`"):
            read_csv(text)


# The wall


def in_vtk(mesh):
    """Return a Mesh as VTK has it."""
    return pyvista.PolyData.from_regular_faces(mesh.points, mesh.faces)


def test_wall_solid_is_closed_and_has_the_grids_volume(cut):
    solid = in_vtk(wall_solid(cut.wall))
    assert solid.is_manifold and solid.n_open_edges == 0
    # Rows of wedges between the first and the last ray, from the outermost piece on each ray.
    inner = np.linalg.norm(standing(cut.wall)[..., 1:], axis=-1)
    areas = np.sum(cut.wall.high.max(axis=0) ** 2 - inner**2, axis=1) / 2
    facet = 2 * np.pi / inner.shape[1]
    length = np.diff(cut.wall.lines.x)
    wedges = facet * np.sum((areas[1:] + areas[:-1]) / 2 * length)
    assert solid.volume == pytest.approx(wedges, rel=2e-3)
    assert np.allclose(np.reshape(solid.bounds, (3, 2))[0], cut.wall.lines.x[[0, -1]])


def test_meshes_refuse_a_block_and_quadrilaterals(cut):
    block = DexelGrid.cartesian((-1, -1, 0), (1, 1, 1), (4, 4))
    for make in (wall_solid, partial(wall_surface, circuit=JOB.circuit)):
        with pytest.raises(ValueError, match=r"^wall: must be on .* rays; got 4 by 4 parallel"):
            make(wall=block)
    with pytest.raises(ValueError, match=r"^mesh: must be of triangles; got 4 corners a face\.$"):
        stl(wall_surface(cut.wall, JOB.circuit))


def test_vtp_escapes_the_names_of_values(cut):
    mesh = wall_surface(cut.wall, JOB.circuit)
    named = replace(mesh, values={'a"<b> & c': mesh.values[SCALAR]})
    (array,) = ElementTree.fromstring(vtp(named)).findall(".//PointData/DataArray")
    assert array.get("Name") == 'a"<b> & c'


def test_wall_solid_faces_outwards(cut):
    # By the divergence theorem the signed volume is positive for outward triangles alone.
    solid = wall_solid(cut.wall)
    a, b, c = np.moveaxis(solid.points[solid.faces], 1, 0)
    assert np.sum(np.cross(a, b) * c) / 6 == pytest.approx(in_vtk(solid).volume, rel=1e-4)


def test_stl_comes_back_in_millimetres(cut, tmp_path):
    solid = in_vtk(wall_solid(cut.wall))
    (tmp_path / "wall.stl").write_bytes(stl(wall_solid(cut.wall)))
    read = pyvista.read(tmp_path / "wall.stl")
    assert read.volume == pytest.approx(1e9 * solid.volume, rel=1e-5)
    np.testing.assert_allclose(read.bounds, 1e3 * np.array(solid.bounds), rtol=1e-6)
    assert read.n_cells == solid.n_cells and read.is_manifold


def test_stl_has_outward_unit_normals(cut):
    mesh = wall_solid(cut.wall)
    faces = np.frombuffer(stl(mesh)[84:], STL)
    np.testing.assert_allclose(np.linalg.norm(faces["normal"], axis=-1), 1, rtol=1e-6)
    first = faces["corners"][0] / MM
    across = np.cross(first[1] - first[0], first[2] - first[0])
    assert np.dot(across, faces["normal"][0]) > 0


def test_vtp_comes_back_with_its_errors(cut, tmp_path):
    mesh = wall_surface(cut.wall, JOB.circuit)
    (tmp_path / "wall.vtp").write_bytes(vtp(mesh))
    read = pyvista.read(tmp_path / "wall.vtp")
    np.testing.assert_array_equal(read[SCALAR], mesh.values[SCALAR])
    np.testing.assert_array_equal(read.points, mesh.points)
    np.testing.assert_array_equal(read.regular_faces, mesh.faces)
    assert read[SCALAR].max() == 1e3 * cut.overbreak.max()
    assert read.area == pytest.approx(wall_mesh(cut.wall, JOB.circuit).area, rel=1e-5)


# The drawing


def entities(text):
    """Return the entities of a drawing in DXF as dicts of their group codes."""
    lines = text.splitlines()
    pairs = list(zip(map(int, lines[::2]), lines[1::2], strict=True))
    assert pairs[-1] == (0, "EOF") and len(lines) % 2 == 0
    found = []
    for code, value in pairs:
        if code == 0:
            found.append({})
        if found:
            found[-1][code] = value if code in (0, 1, 2, 8, 9) else float(value)
    assert found[0] == {0: "SECTION", 2: "HEADER", 9: "$INSUNITS", 1: "AC1009", 70: 4}  # mm
    return [entity for entity in found if entity[0] in ("ARC", "CIRCLE", "LINE")]


def ends(entity):
    """Return start and end (2, 2) of an arc or a line, in mm."""
    if entity[0] == "LINE":
        return np.array([[entity[10], entity[20]], [entity[11], entity[21]]])
    angle = np.radians([entity[50], entity[51]])
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.array([entity[10], entity[20]]) + entity[40] * unit


@pytest.mark.parametrize("section", [EGG, SQUARE, EGG.offset(0.1)], ids=["egg", "square", "offset"])
def test_dxf_closes_and_lies_on_the_section(section):
    pieces = entities(dxf({"WALL": section}))
    assert [piece[0] for piece in pieces] == [
        "ARC" if isinstance(arc, Arc) else "LINE" for arc in section.arcs
    ]
    points = np.array([ends(piece) for piece in pieces])
    np.testing.assert_allclose(points[:, 0], 1e3 * section.point(section.blends[:-1]), atol=1e-9)
    np.testing.assert_allclose(points[:, 1], np.roll(points[:, 0], -1, axis=0), atol=1e-9)
    assert {piece[8] for piece in pieces} == {"WALL"}


def test_dxf_of_arcs_turns_counter_clockwise_by_their_sweep():
    for piece, arc in zip(entities(dxf({"WALL": EGG})), EGG.arcs, strict=True):
        assert (piece[51] - piece[50]) % 360 == pytest.approx(np.degrees(arc.sweep), abs=1e-9)


def test_dxf_of_a_circle_is_a_circle():
    (circle,) = entities(dxf({"WALL": CIRCLE}))
    assert circle[0] == "CIRCLE"
    assert [circle[code] for code in (10, 20, 40)] == pytest.approx([100, -200, 600])


def test_dxf_keeps_layers_apart_and_refuses_other_things():
    layers = [e[8] for e in entities(dxf({"SECTION": EGG, "CENTRE": JOB.circuit.profile}))]
    assert layers == ["SECTION"] * 4 + ["CENTRE"] * 4
    with pytest.raises(ValueError, match=r"^curves: must be of class Section"):
        dxf({"SECTION": [1, 2]})


@pytest.mark.parametrize(
    "layer", ["", "A" * 32, "WALL\n0\nEOF", "\x1b[31mWALL", "TÜR", "A B", "A/B", None, 8]
)
def test_dxf_refuses_names_of_layers_that_are_none(layer):
    with pytest.raises(ValueError, match=r"^curves: a layer's name must be 1 to 31 letters") as no:
        dxf({layer: EGG})
    assert str(no.value).isprintable()


# Files


def test_replacement_leaves_the_old_file_if_the_new_one_fails(tmp_path):
    path = tmp_path / "a" / "table.csv"
    with replacement(path) as new:
        new.write_text("old\n")
    with pytest.raises(KeyError), replacement(path) as new:
        new.write_text("half")
        raise KeyError
    assert path.read_bytes() == b"old\n" and list(path.parent.iterdir()) == [path]
    with replacement(path) as new:
        new.write_text("new\n")
    assert path.read_bytes() == b"new\n" and list(path.parent.iterdir()) == [path]
