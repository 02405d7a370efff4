"""The chart of an evaluation: the rates of every condition with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...bench.chart_style import (
    BLUE,
    INK,
    ORANGE,
    TEXT,
    Provenance,
    add_footer,
    label_axes,
    new_chart,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT, LINE_HEIGHT = 2.5, 0.42
"""Height of the figure without its lines, and of a line, inches."""
OFFSET = 0.15
"""Vertical offset of the two rates from the middle of the line, lines."""
NAMES_LEFT = 0.27
"""Share of the width for the names of the conditions."""
RATES = (("success", "", BLUE, -OFFSET), ("cleared", "cleared_", ORANGE, OFFSET))
"""The drawn rates: name, prefix of the keys, colour, offset."""


def rates_chart(rows: Sequence[Mapping[str, Any]], provenance: Provenance) -> Figure:
    """Draw success and cleared share of every condition as points on their 95 % intervals."""
    height = HEIGHT + LINE_HEIGHT * len(rows)
    figure, (axes,) = new_chart(
        "Unknown objects picked from one noisy depth view",
        "successful picks and objects in the tray, with 95 % intervals",
        height=height,
    )
    figure.subplots_adjust(left=NAMES_LEFT)
    for line, row in enumerate(rows):
        for _, prefix, colour, offset in RATES:
            _draw(axes, row, prefix, colour, line + offset)
    lowest = min((row[f"{p}ci_low_pct"] for row in rows for _, p, _, _ in RATES), default=0.0)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [row["name"] for row in rows])
    axes.set_xlim(max(0.0, 10 * (lowest // 10)), 100.5)
    axes.xaxis.set_major_formatter("{x:g} %")
    axes.grid(False, axis="y")
    label_axes(axes, "share of picks, share of objects", "")
    for name, _, colour, _ in RATES:
        axes.plot([], [], "o-", color=colour, label=name, linewidth=2)
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=2,
        frameon=False,
        fontsize=TEXT,
        labelcolor=INK,
    )
    add_footer(figure, provenance)
    return figure


def _draw(axes: Axes, row: Mapping[str, Any], prefix: str, colour: str, line: float) -> None:
    share = row[f"{prefix}pct" if prefix else "success_pct"]
    if share is None:
        return
    ends = [row[f"{prefix}ci_low_pct"], row[f"{prefix}ci_high_pct"]]
    axes.plot(ends, [line, line], color=colour, linewidth=2.0, solid_capstyle="round", zorder=3)
    axes.plot(
        share,
        line,
        "o",
        color=colour,
        markersize=6.5,
        markeredgecolor="white",
        markeredgewidth=1.0,
        clip_on=False,
        zorder=4,
    )
