"""The chart of a stage: accuracy against time, the Pareto front, the default, baselines in grey."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import dist, log
from typing import TYPE_CHECKING, Any

from .chart_labels import PointLabel, label_points
from .chart_style import (
    BLUE,
    FAINT,
    FOOT,
    GREY,
    HEADER,
    INK,
    LEFT,
    LINE,
    MARGIN,
    SKY,
    TEXT,
    VERMILION,
    WIDTH,
    Provenance,
    add_footer,
    format_time,
    label_axes,
    new_chart,
    set_percent_axis,
    set_time_axis,
)
from .pareto import thin_front

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BASELINE_MARKERS = ("o", "s", "D", "^", "v", "p", "h", "<", ">")
HEIGHT = 5.2
"""Of the figure without its key, inches."""
NAMED_GAIN = 0.03
"""Least share by which the error shrinks at a named point: less is chance."""
NUMBER_SIZE = 0.17
"""Least distance between two numbers, inches."""
MOST_NAMES = 8
"""Of the front, so many points are named at most: those with the largest gains."""
FEW_POINTS = 4
"""So few settings are all named, those behind the front too: there is room, and each was asked
for."""
BESIDE_PT = (11.0, -10.0)
"""A number whose point lies under another is written so far right of it and below, clear of the
front's line, points."""
KEY_LINE, KEY_INDENT = 0.21, 0.2
"""Height of a line of the key and width of its number, inches."""
KEY_FOOT, KEY_GAP = 0.52, 0.12
"""Height of the footer under the key, and free space above the key, inches."""
WORST_SHOWN_PCT = 40.0
"""Worse points would press all others together, where nothing else is asked for."""
BEST_SHOWN_PCT = 99.9
"""A stretched axis has no 100 %: better points are drawn here."""


@dataclass(frozen=True)
class ChartPoint:
    """One setting, measured."""

    name: str
    """In words."""
    time_ms: float
    """Median time, ms."""
    accuracy_pct: float
    """Per cent."""
    told_pct: float | None = None
    """What is written where that is not what is drawn, per cent."""

    @property
    def written_pct(self) -> float:
        """Accuracy as text tells it, per cent."""
        return self.accuracy_pct if self.told_pct is None else self.told_pct


@dataclass(frozen=True)
class BaselineCurve:
    """A baseline, along its dial."""

    name: str
    points: tuple[ChartPoint, ...]


def pareto_chart(
    title: str,
    subtitle: str,
    own: Sequence[ChartPoint],
    front: Sequence[int],
    default: int,
    baselines: Sequence[BaselineCurve],
    accuracy: str,
    made: Provenance,
    *,
    worst_shown_pct: float = WORST_SHOWN_PCT,
    best_shown_pct: float = BEST_SHOWN_PCT,
) -> Figure:
    """Draw accuracy against time: own settings, their front, the default, and baselines.

    Parameters
    ----------
    title, subtitle
        See `new_chart`.
    own
        All own settings.
    front
        Which of them are the Pareto front, by rising time.
    default
        Which of them users get.
    baselines
        Curves of others, in grey.
    accuracy
        Name of the accuracy, for the axis.
    made
        For the footer; the time is that of one of its cases.
    worst_shown_pct
        Baselines' points that are worse are left out, for they would press all others together.
    best_shown_pct
        Where better points are drawn; text tells what they are.
    """
    own = [_drawable(point, best_shown_pct) for point in own]
    star = own[default]
    shown = [_shown(curve, worst_shown_pct, best_shown_pct) for curve in baselines]
    every = [*own, *(point for curve in shown for point in curve.points)]
    view = _view(every, worst_shown_pct)
    if len(own) <= FEW_POINTS:
        named = [point for index, point in enumerate(own) if index != default]
    else:
        named = _worth_naming(own, front, star, view)
    below = KEY_LINE * _key_lines(len(named)) + KEY_GAP
    figure, (axes,) = new_chart(title, subtitle, height=HEIGHT + below, below=below)
    set_time_axis(axes, *view.times_ms)
    set_percent_axis(axes, *view.shares_pct, stretched=True, capped=_capped(every, best_shown_pct))
    label_axes(
        axes,
        f"time per {made.each}, median (logarithmic)",
        f"{accuracy} (logarithmic in error)",
    )
    steps = _steps([own[index] for index in front], view.times_ms[1])
    for curve, mark in zip(shown, BASELINE_MARKERS * len(shown), strict=False):
        _draw_baseline(axes, curve, mark)
    axes.plot(
        [point.time_ms for point in own],
        [point.accuracy_pct for point in own],
        "o",
        color=SKY,
        markersize=4.0,
        markeredgewidth=0,
        alpha=0.75,
        zorder=2.5,
    )
    axes.plot(*zip(*steps, strict=True), color=BLUE, linewidth=LINE, zorder=3)
    axes.plot(
        [own[index].time_ms for index in front],
        [own[index].accuracy_pct for index in front],
        "o",
        color=BLUE,
        markersize=6.5,
        markeredgecolor="white",
        markeredgewidth=1.0,
        zorder=4,
    )
    _number(axes, named, [own[index] for index in front], star, view)
    _write_key(figure, named)
    axes.plot(
        star.time_ms,
        star.accuracy_pct,
        "*",
        color=VERMILION,
        markersize=17,
        markeredgecolor="white",
        markeredgewidth=1.2,
        zorder=5,
    )
    _name(axes, own, star, shown, steps)
    add_footer(figure, made)
    return figure


def _shown(curve: BaselineCurve, worst_shown_pct: float, best_shown_pct: float) -> BaselineCurve:
    points = [
        _drawable(point, best_shown_pct)
        for point in curve.points
        if point.accuracy_pct >= worst_shown_pct
    ]
    return BaselineCurve(curve.name, tuple(points))


def _drawable(point: ChartPoint, best_shown_pct: float) -> ChartPoint:
    """Move a perfect point onto the axis."""
    if point.accuracy_pct <= best_shown_pct:
        return point
    return replace(point, accuracy_pct=best_shown_pct, told_pct=point.accuracy_pct)


def _capped(points: Sequence[ChartPoint], best_shown_pct: float) -> tuple[float, str] | None:
    """Where points were moved to, and what that level is called."""
    moved = [point.told_pct for point in points if point.told_pct is not None]
    if not moved:
        return None
    return best_shown_pct, "100 %" if min(
        moved
    ) == 100.0 else f"\N{GREATER-THAN OR EQUAL TO} {best_shown_pct:g} %"


def _steps(front: Sequence[ChartPoint], end_ms: float) -> list[tuple[float, float]]:
    """Corners of the best accuracy that each time buys."""
    corners: list[tuple[float, float]] = []
    for point in front:
        if corners:
            corners.append((point.time_ms, corners[-1][1]))
        corners.append((point.time_ms, point.accuracy_pct))
    corners.append((end_ms, corners[-1][1]))
    return corners


def _draw_baseline(axes: Axes, curve: BaselineCurve, mark: str) -> None:
    axes.plot(
        [point.time_ms for point in curve.points],
        [point.accuracy_pct for point in curve.points],
        marker=mark,
        color=GREY,
        linewidth=1.1,
        markersize=5.0,
        markeredgecolor="white",
        markeredgewidth=0.7,
        zorder=2,
    )


@dataclass(frozen=True)
class _View:
    """What the axes show."""

    times_ms: tuple[float, float]
    shares_pct: tuple[float, float]

    def place(self, point: ChartPoint) -> tuple[float, float]:
        """Where a point is on the panel, inches from its lower left corner."""
        first, last = self.times_ms
        low, high = self.shares_pct
        across = log(point.time_ms / first) / log(last / first)
        up = log((100 - low) / (100 - point.accuracy_pct)) / log((100 - low) / (100 - high))
        return (WIDTH - LEFT - MARGIN) * across, (HEIGHT - HEADER - FOOT) * up


def _view(points: Sequence[ChartPoint], worst_shown_pct: float) -> _View:
    """Choose axes with room around all points, and above the best one for its name."""
    times = [point.time_ms for point in points]
    best = max(point.accuracy_pct for point in points)
    worst = min(max(point.accuracy_pct, worst_shown_pct) for point in points)
    return _View(
        (0.75 * min(times), 1.35 * max(times)),
        (worst - 0.15 * (100 - worst), 100 - 0.55 * (100 - best)),
    )


def _worth_naming(
    own: Sequence[ChartPoint], front: Sequence[int], default: ChartPoint, view: _View
) -> list[ChartPoint]:
    """Thin the front to points of clear gain with room for a number, not the default itself.

    Gains are those that the axis shows: shares by which the error shrinks.
    """
    gains = [-log(100 - point.accuracy_pct) for point in own]
    kept, least = list(front), NAMED_GAIN
    while len(kept) > MOST_NAMES or least == NAMED_GAIN:
        kept, least = thin_front(gains, front, least), 1.2 * least
    # The best has the first right to a place, then the fastest.
    chosen: list[int] = []
    for index in dict.fromkeys([*kept[-1:], *kept]):
        place = view.place(own[index])
        others = [default, *(own[other] for other in chosen)]
        if all(dist(place, view.place(other)) >= NUMBER_SIZE for other in others):
            chosen.append(index)
    return [own[index] for index in kept if index in chosen]


def _number(
    axes: Axes,
    named: Sequence[ChartPoint],
    front: Sequence[ChartPoint],
    default: ChartPoint,
    view: _View,
) -> None:
    """Write the numbers of the key onto their points, or beside them where another covers them."""
    taken = [default]
    for number, point in enumerate(named, start=1):
        place = view.place(point)
        under = sum(dist(place, view.place(other)) < NUMBER_SIZE for other in taken)
        taken.append(point)
        full = point in front
        style: dict[str, Any] = {"size": 7.5, "weight": "bold", "textcoords": "offset points"}
        spot = (point.time_ms, point.accuracy_pct)
        if under:
            style |= {"color": BLUE, "ha": "left", "va": "center_baseline", "zorder": 5.5}
            axes.annotate(str(number), spot, xytext=(BESIDE_PT[0] * under, BESIDE_PT[1]), **style)
            continue
        axes.plot(
            *spot,
            "o",
            color=BLUE if full else "white",
            markersize=11.5,
            markeredgecolor="white" if full else BLUE,
            markeredgewidth=1.0,
            zorder=4.5,
        )
        style |= {"color": "white" if full else BLUE, "ha": "center", "va": "center_baseline"}
        axes.annotate(str(number), spot, xytext=(0, -0.3), zorder=4.6, **style)


def _write_key(figure: Figure, named: Sequence[ChartPoint]) -> None:
    """Write number, name and figures of the numbered points in two columns over the footer."""
    height = figure.get_size_inches()[1]
    lines = _key_lines(len(named))
    for index, point in enumerate(named):
        column, line = divmod(index, lines)
        left = MARGIN + column * (WIDTH - 2 * MARGIN) / 2
        text = f"{point.name}: {point.written_pct:.1f} %, {_short_time(point)}"
        up = (KEY_FOOT + (lines - line) * KEY_LINE) / height
        style: dict[str, Any] = {"size": TEXT - 0.5, "va": "top", "ha": "left"}
        figure.text(left / WIDTH, up, str(index + 1), color=BLUE, weight="bold", **style)
        figure.text((left + KEY_INDENT) / WIDTH, up, text, color=INK, **style)


def _short_time(point: ChartPoint) -> str:
    return format_time(float(f"{point.time_ms:.2g}"))


def _key_lines(names: int) -> int:
    return -(-names // 2)


def _name(
    axes: Axes,
    own: Sequence[ChartPoint],
    default: ChartPoint,
    baselines: Sequence[BaselineCurve],
    steps: list[tuple[float, float]],
) -> None:
    """Name the default, and the baselines at their best points."""
    names = [
        PointLabel(
            default.time_ms,
            default.accuracy_pct,
            f"default: {default.written_pct:.1f} % in {_short_time(default)}",
            colour=VERMILION,
            bold=True,
        )
    ]
    for curve in baselines:
        if curve.points:
            best = max(curve.points, key=lambda point: point.accuracy_pct)
            names.append(
                PointLabel(best.time_ms, best.accuracy_pct, curve.name, "right", colour=FAINT)
            )
    lines = [
        steps,
        *([(p.time_ms, p.accuracy_pct)] for p in own),
        *([(p.time_ms, p.accuracy_pct) for p in curve.points] for curve in baselines),
    ]
    label_points(axes, names, lines)
