"""Sweeps as small charts side by side, and as rows of figures."""

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
    new_chart,
    write_chart,
)
from .sweep import BROKEN_BELOW, Step, format_value

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .sweep import SweepResult

COLUMNS = 4
"""Panels side by side."""
ROW_HEIGHT = 1.75
"""Height of a row of panels with all its words, inches."""
AROUND = 2.1
"""Height of title, footer and the last panels' words, inches."""
MIDDLE = 0.32
"""Room between panels, inches: only the first of a row names its shares."""
ABOVE = 0.92
"""Room between rows of panels, inches: values, two lines of words, and the next names."""
LETTERS = 28
"""Of the words under a panel, in a line."""
LETTER = 0.068
"""Width of a letter of the values named under a panel, inches."""
KEY = 0.3
"""Height of a key between panels and footer, inches."""
KEY_PLACE = 0.52
"""Of its lower edge above the chart's, inches: over two lines of footer."""


@dataclass(frozen=True)
class ReportSpec:
    """How the sweeps of one stage are told: its words, its figures, its curves."""

    stage: str
    """Second word of the command."""
    title: str
    """Of the chart."""
    subtitle: str
    """What is drawn, in grey under it."""
    data: str
    """What was measured on, for the footer."""
    each: str
    """What one trial is put before, for the same."""
    figures: Callable[[Step], dict[str, Any]]
    """What a row of a sweep and value tells beside the share that is right."""
    draw: Callable[[Axes, Sequence[float], Sequence[Step]], None]
    """Draws the steps at their places on a panel whose y goes from 0 to 100 %."""
    keyed: bool = False
    """Whether what it draws is several things: their labels then stand in a key."""
    time: str = "ms a trial"
    """What the column of times in the table is called."""


def write_stress_chart(
    path: Path, results: Sequence[SweepResult], telling: ReportSpec, seeds: int, first_seed: int
) -> None:
    """Draw every sweep, from easy to hard, with where it breaks.

    Parameters
    ----------
    path
        PNG to write; the CSV goes beside it.
    results
        Sweeps, in reading order.
    telling
        What is drawn of each, and the words around it.
    seeds, first_seed
        How many seeds were tried, and the first one.

    Raises
    ------
    InputError
        If there are no results, or the folder cannot be written to.
    DeviceError
        If the disk fails.
    """
    columns = min(COLUMNS, max(len(results), 1))
    rows = max(-(-len(results) // columns), 1)
    key = KEY if telling.keyed else 0.0
    # A chart makes room for the names of its panels only where there are several.
    named = PANEL_NAME if rows * columns == 1 else 0.0
    height = AROUND + named + rows * ROW_HEIGHT + key
    figure, panels = new_chart(
        telling.title,
        f"{telling.subtitle}, from easy (left) to hard (right)\n"
        "green: must hold      dashed: breaks, fewer than 90 % are right",
        rows=rows,
        columns=columns,
        height=height,
        below=key,
    )
    place = figure.subplotpars
    wide = ((place.right - place.left) * WIDTH - (columns - 1) * MIDDLE) / columns
    top = place.top - (named + 0.5 * MARGIN) / height
    high = ((top - place.bottom) * height - (rows - 1) * ABOVE) / rows
    figure.subplots_adjust(top=top, wspace=MIDDLE / wide, hspace=ABOVE / high)
    for number, panel in enumerate(panels):
        if number < len(results):
            _draw(panel, results[number], telling, wide, shares_named=number % columns == 0)
        else:
            panel.set_axis_off()
    if telling.keyed:
        _add_key(figure, panels[0])
    add_footer(figure, Provenance(telling.data, first_seed, seeds, telling.each))
    write_chart(figure, path, point_rows(results, telling))


def sweep_rows(results: Sequence[SweepResult]) -> list[dict[str, Any]]:
    """One row a sweep: where it breaks and what it must hold, values in the sweep's unit."""
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
        }
        for result in results
    ]


def point_rows(results: Sequence[SweepResult], telling: ReportSpec) -> list[dict[str, Any]]:
    """One row a sweep and value: share of right trials, and the stage's own figures."""
    return [
        {
            "name": result.sweep.name,
            "value": step.value,
            "unit": result.sweep.unit,
            "must_hold": step.value in result.sweep.bounded(),
            "trials": len(step.trials),
            "right_pct": round(100 * step.share, 1),
            **telling.figures(step),
            "wrong": step.worst.note,
        }
        for result in results
        for step in result.steps
    ]


def percent(share: float | None, digits: int = 1) -> float | None:
    """A share in %, rounded; None stays None."""
    return None if share is None else round(100 * share, digits)


def milliseconds(step: Step) -> float | None:
    """Median time of a step, ms, rounded; None where none was measured."""
    return None if step.seconds is None else round(1e3 * step.seconds, 1)


def _draw(
    axes: Axes, result: SweepResult, telling: ReportSpec, wide: float, *, shares_named: bool
) -> None:
    sweep = result.sweep
    # Equal steps: the values are chosen by how much harder each makes it.
    places = list(range(len(sweep.values)))
    held = len(sweep.bounded())
    axes.axvspan(-0.5, held - 0.5, color=GREEN, alpha=0.1, linewidth=0)
    axes.axhline(100 * BROKEN_BELOW, color=GREY, linewidth=0.7, zorder=1.5)
    telling.draw(axes, places, result.steps)
    named = [max(held - 1, 0), places[-1], 0, *places]
    broken = None
    if result.breaks_at is not None:
        broken = sweep.values.index(result.breaks_at)
        axes.axvline(broken, color=VERMILION, linewidth=1.1, linestyle=(0, (4, 3)), zorder=2.5)
        named.insert(0, broken)
    axes.set_xlim(-0.5, len(places) - 0.5)
    axes.set_ylim(-4, 104)
    axes.set_yticks([0, 50, 100], ["0 %", "50 %", "100 %"] if shares_named else [""] * 3)
    words = [format_value(value, "") for value in sweep.values]
    ticks = _apart(named, words, wide / len(places))
    axes.set_xticks(ticks, [words[k] for k in ticks])
    axes.tick_params(labelsize=TEXT - 1.5, pad=3)
    for k, label in zip(ticks, axes.get_xticklabels(), strict=True):
        if k == broken:
            label.set(color=VERMILION, weight="bold")
    axes.grid(False, axis="x")
    axis = f"{sweep.axis} ({sweep.unit})" if sweep.unit else sweep.axis
    axes.set_xlabel(
        textwrap.fill(axis, LETTERS), size=TEXT - 2, color=FAINT, labelpad=3, linespacing=1.15
    )
    axes.set_title(sweep.name, size=LABEL - 0.5, color=INK, weight="bold", loc="left", pad=5)


def _add_key(figure: Figure, panel: Axes) -> None:
    """Say under the panels what their curves and bars are."""
    handles, names = panel.get_legend_handles_labels()
    height = figure.get_size_inches()[1]
    figure.legend(
        handles,
        names,
        loc="lower left",
        bbox_to_anchor=(MARGIN / WIDTH, KEY_PLACE / height),
        ncols=len(names),
        fontsize=TEXT - 0.5,
        labelcolor=INK,
        frameon=False,
        borderpad=0,
        borderaxespad=0,
        handlelength=1.6,
        columnspacing=2.0,
    )


def _apart(wanted: Sequence[int], words: Sequence[str], step: float) -> list[int]:
    """Of the places wanted, first come first served, those whose words do not run together."""
    kept: list[int] = []
    for place in wanted:
        if place not in kept and all(
            abs(place - other) * step > LETTER * (len(words[place]) + len(words[other]) + 2) / 2
            for other in kept
        ):
            kept.append(place)
    return sorted(kept)
