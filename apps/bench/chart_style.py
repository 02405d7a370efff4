"""The style of all charts: sizes, colours, axes, footer, and the files written.

A chart is made in four steps: :func:`new_chart`, drawing on its axes, :func:`add_footer` with the
origin of the figures, :func:`write_chart`. matplotlib is used without its global state, so charts
need no screen and no clean-up.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from eyehand.errors import InputError
from eyehand.perception.io import atomic_write

from .machine import machine_line

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE = "#0072B2"
ORANGE = "#E69F00"
GREEN = "#009E73"
VERMILION = "#D55E00"
SKY = "#56B4E9"
PURPLE = "#CC79A7"
COLOURS = (BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE)
"""Colours of curves, in order: the colour-blind-safe set of Okabe and Ito without its yellow, which
is hard to see on white."""
INK = "#22262B"
"""Main text."""
FAINT = "#6B7280"
"""Explanations."""
GREY = "#9AA1AB"
"""Baselines, and other things of second rank."""
RULE = "#E4E7EB"
"""Grid lines."""

WIDTH = 8.0
"""Width of a chart, inches. With DPI that is 1600 px, twice the width that a README shows."""
DPI = 200
TITLE, LABEL, TEXT, FOOTER = 13.0, 10.5, 9.5, 7.5
"""Font sizes, points: 9.5 are 13 px in the README."""
LINE = 2.0
"""Width of a curve, points."""
MARGIN = 0.22
"""Empty border around everything, inches."""
HEADER, PANEL_NAME, FOOT = 0.86, 0.26, 1.06
"""Height of title with subtitle, of a panel's name, and of axis name with footer, inches."""
LEFT, BETWEEN, BELOW = 0.92, 0.86, 0.62
"""Room for an axis' labels at the left, between panels, and between rows of them, inches."""

Corner = Literal["upper left", "upper right", "lower left", "lower right", "best"]
"""Place of a legend; "best" covers the fewest points."""

MARKERS = ("o", "s", "D", "^", "v", "p", "h", "<", ">")
"""Marks that distinguish methods, in order."""

TIME_STEPS_MS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4, 6e4)
"""Labels of a time axis."""
FINE_TIME_STEPS_MS = tuple(
    round(step * 10**power, 3) for power in range(-1, 5) for step in (1, 1.5, 2, 3, 4, 5, 6, 8)
)
"""Labels of a short time axis."""
SHORT_TIME_AXIS = 12.0
"""A time axis is short when it ends below its start times this factor."""
SHARE_STEPS = (0, 20, 40, 60, 70, 80, 85, 90, 92, 94, 95, 96, 97, 98, 99, 99.5, 99.9)
"""Candidate labels of a stretched percent axis; labels that would touch are dropped."""


@dataclass(frozen=True)
class Provenance:
    """The origin of the figures of a chart, for its footer."""

    data: str
    """What was measured on, in words."""
    seed: int | None
    """Seed of all randomness; None where there is none."""
    frames: int
    """Number of cases behind each point."""
    each: str = "frame"
    """Name of one case, singular."""


def new_chart(
    title: str,
    subtitle: str,
    *,
    rows: int = 1,
    columns: int = 1,
    height: float = 5.2,
    below: float = 0.0,
) -> tuple[Figure, list[Axes]]:
    """Create a figure with a title and empty axes, row by row.

    Parameters
    ----------
    title
        Title, up to about 70 letters.
    subtitle
        What is drawn, in grey under the title.
    rows, columns
        Number of panels.
    height
        Height of the figure, inches; it is 8 inches wide.
    below
        Space between the panels and the footer for a legend, inches.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    left, top = MARGIN / WIDTH, 1 - MARGIN / height
    figure.text(left, top, title, size=TITLE, weight="bold", color=INK, va="top", ha="left")
    figure.text(left, top - 0.27 / height, subtitle, size=TEXT, color=FAINT, va="top", ha="left")
    axes = figure.subplots(rows, columns, squeeze=False)
    named = PANEL_NAME if axes.size > 1 else 0.0
    wide = (WIDTH - LEFT - MARGIN - (columns - 1) * BETWEEN) / columns
    high = (height - HEADER - named - FOOT - below - (rows - 1) * (BELOW + named)) / rows
    if high <= 0:
        raise InputError(f"{rows} rows of panels do not fit into {height} inches")
    figure.subplots_adjust(
        left=LEFT / WIDTH,
        right=1 - MARGIN / WIDTH,
        top=1 - (HEADER + named) / height,
        bottom=(FOOT + below) / height,
        wspace=BETWEEN / wide,
        hspace=(BELOW + named) / high,
    )
    panels: list[Axes] = list(axes.flat)
    for panel in panels:
        _bare(panel)
    return figure, panels


def label_axes(axes: Axes, x: str, y: str, *, panel: str = "") -> None:
    """Label both axes, each with its unit in brackets, and name the panel."""
    axes.set_xlabel(x, size=LABEL, color=INK, labelpad=6)
    axes.set_ylabel(y, size=LABEL, color=INK, labelpad=6)
    if panel:
        axes.set_title(panel, size=LABEL, color=INK, weight="bold", loc="left", pad=8)


def set_time_axis(axes: Axes, fastest_ms: float, slowest_ms: float) -> None:
    """Make x a logarithmic time axis from `fastest_ms` to `slowest_ms`, with readable labels."""
    _check_span("time axis", fastest_ms, slowest_ms)
    if fastest_ms <= 0:
        raise InputError(f"a logarithmic time axis must start above 0 ms, got {fastest_ms}")
    axes.set_xscale("log")
    axes.set_xlim(fastest_ms, slowest_ms)
    short = slowest_ms < SHORT_TIME_AXIS * fastest_ms
    steps = FINE_TIME_STEPS_MS if short else TIME_STEPS_MS
    ticks = [step for step in steps if fastest_ms <= step <= slowest_ms]
    axes.set_xticks(ticks, [format_time(step) for step in ticks])
    axes.set_xticks([], minor=True)


def set_percent_axis(
    axes: Axes,
    lowest: float,
    highest: float,
    *,
    stretched: bool = False,
    capped: tuple[float, str] | None = None,
) -> None:
    """Make y an axis in per cent from `lowest` to `highest`.

    A `stretched` axis is logarithmic in the error, 100 % minus the value. From 90 to 95 is as far
    as from 95 to 97.5, because each halves the error; good and bad methods then fit into one
    chart. Such an axis never reaches 100 %. `capped` is the level, in per cent, at which all
    better points are drawn, and the label of that level.
    """
    _check_span("share axis", lowest, highest)
    if not stretched:
        axes.set_ylim(lowest, highest)
        axes.yaxis.set_major_formatter("{x:g} %")
        return
    if highest >= 100:
        raise InputError(f"a stretched share axis must end below 100 %, got {highest}")
    import numpy as np

    axes.set_yscale(
        "function",
        functions=(
            lambda share: -np.log(np.maximum(100.0 - np.asarray(share), 1e-3)),
            lambda stretch: 100.0 - np.exp(-np.asarray(stretch)),
        ),
    )
    axes.set_ylim(lowest, highest)
    top, words = capped or (highest, "")
    labels = {s: f"{s:g} %" for s in SHARE_STEPS if lowest <= s <= min(top, highest)}
    labels |= {top: words} if capped else {}
    # From the top down: the level of the best points must keep its label.
    ticks = _spaced(list(labels), lowest, highest)
    axes.set_yticks(ticks, [labels[step] for step in ticks])
    axes.set_yticks([], minor=True)


def draw_curve(
    axes: Axes, x: Sequence[float], y: Sequence[float], name: str, number: int = 0
) -> None:
    """Draw a curve with its points in the colour of curve `number`; `name` is its legend entry."""
    axes.plot(
        x,
        y,
        color=COLOURS[number % len(COLOURS)],
        linewidth=LINE,
        marker="o",
        markersize=4.5,
        markeredgecolor="white",
        markeredgewidth=0.8,
        label=name,
        solid_joinstyle="round",
        clip_on=False,
        zorder=3 - 0.01 * number,
    )


def add_legend(axes: Axes, *, where: Corner = "lower left") -> None:
    """Add a legend of all named curves and points of the axes."""
    axes.legend(
        loc=where,
        fontsize=TEXT - 0.5,
        labelcolor=INK,
        frameon=True,
        framealpha=0.9,
        edgecolor="none",
        handlelength=1.6,
        borderpad=0.4,
    )


def add_footer(figure: Figure, made: Provenance) -> None:
    """Write data, seed, number of cases and machine into the footer."""
    height = figure.get_size_inches()[1]
    seed = "no randomness" if made.seed is None else f"seed {made.seed}"
    frames = f"{made.frames} {made.each}{'' if made.frames == 1 else 's'}"
    figure.text(
        MARGIN / WIDTH,
        0.14 / height,
        f"{made.data}; {frames}, {seed}\n{machine_line()}",
        size=FOOTER,
        color=FAINT,
        va="bottom",
        ha="left",
        linespacing=1.35,
    )


def write_chart(figure: Figure, path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the figure to `path` (.png), and its rows to the .csv file beside it.

    Columns are the keys of all rows in the order of their first occurrence; None is left empty.

    Raises
    ------
    InputError
        If `path` does not end in .png, there are no rows, or the folder cannot be written to.
    DeviceError
        If the disk fails.
    """
    if path.suffix != ".png":
        raise InputError(f"a chart must be a .png file, got {path}")
    if not rows:
        raise InputError(f"no rows to write beside {path}: a chart needs at least one row")
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=DPI, metadata={"Software": None})
    write_csv(path.with_suffix(".csv"), rows)


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows whose columns are all their keys, by first occurrence; None is left empty.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    DeviceError
        If the disk fails.
    """
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def format_time(milliseconds: float) -> str:
    """Format a time: ``0.5 ms``, ``20 ms``, ``2 s``, ``1 min``."""
    if milliseconds >= 60e3:
        return f"{milliseconds / 60e3:.3g} min"
    if milliseconds >= 1e3:
        return f"{milliseconds / 1e3:.3g} s"
    return f"{milliseconds:.3g} ms"


def _bare(axes: Axes) -> None:
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(GREY)
    axes.grid(True, color=RULE, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(which="both", length=0, labelsize=TEXT, labelcolor=INK, pad=5)


def _spaced(steps: list[float], lowest: float, highest: float) -> list[float]:
    """Drop labels that are closer than a line of text to the next one on a stretched axis."""
    import numpy as np

    span = np.log((100 - lowest) / (100 - highest))
    kept: list[float] = []
    for step in reversed(steps):
        if not kept or np.log((100 - step) / (100 - kept[-1])) > 0.055 * span:
            kept.append(step)
    return kept[::-1]


def _check_span(what: str, lowest: float, highest: float) -> None:
    if not -float("inf") < lowest < highest < float("inf"):
        raise InputError(
            f"a {what} must go from a lower to a higher value, got {lowest}, {highest}"
        )
