"""`eyehand experiment track`: hold a contact's position and pressure (Table 1, Fig. 8)."""

from __future__ import annotations

from functools import partial

from ..bench import (
    Experiment,
    ExperimentResult,
    TrialPlan,
    machine_line,
    result_table,
    write_csv,
)
from ..console import tracked
from .arm_rig import SensorName
from .cycle_time import cycle_times
from .track_picture import track_picture, track_points
from .track_trial import OBJECTS, track_once, track_rows
from .trial_arguments import TrialArguments, run_trials

SECONDS, QUICK_SECONDS = 20.0, 2.0
"""Length of the evaluated time series after convergence, s. The chapter takes 20 s."""
LANDING = 0.7
"""Time for landing and convergence, s."""


def experiment_track(arguments: TrialArguments | None = None) -> int:
    """Hold a contact's position and pressure on a pen, a toy box and a soft ball.

    An arm lands its pad beside the object's middle. The servo brings the contact to the middle of
    the pad and its pressure to 1 kPa, with the same settings for all objects. Prints Table 1 beside
    the chapter's values. Writes track.png, like Fig. 8, with track.csv, and table.csv. Runs 20
    trials of 20 s per object, as in the chapter, which takes 10 minutes; or 1 trial of 2 s with
    --quick.
    """
    return run_trials(TRACK, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    seconds = QUICK_SECONDS if plan.quick else SECONDS
    cases = [(name, plan.seed + k) for name in OBJECTS for k in range(plan.trials)]
    done = [
        track_once(name, seed, LANDING + seconds, sensor)
        for name, seed in tracked(cases, "trials", len(cases))
    ]
    rows = track_rows(done, seconds)
    times = cycle_times(plan.seed)
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("steady-state error", "{steady_state_error:.5f} ({paper_steady_state_error:.4f})"),
            ("standard deviation", "{standard_deviation:.4f} ({paper_standard_deviation:.3f})"),
            ("response time", "{response_time_s:.2f} s ({paper_response_time_s:.1f})"),
            ("slowest", "{slowest_response_s:.2f} s"),
            ("peak", "{peak:.2f}"),
            ("eq. (12)", "{eq12_pressure:.0f} Pa"),
            ("true error", "{true_error:.4f} px"),
        ],
        caption="in brackets: the chapter's Table 1; objects: as a share of the goal, 1 kPa; X, Y: "
        "in tactels; peak: highest pressure over the goal; eq. (12): mean pressure as printed, "
        "without the soft rim; true error: of the true centre of pressure"
        f"\ncalibration, features and servo: {times['servo_cycle_us']:.1f} µs "
        f"(chapter: 4000); simulated image: {times['image_us']:.0f} µs",
    )
    provenance = plan.provenance("pen, toy box, soft ball; 16 × 16 tactels, 250 cycles a second")
    return ExperimentResult(
        rows,
        table,
        track_picture(done, rows, provenance),
        track_points(done),
        files={"table.csv": partial(write_csv, rows=rows)},
        more={"seconds": seconds, "machine": machine_line(), **times},
    )


TRACK = Experiment("track", _measure, trials=20, quick_trials=1)
