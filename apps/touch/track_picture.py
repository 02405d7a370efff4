"""Figure of the tracking trials, after the chapter's Fig. 8: position above, pressure below."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREEN, GREY, INK, RULE, VERMILION, add_legend, label_axes
from .track_trial import OBJECTS, PIXEL, PRESSURE, TrackTrial

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure


SHOWN = 1.2
"""Plotted time after the landing, s. The curves are constant after it."""
HEIGHT = 6.6
"""Height of the figure, inches."""
POINTS = 4
"""Number of cycles between two rows of the table."""
COLOURS = {"Rigid pen": VERMILION, "Toy box": BLUE, "Soft ball": GREEN}


def track_picture(
    trials: Sequence[TrackTrial], rows: Sequence[dict[str, Any]], provenance: Provenance
) -> Figure:
    """Plot the first trial of each object over time.

    Parameters
    ----------
    trials
        Trials of all objects.
    rows
        Rows of Table 1, for the response times.
    made
        Source of the figure for the footer.
    """
    figure, (above, below) = new_chart(
        "Position and pressure converge in a third of a second",
        "one servo setting; simulated arm and pad; grey: within 5 % of the goal; dots: mean "
        "response time",
        rows=2,
        height=HEIGHT,
    )
    for trial in first_trials(trials):
        run, colour = trial.run, COLOURS[trial.name]
        shown = run.time <= SHOWN
        for axis, style in ((0, "-"), (1, (0, (4, 1.6)))):
            above.plot(
                run.time[shown],
                run.centre[shown, axis] / PIXEL,
                color=colour,
                linestyle=style,
                linewidth=1.8,
                label=f"{trial.name}, {'xy'[axis]}",
            )
        below.plot(run.time[shown], run.pressure[shown] / PRESSURE, color=colour, alpha=0.25, lw=1)
        below.plot(
            run.time[shown], run.averaged[shown] / PRESSURE, color=colour, lw=2, label=trial.name
        )
        response = next(row["response_time_s"] for row in rows if row["name"] == trial.name)
        value = float(np.interp(response, run.time, run.averaged)) / PRESSURE
        below.plot(response, value, "o", color=colour, markersize=7, markeredgecolor="white")
    above.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
    below.axhspan(0.95, 1.05, color=RULE, zorder=0)
    below.axhline(1.0, color=GREY, linewidth=1.0, zorder=1)
    for axes in (above, below):
        axes.set_xlim(0.0, SHOWN)
    label_axes(above, "time since the landing [s]", "offset [pixel]", panel="Contact position")
    label_axes(below, "time since the landing [s]", "pressure [kPa]", panel="Pressure")
    above.legend(
        loc="lower right", ncols=3, fontsize=9, labelcolor=INK, framealpha=0.9, edgecolor="none"
    )
    add_legend(below, where="lower right")
    add_footer(figure, provenance)
    return figure


def first_trials(trials: Sequence[TrackTrial]) -> list[TrackTrial]:
    """Return the first trial of each object."""
    return [next(t for t in trials if t.name == name) for name in OBJECTS]


def track_points(trials: Sequence[TrackTrial]) -> list[dict[str, Any]]:
    """Return the plotted data as table rows."""
    points = []
    for trial in first_trials(trials):
        run = trial.run
        for k in range(0, int(np.sum(run.time <= SHOWN)), POINTS):
            points.append(
                {
                    "name": trial.name,
                    "time_s": round(float(run.time[k]), 4),
                    "x_px": round(float(run.centre[k, 0]) / PIXEL, 5),
                    "y_px": round(float(run.centre[k, 1]) / PIXEL, 5),
                    "pressure_kpa": round(1e-3 * float(run.pressure[k]), 5),
                    "averaged_kpa": round(1e-3 * float(run.averaged[k]), 5),
                    "force_n": round(float(run.force[k]), 5),
                }
            )
    return points
