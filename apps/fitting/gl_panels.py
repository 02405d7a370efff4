"""Panels of a fit's picture drawn by VTK off-screen; run it in a child (see gl_child.py)."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from .panel_look import CURVE, CURVE_WIDTH, PANEL, POINT_SIZE, SOLID, SOLID_OPACITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .picture_parts import PictureScene

PANEL_PIXELS = 640
"""Side of a panel: a third more than in the finished picture, which smooths it."""


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
                    color=CURVE,
                    line_width=CURVE_WIDTH * side,
                    lighting=False,
                )
            rows.append(_from_all_sides(plotter, scene))
        return rows
    finally:
        plotter.close()


def serve() -> None:
    """Draw the scenes that come pickled on stdin to stdout, until there are no more."""
    # Ctrl-C is for the parent, which then ends this process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    # Whatever a library prints must not get among the pictures.
    os.dup2(2, 1)
    while True:
        try:
            scene = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(gl_panels(scene), answers)
        answers.flush()


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
