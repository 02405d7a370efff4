"""Panels of a fit's picture drawn by VTK off-screen, and whether that works here."""

from __future__ import annotations

import functools
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from ..evaluation.chart_style import INK
from .panel_look import CURVE_WIDTH, PANEL, POINT_SIZE, SOLID, SOLID_OPACITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .picture_scene import PictureScene

PANEL_PIXELS = 720
"""Side of a panel: half as much again as in the finished picture, which smooths it."""
PROBE_TIMEOUT_S = 30.0
_PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
raise SystemExit(0 if window.SupportsOpenGL() else 3)
"""


@functools.cache
def gl_works() -> bool:
    """Whether VTK can draw off-screen.

    Where no driver is, VTK does not fail but crashes: so a child process tries first (half a
    second). The answer holds for the life of this process.
    """
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE],
            capture_output=True,
            timeout=PROBE_TIMEOUT_S,
            check=False,
        )
    except (subprocess.TimeoutExpired, OSError):
        return False
    return probe.returncode == 0


def gl_panels(scene: PictureScene) -> list[list[NDArray[np.uint8]]]:
    """Draw the cloud, then the cloud in its solid, each from every view.

    Returns
    -------
    list
        Rows of pictures (PANEL_PIXELS, PANEL_PIXELS, 3) uint8 RGB, each 2 ``half`` across.
    """
    import pyvista

    _quiet()
    side = PANEL_PIXELS
    # Typed as Any: pyvista's delegating decorators hide their methods' signatures.
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=[side, side], lighting="none")
    try:
        plotter.set_background(PANEL)
        plotter.enable_parallel_projection()
        plotter.add_light(pyvista.Light(light_type="headlight", intensity=0.85))
        cloud = pyvista.PolyData(scene.points)
        cloud["rgb"] = np.round(255 * scene.colours).astype(np.uint8)
        # Lit spheres would shade the colours that tell the distance.
        plotter.add_points(
            cloud,
            scalars="rgb",
            rgb=True,
            point_size=POINT_SIZE * side,
            render_points_as_spheres=True,
            lighting=False,
        )
        rows = [_from_all_sides(plotter, scene)]
        if scene.surfaces:
            for vertices, faces in scene.surfaces:
                plotter.add_mesh(
                    pyvista.PolyData.from_regular_faces(vertices, faces),
                    color=SOLID,
                    opacity=SOLID_OPACITY,
                    # The side away from the viewer adds nothing, and unsorted it would flicker.
                    culling="back",
                    smooth_shading=True,
                    split_sharp_edges=True,
                    ambient=0.35,
                    diffuse=0.75,
                    specular=0.15,
                )
            for curve in scene.curves:
                plotter.add_mesh(
                    pyvista.lines_from_points(curve),
                    color=INK,
                    line_width=CURVE_WIDTH * side,
                    lighting=False,
                )
            rows.append(_from_all_sides(plotter, scene))
        return rows
    finally:
        plotter.close()


def _from_all_sides(plotter: Any, scene: PictureScene) -> list[NDArray[np.uint8]]:
    pictures = []
    for view in scene.views:
        distance = 4.0 * scene.half
        plotter.camera_position = [view.towards * distance, (0.0, 0.0, 0.0), view.up]
        plotter.camera.parallel_scale = scene.half
        plotter.camera.clipping_range = (0.01 * distance, 2.0 * distance)
        plotter.render()
        picture = plotter.screenshot(return_img=True)
        pictures.append(np.array(picture))
    return pictures


def _quiet() -> None:
    """Keep VTK from telling the terminal that it found no display, which nobody needs here."""
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
