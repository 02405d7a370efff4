"""`eyehand experiment cable`: follow cables of unknown shape (section 4.4, Fig. 10)."""

from __future__ import annotations

from ..bench import Experiment, ExperimentResult, TrialPlan, result_table
from ..console import tracked
from .arm_rig import SensorName
from .cable_picture import cable_picture
from .cable_run import cable_row, run_cable, speed_row
from .trial_arguments import TrialArguments, run_trials

WANTED_MM = {0.05: 0.5, 0.2: 1.3}
"""Speed along the cable, m/s → rms error that the path should stay below, mm."""


def experiment_cable(arguments: TrialArguments | None = None) -> int:
    """Follow cables of unknown shape along a table, at 50 and at 200 mm/s.

    The pad lands beside the cable's middle line and not quite parallel to it, presses with 2 N, and
    follows the cable to its end. The path of the pad, from the arm's joints, is compared with the
    cable's true middle line. The chapter shows a photograph (Fig. 10). Writes cable.png, which
    shows the first cable, and cable.csv. Runs 5 cables, or 1 with --quick.
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
    # The runs of the first cable, one per speed.
    picture = cable_picture(runs[:: plan.trials], plan.seed, plan.trials)
    return ExperimentResult(rows, table, picture)


CABLE = Experiment("cable", _measure, unit="cable", trials=5, quick_trials=1)
