"""`eyehand experiment fig1`: the chapter's Fig. 1, computed and drawn."""

from __future__ import annotations

from pathlib import Path

from ..bench import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .fig1_picture import fig1_picture
from .fig1_run import DEFAULT, fig1_faults, fig1_rows, fig1_scene, run_fig1


def experiment_fig1(*, out: Path = Path("out/experiment_fig1"), json: bool = False) -> int:
    """Draw how the weight of obstacle avoidance changes the path of a hand.

    A planar arm with 4 joints moves its hand past a pole to a goal beside a wall. Without
    avoidance in task space, the path is straight and passes close to the pole. With a fixed
    weight, the hand keeps its distance but misses the goal. With the dynamic weight, it keeps its
    distance and reaches the goal. All runs use the same scene and the same options; only the
    weight differs. The last row has the safety level on. The exit code is 1 if these statements
    do not hold. Writes experiment_fig1.png and experiment_fig1.csv.

    Parameters
    ----------
    out
        Output folder.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    return run_experiment(FIG1, seed=None, out=out, json=json)


def _measure(_plan: TrialPlan) -> ExperimentResult:
    runs = run_fig1()
    rows = fig1_rows(runs)
    names = {DEFAULT: "dynamic, safety level on"}
    table = result_table(
        [{**row, "name": names.get(row["name"], row["name"])} for row in rows],
        [
            ("avoidance", "{name}"),
            ("mid-course, mm", "{midcourse_clearance_mm:.1f}"),
            ("closest, mm", "{closest_mm:.1f}"),
            ("final error, mm", "{final_error_mm:.3f}"),
            ("status", "{status}"),
        ],
        title="clearance and final error of a hand that passes a pole to a goal beside a wall",
        left=("status",),
    )
    return ExperimentResult(
        rows, table, fig1_picture(fig1_scene(), runs), broken_bounds=fig1_faults(runs)
    )


FIG1 = Experiment("fig1", _measure, file_stem="experiment_fig1")
