"""The chart of sweeps, one small panel each, and its rows of figures."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .chart_style import (
    FAINT,
    GREEN,
    GREY,
    INK,
    LABEL,
    MARGIN,
    PANEL_NAME,
    TEXT,
    VERMILION,
    WIDTH,
    Provenance,
    add_footer,
    draw_curve,
    new_chart,
    write_chart,
)
from .sweep import MIN_PASS_RATE, SweepResult, SweepStep, format_value

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLUMNS = 4
"""Panels side by side."""
ROW_HEIGHT = 1.75
"""Height of a row of panels with its text, inches."""
AROUND = 2.1
"""Height of title, footer and the text under the last row, inches."""
COLUMN_GAP = 0.32
"""Gap between panels, inches: only the first panel of a row has labels on its y axis."""
ROW_GAP = 0.92
"""Gap between rows of panels, inches: tick labels, two lines of text, and the next names."""
MAX_LINE_LETTERS = 28
"""Letters in a line of text under a panel."""
LETTER_WIDTH = 0.068
"""Width of a letter of the tick labels, inches."""
LEGEND_HEIGHT = 0.3
"""Height of a legend between panels and footer, inches."""
LEGEND_BOTTOM = 0.52
"""Distance of the legend from the lower edge, inches: above two lines of footer."""


@dataclass(frozen=True)
class ReportSpec:
    """The words, figures and curves of a stage's stress chart."""

    title: str
    """Title of the chart."""
    subtitle: str
    """What is drawn, in grey under the title."""
    data: str
    """What was measured on, for the footer."""
    case_name: str
    """What one trial is run on, for the footer: frame, cloud, pick."""
    figures: Callable[[SweepStep], dict[str, Any]]
    """Return further columns for a row, beside the share of right trials."""
    draw: Callable[[Axes, Sequence[float], Sequence[SweepStep]], None]
    """Draw the steps at their x positions on a panel whose y axis goes from 0 to 100 %."""
    legend: bool = False
    """Whether the labels of what is drawn stand in a legend."""
    time_column: str = "ms a trial"
    """Heading of the time column in the table."""


def write_stress_chart(
    path: Path, results: Sequence[SweepResult], report: ReportSpec, seeds: int, first_seed: int
) -> None:
    """Draw a panel per sweep, from easy to hard, with a line where the method breaks.

    Parameters
    ----------
    path
        PNG to write; the CSV goes beside it.
    results
        Sweeps, in reading order.
    report
        Words and curves of the stage.
    seeds, first_seed
        Number of seeds and the first one, for the footer.

    Raises
    ------
    InputError
        If there are no results, or the folder cannot be written to.
    DeviceError
        If the disk fails.
    """
    columns = min(COLUMNS, max(len(results), 1))
    rows = max(-(-len(results) // columns), 1)
    key = LEGEND_HEIGHT if report.legend else 0.0
    # new_chart leaves room for panel names only when there are several panels.
    named = PANEL_NAME if rows * columns == 1 else 0.0
    height = AROUND + named + rows * ROW_HEIGHT + key
    figure, panels = new_chart(
        report.title,
        f"{report.subtitle}, from easy (left) to hard (right)\n"
        "green: must hold      dashed: breaks, fewer than 90 % are right",
        rows=rows,
        columns=columns,
        height=height,
        below=key,
    )
    place = figure.subplotpars
    width = ((place.right - place.left) * WIDTH - (columns - 1) * COLUMN_GAP) / columns
    top = place.top - (named + 0.5 * MARGIN) / height
    row_height = ((top - place.bottom) * height - (rows - 1) * ROW_GAP) / rows
    figure.subplots_adjust(top=top, wspace=COLUMN_GAP / width, hspace=ROW_GAP / row_height)
    for number, panel in enumerate(panels):
        if number < len(results):
            _draw(panel, results[number], report, width, y_labelled=number % columns == 0)
        else:
            panel.set_axis_off()
    if report.legend:
        _add_legend(figure, panels[0])
    add_footer(figure, Provenance(report.data, first_seed, seeds, report.case_name))
    write_chart(figure, path, point_rows(results, report))


def sweep_rows(results: Sequence[SweepResult]) -> list[dict[str, Any]]:
    """Return a row per sweep: where it breaks and its bound, in the sweep's unit.

    Where the stage has other methods, their breaks and bounds are columns with their names.
    """
    return [
        {
            "name": result.sweep.name,
            "axis": result.sweep.axis,
            "unit": result.sweep.unit,
            "right": result.sweep.right,
            "holds_to": result.sweep.holds_to,
            "breaks_at": result.breaks_at,
            "bound_kept": not result.faults,
            "wrong": result.shown.worst.note,
            **{
                f"{key}_{other.method}": value
                for other in result.others
                for key, value in (
                    ("holds_to", other.sweep.holds_to),
                    ("breaks_at", other.breaks_at),
                    ("wrong", other.shown.worst.note),
                )
            },
        }
        for result in results
    ]


def point_rows(results: Sequence[SweepResult], report: ReportSpec) -> list[dict[str, Any]]:
    """Return a row per sweep, method and value: share of right trials and the stage's figures."""
    return [
        {
            "name": result.sweep.name,
            **({"method": result.method} if result.method else {}),
            "value": step.value,
            "unit": result.sweep.unit,
            "must_hold": step.value in result.sweep.required_values(),
            "trials": len(step.trials),
            "right_pct": round(100 * step.pass_rate, 1),
            **report.figures(step),
            "wrong": step.worst.note,
        }
        for first in results
        for result in (first, *first.others)
        for step in result.steps
    ]


def _draw(
    axes: Axes, result: SweepResult, report: ReportSpec, width: float, *, y_labelled: bool
) -> None:
    sweep = result.sweep
    # Equal distances: each value was chosen to be about one step harder than the last.
    places = list(range(len(sweep.values)))
    held = len(sweep.required_values())
    axes.axvspan(-0.5, held - 0.5, color=GREEN, alpha=0.1, linewidth=0)
    axes.axhline(100 * MIN_PASS_RATE, color=GREY, linewidth=0.7, zorder=1.5)
    report.draw(axes, places, result.steps)
    for number, other in enumerate(result.others, 1):
        shares = [100 * step.pass_rate for step in other.steps]
        draw_curve(axes, places, shares, other.method, number)
    named = [max(held - 1, 0), places[-1], 0, *places]
    broken = None
    if result.breaks_at is not None:
        broken = sweep.values.index(result.breaks_at)
        axes.axvline(broken, color=VERMILION, linewidth=1.1, linestyle=(0, (4, 3)), zorder=2.5)
        named.insert(0, broken)
    axes.set_xlim(-0.5, len(places) - 0.5)
    axes.set_ylim(-4, 104)
    axes.set_yticks([0, 50, 100], ["0 %", "50 %", "100 %"] if y_labelled else [""] * 3)
    words = [format_value(value, "") for value in sweep.values]
    ticks = _spaced(named, words, width / len(places))
    axes.set_xticks(ticks, [words[k] for k in ticks])
    axes.tick_params(labelsize=TEXT - 1.5, pad=3)
    for k, label in zip(ticks, axes.get_xticklabels(), strict=True):
        if k == broken:
            label.set(color=VERMILION, weight="bold")
    axes.grid(False, axis="x")
    axis = f"{sweep.axis} ({sweep.unit})" if sweep.unit else sweep.axis
    axes.set_xlabel(
        textwrap.fill(axis, MAX_LINE_LETTERS),
        size=TEXT - 2,
        color=FAINT,
        labelpad=3,
        linespacing=1.15,
    )
    axes.set_title(sweep.name, size=LABEL - 0.5, color=INK, weight="bold", loc="left", pad=5)


def _add_legend(figure: Figure, panel: Axes) -> None:
    """Add a legend of the curves and bars under the panels."""
    handles, names = panel.get_legend_handles_labels()
    height = figure.get_size_inches()[1]
    figure.legend(
        handles,
        names,
        loc="lower left",
        bbox_to_anchor=(MARGIN / WIDTH, LEGEND_BOTTOM / height),
        ncols=len(names),
        fontsize=TEXT - 0.5,
        labelcolor=INK,
        frameon=False,
        borderpad=0,
        borderaxespad=0,
        handlelength=1.6,
        columnspacing=2.0,
    )


def _spaced(wanted: Sequence[int], words: Sequence[str], step: float) -> list[int]:
    """Return the positions whose labels do not touch; earlier ones have priority."""
    kept: list[int] = []
    for place in wanted:
        if place not in kept and all(
            abs(place - other) * step
            > LETTER_WIDTH * (len(words[place]) + len(words[other]) + 2) / 2
            for other in kept
        ):
            kept.append(place)
    return sorted(kept)
