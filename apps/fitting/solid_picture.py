"""Draw a fit as a PNG with OpenCV: the cloud above, the cloud with its solid below, in three views.

Hidden edges and points are faint. OpenGL would need a graphics driver and shows no more detail.
matplotlib needs 1.2 s of CPU to load and 0.4 s per picture; OpenCV is loaded and needs 0.15 s.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from ..bench.chart_style import DPI, FAINT, FOOTER, INK, MARGIN, TEXT, TITLE, WIDTH
from .panel_style import CURVE, CURVE_WIDTH, HIDDEN_CURVE, PANEL, POINT_SIZE, SOLID, SOLID_OPACITY
from .picture_scene import PictureScene, View, picture_scene, residual_colours, rgb
from .solid_text import headline

if TYPE_CHECKING:
    Anchor = Literal["left", "center", "right"]
    from numpy.typing import NDArray

    from .fit_inputs import FittedCloud


NAMES, GAP, HEAD, FOOT = 0.34, 0.1, 0.78, 0.62
"""Space for row names, between panels, for the title and for the colour bar, inches."""
BAR_WIDTH, BAR_HEIGHT, BAR_TOP = 2.3, 0.11, 0.47
"""Size of the colour bar, and the distance of its top from the lower edge, inches."""
SCALE_SHARE = 0.3
"""Maximum length of the scale bar, relative to a panel. It has the longest round length."""
ROUND_LENGTHS_MM = tuple(step * 10**power for power in range(5) for step in (1, 2, 5))
BOLD, NORMAL = 600, 400
"""Weights of the font."""
POINTS_PER_INCH = 72.0
PNG_COMPRESSION = 1
"""Level 6 takes twice as long and saves a twentieth of the file."""


def fit_picture(fitted: FittedCloud) -> bytes:
    """Draw a fit as a PNG.

    Parameters
    ----------
    fitted
        Cloud and solid. Without a solid the cloud alone is drawn, with the reason in the title.
    """
    scene = picture_scene(fitted)
    names = ("points", "solid") if scene.surfaces else ("points",)
    panel = (WIDTH - 2 * MARGIN - NAMES - 2 * GAP) / 3
    height = HEAD + MARGIN + len(names) * panel + (len(names) - 1) * GAP + FOOT
    canvas = np.full((_px(height), _px(WIDTH), 3), 255, np.uint8)
    for row, name in enumerate(names):
        top = HEAD + MARGIN + row * (panel + GAP)
        for column, view in enumerate(scene.views):
            left = MARGIN + NAMES + column * (panel + GAP)
            drawn = flat_panel(scene, view, _px(panel), solid=row == 1)
            _paste(canvas, drawn, left, top)
            if row == 0:
                _write(canvas, left + panel / 2, top - 0.06, view.name, at="center")
        _write_upwards(canvas, MARGIN + NAMES - 0.03 * panel, top + panel / 2, name)
    title, below = headline(fitted.fit)
    _write(canvas, MARGIN, MARGIN + 0.14, title, size=TITLE, colour=INK, weight=BOLD)
    _write(canvas, MARGIN, MARGIN + 0.37, below)
    _write(canvas, MARGIN, height - 0.18, fitted.cloud.name, size=FOOTER)
    if scene.surfaces:
        _draw_colour_bar(canvas, scene, height)
    _draw_scale_bar(canvas, scene, panel, height)
    options = [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION]
    _, encoded = cv2.imencode(".png", canvas[..., ::-1], options)
    return encoded.tobytes()


def _px(inches: float) -> int:
    return round(inches * DPI)


def _paste(canvas: NDArray[np.uint8], picture: NDArray[np.uint8], left: float, top: float) -> None:
    """Copy a picture to a place in inches. What lies outside the canvas is cut off."""
    row, column = max(_px(top), 0), max(_px(left), 0)
    place = canvas[row : row + len(picture), column : column + picture.shape[1]]
    place[:] = picture[: len(place), : place.shape[1]]


def _write(
    canvas: NDArray[np.uint8],
    x: float,
    y: float,
    text: str,
    *,
    size: float = TEXT,
    colour: str = FAINT,
    weight: int = NORMAL,
    at: Anchor = "left",
) -> None:
    """Write text of a size in points with its base line at a height in inches."""
    font = cv2.FontFace("sans")
    pixels = round(size * DPI / POINTS_PER_INCH)
    shift = {"left": 0.0, "center": 0.5, "right": 1.0}[at]
    _, _, width, _ = cv2.getTextSize((1, 1), text, (0, 0), font, pixels, weight)
    place = (round(_px(x) - shift * width), _px(y))
    cv2.putText(canvas, text, place, rgb(colour), font, pixels, weight)


def _write_upwards(canvas: NDArray[np.uint8], right: float, middle: float, text: str) -> None:
    """Write text from bottom to top, left of a place in inches and centred on it."""
    strip = np.full((_px(0.2), _px(1.0), 3), 255, np.uint8)
    _write(strip, 0.5, 0.15, text, at="center")
    _paste(canvas, np.rot90(strip), right - 0.2, middle - 0.5)


def _draw_colour_bar(canvas: NDArray[np.uint8], scene: PictureScene, height: float) -> None:
    limit = scene.limit_mm
    left, top = WIDTH - MARGIN - BAR_WIDTH, height - BAR_TOP
    colours = residual_colours(np.linspace(-1e-3, 1e-3, _px(BAR_WIDTH)) * limit, limit)
    bar = np.round(255 * colours).astype(np.uint8)
    _paste(canvas, np.broadcast_to(bar, (_px(BAR_HEIGHT), *bar.shape)), left, top)
    base, size = top + BAR_HEIGHT + 0.13, FOOTER + 0.5
    _write(canvas, left, base, f"{-limit:g}", size=size, colour=INK)
    _write(canvas, left + BAR_WIDTH / 2, base, "0", size=size, colour=INK, at="center")
    _write(canvas, left + BAR_WIDTH, base, f"{limit:g} mm", size=size, colour=INK, at="right")
    text = "inside / outside the solid"
    _write(canvas, left - 0.1, top + BAR_HEIGHT - 0.02, text, size=size, at="right")


def _draw_scale_bar(
    canvas: NDArray[np.uint8], scene: PictureScene, panel: float, height: float
) -> None:
    """Draw a round length under the first panel, at the scale of the panels."""
    per_mm = panel / (2e3 * scene.half)
    length = max((mm for mm in ROUND_LENGTHS_MM if mm * per_mm <= SCALE_SHARE * panel), default=0)
    if not length:
        return
    left, top = MARGIN + NAMES, height - FOOT + 0.05
    bar = np.empty((_px(0.03), _px(length * per_mm), 3), np.uint8)
    bar[:] = rgb(INK)
    _paste(canvas, bar, left, top)
    text = f"{length:g} mm"
    _write(canvas, left + length * per_mm + 0.06, top + 0.05, text, size=FOOTER + 0.5, colour=INK)


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
