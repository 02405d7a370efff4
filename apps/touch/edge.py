"""`eyehand experiment edge`: turn the pad with an object's edge (section 4.3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREY, INK, LINE, VERMILION, add_legend, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from .arm_rig import SensorName
from .edge_run import ALIGN_SECONDS, DONE, EdgeRun, edge_row, mean_row, run_edge
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 5.0
"""Height of the figure, inches."""


def experiment_edge(arguments: TrialArguments | None = None) -> int:
    """Align the pad with an object's edge, and keep it aligned while the edge turns.

    The arm lands the pad on an edge that lies up to 60° off the pad's y-axis. The servo controls
    only pressure and rotation. It aligns the pad with the edge. Then the edge turns to and fro by
    40°. The chapter shows this in its video only. A trial that the servo ends early is a row with
    its outcome, and does not enter the means. Writes edge.png and edge.csv. Runs 10 trials, or 2
    with --quick.
    """
    return run_trials(EDGE, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    runs = [run_edge(seed, sensor) for seed in plan.seeds()]
    rows = [edge_row(run) for run in runs]
    rows.append(mean_row(rows))
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("at touch", "{start_deg:.1f}°"),
            ("response", "{response_time_s:.2f} s"),
            ("at rest", "{steady_state_error_deg:.3f} ± {standard_deviation_deg:.3f}°"),
            ("turning", "{turning_rms_deg:.2f}°"),
            ("delay", "{delay_ms:.0f} ms"),
            ("force", "{force_mean_n:.3f} ± {force_std_n:.3f} N"),
            ("outcome", "{outcome}"),
        ],
        title="angle between the pad and an edge; the chapter shows this in its video only",
        caption="response: time to a tenth of the angle at touch; at rest: mean and standard "
        "deviation of the error; turning: rms error while the edge turns; delay: of the pad behind "
        "the edge",
    )
    return ExperimentResult(rows, table, edge_picture(runs, plan.seed))


EDGE = Experiment("edge", _measure, trials=10, quick_trials=2)


def edge_picture(runs: Sequence[EdgeRun], seed: int) -> Figure:
    """Draw the alignment of all trials, and one pad that follows the turning edge."""
    figure, (left, right) = new_chart(
        "The pad turns with an object's edge",
        "only pressure and rotation are controlled, P = diag(0, 0, 1, 0, 0, 1); true angles",
        columns=2,
        height=HEIGHT,
    )
    for number, run in enumerate(runs):
        early = (run.times >= run.landing) & (run.times < ALIGN_SECONDS)
        left.plot(
            run.times[early] - run.landing,
            run.errors_deg[early],
            color=BLUE,
            linewidth=1.4,
            alpha=0.8,
            label=None if number else "each trial",
        )
    left.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
    label_axes(left, "time since touch [s]", "angle of pad to edge [°]", panel="Alignment")
    add_legend(left, where="lower right")
    run = next((run for run in runs if run.outcome == DONE), None)
    if run is not None:
        _draw_turning(right, run)
    label_axes(right, "time [s]", "direction [°]", panel="The edge turns")
    add_footer(
        figure,
        Provenance("box edge on the simulated 16 × 16 pad and arm", seed, len(runs), "trial"),
    )
    return figure


def _draw_turning(panel: Axes, run: EdgeRun) -> None:
    late = run.times >= ALIGN_SECONDS
    times = run.times[late] - ALIGN_SECONDS
    edge = run.edge_deg[late] - run.edge_deg[late][0]
    panel.plot(times, edge, color=INK, linewidth=1.2, linestyle=(0, (4, 3)), label="edge", zorder=4)
    panel.plot(times, edge + run.errors_deg[late], color=VERMILION, linewidth=LINE, label="pad")
    panel.set_ylim(top=1.35 * float(np.abs(edge).max()))
    add_legend(panel, where="upper right")
