"""Scene and animation of a mill on its way, and what is left on the surface by then."""

import re
from pathlib import Path

import numpy as np
import pytest
import pyvista

from exhibits import flank_scene
from tunneller_lib.job.flank import read_flank
from tunneller_lib.milling import sweep_error

READS = ["notebooks/flank.toml"]

JOB = Path(__file__).resolve().parents[1] / "notebooks" / "flank.toml"


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    path = tmp_path_factory.mktemp("flank") / "job.toml"
    path.write_text(quick(), encoding="utf-8")
    job = read_flank(path)
    return job, job.solved(lambda text: None)


def quick():
    """Return the text of the study's job, with few points, a coarse mesh and no feeds."""
    text = JOB.read_text(encoding="utf-8")
    text, found = re.subn(r"^\[feed\].*?(?=^# Tables)", "", text, flags=re.M | re.S)
    assert found == 1
    quickly = {"points = 9": "points = 4", "strips = 12": "strips = 3", "mesh = 121": "mesh = 41"}
    for old, new in quickly.items():
        text = text.replace(old, new)
    return text


def drawn(plotter, name):
    """Return the mesh of a name that a scene shows."""
    mapper = plotter.actors[name].mapper
    mapper.Update()
    return pyvista.wrap(mapper.GetInput())


def left(plotter):
    """Return what the surface of a scene says is left at its points, in m, and these."""
    mesh = drawn(plotter, "surface")
    return 1e-6 * mesh[flank_scene.SCALAR], mesh.points


def test_the_surface_has_the_colour_of_what_the_mill_has_left(solved):
    job, result = solved
    plotter = flank_scene.mill_scene(job, result, None)
    error, points = left(plotter)
    [mill] = job.tools
    mills = [sweep_error(points, mill, c.tip, c.axis) for c in result.covered.chains]
    wanted = np.minimum(np.min(mills, axis=0), job.paths["stock"])
    np.testing.assert_allclose(error, wanted, atol=1e-7)  # points of a scene have single precision
    plotter.close()


def test_before_the_first_cut_the_stock_stands(solved):
    job, result = solved
    [tour], [mill] = result.tours, job.tools
    assert tour.kind[0] == "approach"
    plotter = flank_scene.mill_scene(job, result, 0)
    error, _ = left(plotter)
    assert np.all(error == job.paths["stock"])
    tip = drawn(plotter, "mill").points.mean(axis=0)
    middle = tour.tip[0] + mill.length / 2 * tour.axis[0]
    np.testing.assert_allclose(tip, middle, atol=1e-3 * mill.length)
    plotter.close()


def test_amid_a_chain_what_was_passed_is_cut(solved):
    job, result = solved
    first = result.covered.chains[0]
    passed = len(first) // 2
    place = np.flatnonzero(result.tours[0].kind == "cut")[passed - 1]
    plotter = flank_scene.mill_scene(job, result, int(place))
    error, points = left(plotter)
    swept = sweep_error(points, job.tools[0], first.tip[:passed], first.axis[:passed])
    np.testing.assert_allclose(error, np.minimum(swept, job.paths["stock"]), atol=1e-7)
    plotter.close()


def test_a_place_beyond_the_way_is_refused(solved):
    job, result = solved
    with pytest.raises(
        ValueError, match=r"^place: must be below \d+, the places of the way; got \d+\.$"
    ):
        flank_scene.mill_scene(job, result, len(result.tours[0]))


def test_pictures_change_as_the_mill_goes_on(solved):
    job, result = solved
    pictures = list(flank_scene.mill_pictures(job, result, 3, width=200))
    assert [picture.shape for picture in pictures] == [(150, 200, 3)] * 3
    assert np.any(pictures[0] != pictures[1]) and np.any(pictures[1] != pictures[2])
