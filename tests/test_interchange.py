"""Files for other programs, written and read back."""

import numpy as np
import pytest
import pyvista

from kit import scene
from tests.examples.job import _JOB
from tunneller_lib.job import read_job
from tunneller_lib.job.atomic_write import replacement
from tunneller_lib.job.csv_tables import knots_csv, plan_csv, setpoints_csv, setvalues_csv
from tunneller_lib.job.drawing import dxf
from tunneller_lib.job.mesh import STL, stl, vtk, wall_solid
from tunneller_lib.job.results import write_all
from tunneller_lib.motion import polyline
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, carve, plan
from tunneller_lib.ream.wall import standing
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


def rows(text):
    """Return a table as columns, as any reader of CSV with a heading has them."""
    return np.genfromtxt(text.splitlines(), delimiter=",", names=True, dtype=None, encoding=None)


ABOUT = rows(plan_csv(JOB, "a job"))


def joints(table, unit):
    return np.stack([table[f"theta_{unit}"], table[f"phi_{unit}"]], axis=-1)


def test_setvalues_come_back_bit_for_bit():
    table = rows(setvalues_csv(JOB))
    counts = joints(table, "counts")
    assert counts.dtype.kind == "i" and ABOUT["job"] == "a job"
    np.testing.assert_array_equal(ABOUT["count_rad"] * counts, JOB.setvalues)
    np.testing.assert_array_equal(table["tick"], np.arange(len(counts)))
    np.testing.assert_allclose(table["time_s"], ABOUT["tick_s"] * table["tick"], atol=1e-9)
    np.testing.assert_array_equal(joints(table, "slope_rad_s")[:-1], JOB.slopes)
    assert (ABOUT["laps"], ABOUT["advance_m"]) == (2, 0.04)


def test_setpoints_make_the_setvalues():
    table = rows(setpoints_csv(JOB))
    assert table["ticks"][0] == 0 and table["ticks"].sum() == len(JOB.setvalues) - 1
    made = polyline(joints(table, "parts"), table["ticks"][1:], parts=int(ABOUT["parts"]))
    np.testing.assert_array_equal(ABOUT["count_rad"] * made, JOB.setvalues)
    np.testing.assert_array_equal(table["feed_m_s"], JOB.feed)
    np.testing.assert_allclose(table["time_s"], JOB.tick * np.cumsum(table["ticks"]), atol=1e-9)


def test_knots_come_back_bit_for_bit():
    table = rows(knots_csv(JOB))
    np.testing.assert_array_equal(table["s_m"], JOB.knots)
    at = ABOUT["count_rad"] * joints(table, "counts")
    assert np.max(np.abs(at - JOB.circuit.position(JOB.knots))) <= JOB.count / 2


# The wall


def test_wall_solid_is_closed_faces_outwards_and_has_the_grids_volume(cut, tmp_path):
    points, faces = wall_solid(cut.wall)
    solid = pyvista.PolyData.from_regular_faces(points, faces)
    assert solid.is_manifold and solid.n_open_edges == 0
    # Rows of wedges between the first and the last ray, from the outermost piece on each ray.
    inner = np.linalg.norm(standing(cut.wall)[..., 1:], axis=-1)
    areas = np.sum(cut.wall.high.max(axis=0) ** 2 - inner**2, axis=1) / 2
    length = np.diff(cut.wall.lines.x)
    wedges = 2 * np.pi / inner.shape[1] * np.sum((areas[1:] + areas[:-1]) / 2 * length)
    assert solid.volume == pytest.approx(wedges, rel=2e-3)
    # By the divergence theorem the signed volume is positive for outward triangles alone.
    a, b, c = np.moveaxis(points[faces], 1, 0)
    assert np.sum(np.cross(a, b) * c) / 6 == pytest.approx(solid.volume, rel=1e-4)
    content = b"".join(stl(points, faces, "a job"))
    assert content.startswith(b"in mm, a job")
    (tmp_path / "wall.stl").write_bytes(content)
    read = pyvista.read(tmp_path / "wall.stl")
    assert read.volume == pytest.approx(1e9 * solid.volume, rel=1e-5)
    np.testing.assert_allclose(read.bounds, 1e3 * np.array(solid.bounds), rtol=1e-6)
    assert read.n_cells == solid.n_cells and read.is_manifold
    written = np.frombuffer(content[84:], STL)
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    np.testing.assert_allclose(written["normal"], across, atol=1e-3)


def test_vtk_comes_back_with_its_overbreak(cut, tmp_path):
    (tmp_path / "wall.vtk").write_bytes(b"".join(vtk(cut.wall, JOB.circuit, "a job")))
    read = pyvista.read(tmp_path / "wall.vtk")
    points = standing(cut.wall)
    np.testing.assert_array_equal(read.points, points.reshape(-1, 3))
    assert read["overbreak_mm"].max() == 1e3 * cut.overbreak.max()
    np.testing.assert_array_equal(read["overbreak_mm"], 1e3 * cut.overbreak.ravel())
    closed = np.concatenate([points, points[:, :1]], axis=1)
    assert read.area == pytest.approx(scene.surface(closed).area, rel=1e-5)


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
    for piece, arc in zip(pieces, section.arcs, strict=True):
        if isinstance(arc, Arc):
            assert (piece[51] - piece[50]) % 360 == pytest.approx(np.degrees(arc.sweep), abs=1e-9)


def test_dxf_of_a_circle_is_a_circle_on_its_layer():
    (circle, *arcs) = entities(dxf({"WALL": CIRCLE, "CENTRE": EGG}))
    assert (circle[0], circle[8]) == ("CIRCLE", "WALL") and [e[8] for e in arcs] == ["CENTRE"] * 4
    assert [circle[code] for code in (10, 20, 40)] == pytest.approx([100, -200, 600])


def test_drawing_of_a_job_has_the_section_the_wanted_wall_and_the_centre_s_path(tmp_path):
    job = read_job(_JOB)
    write_all(job, job.simulated(), tmp_path / "new", {"faults": [{"source": "none"}]}, str)
    drawn = entities((tmp_path / "new" / "section.dxf").read_text().split("\n", 2)[2])
    radii = np.reshape([entity[40] for entity in drawn], (3, 4))
    assert [entity[8] for entity in drawn[::4]] == ["SECTION", "WALL", "CENTRE"]
    # By the depth of cut, and less the cutter's radius, in mm.
    np.testing.assert_allclose(radii[1:], radii[0] + [[20], [-180]])


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
