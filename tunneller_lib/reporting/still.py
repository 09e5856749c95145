"""A scene for one picture, by VTK alone: a `pyvista.Plotter` takes a second to load.

It has what `tunnel_scene` needs of a ``pyvista.Plotter``, by the same names, and looks like it.
"""

import os

# VTK chooses its window when it is imported.
if "DISPLAY" not in os.environ:
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - both are what draws letters and windows
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLight,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

from . import gl
from .style import error_shades, red_green_blue

# Lights as the camera sees them, x to the right and y up: one in front, two from above.
LIGHTS = [((0, 0, 1), 0.6), ((-1, 1, 1), 0.35), ((1, 0.6, 0.4), 0.2)]
AMBIENT = 0.25  # nothing is quite black
SAMPLES = 4  # of a pixel, at edges
SHARP = 30.0  # deg, from which on an edge is one
LETTERS = 18  # px, of a bar of colours


class Still:
    """An empty scene: white, in perspective, its lights moving with the camera.

    Parameters
    ----------
    width, height : int
        Of its picture, in px.

    Raises
    ------
    OSError
        If there is no off-screen GL library, without which VTK would crash.
    """

    def __init__(self, width, height):
        gl.require()
        self.title = ""
        self.named = {}
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.renderer.AutomaticLightCreationOff()
        for position, intensity in LIGHTS:
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(position)
            light.SetIntensity(intensity)
            self.renderer.AddLight(light)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetSize(width, height)
        self.window.SetMultiSamples(SAMPLES)
        self.window.AddRenderer(self.renderer)

    @property
    def camera(self):
        """Return VTK's camera."""
        return self.renderer.GetActiveCamera()

    def view_vector(self, vector, viewup):
        """Look at all that is there; a `vector` leads to the camera, `viewup` is its upper side."""
        low, high = np.reshape(self.renderer.ComputeVisiblePropBounds(), (3, 2)).T
        self.camera.SetFocalPoint((low + high) / 2)
        self.camera.SetPosition((low + high) / 2 + vector)
        self.camera.SetViewUp(viewup)
        self.renderer.ResetCamera()

    def add_mesh(
        self,
        mesh,
        *,
        name=None,
        color=None,
        opacity=1.0,
        split_sharp_edges=False,
        scalars=None,
        clim=None,
        below_color=None,
        show_scalar_bar=True,
        scalar_bar_args=None,
        **_others,
    ):
        """Add a mesh; arguments are those of ``pyvista.Plotter.add_mesh``.

        Parameters
        ----------
        mesh : vtkPolyData
            What.
        name : str, optional
            It replaces what was added by the same name before.
        color : str, optional
            As "#8FA3B5"; needed without `scalars`.
        opacity : float
            From 0 to 1.
        split_sharp_edges : bool
            Whether edges are seen, or all is round.
        scalars : str, optional
            The name of those that colour the points, by `ERROR_MAP`.
        clim : (float, float), optional
            What has the colours at its ends.
        below_color : str, optional
            Of what is below them.
        show_scalar_bar : bool
            Whether a bar explains the colours.
        scalar_bar_args : dict, optional
            How, as ``add_scalar_bar`` has them.
        **_others
            What a still picture does without, or always does.
        """
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(_with_normals(mesh, split_sharp_edges))
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetInterpolationToPhong()
        look.SetAmbient(AMBIENT)
        look.SetOpacity(opacity)
        self._put(name, actor)
        if scalars is None:
            mapper.ScalarVisibilityOff()
            look.SetColor(red_green_blue(color))
            return
        colours = _table(error_shades(), clim, below_color)
        mesh.GetPointData().SetActiveScalars(scalars)
        mapper.SetLookupTable(colours)
        mapper.SetScalarRange(clim)
        mapper.InterpolateScalarsBeforeMappingOn()
        if show_scalar_bar:
            self._put(f"bar of {name}", _bar(colours, **scalar_bar_args))

    def _put(self, name, prop):
        """Add a prop in the place of the one before that has its name, if it has any."""
        if before := self.named.get(name):
            self.renderer.RemoveViewProp(before)
        self.renderer.AddViewProp(prop)
        if name:
            self.named[name] = prop

    def screenshot(self):
        """Return the picture (n, m, 3) uint8."""
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        pixels = vtkWindowToImageFilter()
        pixels.SetInput(self.window)
        pixels.ReadFrontBufferOff()
        pixels.ShouldRerenderOff()
        pixels.Update()
        image = pixels.GetOutput()
        width, height, _ = image.GetDimensions()
        values = vtk_to_numpy(image.GetPointData().GetScalars())
        return values.reshape(height, width, 3)[::-1].copy()  # VTK begins below


def _with_normals(mesh, split_sharp_edges):
    """Return a mesh whose points have normals, those of sharp edges one for either side."""
    if not split_sharp_edges and mesh.GetPointData().GetNormals():
        return mesh
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SetSplitting(split_sharp_edges)
    normals.SetFeatureAngle(SHARP)
    normals.Update()
    return normals.GetOutput()


def _table(colours, limits, below):
    """Return VTK's table of colours (n, 3), from 0 to 1, between limits, and of what is below."""
    opaque = np.insert(255 * colours, 3, 255, axis=1)
    table = vtkLookupTable()
    table.SetTable(numpy_to_vtk(opaque.astype(np.uint8), deep=True))
    table.SetRange(limits)
    table.SetBelowRangeColor(*red_green_blue(below), 1)
    table.UseBelowRangeColorOn()
    return table


def _bar(colours, *, title, vertical, fmt, n_labels, below_label, width, height, **place):
    """Return a bar that explains colours; sizes and its place are shares of the picture's."""
    bar = vtkScalarBarActor()
    bar.SetLookupTable(colours)
    bar.SetMaximumNumberOfColors(colours.GetNumberOfTableValues())
    bar.SetOrientation(int(vertical))
    bar.SetPosition(place["position_x"], place["position_y"])
    bar.SetTitle(title)
    bar.SetLabelFormat(fmt)
    bar.SetNumberOfLabels(n_labels)
    bar.DrawBelowRangeSwatchOn()
    bar.SetBelowRangeAnnotation(below_label)
    bar.SetWidth(width)
    bar.SetHeight(height)
    bar.SetUnconstrainedFontSize(True)
    bar.SetAnnotationTextScaling(False)
    title = bar.GetTitleTextProperty()
    title.SetJustificationToCentered()
    for text in (title, bar.GetLabelTextProperty(), bar.GetAnnotationTextProperty()):
        text.SetColor(0, 0, 0)
        text.SetFontSize(LETTERS)
        text.SetFontFamilyToArial()
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    return bar
