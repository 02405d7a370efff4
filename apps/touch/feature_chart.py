"""Chart of feature accuracy: direction error against time, position error against threshold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import (
    BLUE,
    COLOURS,
    GREEN,
    INK,
    LINE,
    MARKERS,
    ORANGE,
    VERMILION,
    add_legend,
    draw_curve,
    label_axes,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 5.4
"""Height of the figure, inches."""
TIMES_US = (0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000)
ANGLES_DEG = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 45)
GAPS_MM = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)
"""Tick positions of the axes."""
MARGIN_FACTOR = 1.7
"""Factor between the outermost points and the limits of a logarithmic axis."""


def feature_chart(rows: Sequence[Mapping[str, Any]], provenance: Provenance) -> Figure:
    """Plot the direction error against time, and the position error against the threshold."""
    figure, (left, right) = new_chart(
        "Moments and pressure weights are more accurate and faster",
        "dots: median error over the imprints; vertical lines: up to the 95th percentile; "
        "Hough: 36 to 720 angles",
        columns=2,
        height=HEIGHT,
    )
    _directions(left, [row for row in rows if row["feature"] == "orientation"])
    _centres(right, [row for row in rows if row["feature"] == "centre"])
    add_footer(figure, provenance)
    return figure


def _directions(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    times = [row["time_p50_us"] for row in rows]
    errors = [row["error_p50_deg"] for row in rows] + [row["error_p95_deg"] for row in rows]
    _set_log_axis(axes, "x", times, TIMES_US)
    _set_log_axis(axes, "y", errors, ANGLES_DEG)
    label_axes(
        axes, "time without region search [µs]", "error of a line's direction [°]", panel="Line"
    )
    hough = list(dict.fromkeys(row["method"] for row in rows if row["angles"]))
    for number, method in enumerate(hough):
        own = [row for row in rows if row["method"] == method]
        colour = (ORANGE, GREEN, BLUE)[number % 3]
        words = method.replace("hough above 0 %", "Hough, all tactels").replace("hough", "Hough")
        x, y = [r["time_p50_us"] for r in own], [r["error_p50_deg"] for r in own]
        draw_curve(axes, x, y, words, COLOURS.index(colour))
        for row in own:
            _draw_error_bar(axes, row["time_p50_us"], row, "deg", colour)
    single = [row for row in rows if not row["angles"]]
    for row, mark in zip(single, MARKERS * len(single), strict=False):
        default = row["method"] == "moments"
        x, y = row["time_p50_us"], row["error_p50_deg"]
        colour = VERMILION if default else INK
        _draw_error_bar(axes, x, row, "deg", colour)
        axes.plot(
            x,
            y,
            "*" if default else mark,
            color=colour,
            markersize=17 if default else 6.5,
            markeredgecolor="white",
            markeredgewidth=1.0,
            label=f"{row['method']}: {y:.2g}°, {x:.2g} µs",
            linestyle="none",
            zorder=5,
        )
    add_legend(axes, where="best")


def _centres(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    errors = [row["error_p50_mm"] for row in rows] + [row["error_p95_mm"] for row in rows]
    axes.set_xlim(-2, max(row["threshold_pct"] for row in rows) + 2)
    _set_log_axis(axes, "y", errors, GAPS_MM)
    label_axes(
        axes,
        "threshold [% of the peak; 0: noise level]",
        "error of a probe's position [mm]",
        panel="Probe",
    )
    for number, (method, colour) in enumerate((("weighted", VERMILION), ("binarised", INK))):
        own = [row for row in rows if row["method"] == method]
        x = [row["threshold_pct"] + (0.4 if number else -0.4) for row in own]
        words = {"weighted": "weighted by pressure (default)", "binarised": "equal weights"}
        axes.plot(
            x,
            [row["error_p50_mm"] for row in own],
            "o-",
            color=colour,
            linewidth=LINE,
            markersize=5,
            markeredgecolor="white",
            label=words[method],
            zorder=3,
        )
        for place, row in zip(x, own, strict=True):
            _draw_error_bar(axes, place, row, "mm", colour)
    add_legend(axes, where="lower right")


def _draw_error_bar(axes: Axes, x: float, row: Mapping[str, Any], unit: str, colour: str) -> None:
    ends = [row[f"error_p50_{unit}"], row[f"error_p95_{unit}"]]
    axes.plot([x, x], ends, color=colour, linewidth=1.4, alpha=0.35, zorder=2)


def _set_log_axis(
    axes: Axes, axis: Literal["x", "y"], values: Sequence[float], steps: Sequence[float]
) -> None:
    """Scale an axis logarithmically around values, with ticks at those of `steps` that fit."""
    low, high = min(values) / MARGIN_FACTOR, max(values) * MARGIN_FACTOR
    ticks = [step for step in steps if low <= step <= high]
    axes.set(**{f"{axis}scale": "log", f"{axis}lim": (low, high)})
    scale = axes.xaxis if axis == "x" else axes.yaxis
    scale.set_ticks(ticks, [f"{step:g}" for step in ticks])
    scale.set_ticks([], minor=True)
