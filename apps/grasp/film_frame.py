"""One picture of the film: the cell, beside it what was seen and felt, below it what happens."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from .force_plot import PHASE_COLOURS, force_colour

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.grasping import Phase

PANEL_SHARE = 0.3
"""Width of the panel beside the cell over the film's: nothing is drawn over the cell itself, as
the arm may be anywhere in it."""
DRAWN_AT = 540
"""Height of a film that lengths here are told for, px; they grow with it."""
STRIP = 46
"""Height of the strip at the foot, px."""
CHIP = 116
"""Width of the phase's ground in it, px."""
GAP = 14
"""Around what stands in the panel, px."""
HEAD = 48
"""Height of the two lines over what was seen, px."""
METERS_HEAD = 36
"""Height of the line over the force meters, px."""
METER_STEP, METER_BAR = 30, 13
"""From one force meter to the next, and the height of its bar, px."""
NUMBER = 36
"""Width of the number beside a bar, px."""
METER_FULL = 30.0
"""Force at which a bar is full, N: more than a grasp takes; knocks beyond are marked."""
SIZE, SMALL, TINY = 21, 17, 15
"""Of letters, px."""
GROUND, EMPTY = (24, 27, 32), (52, 57, 64)
"""Of panel and strip; of bars and pictures with nothing in them; RGB."""
WHITE, GREY, LOUD = (240, 242, 245), (165, 172, 182), (255, 92, 70)
"""Letters; lesser ones; a bar that overflows; RGB."""


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


@dataclass(frozen=True)
class Aside:
    """What the panel shows."""

    seen: NDArray[np.uint8] | None
    """What was seen, (H, W, 3); None before the first choice."""
    names: Sequence[str]
    """Of what feels forces, in their order."""
    force: NDArray[np.float64] | None
    """On each of them, N; None where none is read."""


def stage_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height of the cell's part in a film of a size, px."""
    wide, high = size
    return wide - round(PANEL_SHARE * wide), high - _px(STRIP, high)


def film_frame(
    picture: NDArray[np.uint8], caption: Caption, aside: Aside, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Put picture, panel and strip together, (H, W, 3) uint8 RGB.

    Parameters
    ----------
    picture
        Photograph of the cell, as large as :func:`stage_size` says.
    caption, aside
        What strip and panel say.
    size
        Width and height of the film, px.
    """
    wide, high = size
    stage_wide, stage_high = stage_size(size)
    frame = np.empty((high, wide, 3), np.uint8)
    frame[:] = GROUND
    frame[:stage_high, wide - stage_wide :] = picture
    panel = np.ascontiguousarray(frame[:stage_high, : wide - stage_wide])
    below = _draw_seen(panel, aside.seen, high)
    if len(aside.names):
        _draw_meters(panel, aside, below, high)
    frame[:stage_high, : wide - stage_wide] = panel
    _draw_strip(frame, caption)
    return frame


def _draw_seen(panel: NDArray[np.uint8], seen: NDArray[np.uint8] | None, height: int) -> int:
    """Draw what was seen, at the top, and give the row under it."""
    gap, head = _px(GAP, height), _px(HEAD, height)
    _write(panel, "one depth view", (gap, gap + _px(SMALL, height)), WHITE, _px(SMALL, height))
    second = "segments, solids, grasp to come"
    _write(panel, second, (gap, head + gap // 4), GREY, _px(TINY, height))
    left, top, wide = gap, head + gap, panel.shape[1] - 2 * gap
    tall = round(0.75 * wide)
    panel[top : top + tall, left : left + wide] = EMPTY
    if seen is not None:
        share = min(wide / seen.shape[1], tall / seen.shape[0])
        across, down = round(share * seen.shape[1]), round(share * seen.shape[0])
        small = cv2.resize(seen, (across, down), interpolation=cv2.INTER_AREA)
        y, x = top + (tall - down) // 2, left + (wide - across) // 2
        panel[y : y + down, x : x + across] = small
    return top + tall


def _draw_meters(panel: NDArray[np.uint8], aside: Aside, above: int, height: int) -> None:
    """Draw a bar for each that feels a force, below a row, as far as there is room."""
    gap, tiny = _px(GAP, height), _px(TINY, height)
    head = above + _px(METERS_HEAD, height)
    _write(panel, "contact force, N", (gap, head), WHITE, _px(SMALL, height))
    room = panel.shape[0] - head - gap
    step = min(_px(METER_STEP, height), room // len(aside.names))
    bar = min(_px(METER_BAR, height), max(step - 3, 1))
    start = 2 * gap + max(_width(name, tiny) for name in aside.names)
    end = panel.shape[1] - gap - _px(NUMBER, height)
    for number, name in enumerate(aside.names):
        force = 0.0 if aside.force is None else float(aside.force[number])
        top = head + gap // 2 + step * number + (step - bar) // 2
        foot = top + bar // 2 + tiny // 3 + 1
        _write(panel, name, (gap, foot), GREY, tiny)
        cv2.rectangle(panel, (start, top), (end, top + bar), EMPTY, cv2.FILLED)
        over = force > METER_FULL
        filled = start + round((end - start) * min(force / METER_FULL, 1.0))
        if filled > start:
            colour = _rgb(_force_colour(number, len(aside.names)))
            cv2.rectangle(panel, (start, top), (filled, top + bar), colour, cv2.FILLED)
        if over:
            cv2.rectangle(panel, (end - bar // 2, top), (end, top + bar), LOUD, cv2.FILLED)
        told = f"{force:.0f}"
        at = panel.shape[1] - gap - _width(told, tiny)
        _write(panel, told, (at, foot), LOUD if over else GREY, tiny)


def _force_colour(number: int, count: int) -> str:
    """Colour of a bar: those of the report, but for its black, which is the palm's."""
    return "#E4E7EB" if number == count - 1 else force_colour(number, count)


def _draw_strip(frame: NDArray[np.uint8], caption: Caption) -> None:
    height, width = frame.shape[:2]
    strip, size, edge = _px(STRIP, height), _px(SIZE, height), _px(GAP, height)
    foot = height - strip // 2 + size // 3 + 1
    at = edge
    if caption.phase is not None:
        colour = _rgb(PHASE_COLOURS[caption.phase])
        wide, inside = _px(CHIP, height), _px(9, height)
        corners = (at, height - strip + inside), (at + wide, height - inside - 1)
        cv2.rectangle(frame, *corners, colour, cv2.FILLED)
        letters = _width(caption.phase, size)
        _write(frame, caption.phase, (at + (wide - letters) // 2, foot), GROUND, size)
        at += wide + edge
    _write(frame, caption.told, (at, foot), WHITE, size)
    right = f"{caption.count}   ×{caption.pace:g}"
    _write(frame, right, (width - edge - _width(right, size), foot), GREY, size)


def _px(length: int, height: int) -> int:
    """Give a length in a film of a height, px."""
    return max(round(length * height / DRAWN_AT), 1)


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
