"""Draw one view of a fit with matplotlib.

Hidden edges and points are faint. OpenGL would need a graphics driver and shows no more detail.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .panel_style import CURVE, CURVE_WIDTH, HIDDEN_CURVE, PANEL, POINT_SIZE, SOLID, SOLID_OPACITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .picture_scene import PictureScene, View

POINTS_PER_INCH = 72.0
MIN_BRIGHTNESS = 0.7
"""Brightness of a surface at a right angle to the viewer, relative to one that faces the viewer."""


def flat_panel(axes: Axes, scene: PictureScene, view: View, *, solid: bool, panel: float) -> None:
    """Draw one view onto axes whose unit is the metre.

    Parameters
    ----------
    axes
        Square axes with the limits ± ``half``.
    scene, view
        The scene and its view.
    solid
        Whether to draw the solids too.
    panel
        Side of the axes, inches.
    """
    side = panel * POINTS_PER_INCH
    order = np.argsort(scene.points @ view.towards)
    flat = view.flat(scene.points[order])
    behind = (scene.facing[order] @ view.towards < 0) & solid
    colours = np.column_stack([scene.colours[order], np.where(behind, 1 - SOLID_OPACITY, 1.0)])
    axes.scatter(*flat.T, s=(POINT_SIZE * side) ** 2, c=colours, linewidths=0, zorder=3)
    if not solid:
        return
    for vertices, faces in scene.surfaces:
        _surface(axes, vertices, faces, view)
    width = CURVE_WIDTH * side
    for curve, normals in zip(scene.curves, scene.normals, strict=True):
        line = view.flat(curve)
        visible = normals @ view.towards >= 0
        axes.plot(*line.T, color=HIDDEN_CURVE, linewidth=0.6 * width, zorder=2)
        front = np.where(visible[:, None], line, np.nan)
        axes.plot(*front.T, color=CURVE, linewidth=width, zorder=4, solid_capstyle="round")


def _surface(
    axes: Axes, vertices: NDArray[np.float64], faces: NDArray[np.int64], view: View
) -> None:
    from matplotlib.colors import LinearSegmentedColormap, to_rgb

    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    at_vertices = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(at_vertices, faces[:, k], normals)
    length = np.maximum(np.linalg.norm(at_vertices, axis=1), np.finfo(float).tiny)
    bright = np.clip(at_vertices @ view.towards / length, 0.0, 1.0)
    light = SOLID_OPACITY * np.array(to_rgb(SOLID)) + (1 - SOLID_OPACITY) * np.array(to_rgb(PANEL))
    shades = LinearSegmentedColormap.from_list(
        "solid", [tuple(MIN_BRIGHTNESS * light), tuple(light)]
    )
    flat = view.flat(vertices)
    # Translucent triangles would show their seams. The surface is opaque, in a mixed colour.
    axes.tripcolor(
        flat[:, 0],
        flat[:, 1],
        bright,
        triangles=faces[normals @ view.towards > 0],
        cmap=shades,
        vmin=0.0,
        vmax=1.0,
        shading="gouraud",
        zorder=1,
    )
