"""The chart of the reaching benchmark: success against time to the goal, and time per cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import (
    BLUE,
    FOOT,
    GREY,
    INK,
    LINE,
    MARGIN,
    MARKERS,
    TEXT,
    VERMILION,
    WIDTH,
    label_axes,
    set_percent_axis,
)
from .reach_methods import BASELINES, DEFAULT

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIME_MARGIN = 1.4
"""Factor of free space beside the fastest and the slowest method."""
FREE = 6.0
"""Free space below the lowest interval and above the highest, percentage points."""
HEIGHT, KEY_LINE = 8.4, 0.24
"""Height of the figure without its key, and of a line of the key, inches."""
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
    below = KEY_LINE * (len(rows) + 1)
    figure, panels = new_chart(
        "Reaching: time to the goal and time per cycle against success",
        "success with 95 % interval; ○ touches obstacles in some scenes, ● in none; grey: baseline",
        rows=2,
        height=HEIGHT + below,
        below=below,
    )
    low = max(min(row["success_low_pct"] for row in rows) - FREE, 0.0)
    for axes, scale in zip(panels, (TO_GOAL, PER_CYCLE), strict=True):
        times = [row[scale.column] for row in rows]
        _time_axis(axes, scale, min(times) / TIME_MARGIN, max(times) * TIME_MARGIN)
        set_percent_axis(axes, low, 100.0 + FREE)
        axes.set_yticks([tick for tick in range(0, 101, 10) if tick >= low])
        label_axes(axes, scale.label, "goal reached without contact")
        for row, mark in zip(rows, MARKERS * len(rows), strict=False):
            _draw(axes, row, row[scale.column], "*" if row["name"] == DEFAULT else mark)
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        loc="lower left",
        bbox_to_anchor=(MARGIN / WIDTH, (FOOT - below / len(rows)) / (HEIGHT + below)),
        fontsize=TEXT,
        labelcolor=INK,
        frameon=False,
        borderpad=0.0,
    )
    add_footer(figure, made)
    return figure


def _draw(axes: Axes, row: Mapping[str, Any], x: float, mark: str) -> None:
    name, default = row["name"], row["name"] == DEFAULT
    colour = VERMILION if default else GREY if name in BASELINES else BLUE
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
        row["success_pct"],
        mark,
        color=colour,
        markersize=17 if default else 8,
        markerfacecolor="white" if row["contacts"] else colour,
        markeredgecolor=colour if row["contacts"] else "white",
        markeredgewidth=1.6 if row["contacts"] else 1.2,
        label=_label(row),
        zorder=5 if default else 4,
    )


def _label(row: Mapping[str, Any]) -> str:
    label = f"{row['name']}: {row['success_pct']:.1f} %, 90 % in {row['time_p90_s']:.1f} s"
    if row["contacts"]:
        label += f", {row['contacts']} touched"
    if "plan_p50_ms" in row:
        label += f", planning {row['plan_p50_ms']:.0f} ms, 90 % in {row['plan_p90_ms']:.0f} ms"
    return label


def _time_axis(axes: Axes, scale: _TimeScale, fastest: float, slowest: float) -> None:
    axes.set_xscale("log")
    axes.set_xlim(fastest, slowest)
    steps = WIDE_STEPS if slowest > WIDE * fastest else STEPS
    ticks = [step for step in steps if fastest <= step <= slowest]
    axes.set_xticks(ticks, [f"{step:g} {scale.unit}" for step in ticks])
    axes.set_xticks([], minor=True)
