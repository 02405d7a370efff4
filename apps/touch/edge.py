"""`eyehand experiment edge`: turn the pad with an object's edge (section 4.3)."""

from __future__ import annotations

from ..bench import Experiment, ExperimentResult, TrialPlan, result_table
from .arm_rig import SensorName
from .edge_picture import edge_picture
from .edge_run import edge_row, mean_row, run_edge
from .trial_arguments import TrialArguments, run_trials


def experiment_edge(arguments: TrialArguments | None = None) -> int:
    """Align the pad with an object's edge, and keep it aligned while the edge turns.

    The arm lands the pad on an edge that lies up to 60° off the pad's y-axis. The servo controls
    only pressure and rotation. It aligns the pad with the edge. Then the edge turns to and fro by
    40°. The chapter shows this in its video only. Writes edge.png and edge.csv. Runs 10 trials, or
    2 with --quick.
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
        ],
        title="angle between the pad and an edge; the chapter shows this in its video only",
        caption="response: time to a tenth of the angle at touch; at rest: mean and standard "
        "deviation of the error; turning: rms error while the edge turns; delay: of the pad behind "
        "the edge",
    )
    return ExperimentResult(rows, table, edge_picture(runs, plan.seed))


EDGE = Experiment("edge", _measure, trials=10, quick_trials=2)
