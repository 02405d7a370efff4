"""One picture of the film: the cell, a strip that says what happens, and what was seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from .force_plot import FORCE_COLOURS, PHASE_COLOURS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping.report import Phase

STRIP = 46
"""Height of the strip at the foot, px."""
STRIP_COLOUR, STRIP_COVER = (24, 27, 32), 0.86
"""Its colour, RGB, and how much of the picture it hides."""
WHITE, GREY = (240, 242, 245), (165, 172, 182)
INSET_SHARE = 0.28
"""Width of the inset over the picture's."""
INSET_GAP = 14
"""From the picture's corner to the inset, px."""
METER_WIDTH, METER_BAR = 168, 9
"""Of the force meters and of each of their bars, px."""
METER_FULL = 15.0
"""Force at which a bar is full, N."""
SIZE, SMALL = 19, 14
"""Of letters, px."""


@dataclass(frozen=True)
class Caption:
    """What the strip says."""

    phase: Phase | None
    """Phase under way; None between picks."""
    told: str
    """Which pick, object and grasp."""
    count: str
    """How many are in the tray."""
    pace: float
    """Times real time."""


def film_frame(
    picture: NDArray[np.uint8],
    caption: Caption,
    inset: NDArray[np.uint8] | None,
    force: NDArray[np.float64] | None,
) -> NDArray[np.uint8]:
    """Put strip, inset and force meters into a picture (H, W, 3), and return it.

    Parameters
    ----------
    picture
        Photograph of the cell; a copy is drawn on.
    caption
        What the strip says.
    inset
        What was seen, from :func:`inset_of`; none while nothing is.
    force
        On fingers, thumb and palm, N; not shown where None.
    """
    frame = np.ascontiguousarray(picture).copy()
    if inset is not None:
        high, wide = inset.shape[:2]
        frame[INSET_GAP : INSET_GAP + high, INSET_GAP : INSET_GAP + wide] = inset
    _draw_strip(frame, caption)
    if force is not None:
        below = INSET_GAP if inset is None else 2 * INSET_GAP + inset.shape[0]
        _draw_meters(frame, force, below)
    return frame


def inset_of(picture: NDArray[np.uint8], frame_width: int, title: str) -> NDArray[np.uint8]:
    """Shrink a picture of what was seen to an inset with its title and a light border."""
    wide = round(INSET_SHARE * frame_width)
    high = round(wide * picture.shape[0] / picture.shape[1])
    inset = np.asarray(cv2.resize(picture, (wide, high), interpolation=cv2.INTER_AREA))
    inset = np.ascontiguousarray(inset, dtype=np.uint8)
    _blend(inset[: SMALL + 12])
    _write(inset, title, (9, SMALL + 4), WHITE, SMALL)
    cv2.rectangle(inset, (0, 0), (wide - 1, high - 1), GREY, 1)
    return inset


def _draw_strip(frame: NDArray[np.uint8], caption: Caption) -> None:
    height, width = frame.shape[:2]
    _blend(frame[height - STRIP :])
    foot = height - STRIP // 2 + SIZE // 3 + 1
    at = 18
    if caption.phase is not None:
        colour = _rgb(PHASE_COLOURS[caption.phase])
        cv2.rectangle(frame, (at, height - STRIP + 10), (at + 104, height - 11), colour, cv2.FILLED)
        letters = _width(caption.phase, SIZE)
        _write(frame, caption.phase, (at + 52 - letters // 2, foot), STRIP_COLOUR, SIZE)
        at += 122
    _write(frame, caption.told, (at, foot), WHITE, SIZE)
    right = f"{caption.count}   ×{caption.pace:g}"
    _write(frame, right, (width - 18 - _width(right, SIZE), foot), GREY, SIZE)


def _draw_meters(frame: NDArray[np.uint8], force: NDArray[np.float64], top: int) -> None:
    """Draw a bar per finger and the palm at the left, from a row downwards."""
    left, right = INSET_GAP, INSET_GAP + METER_WIDTH
    names = [f"finger {k + 1}" for k in range(len(force) - 2)] + ["thumb", "palm"]
    step = METER_BAR + 10
    _blend(frame[top : top + 30 + step * len(force), left:right])
    _write(frame, f"force, 0 to {METER_FULL:g} N", (left + 9, top + SMALL + 4), WHITE, SMALL)
    for number, (name, value) in enumerate(zip(names, force, strict=True)):
        y = top + 30 + step * number
        _write(frame, name, (left + 9, y + METER_BAR), GREY, SMALL - 2)
        start, end = left + 66, right - 9
        filled = start + round((end - start) * min(float(value) / METER_FULL, 1.0))
        colour = FORCE_COLOURS[number] if number < len(force) - 1 else "#E4E7EB"
        cv2.rectangle(frame, (start, y), (end, y + METER_BAR), (70, 75, 82), cv2.FILLED)
        if filled > start:
            cv2.rectangle(frame, (start, y), (filled, y + METER_BAR), _rgb(colour), cv2.FILLED)


def _blend(region: NDArray[np.uint8]) -> None:
    """Darken a part of a picture, so that light letters show on it."""
    dark = np.array(STRIP_COLOUR, dtype=np.float32)
    region[:] = ((1 - STRIP_COVER) * region + STRIP_COVER * dark).astype(np.uint8)


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


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue
