"""The chart of the reaching bench: time per cycle against success, contacts told at each point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..bench import PointLabel, Provenance, add_footer, label_points, new_chart
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
from .reach_methods import BASELINE as BASELINE_METHOD
from .reach_methods import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROOM = 1.9
"""Factor of free time beside the fastest and slowest row, for names."""
FREE_BELOW, FREE_ABOVE = 12.0, 15.0
"""Points of per cent below the worst interval and above the best, for names: those of two lines
above a point at 100 %."""
STEPS_US = (1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 150, 200, 300, 500, 700, 1000, 2000, 5000)
"""Where the time axis has labels."""


def bench_chart(rows: Sequence[Mapping[str, Any]], made: Provenance) -> Figure:
    """Draw each row's success, with its 95 % interval, against its time per cycle.

    Parameters
    ----------
    rows
        Rows of `summary_row`.
    made
        For the footer.
    """
    figure, (axes,) = new_chart(
        "Reaching among boxes: time per cycle against success",
        "success with 95 % interval; ○ touched something in some scene, ● never; grey: baseline",
    )
    times = [row["cycle_p50_us"] for row in rows]
    _time_axis(axes, min(times) / ROOM, max(times) * ROOM)
    low = min(row["success_low_pct"] for row in rows) - FREE_BELOW
    high = max(row["success_high_pct"] for row in rows) + FREE_ABOVE
    set_percent_axis(axes, max(low, 0.0), high)
    axes.set_yticks([tick for tick in range(0, 101, 10) if max(low, 0.0) <= tick <= high])
    label_axes(
        axes,
        "time per control cycle, median (logarithmic)",
        "goal reached to 1 mm, nothing touched",
    )
    names, lines = [], []
    for row in rows:
        names.append(_draw(axes, row))
        x = row["cycle_p50_us"]
        lines.append([(x, row["success_low_pct"]), (x, row["success_high_pct"])])
        lines.append([(x, row["success_pct"])])
    # The default has the first right to a place.
    names.sort(key=lambda name: not name.bold)
    label_points(axes, names, lines)
    add_footer(figure, made)
    return figure


def _draw(axes: Axes, row: Mapping[str, Any]) -> PointLabel:
    name, x, y = row["name"], row["cycle_p50_us"], row["success_pct"]
    colour = _colour(name)
    axes.plot(
        [x, x],
        [row["success_low_pct"], row["success_high_pct"]],
        color=colour,
        linewidth=LINE,
        alpha=0.3,
        solid_capstyle="butt",
        zorder=2,
    )
    star = name == DEFAULT
    axes.plot(
        x,
        y,
        "*" if star else "o",
        color=colour,
        markersize=17 if star else 8,
        markerfacecolor="white" if row["contacts"] else colour,
        markeredgecolor=colour if row["contacts"] else "white",
        markeredgewidth=1.6 if row["contacts"] else 1.2,
        zorder=5 if star else 4,
    )
    return PointLabel(x, y, _words(row), "right", colour=_ink(name), bold=star)


def _words(row: Mapping[str, Any]) -> str:
    count = row["contacts"]
    touched = f"touched in {count} scene{'' if count == 1 else 's'}" if count else "never touched"
    words = f"{row['name']}: {row['success_pct']:.1f} %, {touched}"
    if "plan_p50_ms" in row:
        words += f"\nplanning {row['plan_p50_ms']:.0f} ms, 90 % within {row['plan_p90_ms']:.0f} ms"
    return words


def _colour(name: str) -> str:
    if name == BASELINE_METHOD:
        return GREY
    return VERMILION if name == DEFAULT else BLUE


def _ink(name: str) -> str:
    if name == BASELINE_METHOD:
        return FAINT
    return VERMILION if name == DEFAULT else INK


def _time_axis(axes: Axes, fastest_us: float, slowest_us: float) -> None:
    axes.set_xscale("log")
    axes.set_xlim(fastest_us, slowest_us)
    ticks = [step for step in STEPS_US if fastest_us <= step <= slowest_us]
    axes.set_xticks(ticks, [f"{step} µs" for step in ticks])
    axes.set_xticks([], minor=True)
