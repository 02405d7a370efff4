"""Draw one view of a fit with OpenCV.

Hidden edges and points are faint. OpenGL would need a graphics driver and shows no more detail.
matplotlib needs 1.2 s of CPU to load and 0.4 s per picture; OpenCV is loaded and needs 0.15 s.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .panel_style import CURVE, CURVE_WIDTH, HIDDEN_CURVE, PANEL, POINT_SIZE, SOLID, SOLID_OPACITY
from .picture_scene import PictureScene, View, rgb

MIN_BRIGHTNESS = 0.7
"""Brightness of a surface at a right angle to the viewer, relative to one that faces the viewer."""
EDGE_TOLERANCE = 1e-3
"""Tolerance for rounding of a normal at a right angle to the viewer: the outline is visible."""
FINER = 2
"""Enlargement at which a panel is drawn. Its reduction smooths the edges of everything drawn."""
SUBPIXEL = 4
"""Binary digits of the fraction of a pixel in the coordinates of OpenCV."""


def flat_panel(scene: PictureScene, view: View, side: int, *, solid: bool) -> NDArray[np.uint8]:
    """Draw one view with the limits ± ``half``.

    Parameters
    ----------
    scene, view
        The scene and its view.
    side
        Side of the panel, pixels.
    solid
        Whether to draw the solids too.

    Returns
    -------
    NDArray[np.uint8]
        RGB picture (side, side, 3).
    """
    large = FINER * side
    canvas = np.empty((large, large, 3), np.uint8)
    canvas[:] = rgb(PANEL)
    width = max(round(CURVE_WIDTH * large), 1)
    if solid:
        _draw_surfaces(canvas, scene, view)
        for curve in scene.curves:
            line = _pixels(canvas, scene, view, curve)
            _draw_line(canvas, line, HIDDEN_CURVE, max(round(0.6 * width), 1))
    _draw_points(canvas, scene, view, solid=solid)
    if solid:
        for curve, normals in zip(scene.curves, scene.normals, strict=True):
            line = _pixels(canvas, scene, view, curve)
            visible = normals @ view.towards >= -EDGE_TOLERANCE
            for run in np.split(np.arange(len(line)), np.flatnonzero(np.diff(visible)) + 1):
                if visible[run[0]] and len(run) > 1:
                    _draw_line(canvas, line[run], CURVE, width)
    small = cv2.resize(canvas, (side, side), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _pixels(
    canvas: NDArray[np.uint8], scene: PictureScene, view: View, points: NDArray[np.float64]
) -> NDArray[np.int32]:
    """Project points (..., 3) to pixels (..., 2) in fixed point with SUBPIXEL binary digits."""
    flat = view.flat(points) / scene.half
    # A stray point far outside would overflow. It stays outside.
    flat = np.clip(flat, -4.0, 4.0) * [1.0, -1.0]
    pixels = (flat + 1.0) * 0.5 * len(canvas) - 0.5
    return np.round(pixels * (1 << SUBPIXEL)).astype(np.int32)


def _draw_points(
    canvas: NDArray[np.uint8], scene: PictureScene, view: View, *, solid: bool
) -> None:
    """Draw the points as discs, far ones first; those behind a solid are faint."""
    order = np.argsort(scene.points @ view.towards)
    colours = 255.0 * scene.colours[order]
    if solid:
        behind = scene.facing[order] @ view.towards < 0
        colours[behind] += SOLID_OPACITY * (_light() - colours[behind])
    centres = _pixels(canvas, scene, view, scene.points[order]).tolist()
    radius = round(0.5 * POINT_SIZE * len(canvas) * (1 << SUBPIXEL))
    for centre, colour in zip(centres, colours.tolist(), strict=True):
        cv2.circle(canvas, centre, radius, colour, cv2.FILLED, cv2.LINE_8, SUBPIXEL)


def _draw_line(
    canvas: NDArray[np.uint8], pixels: NDArray[np.int32], colour: str, width: int
) -> None:
    cv2.polylines(canvas, [pixels], False, rgb(colour), width, cv2.LINE_8, SUBPIXEL)


def _draw_surfaces(canvas: NDArray[np.uint8], scene: PictureScene, view: View) -> None:
    """Draw the faces of all solids that face the viewer, far ones first.

    Translucent triangles would show their seams. The surface is opaque, in a mixed colour.
    """
    if not scene.surfaces:
        return
    corners = np.concatenate([vertices[faces] for vertices, faces in scene.surfaces])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    bright = normals @ view.towards
    bright /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    front = np.flatnonzero(bright > 0)
    front = front[np.argsort(corners[front].mean(axis=1) @ view.towards, kind="stable")]
    shades = (MIN_BRIGHTNESS + (1 - MIN_BRIGHTNESS) * bright[front, None]) * _light()
    triangles = _pixels(canvas, scene, view, corners[front])
    for triangle, shade in zip(triangles, shades.tolist(), strict=True):
        cv2.fillConvexPoly(canvas, triangle, shade, cv2.LINE_8, SUBPIXEL)


def _light() -> NDArray[np.float64]:
    """Return the colour (3,), 0 to 255, of a surface that faces the viewer."""
    return SOLID_OPACITY * np.array(rgb(SOLID)) + (1 - SOLID_OPACITY) * np.array(rgb(PANEL))
