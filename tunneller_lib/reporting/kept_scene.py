"""Scenes kept for the web pages, packed so that they travel."""

import os
from pathlib import Path

import numpy as np
from IPython import get_ipython


def keep(plotter):
    """Keep a scene for the web pages, where ``TUNNELLER_SCENES`` names a folder.

    Parameters
    ----------
    plotter : pyvista.Plotter
        The scene; it is named by the notebook's cell that is running.
    """
    if folder := os.environ.get("TUNNELLER_SCENES"):
        for actor in plotter.actors.values():
            if hasattr(getattr(actor, "mapper", None), "dataset"):  # texts and bars have no mesh
                actor.mapper.dataset = light(actor.mapper.dataset)
        cell = get_ipython().execution_count
        before = sum(1 for _ in Path(folder).glob(f"{cell:02}-*"))
        Path(folder).mkdir(parents=True, exist_ok=True)
        plotter.trame.export_vtksz(Path(folder, f"{cell:02}-{before}.vtksz"))


def light(mesh):
    """Return a mesh that packs well: single precision, without the bits that no screen shows."""
    if not mesh.length:
        return mesh
    packed = mesh.copy()
    step = 2.0 ** (np.ceil(np.log2(mesh.length)) - 13)
    packed.points = (np.round(mesh.points / step) * step).astype(np.float32)
    if "Normals" in mesh.point_data:
        normals = np.round(mesh.point_data["Normals"] * 64) / 64
        packed.point_data["Normals"] = normals.astype(np.float32)
    return packed
