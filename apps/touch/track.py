"""`eyehand experiment track`: hold a contact's position and pressure (Table 1, Fig. 8)."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..bench import (
    Experiment,
    ExperimentResult,
    machine_line,
    result_table,
    run_experiment,
    write_csv,
)
from ..console import tracked
from .cycle_time import cycle_times
from .track_picture import track_picture, track_points
from .track_trial import OBJECTS, track_once, track_rows

if TYPE_CHECKING:
    from ..bench import TrialPlan

SECONDS, QUICK_SECONDS = 20.0, 2.0
"""Length of the judged time series from convergence on, s. The chapter takes 20 s."""
LANDING = 0.7
"""Time for landing and convergence, s."""


def experiment_track(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_track"),
    json: bool = False,
) -> int:
    """Hold a contact's position and pressure on a pen, a toy box and a soft ball.

    An arm lands its pad beside the object's middle. The servo brings the contact to the middle of
    the pad and its pressure to 1 kPa, with the same settings for all objects. Prints Table 1
    beside the chapter's values. Writes track.png, like Fig. 8, with track.csv, and table.csv.

    Parameters
    ----------
    trials
        Number of trials per object, >= 1. Default: 20, as in the chapter; they take 10 minutes.
    seed
        Trial k draws electronics, noise and the object's place from seed + k.
    quick
        1 trial of 2 s instead of 20 s, for a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    return run_experiment(TRACK, trials=trials, seed=seed, quick=quick, out=out, json=json)


def _measure(plan: TrialPlan) -> ExperimentResult:
    seconds = QUICK_SECONDS if plan.quick else SECONDS
    cases = [(name, plan.seed + k) for name in OBJECTS for k in range(plan.trials)]
    done = [
        track_once(name, seed, LANDING + seconds)
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
        ],
        caption="in brackets: the chapter's Table 1; objects: as a share of the goal, 1 kPa; X, Y: "
        f"in tactels\ncalibration, features and servo: {times['servo_cycle_us']:.1f} µs "
        f"(chapter: 4000); simulated image: {times['image_us']:.0f} µs",
    )
    made = plan.provenance("pen, toy box, soft ball; 16 × 16 tactels, 250 cycles a second")
    return ExperimentResult(
        rows,
        table,
        track_picture(done, rows, made),
        track_points(done),
        files={"table.csv": partial(write_csv, rows=rows)},
        more={"seconds": seconds, "machine": machine_line(), **times},
    )


TRACK = Experiment("track", _measure, trials=20, quick_trials=1)
