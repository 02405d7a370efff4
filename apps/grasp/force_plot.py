"""The timeline of a pick as SVG: its phases and the contact forces."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..bench.chart_style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE, RULE, SKY
from ..bench.chart_style import VERMILION as WRONG

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.grasping import Phase, PhaseRecord, PickReport

PHASE_COLOURS: dict[Phase, str] = {
    "observe": "#EEF0F3",
    "select": "#EEF0F3",
    "pre-grasp": "#DDE7F1",
    "approach": "#BFD6EA",
    "contact": "#FBE3B6",
    "close": "#F8CE85",
    "grip": "#F2B56B",
    "lift": "#BFE5D4",
    "check": "#9ED7BF",
    "place": "#D9D3E8",
}
"""Colours of the phases: cool for motion, warm at the object, green with the object in the hand."""

FORCE_COLOURS = (BLUE, SKY, GREEN, ORANGE, PURPLE, INK)
"""Colours of the fingers in the order of the hand, then of the palm."""

WIDTH, HEIGHT = 760.0, 236.0
"""Size of the drawing, px."""
LEFT, RIGHT, TOP, BOTTOM = 46.0, 12.0, 62.0, 34.0
"""Margins around the force plot, px: force axis, none, key and phases, time axis."""
STRIP_TOP, STRIP_HEIGHT = 26.0, 28.0
"""Position and height of the bar of phases, px."""
LETTER_WIDTH = 6.3
"""Mean width of a letter of an 11 px font, px."""
BINS = 500
"""Number of time bins. Each shows its maximum force, so that short impacts stay visible."""
MIN_FORCE_SPAN = 2.0
"""Minimum span of the force axis, N. Noise must not look like a grasp."""


def pick_timeline(pick: PickReport, fingers: Sequence[str]) -> str:
    """Draw the phases of a pick and the forces on fingers, thumb and palm.

    Parameters
    ----------
    pick
        The pick.
    fingers
        Names of the fingers in the order of the forces. The palm comes after them.

    Returns
    -------
    str
        An ``<svg>`` element.
    """
    start, end = _span(pick)
    x = _Scale(start, end, LEFT, WIDTH - RIGHT)
    highest = max(MIN_FORCE_SPAN, float(pick.forces.max(initial=0.0)))
    step = _round_step(highest / 3)
    highest = step * np.ceil(highest / step)
    y = _Scale(0.0, highest, HEIGHT - BOTTOM, TOP)
    parts = [
        f'<svg class="timeline" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" '
        f'font-family="inherit" font-size="11" aria-label="phases and contact forces">',
        *(_phase(record, x) for record in pick.phases),
        *_force_axis(y, step, highest),
        *_time_axis(x, start, end),
        *_curves(pick, x, y),
        *_key((*fingers, "palm")),
        "</svg>",
    ]
    return "".join(parts)


def force_colour(number: int, count: int) -> str:
    """Return the colour of a force by its index. The last one is the palm."""
    fingers = FORCE_COLOURS[:-1]
    return FORCE_COLOURS[-1] if number == count - 1 else fingers[number % len(fingers)]


class _Scale:
    """A linear map from values to pixels."""

    def __init__(self, low: float, high: float, first: float, last: float) -> None:
        self._low, self._first = low, first
        self._slope = (last - first) / max(high - low, 1e-9)

    def __call__(self, value: float) -> float:
        return self._first + self._slope * (value - self._low)

    def array(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._first + self._slope * (values - self._low)


def _span(pick: PickReport) -> tuple[float, float]:
    starts = [record.start for record in pick.phases] + pick.times[:1].tolist()
    ends = [record.end for record in pick.phases] + pick.times[-1:].tolist()
    return (min(starts), max(ends)) if starts else (0.0, 1.0)


def _phase(record: PhaseRecord, x: _Scale) -> str:
    left, right = x(record.start), x(record.end)
    wide = max(right - left, 1.0)
    failed = record.outcome != "done"
    colour = PHASE_COLOURS[record.phase]
    seconds = f"{record.end - record.start:.2f} s"
    tip = escape(f"{record.phase}, {seconds}: {record.outcome}")
    parts = [
        f"<g><title>{tip}</title>",
        f'<rect x="{left:.1f}" y="{TOP}" width="{wide:.1f}" height="{HEIGHT - BOTTOM - TOP}" '
        f'fill="{colour}" opacity="0.38"/>',
        f'<rect x="{left:.1f}" y="{STRIP_TOP}" width="{max(wide - 1, 1):.1f}" '
        f'height="{STRIP_HEIGHT}" rx="3" fill="{colour}"'
        + (f' stroke="{WRONG}" stroke-width="1.6"/>' if failed else "/>"),
    ]
    middle = left + wide / 2
    if len(record.phase) * LETTER_WIDTH < wide - 6:
        ink = WRONG if failed else INK
        parts.append(_text(middle, STRIP_TOP + 12, record.phase, ink, "middle", weight=600))
        parts.append(_text(middle, STRIP_TOP + 23.5, seconds, FAINT, "middle", size=9.5))
    return "".join((*parts, "</g>"))


def _force_axis(y: _Scale, step: float, highest: float) -> list[str]:
    parts = []
    for value in np.arange(0.0, highest + step / 2, step):
        height = y(float(value))
        parts.append(
            f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{height:.1f}" y2="{height:.1f}" '
            f'stroke="{GREY if value == 0 else RULE}" stroke-width="1"/>'
        )
        unit = " N" if value + step > highest + step / 2 else ""
        parts.append(_text(LEFT - 7, height + 4, f"{value:g}{unit}", FAINT, "end"))
    return parts


def _time_axis(x: _Scale, start: float, end: float) -> list[str]:
    step = _round_step((end - start) / 8)
    parts = []
    for value in np.arange(0.0, end - start + 1e-9, step):
        at = x(start + float(value))
        anchor = "start" if value == 0 else "end" if at > WIDTH - RIGHT - 14 else "middle"
        unit = " s" if value == 0 else ""
        parts.append(_text(at, HEIGHT - BOTTOM + 16, f"{value:g}{unit}", FAINT, anchor))
    return parts


def _curves(pick: PickReport, x: _Scale, y: _Scale) -> list[str]:
    if not len(pick.times):
        return []
    starts = np.unique(np.linspace(0, len(pick.times), BINS + 1).astype(int)[:-1])
    times = x.array(pick.times[starts])
    tops = y.array(np.maximum.reduceat(pick.forces, starts, axis=0))
    parts = []
    for number, curve in enumerate(tops.T):
        colour = force_colour(number, tops.shape[1])
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(times, curve, strict=True))
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{colour}" '
            'stroke-width="1.6" stroke-linejoin="round"/>'
        )
    return parts


def _key(names: tuple[str, ...]) -> list[str]:
    parts, at = [_text(LEFT, 14, "contact force", INK, "start", weight=600)], LEFT + 96.0
    for number, name in enumerate(names):
        colour = force_colour(number, len(names))
        parts.append(
            f'<line x1="{at}" x2="{at + 16}" y1="10" y2="10" stroke="{colour}" stroke-width="3" '
            'stroke-linecap="round"/>'
        )
        parts.append(_text(at + 21, 14, name, INK, "start"))
        at += 38 + LETTER_WIDTH * len(name)
    return parts


def _text(
    x: float,
    y: float,
    text: str,
    colour: str,
    anchor: str,
    *,
    size: float = 11,
    weight: int = 400,
) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" '
        f'font-size="{size:g}" font-weight="{weight}">{escape(text)}</text>'
    )


def _round_step(span: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is at least a span."""
    power = 10.0 ** np.floor(np.log10(max(span, 1e-6)))
    return float(next(power * f for f in (1, 2, 5, 10) if power * f >= span * (1 - 1e-9)))
