"""The chart of the reaching benchmark: success against time to the goal, and time per cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_labels import PointLabel, label_points
from ..bench.chart_style import (
    BLUE,
    FAINT,
    GREY,
    INK,
    LINE,
    VERMILION,
    label_axes,
    set_percent_axis,
)
from .reach_methods import BASELINES, DEFAULT

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIME_MARGIN = 1.9
"""Factor of free space beside the fastest and the slowest method, for names."""
FREE_BELOW, FREE_ABOVE = 12.0, 15.0
"""Free space below the lowest interval and above the highest, for names of two lines, percentage
points."""
STEPS = (1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200, 300, 500, 700, 1000, 2000, 5000)
WIDE_STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
"""Times with a label on an axis, s or µs, and those on a wide axis."""
WIDE = 30.0
"""Ratio of the slowest to the fastest time above which an axis is wide."""


class _TimeScale(NamedTuple):
    column: str
    label: str
    unit: str


TO_GOAL = _TimeScale("time_p50_s", "time to the goal, median (logarithmic)", "s")
PER_CYCLE = _TimeScale("cycle_p50_us", "time per control cycle, median (logarithmic)", "µs")
"""The time axes of the two panels."""


def reach_chart(rows: Sequence[Mapping[str, Any]], made: Provenance) -> Figure:
    """Draw the success of each method, with its 95 % interval, against its time per cycle.

    Parameters
    ----------
    rows
        Rows of `summary_row`, one per method.
    made
        Data and seed, for the footer.
    """
    figure, panels = new_chart(
        "Reaching: time to the goal and time per cycle against success",
        "success with 95 % interval; ○ touches obstacles in some scenes, ● in none; grey: baseline",
        rows=2,
        height=9.0,
    )
    low = min(row["success_low_pct"] for row in rows) - FREE_BELOW
    high = max(row["success_high_pct"] for row in rows) + FREE_ABOVE
    for axes, scale in zip(panels, (TO_GOAL, PER_CYCLE), strict=True):
        times = [row[scale.column] for row in rows]
        _time_axis(axes, scale, min(times) / TIME_MARGIN, max(times) * TIME_MARGIN)
        set_percent_axis(axes, max(low, 0.0), high)
        axes.set_yticks([tick for tick in range(0, 101, 10) if max(low, 0.0) <= tick <= high])
        label_axes(axes, scale.label, "goal reached without contact")
        names, lines = [], []
        for row in rows:
            names.append(_draw(axes, row, scale))
            x = row[scale.column]
            lines.append([(x, row["success_low_pct"]), (x, row["success_high_pct"])])
            lines.append([(x, row["success_pct"])])
        # The label of the default method is placed first.
        names.sort(key=lambda name: not name.bold)
        label_points(axes, names, lines)
    add_footer(figure, made)
    return figure


def _draw(axes: Axes, row: Mapping[str, Any], scale: _TimeScale) -> PointLabel:
    name, x, y = row["name"], row[scale.column], row["success_pct"]
    default, baseline = name == DEFAULT, name in BASELINES
    colour = VERMILION if default else GREY if baseline else BLUE
    text_colour = VERMILION if default else FAINT if baseline else INK
    axes.plot(
        [x, x],
        [row["success_low_pct"], row["success_high_pct"]],
        color=colour,
        linewidth=LINE,
        alpha=0.3,
        solid_capstyle="butt",
        zorder=2,
    )
    axes.plot(
        x,
        y,
        "*" if default else "o",
        color=colour,
        markersize=17 if default else 8,
        markerfacecolor="white" if row["contacts"] else colour,
        markeredgecolor=colour if row["contacts"] else "white",
        markeredgewidth=1.6 if row["contacts"] else 1.2,
        zorder=5 if default else 4,
    )
    return PointLabel(x, y, _label(row, scale), "right", colour=text_colour, bold=default)


def _label(row: Mapping[str, Any], scale: _TimeScale) -> str:
    count = row["contacts"]
    label = f"{row['name']}: {row['success_pct']:.1f} %" + (f", {count} touched" if count else "")
    if scale is TO_GOAL:
        return f"{label}\n90 % in {row['time_p90_s']:.1f} s"
    if "plan_p50_ms" in row:
        label += f"\nplanning {row['plan_p50_ms']:.0f} ms, 90 % in {row['plan_p90_ms']:.0f} ms"
    return label


def _time_axis(axes: Axes, scale: _TimeScale, fastest: float, slowest: float) -> None:
    axes.set_xscale("log")
    axes.set_xlim(fastest, slowest)
    steps = WIDE_STEPS if slowest > WIDE * fastest else STEPS
    ticks = [step for step in steps if fastest <= step <= slowest]
    axes.set_xticks(ticks, [f"{step:g} {scale.unit}" for step in ticks])
    axes.set_xticks([], minor=True)
