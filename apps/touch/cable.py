"""`eyehand experiment cable`: follow cables of unknown shape (section 4.4, Fig. 10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, FAINT, GREY, LINE, TEXT, VERMILION, add_legend, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from ..console import tracked
from .arm_rig import SensorName
from .cable_run import SETTLING, CableRun, cable_row, run_cable, speed_row
from .cable_shapes import CABLE_RADIUS
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

WANTED_MM = {0.05: 0.5, 0.2: 1.3}
"""Speed along the cable, m/s → rms error that the path should stay below, mm."""

HEIGHT = 6.2
"""Height of the figure, inches."""
SHEATH, SHINE = "#3A3F47", "#6B727D"
"""Colours of the cable and of its highlight."""
TABLE = "#F4EFE6"
"""Colour of the table."""
SPEED_COLOURS = (BLUE, VERMILION)
"""Colours of the slow and the fast run. The slow run is the chapter's blue line."""


def experiment_cable(arguments: TrialArguments | None = None) -> int:
    """Follow cables of unknown shape along a table, at 50 and at 200 mm/s.

    Each pad that is not ideal first presses a flat plate once, because the gains of its tactels
    have changed since the bench. The pad lands beside the cable's middle line and not quite
    parallel to it, presses with 2 N, and follows the cable to its end. The path of the pad, from
    the arm's joints, is compared with the cable's true middle line. The chapter shows a photograph
    (Fig. 10). Writes cable.png, which shows the first cable, and cable.csv. Runs 5 cables, or 1
    with --quick.
    """
    return run_trials(CABLE, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    cases = [(plan.seed + k, speed) for speed in WANTED_MM for k in range(plan.trials)]
    runs = [run_cable(seed, speed, sensor) for seed, speed in tracked(cases, "cables", len(cases))]
    rows = [cable_row(run) for run in runs]
    for speed, wanted in WANTED_MM.items():
        summary = speed_row([run for run in runs if run.speed == speed])
        rows.append({**summary, "wanted_rms_mm": wanted})
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("speed", "{speed_mm_s:.0f} mm/s"),
            ("rms", "{path_rms_mm:.3f} mm"),
            ("maximum", "{path_max_mm:.3f} mm"),
            ("wanted rms", "{wanted_rms_mm:g} mm"),
            ("followed", "{followed_pct:.1f} %"),
            ("force", "{force_mean_n:.2f} ± {force_std_n:.2f} N"),
            ("end", "{outcome}"),
        ],
        title="path error of a pad that follows a cable; the chapter shows a photograph (Fig. 10)",
        caption="error: distance of the pad's middle from the cable's middle line, from 0.3 s "
        "after touch to the cable's end; followed: share of the cable ahead of the landing",
    )
    # The runs of the first cable with readings, one per speed.
    seed = next(run.seed for run in runs if len(run.errors))
    shown = [run for run in runs if run.seed == seed and len(run.errors)]
    picture = cable_picture(shown, plan.seed, plan.trials)
    return ExperimentResult(rows, table, picture)


CABLE = Experiment("cable", _measure, unit="cable", trials=5, quick_trials=1)


def cable_picture(runs: Sequence[CableRun], seed: int, cables: int) -> Figure:
    """Plot the runs over one cable, one per speed.

    Parameters
    ----------
    runs
        Runs over the same cable.
    seed, cables
        Random seed and number of cables of the whole experiment, for the footer.
    """
    figure, (above, below) = new_chart(
        "Following a cable of unknown shape by touch",
        "the true cable, the pad's path from the arm's forward kinematics, and the path error",
        rows=2,
        height=HEIGHT,
    )
    _map(above, runs)
    for number, run in enumerate(runs):
        below.plot(
            1e3 * run.length,
            1e3 * run.errors,
            color=SPEED_COLOURS[number % 2],
            linewidth=1.6,
            label=f"{1e3 * run.speed:.0f} mm/s: {1e3 * run.rms:.2f} mm rms",
            zorder=4 - number,
        )
    below.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
    reach = max(0.5, 1.5e3 * max(float(np.abs(run.errors).max()) for run in runs))
    below.set_ylim(-reach, reach)
    below.set_xlim(left=0.0)
    label_axes(below, "distance along the cable [mm]", "lateral error [mm]", panel="Error")
    add_legend(below, where="lower right")
    add_footer(
        figure,
        Provenance("cables of 6 mm, simulated 16 × 16 pad and arm", seed, cables, "cable"),
    )
    return figure


def _map(axes: Axes, runs: Sequence[CableRun]) -> None:
    shape = runs[0].shape
    axes.set_facecolor(TABLE)
    axes.grid(False)
    for radius, colour in ((CABLE_RADIUS, SHEATH), (0.25 * CABLE_RADIUS, SHINE)):
        outline = _outline(shape.line, radius)
        axes.fill(*_plot_coordinates(outline), color=colour, linewidth=0, zorder=2)
    for number, run in enumerate(runs):
        x, y = _plot_coordinates(run.path)
        colour = SPEED_COLOURS[number % 2]
        slow = number == 0
        axes.plot(
            x,
            y,
            color=colour,
            linewidth=LINE if slow else 1.2,
            linestyle="-" if slow else (0, (4, 4)),
            solid_capstyle="round",
            zorder=3 + number,
        )
        if slow:
            axes.plot(
                x[0], y[0], "o", color=colour, markersize=7, markeredgecolor="white", zorder=6
            )
            axes.annotate(
                f"{SETTLING:g} s after touch",
                (x[0], y[0]),
                xytext=(0, 12),
                textcoords="offset points",
                ha="center",
                size=TEXT,
                color=FAINT,
                zorder=6,
            )
    axes.set_aspect("equal", adjustable="datalim")
    low, high = _plot_coordinates(shape.line)[0].min(), _plot_coordinates(shape.line)[0].max()
    axes.set_xlim(low - 15.0, high + 15.0)
    label_axes(axes, "along the table [mm]", "across [mm]", panel="Path")


def _plot_coordinates(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return plot coordinates (right, up), mm. The cable runs from left to right."""
    return 1e3 * points[:, 1], -1e3 * points[:, 0]


def _outline(line: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    steps = np.gradient(line, axis=0)
    along = steps / np.linalg.norm(steps, axis=1)[:, None]
    across = radius * np.column_stack([-along[:, 1], along[:, 0]])
    turn = np.linspace(np.pi / 2, -np.pi / 2, 13)[1:-1, None]
    cap = line[-1] + radius * (np.cos(turn) * along[-1] + np.sin(turn) * across[-1] / radius)
    butt = line[0] - radius * (np.cos(turn) * along[0] + np.sin(turn) * across[0] / radius)
    return np.concatenate([line + across, cap, (line - across)[::-1], butt])
