"""The chart of a stage: accuracy against time, the Pareto front, the default, baselines in grey."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .chart_style import (
    BLUE,
    GREY,
    LINE,
    MARKERS,
    SKY,
    VERMILION,
    Provenance,
    add_footer,
    add_legend,
    label_axes,
    new_chart,
    set_percent_axis,
    set_time_axis,
)
from .pareto_key import (
    HEIGHT,
    KEY_GAP,
    KEY_LINE,
    ChartPoint,
    draw_numbers,
    fit_view,
    key_lines,
    select_named,
    short_time,
    write_key,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FEW_POINTS = 4
"""With at most this many settings all are named, also those behind the front."""
MIN_SHOWN_PCT = 40.0
"""Baselines below this accuracy are left out by default: they would compress the chart."""
MAX_SHOWN_PCT = 99.9
"""A stretched axis has no 100 %; better points are drawn at this level."""


@dataclass(frozen=True)
class BaselineCurve:
    """A baseline at several settings."""

    name: str
    points: tuple[ChartPoint, ...]


@dataclass(frozen=True)
class ParetoChart:
    """Accuracy against time: own settings, their Pareto front, the default, and baselines."""

    title: str
    """Title of the chart."""
    subtitle: str
    """What is drawn, in grey under the title."""
    own: Sequence[ChartPoint]
    """All own settings."""
    front: Sequence[int]
    """Indices of the Pareto front, by rising time."""
    accuracy: str
    """Name of the accuracy, for the axis."""
    made: Provenance
    """Origin of the figures, for the footer."""
    default: int = 0
    """Index of the default setting."""
    baselines: Sequence[BaselineCurve] = ()
    """Baselines, in grey."""
    min_shown_pct: float = MIN_SHOWN_PCT
    """Points of baselines below this accuracy are left out, per cent."""
    max_shown_pct: float = MAX_SHOWN_PCT
    """Better points are drawn at this level; text states their true accuracy, per cent."""

    def figure(self) -> Figure:
        """Draw the chart."""
        own = [_drawable(point, self.max_shown_pct) for point in self.own]
        star, front = own[self.default], [own[index] for index in self.front]
        shown = [self._shown(curve) for curve in self.baselines]
        every = [*own, *(point for curve in shown for point in curve.points)]
        view = fit_view(every, self.min_shown_pct)
        if len(own) <= FEW_POINTS:
            named = [point for index, point in enumerate(own) if index != self.default]
        else:
            named = select_named(own, self.front, star, view)
        below = KEY_LINE * key_lines(named) + KEY_GAP
        figure, (axes,) = new_chart(self.title, self.subtitle, height=HEIGHT + below, below=below)
        set_time_axis(axes, *view.times_ms)
        capped = _capped(every, self.max_shown_pct)
        set_percent_axis(axes, *view.accuracies_pct, stretched=True, capped=capped)
        label_axes(
            axes,
            f"time per {self.made.each}, median (logarithmic)",
            f"{self.accuracy} (logarithmic in error)",
        )
        steps = _steps(front, view.times_ms[1])
        for curve, mark in zip(shown, MARKERS * len(shown), strict=False):
            _draw_baseline(axes, curve, mark)
        _draw_own(axes, own, front, steps)
        draw_numbers(axes, named, front, star, view)
        write_key(figure, named)
        axes.plot(
            star.time_ms,
            star.accuracy_pct,
            "*",
            color=VERMILION,
            markersize=17,
            markeredgecolor="white",
            markeredgewidth=1.2,
            label=f"default: {star.written_pct:.1f} % in {short_time(star)}",
            zorder=5,
        )
        add_legend(axes, where="best")
        add_footer(figure, self.made)
        return figure

    def _shown(self, curve: BaselineCurve) -> BaselineCurve:
        points = [
            _drawable(point, self.max_shown_pct)
            for point in curve.points
            if point.accuracy_pct >= self.min_shown_pct
        ]
        return BaselineCurve(curve.name, tuple(points))


def _draw_own(
    axes: Axes,
    own: Sequence[ChartPoint],
    front: Sequence[ChartPoint],
    steps: Sequence[tuple[float, float]],
) -> None:
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
        [point.time_ms for point in front],
        [point.accuracy_pct for point in front],
        "o",
        color=BLUE,
        markersize=6.5,
        markeredgecolor="white",
        markeredgewidth=1.0,
        zorder=4,
    )


def _drawable(point: ChartPoint, max_shown_pct: float) -> ChartPoint:
    """Move a point above the axis to its upper level."""
    if point.accuracy_pct <= max_shown_pct:
        return point
    return replace(point, accuracy_pct=max_shown_pct, true_pct=point.accuracy_pct)


def _capped(points: Sequence[ChartPoint], max_shown_pct: float) -> tuple[float, str] | None:
    """Return the level to which points were moved and its label; None when none was moved."""
    moved = [point.true_pct for point in points if point.true_pct is not None]
    if not moved:
        return None
    return max_shown_pct, "100 %" if min(
        moved
    ) == 100.0 else f"\N{GREATER-THAN OR EQUAL TO} {max_shown_pct:g} %"


def _steps(front: Sequence[ChartPoint], end_ms: float) -> list[tuple[float, float]]:
    """Return the corners of the stepped line of the best accuracy within each time."""
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
        label=curve.name,
        color=GREY,
        linewidth=1.1,
        markersize=5.0,
        markeredgecolor="white",
        markeredgewidth=0.7,
        zorder=2,
    )
