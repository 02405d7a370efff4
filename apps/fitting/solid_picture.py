"""Draw a fit as a PNG: the cloud above, the cloud with its solid below, in three views."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import cv2
import numpy as np

from ..bench.chart_style import DPI, FAINT, FOOTER, INK, MARGIN, TEXT, TITLE, WIDTH
from .flat_panels import flat_panel
from .picture_scene import PictureScene, picture_scene, residual_colours, rgb
from .solid_text import headline

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .fit_inputs import FittedCloud

    Anchor = Literal["left", "center", "right"]

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
