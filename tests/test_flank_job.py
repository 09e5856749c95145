"""`tunneller flank`: from a file to paths, and what is refused, each in a sentence."""

import csv
import io
import json
import re
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tunneller_lib.__main__ import main
from tunneller_lib.envelopes.blade import BladeRing
from tunneller_lib.job.csv_reading import read_csv
from tunneller_lib.job.flank import read_flank
from tunneller_lib.job.measured_patch import _check_normals, _table, patch_through
from tunneller_lib.job.mesh import PLY_POINT, Mesh, read_stl, stl
from tunneller_lib.job.tables import WrongJob
from tunneller_lib.milling import find_positions, fit_nurbs, sweep_error

READS = ["notebooks/flank.toml"]

ROOT = Path(__file__).resolve().parents[1]
JOB = ROOT / "notebooks" / "flank.toml"
RING = BladeRing(0.06, 0.03, 0.05, np.radians(-40), np.radians(70), -0.006, -0.006, 6)
# Few points and strips: soon done.
QUICK = {"points = 9": "points = 4", "strips = 12": "strips = 2", "mesh = 121": "mesh = 41"}
BLADE = JOB.read_text(encoding="utf-8").partition('kind = "blade"')[2].partition("\n[mill]")[0]


# Least times take longest: of the job as it is and of jobs that change its feeds alone.
FEED = re.search(r"^\[feed\].*?(?=^# Tables)", JOB.read_text(encoding="utf-8"), re.M | re.S)[0]


def ran(folder, changes=None, *more, surface=None, feed=""):
    """Run a changed job in a folder: exit code, both outputs, and the folder that it writes.

    In the place of feeds that it leaves as they are it has `feed`.
    """
    text = JOB.read_text(encoding="utf-8")
    if surface:
        text = text.replace('kind = "blade"' + BLADE, surface)
    for old, new in (QUICK | (changes or {})).items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    text = text.replace(FEED, feed)
    job = folder / "job.toml"
    job.write_text(text, encoding="utf-8")
    said, errors = io.StringIO(), io.StringIO()
    with redirect_stdout(said), redirect_stderr(errors):
        code = main(["flank", str(job), "--out", str(folder / "out"), *map(str, more)])
    return code, said.getvalue(), errors.getvalue(), folder / "out"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a changed job."""
    return partial(ran, tmp_path)


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """Return what comes of the job as it is."""
    return ran(tmp_path_factory.mktemp("usual"), feed=FEED)


def measured(n=40, low=0.3, high=0.7):
    """Return points (n * n, 3) and unit normals of a part of the blade."""
    part = np.linspace(low, high, n)
    s, t = np.meshgrid(part, part, indexing="ij")
    points = np.stack(RING.coordinates(s, t), axis=-1)
    step = 1e-6
    by_s = np.stack(RING.coordinates(s + step, t), -1) - np.stack(RING.coordinates(s - step, t), -1)
    by_t = np.stack(RING.coordinates(s, t + step), -1) - np.stack(RING.coordinates(s, t - step), -1)
    normal = np.cross(by_s, by_t)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return points.reshape(-1, 3), normal.reshape(-1, 3)


def table(path, points, normal):
    rows = np.concatenate([points, normal], axis=1).tolist()
    lines = ["x_m,y_m,z_m,nx,ny,nz", *(",".join(map(repr, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


POINTS = 'kind = "points"\ncontact_error = 1e-7\nnormal_error = 1e-5\n'


def columns_of(path):
    """Return the columns, as texts, of a table below a line of comment."""
    names, *rows = csv.reader(path.read_text().splitlines()[1:])
    return dict(zip(names, np.array(rows).T, strict=True))


def test_a_job_gives_tables_and_paths_that_agree(run):
    code, said, _, out = run({}, "--json")
    assert code == 0
    numbers = json.loads(said)
    assert sorted(path.name for path in out.iterdir()) == [
        "axes.csv", "manifest.txt", "milled.ply", "milled.stl", "milled.vtp", "paths.apt",
        "paths.csv", "positions.csv",
    ]  # fmt: skip
    _, paths = read_csv((out / "paths.csv").read_text())
    assert len(paths["chain"]) == sum(chain["positions"] for chain in numbers["chains"]) > 10
    cuts = re.findall(r"^\$\$ CUT.*\n((?:[GF].*\n)+)", (out / "paths.apt").read_text(), re.M)
    goto = re.findall(r"^GOTO/(.*)$", "".join(cuts), re.M)
    apt = np.array([list(map(float, line.split(","))) for line in goto])
    tip = np.stack([paths[f"tip_{c}_m"].astype(float) for c in "xyz"], axis=-1)
    axis = np.stack([paths[f"axis_{c}"].astype(float) for c in "xyz"], axis=-1)
    np.testing.assert_allclose(apt[:, :3], 1e3 * tip, atol=1e-6)  # mm, six digits
    np.testing.assert_allclose(apt[:, 3:], axis, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(axis, axis=-1), 1)
    axes = columns_of(out / "axes.csv")
    cut = axes["motion"] == "cut"
    np.testing.assert_allclose(axes["tip_x_m"][cut].astype(float), tip[:, 0], atol=1e-15)
    assert np.array_equal(axes["chain"][cut].astype(float), paths["chain"])
    rows = (out / "positions.csv").read_text().splitlines()[2:]
    assert sum(row.endswith(",fits") for row in rows) == numbers["positions"]["fits"]
    assert len(rows) == sum(numbers["positions"].values())
    assert list(numbers["covered"]) == ["1e-05", "5e-05", "0.0001"]  # m
    assert 0 < numbers["covered"]["1e-05"] <= numbers["covered"]["0.0001"] <= 1
    assert numbers["gouge_m"] <= 10e-6


def test_only_traverses_are_rapid(usual):
    code, _, _, out = usual
    assert code == 0
    text = (out / "paths.apt").read_text()
    parts = re.split(r"^\$\$ (\w+), CHAIN \d+$", text, flags=re.M)[1:]
    for kind, lines in zip(parts[::2], parts[1::2], strict=True):
        assert lines.count("RAPID\n") == (lines.count("GOTO/") if kind == "TRAVERSE" else 0)
    assert parts[::2] == ["APPROACH", "CUT", "RETRACT", "TRAVERSE", "APPROACH", "CUT", "RETRACT"]


FAMILY = {
    "[mill]": "[[mill]]",
    "[paths]": "[[mill]]\nhalf_angle_deg = 20\ntip_radius = 0.0031\nlength = 0.0601\n"
    "holder_radius = 0.0121\nholder_length = 0.0401\n\n[paths]",
    "points = 9": "points = 5", "strips = 12": "strips = 5", "mesh = 121": "mesh = 61",
}  # fmt: skip


def test_several_mills_go_one_after_the_other_each_where_something_is_left(run):
    code, said, err, out = run(FAMILY, "--json", feed=FEED)
    assert code == 0, err
    numbers = json.loads(said)
    by = [chain["mill"] for chain in numbers["chains"]]
    assert by == sorted(by) and set(by) == {1, 2}
    every = sum((Counter(one) for one in numbers["mills"]), Counter())
    assert dict(every) == numbers["positions"]
    for name, columns in (
        ("positions.csv", "reason"),
        ("paths.csv", "chain"),
        ("axes.csv", "chain"),
    ):
        table = columns_of(out / name)
        assert set(table["mill"]) == {"1", "2"} and columns in table
    apt = (out / "paths.apt").read_text()
    assert re.findall(r"^LOADTL/(\d)\nCUTTER/([\d.]+)", apt, re.M) == [
        ("1", "6.000000"), ("2", "6.200000")
    ]  # fmt: skip
    assert (
        len(re.findall(r"^MULTAX/ON\n\$\$ THE WAY TO THE FIRST PLACE IS NOT PLANNED$", apt, re.M))
        == 2
    )
    assert re.findall(r"^\$\$ CUT, CHAIN (\d)", apt, re.M) == [str(k + 1) for k in range(len(by))]


def test_one_strip_of_two_mills_is_that_of_the_first(run):
    _, alone, _, _ = run({"strips = 12": "strips = 1"}, "--json")
    _, both, _, _ = run(FAMILY | QUICK | {"strips = 12": "strips = 1"}, "--json")
    alone, both = json.loads(alone), json.loads(both)
    assert alone["chains"] == both["chains"] and alone["covered"] == both["covered"]


def test_a_mill_that_is_given_twice_is_refused(run):
    text = JOB.read_text(encoding="utf-8")
    table = text[text.index("half_angle_deg") : text.index("[paths]")]
    twice = {"[mill]": "[[mill]]", "[paths]": f"[[mill]]\n{table}\n[paths]"}
    refused(run(twice), 2, r"\[\[mill\]\]: must be different ones")
    wrong = FAMILY | {"half_angle_deg = 12": "half_angle_deg = 95"}
    refused(run(wrong), 1, r"\[mill 1\] half_angle_deg: must lie")


@pytest.mark.parametrize("slow", ["turn_deg = 90", "acceleration"])
def test_feeds_keep_speeds_and_accelerations_of_mill_and_axes(run, slow):
    changes = {"turn_deg = 90": "turn_deg = 10"}
    accelerations = {"x_mm": 1000, "y_mm": 1000, "z_mm": 1000, "A_deg": 300, "C_deg": 450}
    if slow == "acceleration":
        changes = {f"{c}_acceleration = 1.0": f"{c}_acceleration = 0.05" for c in "xyz"}
        accelerations |= {"x_mm": 50, "y_mm": 50, "z_mm": 50}
    code, said, err, out = run(changes, "--json")
    assert code == 0, err
    axes = columns_of(out / "axes.csv")
    seconds = axes["least_time_s"].astype(float)
    assert json.loads(said)["seconds"] == pytest.approx(seconds.sum(), rel=1e-3)
    tip, axis = (
        np.stack([axes[f"{of}_{c}{unit}"].astype(float) for c in "xyz"], axis=-1)
        for of, unit in (("tip", "_m"), ("axis", ""))
    )
    speeds = {"x_mm": 300, "y_mm": 300, "z_mm": 300, "A_deg": 60, "C_deg": 90}
    speeds["C_deg"] = 10 if slow != "acceleration" else 90
    ways = [np.abs(np.diff(axes[name].astype(float))) / most for name, most in speeds.items()]
    cuts = axes["motion"][1:] != "traverse"
    for height in (0.0, 0.03, 0.06):
        way = np.linalg.norm(np.diff(tip + height * axis, axis=0), axis=-1)
        ways.append(np.where(cuts, way / 0.02, 0.0))
    shares = np.array(ways) / np.maximum(seconds[1:], 1e-5)  # of each greatest speed
    # From rest to rest the mean speeds of steps change as fast as means of the accelerations.
    begins = np.append(True, axes["motion"][1:] != axes["motion"][:-1])
    starts = np.flatnonzero(begins)
    for first, stop in zip(starts, [*starts[1:], len(seconds)], strict=True):
        rows = slice(max(first - (axes["motion"][first] != "cut"), 0), stop)
        time = seconds[rows.start + 1 : stop]
        found = [shares[:, rows.start : stop - 1].max()]
        for name, most in accelerations.items():
            speed = np.diff(axes[name].astype(float)[rows]) / time
            ends = 2 * np.abs(speed[[0, -1]] / time[[0, -1]])
            inner = np.abs(np.diff(speed)) / ((time[1:] + time[:-1]) / 2)
            found.append(max(*ends, inner.max(initial=0.0)) / most)
        assert max(found) <= 1 + 2e-3  # the table has six digits of each
        assert max(found) > 0.95
    if slow == "acceleration":
        assert found[3] > 0.985  # z, at the last retraction, of 0.99 that are used
    else:
        assert shares[4].max() == pytest.approx(1, abs=2e-3)  # C
    assert shares[5].max() == pytest.approx(1, abs=2e-3)  # the mill's tip
    text = (out / "paths.apt").read_text()
    assert 2 < seconds.sum() < 120 and f"{seconds.sum():.1f} S AT LEAST" in text
    told = np.nan
    feeds = []
    for line in text.splitlines():
        if line.startswith("FEDRAT/"):
            told = float(line[7:].removesuffix(",MMPM"))
        if line.startswith("GOTO/"):
            feeds.append(told)
    moved = 6e4 * np.linalg.norm(np.diff(tip, axis=0), axis=-1)
    moves = cuts & (moved > 1e-4)
    slower = np.array(feeds[1:])[moves] * seconds[1:][moves] / moved[moves]
    assert slower.max() <= 1 + 1e-4 and slower.min() > 0.99
    assert np.nanmin(feeds) > 1.0  # mm/min: what rounding alone moves has no feed of its own


def test_without_a_machine_no_way_between_chains_is_planned(run):
    text = JOB.read_text(encoding="utf-8")
    code, _, _, out = run({text[text.index("[machine]") :]: ""})
    assert code == 0
    assert not (out / "axes.csv").exists()
    assert "THE WAY TO IT AND FROM IT IS NOT PLANNED" in (out / "paths.apt").read_text()


def test_boxes_are_neighbours(run, usual):
    _, _, _, free = usual
    rows = columns_of(free / "positions.csv")
    row = np.flatnonzero(rows["reason"] == "fits")[0]
    tip, axis = (
        np.array([float(rows[f"{of}_{c}{unit}"][row]) for c in "xyz"])
        for of, unit in (("tip", "_m"), ("axis", ""))
    )
    middle = tip + 0.09 * axis  # within the holder
    box = "\n".join(
        f"{c}_min = {x - 0.004}\n{c}_max = {x + 0.004}" for c, x in zip("xyz", middle, strict=True)
    )
    text = JOB.read_text(encoding="utf-8")
    last = text[text.index("# Tables [[box]]") :]
    code, _, err, out = run({last: f"[[box]]\n{box}\n"})
    assert code == 0, err
    again = columns_of(out / "positions.csv")
    assert again["reason"][row] == "enters a neighbour"
    assert float(again["others_enter_m"][row]) > 0.004


def test_spindle_and_table_refuse_positions(tmp_path):
    """A wide table across the blade: the spindle's lowest point is below it, or it isn't."""
    top, radius, length = 0.005, 0.06, 0.2
    text = JOB.read_text(encoding="utf-8")
    spindle = f"spindle_radius = {radius}\nspindle_length = {length}\n"
    sides = "".join(f"{c}_min = -0.45\n{c}_max = 0.45\n" for c in "yz")
    table = f"[box]\nx_min = -0.02\nx_max = {top}\n{sides}\n"
    changed = text.replace("\n[paths]", f"{spindle}\n{table}[paths]")
    found = []
    for number, content in enumerate((text, changed)):
        path = tmp_path / f"{number}.toml"
        path.write_text(content, encoding="utf-8")
        job = read_flank(path)
        [mill] = job.tools
        about = {"tolerance": 10e-6, "others": job.neighbours, "n": 41}
        at = job.patch.parameters(4, margin=0.05)
        found.append(find_positions(job.patch, mill, *at, **about))
    free, again = found
    ends = free.tip[:, :1] + np.array([0.1, 0.1 + length]) * free.axis[:, :1]  # of the spindle
    deep = top - (ends.min(axis=1) - radius * np.sqrt(1 - free.axis[:, 0] ** 2))
    enters = (deep > 0)[free.fits]
    assert enters.any() and not enters.all()
    reasons = again.reason[free.fits]
    np.testing.assert_array_equal(reasons, np.where(enters, "enters a neighbour", "fits"))
    depth = again.others_enter[free.fits][enters]
    np.testing.assert_array_less(depth, deep[free.fits][enters] + 1e-9)


def test_a_cradle_is_the_faces_of_boxes_that_the_machine_has(tmp_path, run):
    box = "[[cradle]]\n" + "".join(f"{c}_min = -0.3\n{c}_max = -0.25\n" for c in "xyz")
    text = JOB.read_text(encoding="utf-8")
    path = tmp_path / "cradle.toml"
    path.write_text(text + box, encoding="utf-8")
    cradle = read_flank(path).table.cradle.points
    np.testing.assert_allclose([cradle.min(axis=0), cradle.max(axis=0)], [[-0.3] * 3, [-0.25] * 3])
    assert len(np.unique(cradle, axis=0)) == 8 and len(cradle) == 6 * 4
    path.write_text(text, encoding="utf-8")
    assert read_flank(path).table.cradle is None
    machine = text[text.index("[machine] ") : text.index("# Tables [[box]]")]
    refused(
        run({machine: box}), 2, r"\[cradle\]: needs the machine that it belongs to, \[machine\]"
    )


@pytest.mark.parametrize(("low", "high"), [(0.1, 0.1), (0.1, "nan"), ("-inf", 0.1), (0.1, "inf")])
@pytest.mark.parametrize("name", ["box", "cradle"])
def test_a_box_whose_limits_dont_ascend_or_are_not_finite_is_refused(run, name, low, high):
    box = "".join(f"{c}_min = {low}\n{c}_max = {high}\n" for c in "xyz")
    refused(
        run({"[machine] ": box.join([f"[{name}]\n", "[machine] "])}),
        1,
        rf"\[{name}\] \w_min: must be below \w_max, both finite; got",
    )


def test_a_machine_limits_the_positions(run):
    flat = {"tilt_max_deg = 120": "tilt_max_deg = 95", "tilt_min_deg = -30": "tilt_min_deg = 85"}
    code, said, err, out = run(flat)
    assert code == 0, err
    assert "positions: beyond the machine's axes" in said
    axes = columns_of(out / "axes.csv")
    tilt = axes["A_deg"].astype(float)
    assert tilt.min() >= 85 and tilt.max() <= 95


def test_the_milled_surface_is_what_the_mill_sweeps(usual):
    """Where little is left, points of both files lie on the swept mill; else the stock stands."""
    code, _, _, out = usual
    assert code == 0
    read = read_stl((out / "milled.stl").read_bytes())
    _, paths = read_csv((out / "paths.csv").read_text())
    columns = [[paths[f"{of}_{c}{unit}"].astype(float) for c in "xyz"]
               for of, unit in (("tip", "_m"), ("axis", ""))]  # fmt: skip
    [mill] = read_flank(JOB).tools
    error = np.full(len(read.points), np.inf)
    for chain in np.unique(paths["chain"]):
        tip, axis = (np.stack(part, axis=-1)[paths["chain"] == chain] for part in columns)
        error = np.minimum(error, sweep_error(read.points, mill, tip, axis))
    head, _, body = (out / "milled.ply").read_bytes().partition(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", head)[1])
    points = np.frombuffer(body, PLY_POINT, count)
    near = np.abs(points["value"]) < 50
    assert near.sum() > 100
    off = [np.abs(error[np.linalg.norm(read.points - p, axis=-1).argmin()])
           for p in points["place"][near][::10]]  # fmt: skip
    assert max(off) < 2e-6
    assert points["value"].max() == pytest.approx(1000)  # the stock, in um
    assert (points["colour"][points["value"] == points["value"].max()] == (255, 0, 0)).all()
    # The colour is full from 100 um on, and paler in proportion below.
    pale = np.round(255 * (1 - np.minimum(np.abs(points["value"]) / 100, 1)))
    assert (np.abs(points["colour"].min(axis=1) - pale) <= 1).all()


def test_people_get_lines(usual):
    code, said, _, _ = usual
    assert code == 0
    assert re.search(r"positions: fits\n", said)
    assert re.search(r"% of the patch is milled to within 10 um", said)


def nurbs(count=9, **changes):
    part = np.linspace(0.2, 0.8, 40)
    grid = np.stack(RING.coordinates(*np.meshgrid(part, part, indexing="ij")), axis=-1)
    fit, _ = fit_nurbs(grid, part, part, count=count)
    rows = ",\n".join(str(row) for row in (1e3 * fit.control).round(9).tolist())
    values = {"control": f"[{rows}]", "knots_s": fit.knots_s.tolist(),
              "knots_t": fit.knots_t.tolist(), "unit": '"mm"'} | changes  # fmt: skip
    return 'kind = "nurbs"\n' + "".join(f"{k} = {v}\n" for k, v in values.items())


def test_a_surface_by_knots_in_millimetres_is_milled(run):
    code, said, err, _ = run(surface=nurbs())
    assert code == 0, err
    assert "positions: fits" in said


BIG = {"tip_radius = 0.003": "tip_radius = 0.010", "length = 0.060": "length = 0.300",
       "holder_radius = 0.012": "holder_radius = 0.030"}  # fmt: skip


def test_a_surface_of_low_degree_is_warned_of(run):
    line = np.linspace(-10, 10, 4)
    x, y = np.meshgrid(line, line, indexing="ij")
    control = np.stack([x, y, 0.03 * x * y], axis=-1).tolist()
    knots = [0.0] * 4 + [1.0] * 4
    surface = nurbs(control=control, knots_s=knots, knots_t=knots)
    code, _, err, _ = run(BIG, surface=surface)
    assert code == 0, err
    assert "warning: the surface's degree is below 5" in err


def test_a_surface_that_is_a_saddle_in_part_is_milled_there_and_warned_of(run):
    line = np.linspace(-10, 10, 8)
    x, y = np.meshgrid(line, line, indexing="ij")
    height = 0.03 * x * y + 0.001 * x**3 + 0.02 * y**2
    control = np.stack([x, y, height], axis=-1).tolist()
    knots = [0.0] * 8 + [1.0] * 8
    surface = nurbs(control=control, knots_s=knots, knots_t=knots)
    code, _, err, out = run(BIG, surface=surface)
    assert code == 0, err
    assert re.search(r"no regular saddle: of 16 points are 4 convex \(K > 0\)", err)
    assert "fits" in columns_of(out / "positions.csv")["reason"]


def test_measured_points_are_milled(run, tmp_path):
    points = table(tmp_path / "points.csv", *measured())
    code, said, err, _ = run({}, "--points", points, surface=POINTS)
    assert code == 0, err
    assert "positions: fits" in said


def triangles(n=60):
    """Return a part of the blade as a `Mesh`."""
    points, _ = measured(n)
    corners = np.arange(n * n).reshape(n, n)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    faces = [np.stack(one, axis=-1).reshape(-1, 3) for one in ((a, b, c), (a, c, d))]
    return Mesh(points, np.concatenate(faces))


def test_a_mesh_of_triangles_is_milled(run, tmp_path):
    path = tmp_path / "part.STL"
    path.write_bytes(stl(triangles()))
    errors = POINTS.replace("1e-5", "3e-3")  # normals amid triangles
    code, said, err, _ = run({}, "--points", path, surface=errors)
    assert code == 0, err
    assert "positions: fits" in said
    assert re.search(r"are the greatest standard errors of the surface's points", said)


def test_a_mesh_that_is_none_is_refused(run, tmp_path):
    path = tmp_path / "part.stl"
    path.write_bytes(b"solid nothing\nendsolid\n")
    refused(run({}, "--points", path, surface=POINTS), 2, rf"^wrong: {path}: must be an STL file")


def test_a_ball_is_refused_as_umbilic(run):
    """A quarter of a ball's strip, by the fifth degree of its angles: umbilic everywhere."""
    part = np.linspace(-0.3, 0.3, 40)
    u, v = np.meshgrid(part, part, indexing="ij")
    grid = 0.02 * np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1)
    fit, _ = fit_nurbs(grid, part, part, count=14, degree=7)
    rows = ",\n".join(str(row) for row in (1e3 * fit.control).tolist())
    surface = nurbs(control=f"[{rows}]", knots_s=fit.knots_s.tolist(),
                    knots_t=fit.knots_t.tolist())  # fmt: skip
    refused(run(surface=surface), 1, r"is nowhere a regular saddle .* (umbilic|convex)")


def refused(result, code, sentence):
    got, _, err, folder = result
    assert got == code, err
    assert re.search(sentence, err), err
    assert err.strip().splitlines()[-1].endswith(".")
    assert not folder.exists()


def test_points_with_a_hole_are_refused(run, tmp_path):
    points, normal = measured()
    away = np.linalg.norm(points - points.mean(axis=0), axis=-1) > 2.5e-3
    path = table(tmp_path / "points.csv", points[away], normal[away])
    refused(run({}, "--points", path, surface=POINTS), 1, "points: must leave no hole; got one")


def test_flipped_normals_are_refused(run, tmp_path):
    points, normal = measured()
    normal[[100, 700, 701]] *= -1
    path = table(tmp_path / "points.csv", points, normal)
    refused(run({}, "--points", path, surface=POINTS), 1, "must point to one side.*; 3 of 1600 don")


def test_meshes_with_a_hole_or_flipped_triangles_are_refused(run, tmp_path):
    path = tmp_path / "part.stl"
    mesh = triangles()
    middle = mesh.points[mesh.faces].mean(axis=1)
    near = np.linalg.norm(middle - mesh.points.mean(axis=0), axis=-1) < 2.5e-3
    path.write_bytes(stl(Mesh(mesh.points, mesh.faces[~near])))
    errors = POINTS.replace("1e-5", "3e-3")
    refused(run({}, "--points", path, surface=errors), 1, "points: must leave no hole; got one")
    flipped = np.where(near[:, None], mesh.faces[:, ::-1], mesh.faces)
    path.write_bytes(stl(Mesh(mesh.points, flipped)))
    refused(run({}, "--points", path, surface=errors), 1, "normals must point to one side")


def test_points_noisier_than_said_are_refused(run, tmp_path):
    points, normal = measured()
    points += 20e-6 * np.random.default_rng(0).normal(size=points.shape)
    path = table(tmp_path / "points.csv", points, normal)
    refused(run({}, "--points", path, surface=POINTS), 1, "no polynomial passes all of them")


def test_a_patch_leaves_out_eight_hundredths_of_the_points_on_each_side(tmp_path):
    path = table(tmp_path / "points.csv", *measured())
    errors = {"contact_error": 1e-7, "normal_error": 1e-5}
    patch, fit = patch_through(path.read_text(encoding="utf-8"), errors, 1)
    for place, (low, high) in zip(fit.place.T, (patch.s, patch.t), strict=True):
        assert np.mean(place < low) == pytest.approx(0.08, abs=1e-3)
        assert np.mean(place > high) == pytest.approx(0.08, abs=1e-3)


def test_normals_of_a_table_are_made_unit_vectors_and_eight_points_are_too_few(tmp_path):
    points, normal = measured()
    text = table(tmp_path / "points.csv", points, 1.005 * normal).read_text(encoding="utf-8")
    contact, unit = _table(text)
    np.testing.assert_allclose(contact, points, rtol=1e-14)
    np.testing.assert_allclose(unit, normal, rtol=1e-12, atol=1e-15)
    _check_normals(contact[:9], unit[:9])
    with pytest.raises(ValueError, match=r"^points: must be more than 8; got 8\.$"):
        _check_normals(contact[:8], unit[:8])


def test_points_that_are_no_table_are_refused(run, tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("x_m,y_m\n1,2\n", encoding="utf-8")
    said = rf"^wrong: {path}: must have the columns x_m, y_m, z_m, nx, ny, nz; got x_m, y_m\.$"
    refused(run({}, "--points", path, surface=POINTS), 2, said)
    path.write_text("x_m,y_m\n1\n", encoding="utf-8")
    said = rf"^wrong: {path}: line 2 must have 2 numbers, one under each name; got 1\.$"
    refused(run({}, "--points", path, surface=POINTS), 2, said)
    mesh = tmp_path / "mesh.stl"
    mesh.write_bytes(b"solid")
    refused(run({}, "--points", mesh, surface=POINTS), 2, rf"^wrong: {mesh}: must be an STL file")
    refused(
        run({}, "--points", path), 2, r'^wrong: --points: is for a \[surface\] of kind "points";'
    )
    refused(run({}, surface=POINTS), 2, r"needs the file of measured points, --points FILE\.$")
    refused(run({}, "--points", tmp_path / "none.csv", surface=POINTS), 2, "can't be read")


def test_a_bowl_is_refused_where_it_is_nowhere_a_saddle(run):
    line = np.linspace(-10, 10, 6)
    x, y = np.meshgrid(line, line, indexing="ij")
    control = np.stack([x, y, 0.03 * (x * x + 0.7 * y * y)], axis=-1).tolist()
    knots = [0.0] * 6 + [1.0] * 6
    surface = nurbs(control=control, knots_s=knots, knots_t=knots)
    refused(run(surface=surface), 1, r"is nowhere a regular saddle .* of 16 points are 16 convex")


def test_a_mill_that_is_too_large_is_refused(run):
    large = {"tip_radius = 0.003": "tip_radius = 0.500"}
    refused(run(large), 1, r"\[mill\] none of its \d+ positions fits: .* off the cutting part")


@pytest.mark.parametrize(
    "name, low, high", [("points", 2, 50), ("strips", 1, 100), ("mesh", 20, 500)]
)
def test_how_many_are_looked_at_has_both_its_ends(tmp_path, name, low, high):
    path = tmp_path / "job.toml"
    text = JOB.read_text(encoding="utf-8")

    def read(value):
        path.write_text(re.sub(rf"^{name} = \d+", f"{name} = {value}", text, flags=re.M))
        return read_flank(path).paths[name]

    assert [read(value) for value in (low, high)] == [low, high]
    for value in (low - 1, high + 1):
        with pytest.raises(
            ValueError, match=rf"^\[paths\] {name}: must be from {low} to {high}; got"
        ):
            read(value)


def test_what_should_be_a_table_is_one(tmp_path):
    path = tmp_path / "job.toml"
    path.write_text("surface = 5", encoding="utf-8")
    with pytest.raises(WrongJob, match=r"^surface: must be a table, \[surface\]; got 5\.$"):
        read_flank(path)


@pytest.mark.parametrize(
    ("changes", "code", "sentence"),
    [
        ({"tolerance = 10e-6": ""}, 2, r"\[paths\] tolerance: is missing \(m\)"),
        (
            {"tolerance = 10e-6": "tolerance = -1e-3"},
            1,
            r"\[paths\] step, stock, tolerance: must be finite",
        ),
        ({"side = 1  ": "side = 2  "}, 1, r"\[paths\] side: must be 1 or -1; got 2"),
        ({"hub = 0.060": "hub = 60"}, 1, r"\[surface\] hub: must be at most 50 m; .* in mm"),
        ({'kind = "blade"': 'kind = "step"'}, 1, r"\[surface\] kind: must be"),
        ({"blades = 6": "blade = 6"}, 2, "'blades' is meant, perhaps"),
        ({"clearance = 0.010": ""}, 2, r"\[machine\] clearance: is missing \(m\)"),
        ({"clearance = 0.010": "clearance = 0"}, 1, r"\[machine\] clearance: must be a finite"),
        ({"up_x = 1": "up_x = 0"}, 1, r"\[machine\] up: must"),
        (
            {"tilt_max_deg = 120": "tilt_max_deg = -40"},
            1,
            r"\[machine\] tilt_min_deg: must be below tilt_max_deg, both finite; got -30 and -40",
        ),
        ({"z_max = 0.4": "z_max = 0.05"}, 1, r"machine: z must reach .* mm, where the table moves"),
        (
            {"tilt_max_deg = 120": "tilt_max_deg = -20"},
            1,
            r"\[mill\] none of its \d+ positions fits: .* beyond the machine's axes",
        ),
        ({"contacts = 1": "contacts = 3"}, 1, r"\[paths\] contacts: must be from 1 to 2; got 3"),
        ({"turn_deg = 90": ""}, 2, r"\[feed\] turn: is missing \(rad/s, or turn_deg\)"),
        (
            {"turn_deg = 90": "turn_deg = 0"},
            1,
            r"\[feed\] turn_deg: must be finite and above zero; got 0\.$",
        ),
        (
            {"half_angle_deg = 12": "half_angle_deg = 95"},
            1,
            r"\[mill\] half_angle_deg: must lie between 0 and 90, both left out; got 95\.$",
        ),
        (
            {"most_turn_deg = 15": "most_turn_deg = -5"},
            1,
            r"\[machine\] most_turn_deg: must be one finite number above zero; got -5\.$",
        ),
        ({"blades = 6": "blades = 0"}, 1, r"\[surface\] blades: must be one whole number from 2"),
        (
            {"tilt_acceleration_deg = 300": ""},
            2,
            r"\[feed\] tilt_acceleration: is missing \(rad/s\^2, or tilt_acceleration_deg\)",
        ),
        ({"stock = 1e-3": "stock = 0"}, 1, r"\[paths\] step, stock, tolerance: must be finite"),
        ({"[mill]": "[tool]"}, 2, r"\[tool\]: is no table of such a job"),
    ],
)
def test_what_a_job_says_wrongly_is_refused_in_a_sentence(run, changes, code, sentence):
    refused(run(changes), code, sentence)


@pytest.mark.parametrize(
    ("changes", "code", "sentence"),
    [
        ({"control": "[[1, 2], [3]]"}, 2, "control: must be finite numbers in lists"),
        ({"unit": '"inch"'}, 1, r"\[surface\] unit: must be"),
        (
            {"knots_s": "[0, 1]"},
            1,
            r"\[surface\] knots_s: must be for a degree from 3 to 9, .*; got 2 knots for 9 points: "
            "degree -8",
        ),
    ],
)
def test_knots_and_points_that_make_no_surface_are_refused(run, changes, code, sentence):
    refused(run(surface=nurbs(**changes)), code, sentence)
