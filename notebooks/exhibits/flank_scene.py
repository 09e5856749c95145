"""A conical mill on its way over a surface, which has the colour of what is left on it."""

import numpy as np
import PIL.Image

from kit import scene
from kit.style import COLOURS, ERROR_MAP
from tunneller_lib.arguments import Length, Whole, checked
from tunneller_lib.job.flank import FlankJob, FlankResult
from tunneller_lib.milling import sweep_error

WINDOW = 1200, 900
LIMIT = 100e-6  # m, left or cut, that has the full colour
SCALAR = "left on the surface / um"
BAR = dict(
    width=0.55,
    position_x=0.22,
    position_y=0.05,
    n_labels=3,
    fmt="%.0f",
    color="black",
    title=f"{SCALAR}; grey: the stock\n",  # a free line keeps it off the numbers
    above_label=" ",  # a word would lie upon the grey
)
AWAY = 0.6  # of the still picture's size: more of the mill's way is in view
COARSE = 81  # points of the surface each way


@checked
def mill_scene(
    job: FlankJob,
    result: FlankResult,
    place: Whole(0, 10**7) | None = None,
    *,
    limit: Length = LIMIT,
):
    """Return the scene of a mill at a place of its way, and of what it has left by then.

    Parameters
    ----------
    job : FlankJob
        With surface, mills and neighbours.
    result : FlankResult
        From its `solved`.
    place : int, optional
        Of the tours one after the other, or of the chains where there is none. By default, the
        mill stands amid the longest chain, and all chains are cut.
    limit : float
        What is left, or cut, with the full colour, in m.

    Returns
    -------
    plotter : pyvista.Plotter
        Its camera is set, and the same at all places.

    Raises
    ------
    ValueError
        If the place is beyond the way.
    """
    way = _Way(job, result)
    if place is not None and place >= len(way):
        raise ValueError(f"place: must be below {len(way)}, the places of the way; got {place}.")
    plotter = _still(job, result)
    error = way.error(len(way) if place is None else place + 1)
    _put(plotter, job, way, way.amid if place is None else place, error, limit)
    return plotter


@checked
def mill_pictures(
    job: FlankJob,
    result: FlankResult,
    count: Whole(2, 10_000),
    *,
    width: Whole(64, WINDOW[0]) = 600,
    limit: Length = LIMIT,
):
    """Yield the pictures of an animation of the mill, from its first place to its last.

    Parameters
    ----------
    job, result
        As for `mill_scene`.
    count : int
        How many, at least 2.
    width : int
        In pixels, at most that of a scene; the height is 3/4 of it.
    limit : float
        As for `mill_scene`.

    Yields
    ------
    pixels : (n, m, 3) uint8
        Red, green, blue.
    """
    way = _Way(job, result)
    plotter = _still(job, result)
    plotter.camera.zoom(AWAY)
    for place in np.linspace(0, len(way) - 1, count).round().astype(int):
        _put(plotter, job, way, place, way.error(place + 1), limit)
        plotter.render()
        pixels = plotter.screenshot(return_img=True)
        yield np.asarray(PIL.Image.fromarray(pixels).resize((width, width * 3 // 4)))
    plotter.close()


class _Way:
    """All places of a mill, and what is left after the first of them."""

    def __init__(self, job, result):
        covered = result.covered
        self.mills = covered.mills
        self.chains = covered.chains
        self.mesh = job.patch.mesh(COARSE)
        count = [len(chain) for chain in self.chains]
        parts = result.tours or self.chains
        self.tip = np.concatenate([part.tip for part in parts])
        self.axis = np.concatenate([part.axis for part in parts])
        if result.tours:
            cut = np.concatenate([tour.kind == "cut" for tour in result.tours])
            pairs = zip(result.begins, result.tours, strict=True)
            self.chain = np.concatenate([tour.chain + first for first, tour in pairs])
        else:
            cut = np.ones(len(self.tip), dtype=bool)
            self.chain = np.repeat(np.arange(len(count)), count)
        self.cuts = np.cumsum(cut)  # positions of chains, up to each place
        self.first = np.cumsum([0, *count])
        self.whole = {}

    def __len__(self):
        return len(self.tip)

    @property
    def amid(self):
        """Return the place of the mill amid the longest chain."""
        longest = int(np.argmax(np.diff(self.first)))
        middle = (self.first[longest] + self.first[longest + 1]) // 2
        return int(np.searchsorted(self.cuts, middle + 1))

    def error(self, places):
        """Return what is left (n, n), in m, after so many places: infinite where nothing is cut."""
        error = np.full(self.mesh.shape[:2], np.inf)
        done = self.cuts[places - 1]
        for k, chain in enumerate(self.chains):
            here = int(np.clip(done - self.first[k], 0, len(chain)))
            if here == len(chain):
                if k not in self.whole:
                    self.whole[k] = self._swept(k, here)
                error = np.minimum(error, self.whole[k])
            elif here >= 4:
                error = np.minimum(error, self._swept(k, here))
        return error

    def _swept(self, k, count):
        chain = self.chains[k]
        return sweep_error(self.mesh, self.mills[k], chain.tip[:count], chain.axis[:count])


def _still(job, result):
    """Return the scene of what stands still, with the camera: neighbours and chains."""
    plotter = scene.empty(parallel=False)
    plotter.window_size = WINDOW
    for grid in job.neighbours:
        plotter.add_mesh(scene.surface(grid), color=COLOURS["tunnel"])
    mesh = job.patch.mesh(COARSE)
    for chain in result.covered.chains:
        line = scene.curve(chain.contact, 2e-3 * np.ptp(mesh.reshape(-1, 3), axis=0).max())
        plotter.add_mesh(line, color="black")
    towards = np.mean([chain.normal.mean(axis=0) for chain in result.covered.chains], axis=0)
    middle = mesh.reshape(-1, 3).mean(axis=0)
    size = np.ptp(mesh.reshape(-1, 3), axis=0).max()
    spindle = np.mean([chain.axis.mean(axis=0) for chain in result.covered.chains], axis=0)
    up = spindle / np.linalg.norm(spindle)
    plotter.camera.focal_point = middle + 0.5 * size * up
    plotter.camera.position = middle + 4.5 * size * (towards + 0.6 * up)
    plotter.camera.up = up
    return plotter


def _put(plotter, job, way, place, error, limit):
    """Put surface and mill at a place in the place of those before."""
    micrometres = 1e6 * limit
    left = np.minimum(1e6 * error, 1e6 * job.paths["stock"])
    kept = {"reset_camera": False, "render": False}
    plotter.title = f"A conical mill on the surface; colours: {SCALAR}"
    plotter.add_mesh(
        scene.surface(way.mesh, {SCALAR: left}),
        name="surface",
        scalars=SCALAR,
        cmap=ERROR_MAP,
        clim=(-micrometres, micrometres),
        above_color=COLOURS["tunnel"],
        scalar_bar_args=dict(BAR),
        **kept,
    )
    mill = way.mills[way.chain[place]]
    tip = way.tip[place]
    axis = way.axis[place]
    near, far = mill.rulings
    cone = scene.cone(tip - mill.below * axis, axis, mill.half_angle, near, far)
    plotter.add_mesh(cone, name="mill", color=COLOURS["cone"], opacity=0.8, **kept)
    ends = tip + np.array([[mill.length], [mill.length + mill.holder_length]]) * axis
    holder = scene.curve(ends, mill.holder_radius)
    plotter.add_mesh(holder, name="holder", color=COLOURS["machine"], opacity=0.8, **kept)
    if mill.spindle_length:
        ends = tip + np.array([[mill.length + mill.holder_length], [mill.height]]) * axis
        housing = scene.curve(ends, mill.spindle_radius)
        plotter.add_mesh(housing, name="spindle", color=COLOURS["machine"], opacity=0.5, **kept)
