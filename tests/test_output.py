"""What a command leaves: one job's files whole, whatever happens to it; read back by others."""

import re
import shutil
from hashlib import sha256

import numpy as np
import pytest
import pyvista

from kit import figure
from tests.examples.job import _JOB
from tunneller_lib.__main__ import main
from tunneller_lib.atomic_write import replacement
from tunneller_lib.job import mesh, read_job, wall_plot
from tunneller_lib.job.csv_tables import knots_csv, plan_csv, setpoints_csv, setvalues_csv
from tunneller_lib.job.drawing import dxf
from tunneller_lib.job.results import write_all
from tunneller_lib.job.tables import stamp_of
from tunneller_lib.motion import polyline
from tunneller_lib.paths import cutting_circuit
from tunneller_lib.ream import Limits, carve, plan
from tunneller_lib.ream.wall import standing
from tunneller_lib.surfaces import REFERENCE_MACHINE, Arc, Egg, Line, closed_profile

READS = []

GAINS = {"earlier": 10, "later": 9, "bad": 1000}
JOBS = {name: _JOB.read_text(encoding="utf-8").replace("gain = 10", f"gain = {gain}")
        for name, gain in GAINS.items()}  # fmt: skip
EGG = Egg(0.5)
SQUARE = closed_profile([
    Line(y, z, k * np.pi / 2, 1.0)
    for k, (y, z) in enumerate([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
])  # fmt: skip
PLAN = plan(cutting_circuit(REFERENCE_MACHINE, EGG), Limits(feed=0.2, acceleration=0.5),
            tolerance=1e-3, step=1e-2, rest=0.2, laps=2, advance=0.04)  # fmt: skip


# A run's folder


def told_by(folder):
    """Return whose files are in a folder that is whole: each as listed and of the same job."""
    first, *lines = (folder / "manifest.txt").read_text().splitlines()
    stamp = first.removeprefix("# ").partition(";")[0].encode()
    listed = dict(reversed(line.split("  ")) for line in lines)
    assert {path.name for path in folder.iterdir()} == {*listed, "manifest.txt"}
    for name, digest in listed.items():
        content = (folder / name).read_bytes()
        assert sha256(content).hexdigest() == digest, name
        assert stamp in content or (name.endswith(".csv") and name != "plan.csv"), name
    name, digest = re.search(r"job (\w+)\.toml, sha256 (\w+);", first).groups()
    assert len(listed) > 11 and sha256(JOBS[name].encode()).hexdigest().startswith(digest)
    return name


@pytest.fixture(scope="module")
def jobs(tmp_path_factory):
    """Return a folder with the jobs, and the results of one where nothing was in the way."""
    folder = tmp_path_factory.mktemp("jobs")
    for name, text in JOBS.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    assert cut(folder, "earlier", folder / "earlier") == 0
    return folder


def cut(jobs, name, out):
    return main(["cut", str(jobs / f"{name}.toml"), "--out", str(out)])


def test_same_job_gives_the_same_bytes_through_a_link(jobs, tmp_path):
    (tmp_path / "disk" / "again").mkdir(parents=True)
    (tmp_path / "again").symlink_to(tmp_path / "disk" / "again")
    assert cut(jobs, "earlier", tmp_path / "again") == 0
    assert (tmp_path / "again").is_symlink()
    for path in (jobs / "earlier").iterdir():
        assert path.read_bytes() == (tmp_path / "disk" / "again" / path.name).read_bytes()


def test_stamp_keeps_to_letters_that_any_comment_may_hold():
    stamp = stamp_of('*/ -->\n*) "é".toml' + 99 * "x", b"text")
    assert re.fullmatch(r"tunneller_lib [\d.]+, job [\w.]{20}, sha256 [0-9a-f]{16}", stamp, re.A)


def test_later_run_takes_the_place_and_a_refused_one_leaves_it(jobs, tmp_path):
    out = tmp_path / "cut"
    shutil.copytree(jobs / "earlier", out)
    assert cut(jobs, "bad", out) == 1 and told_by(out) == "earlier"
    assert cut(jobs, "later", out) == 0 and told_by(out) == "later"
    assert [path.name for path in tmp_path.iterdir()] == ["cut"]


CHANGES = {
    "notes.txt": lambda out: (out / "notes.txt").write_text("mine"),
    "budget.csv": lambda out: (out / "budget.csv").write_text("mine"),
    "figures": lambda out: (out / "figures").mkdir(),
    "blocks.st": lambda out: (out / "manifest.txt").unlink(),  # the first, without a manifest
}


@pytest.mark.parametrize("change", CHANGES)
def test_folder_that_holds_a_user_s_files_is_refused_and_stays(jobs, tmp_path, capsys, change):
    out = tmp_path / "cut"
    shutil.copytree(jobs / "earlier", out)
    CHANGES[change](out)
    before = {path: path.is_dir() or path.read_bytes() for path in out.iterdir()}
    assert cut(jobs, "later", out) == 2
    assert f"cut: holds {change}, which isn't as a run has left it" in capsys.readouterr().err
    assert {path: path.is_dir() or path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize("name", ["wall.stl", "wall.png"])
def test_disk_that_takes_no_more_is_told_and_nothing_is_left(
    jobs, tmp_path, monkeypatch, capsys, name
):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    drawing = "tunneller_lib.job.wall_plot.FigureCanvasAgg.print_png"
    makers = {"wall.stl": ("tunneller_lib.job.results.stl", lambda *_: map(full, [0])),
              "wall.png": (drawing, full)}  # fmt: skip
    monkeypatch.setattr(*makers[name])
    assert cut(jobs, "later", tmp_path / "cut") == 2 and list(tmp_path.iterdir()) == []
    told = capsys.readouterr().err.splitlines()[-1]
    assert told == f"wrong: {tmp_path / 'cut' / name}: No space left on device."


def test_replacement_leaves_the_old_file_if_the_new_one_fails(tmp_path):
    path = tmp_path / "a" / "table.csv"
    for text in ("old\n", "new\n"):
        with replacement(path) as new:
            new.write_text(text)
        with pytest.raises(KeyError), replacement(path) as new:
            new.write_text("half")
            raise KeyError
        assert path.read_bytes() == text.encode() and list(path.parent.iterdir()) == [path]


# Tables


def rows(text):
    """Return a table as columns, as any reader of CSV with a heading has them."""
    return np.genfromtxt(text.splitlines(), delimiter=",", names=True, dtype=None, encoding=None)


ABOUT = rows(plan_csv(PLAN, "a job"))


def joints(table, unit):
    return np.stack([table[f"theta_{unit}"], table[f"phi_{unit}"]], axis=-1)


def test_setvalues_come_back_bit_for_bit():
    table = rows(setvalues_csv(PLAN))
    counts = joints(table, "counts")
    assert counts.dtype.kind == "i" and ABOUT["job"] == "a job"
    np.testing.assert_array_equal(ABOUT["count_rad"] * counts, PLAN.setvalues)
    np.testing.assert_array_equal(table["tick"], np.arange(len(counts)))
    np.testing.assert_allclose(table["time_s"], ABOUT["tick_s"] * table["tick"], atol=1e-9)
    np.testing.assert_array_equal(joints(table, "slope_rad_s"), [*PLAN.slopes, (0, 0)])
    assert (ABOUT["laps"], ABOUT["advance_m"]) == (2, 0.04)


def test_setpoints_make_the_setvalues():
    table = rows(setpoints_csv(PLAN))
    assert table["ticks"][0] == 0 and table["ticks"].sum() == len(PLAN.setvalues) - 1
    made = polyline(joints(table, "parts"), table["ticks"][1:], parts=int(ABOUT["parts"]))
    np.testing.assert_array_equal(ABOUT["count_rad"] * made, PLAN.setvalues)
    np.testing.assert_array_equal(table["feed_m_s"], PLAN.feed)
    np.testing.assert_allclose(table["time_s"], PLAN.tick * np.cumsum(table["ticks"]), atol=1e-9)


def test_knots_come_back_bit_for_bit():
    table = rows(knots_csv(PLAN))
    np.testing.assert_array_equal(table["s_m"], PLAN.knots)
    at = ABOUT["count_rad"] * joints(table, "counts")
    assert np.max(np.abs(at - PLAN.circuit.position(PLAN.knots))) <= PLAN.count / 2


# The wall


@pytest.fixture(scope="module")
def walled():
    return carve(PLAN, PLAN.setvalues, shape=(40, 92))


def test_wall_solid_is_closed_faces_outwards_and_has_the_grids_volume(
    walled, tmp_path, monkeypatch
):
    points, faces = mesh.wall_solid(walled.wall)
    # Rows of wedges between the first and the last ray, from the outermost piece on each ray.
    inner = np.linalg.norm(standing(walled.wall)[..., 1:], axis=-1)
    areas = np.sum(walled.wall.high.max(axis=0) ** 2 - inner**2, axis=1) / 2
    length = np.diff(walled.wall.lines.x)
    wedges = 2 * np.pi / inner.shape[1] * np.sum((areas[1:] + areas[:-1]) / 2 * length)
    # By the divergence theorem the signed volume is positive for outward triangles alone.
    a, b, c = np.moveaxis(points[faces], 1, 0)
    volume = np.sum(np.cross(a, b) * c) / 6
    assert volume == pytest.approx(wedges, rel=2e-3)
    monkeypatch.setattr(mesh, "BLOCK", 7)
    content = b"".join(mesh.stl(points, faces, "a job"))
    assert content.startswith(b"in mm, a job")
    (tmp_path / "wall.stl").write_bytes(content)
    read = pyvista.read(tmp_path / "wall.stl")
    assert read.volume == pytest.approx(1e9 * volume, rel=1e-5)
    assert read.n_cells == len(faces) and read.is_manifold and read.n_open_edges == 0
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    np.testing.assert_allclose(np.frombuffer(content[84:], mesh.STL)["normal"], across, atol=1e-3)


def test_unrolled_wall_has_each_ray_at_its_arc_length_and_its_overbreak_in_colour(walled):
    section, lines = PLAN.circuit.section, walled.wall.lines
    drawn = wall_plot.draw_unrolled(figure(height=8)[1], walled, limit=2e-3)
    # From the invert over left springing, roof and right springing.
    order = np.lexsort([np.where(lines.cos > 0, lines.sin, -lines.sin), lines.cos < 0])
    edges = np.asarray(drawn.get_coordinates()[0, :, 0])
    roof = section.a * np.pi / 2  # of the arc that begins at the left springing
    point = section.point(roof + edges)
    across = np.transpose([-lines.sin, lines.cos])[order]
    passed = np.einsum("ij,ij->i", point[1:-1], across[:-1])
    ahead = -np.einsum("ij,ij->i", point[1:-1], across[1:])
    assert np.all(passed > 0)
    np.testing.assert_allclose(passed, ahead, rtol=0.15)  # edges lie midway between their rays
    shown = drawn.get_array()
    over = 1e3 * walled.overbreak[:, order]
    # Ground that stands as far in as the cut is deep, 20 mm, has no colour.
    np.testing.assert_array_equal(shown.filled(0), np.where(over < -19.98, 0, over))
    assert drawn.get_clim() == (-2, 2)


# The drawing


def entities(text):
    """Return the entities of a drawing in DXF as dicts of their group codes."""
    lines = text.splitlines()
    pairs = list(zip(map(int, lines[::2]), lines[1::2], strict=True))
    assert pairs[-1] == (0, "EOF")
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
    points = np.array([ends(piece) for piece in pieces])
    np.testing.assert_allclose(points[:, 0], 1e3 * section.point(section.blends[:-1]), atol=1e-9)
    np.testing.assert_allclose(points[:, 1], np.roll(points[:, 0], -1, axis=0), atol=1e-9)
    assert {piece[8] for piece in pieces} == {"WALL"}
    for piece, arc in zip(pieces, section.arcs, strict=True):
        assert piece[0] == ("ARC" if isinstance(arc, Arc) else "LINE")
        if isinstance(arc, Arc):
            assert (piece[51] - piece[50]) % 360 == pytest.approx(np.degrees(arc.sweep), abs=1e-9)


def test_dxf_of_a_circle_is_a_circle_on_its_layer():
    wall = closed_profile([Arc(0.1, -0.2, 0.6, 0.3, 2 * np.pi)])
    (circle, *arcs) = entities(dxf({"WALL": wall, "CENTRE": EGG}))
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
