"""One frame of the film: the cell, a side panel with scene and forces, and a caption strip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from ..fitting.picture_scene import rgb
from .force_plot import PHASE_COLOURS, force_colour

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.grasping import Phase

PANEL_SHARE = 0.3
"""Width of the side panel over the width of the film. Nothing is drawn over the cell, because the
arm can be anywhere in it."""
REFERENCE_HEIGHT = 540
"""Film height to which the lengths below apply, px. They scale with the height."""
STRIP = 46
"""Height of the caption strip, px."""
PHASE_LABEL = 116
"""Width of the label of the phase in the strip, px."""
GAP = 14
"""Margin around the items of the panel, px."""
HEAD = 48
"""Height of the two text lines above the scene, px."""
METERS_HEAD = 36
"""Height of the text line above the force meters, px."""
METER_STEP, METER_BAR = 30, 13
"""Distance between force meters, and the height of a bar, px."""
METER_NUMBER = 36
"""Width of the number beside a bar, px."""
METER_MAX = 30.0
"""Force of a full bar, N, more than a grasp needs. Larger forces are marked."""
LARGE, SMALL, TINY = 21, 17, 15
"""Text heights, px."""
BACKGROUND, EMPTY = (24, 27, 32), (52, 57, 64)
"""Colours of panel and strip, and of empty bars and pictures, RGB."""
WHITE, GREY, RED = (240, 242, 245), (165, 172, 182), (255, 92, 70)
"""Colours of the text, of secondary text, and of a force beyond the bar, RGB."""


@dataclass(frozen=True)
class Caption:
    """The texts of the caption strip."""

    phase: Phase | None
    """Current phase; None between picks."""
    text: str
    """Pick, object and grasp."""
    count: str
    """Number of objects in the tray, as text."""
    speed: float
    """Playback speed, times real time."""


@dataclass(frozen=True)
class SidePanel:
    """The content of the side panel."""

    scene_picture: NDArray[np.uint8] | None
    """Picture of the perceived scene, (H, W, 3); None before the first selection."""
    names: Sequence[str]
    """Names of the force sensors, in their order."""
    force: NDArray[np.float64] | None
    """Force on each sensor, N; None if not measured."""


def cell_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of the image of the cell in a film of a given size, px."""
    wide, high = size
    return wide - round(PANEL_SHARE * wide), high - _px(STRIP, high)


def film_frame(
    picture: NDArray[np.uint8], caption: Caption, side: SidePanel, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Compose the image of the cell, the panel and the strip, (H, W, 3) uint8 RGB.

    Parameters
    ----------
    picture
        Image of the cell, in the size of :func:`cell_size`.
    caption, side
        Content of strip and panel.
    size
        Width and height of the film, px.
    """
    wide, high = size
    cell_wide, cell_high = cell_size(size)
    frame = np.empty((high, wide, 3), np.uint8)
    frame[:] = BACKGROUND
    frame[:cell_high, wide - cell_wide :] = picture
    panel = np.ascontiguousarray(frame[:cell_high, : wide - cell_wide])
    below = _draw_scene(panel, side.scene_picture, high)
    if len(side.names):
        _draw_meters(panel, side, below, high)
    frame[:cell_high, : wide - cell_wide] = panel
    _draw_strip(frame, caption)
    return frame


def _draw_scene(panel: NDArray[np.uint8], picture: NDArray[np.uint8] | None, height: int) -> int:
    """Draw the picture of the scene at the top, and return the row below it."""
    gap, head = _px(GAP, height), _px(HEAD, height)
    _write(panel, "one depth view", (gap, gap + _px(SMALL, height)), WHITE, _px(SMALL, height))
    second = "segments, solids, selected grasp"
    _write(panel, second, (gap, head + gap // 4), GREY, _px(TINY, height))
    left, top, wide = gap, head + gap, panel.shape[1] - 2 * gap
    tall = round(0.75 * wide)
    panel[top : top + tall, left : left + wide] = EMPTY
    if picture is not None:
        share = min(wide / picture.shape[1], tall / picture.shape[0])
        across, down = round(share * picture.shape[1]), round(share * picture.shape[0])
        small = cv2.resize(picture, (across, down), interpolation=cv2.INTER_AREA)
        y, x = top + (tall - down) // 2, left + (wide - across) // 2
        panel[y : y + down, x : x + across] = small
    return top + tall


def _draw_meters(panel: NDArray[np.uint8], side: SidePanel, above: int, height: int) -> None:
    """Draw a bar for each force sensor below a row. The bars shrink to fit."""
    gap, tiny = _px(GAP, height), _px(TINY, height)
    head = above + _px(METERS_HEAD, height)
    _write(panel, "contact force, N", (gap, head), WHITE, _px(SMALL, height))
    available = panel.shape[0] - head - gap
    step = min(_px(METER_STEP, height), available // len(side.names))
    bar = min(_px(METER_BAR, height), max(step - 3, 1))
    start = 2 * gap + max(_width(name, tiny) for name in side.names)
    end = panel.shape[1] - gap - _px(METER_NUMBER, height)
    for number, name in enumerate(side.names):
        force = 0.0 if side.force is None else float(side.force[number])
        top = head + gap // 2 + step * number + (step - bar) // 2
        foot = top + bar // 2 + tiny // 3 + 1
        _write(panel, name, (gap, foot), GREY, tiny)
        cv2.rectangle(panel, (start, top), (end, top + bar), EMPTY, cv2.FILLED)
        over = force > METER_MAX
        filled = start + round((end - start) * min(force / METER_MAX, 1.0))
        if filled > start:
            colour = rgb(_force_colour(number, len(side.names)))
            cv2.rectangle(panel, (start, top), (filled, top + bar), colour, cv2.FILLED)
        if over:
            cv2.rectangle(panel, (end - bar // 2, top), (end, top + bar), RED, cv2.FILLED)
        number_text = f"{force:.0f}"
        at = panel.shape[1] - gap - _width(number_text, tiny)
        _write(panel, number_text, (at, foot), RED if over else GREY, tiny)


def _force_colour(number: int, count: int) -> str:
    """Return the colour of a bar: as in the report, but light for the palm."""
    return "#E4E7EB" if number == count - 1 else force_colour(number, count)


def _draw_strip(frame: NDArray[np.uint8], caption: Caption) -> None:
    height, width = frame.shape[:2]
    strip, size, edge = _px(STRIP, height), _px(LARGE, height), _px(GAP, height)
    foot = height - strip // 2 + size // 3 + 1
    at = edge
    if caption.phase is not None:
        colour = rgb(PHASE_COLOURS[caption.phase])
        wide, inside = _px(PHASE_LABEL, height), _px(9, height)
        corners = (at, height - strip + inside), (at + wide, height - inside - 1)
        cv2.rectangle(frame, *corners, colour, cv2.FILLED)
        letters = _width(caption.phase, size)
        _write(frame, caption.phase, (at + (wide - letters) // 2, foot), BACKGROUND, size)
        at += wide + edge
    _write(frame, caption.text, (at, foot), WHITE, size)
    right = f"{caption.count}   ×{caption.speed:g}"
    _write(frame, right, (width - edge - _width(right, size), foot), GREY, size)


def _px(length: int, height: int) -> int:
    """Scale a length to the height of the film, px."""
    return max(round(length * height / REFERENCE_HEIGHT), 1)


def _write(
    frame: NDArray[np.uint8],
    text: str,
    at: tuple[int, int],
    colour: tuple[int, int, int],
    size: int,
) -> None:
    cv2.putText(frame, text, at, colour, cv2.FontFace("sans"), size)


def _width(text: str, size: int) -> int:
    _, _, wide, _ = cv2.getTextSize((1, 1), text, (0, 0), cv2.FontFace("sans"), size)
    return int(wide)
