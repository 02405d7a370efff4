"""`eyehand experiment track`: hold a contact's position and pressure (Table 1, Fig. 8)."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import PlacedObject, pad_scene, toy_box
from eyehand.tactile import ServoGoal, TactileServo, TouchPhases

from ..bench import Provenance, add_footer, machine_line, new_chart, write_csv
from ..bench.chart_style import BLUE, GREEN, GREY, INK, RULE, VERMILION, add_legend, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from ..console import tracked
from .arm_rig import CYCLE, ArmRig, SensorName, home_pose
from .servo_run import run_servo
from .track_trial import OBJECTS, PIXEL, PRESSURE, TrackTrial, track_once, track_rows
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

SECONDS, QUICK_SECONDS = 20.0, 2.0
"""Length of the evaluated time series after convergence, s. The chapter takes 20 s."""
LANDING = 0.7
"""Time for landing and convergence, s."""

CYCLES = 2000
"""Number of calls that are timed one by one. The result is their median."""
SETTLE = 0.5
"""Servo time before the measurement, s. Kernels are compiled and a contact exists after it."""

SHOWN = 1.2
"""Plotted time after the landing, s. The curves are constant after it."""
HEIGHT = 6.6
"""Height of the figure, inches."""
POINTS = 4
"""Number of cycles between two rows of the table."""
COLOURS = {"Rigid pen": VERMILION, "Toy box": BLUE, "Soft ball": GREEN}


def experiment_track(arguments: TrialArguments | None = None) -> int:
    """Hold a contact's position and pressure on a pen, a toy box and a soft ball.

    An arm lands its pad beside the object's middle. The servo brings the contact to the middle of
    the pad and its pressure to 1 kPa, with the same settings for all objects. Prints Table 1 beside
    the chapter's values. Trials that the servo ends early enter only the peak. Writes track.png,
    like Fig. 8, with track.csv, and table.csv. Runs 20 trials of 20 s per object, as in the
    chapter, which takes 10 minutes; or 1 trial of 2 s with --quick.
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
            ("held", "{converged} of {trials}"),
            ("ended early", "{ended_early} {outcomes}"),
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


def cycle_times(seed: int) -> dict[str, float]:
    """Measure the computing time of one cycle on a toy box.

    Returns
    -------
    dict
        `servo_cycle_us`: time of calibration, features and servo. `image_us`: time of the
        simulated image and its electronics. Both are medians in µs, called from Python.
    """
    place = home_pose().apply([0.002, 0.001, 0.001])
    placed = PlacedObject(toy_box(), RigidTransform.from_translation(place))
    rig = ArmRig(pad_scene((placed,)), seed=seed)
    servo = TactileServo(ServoGoal(pressure=1000.0))
    run_servo(rig, TouchPhases(servo), SETTLE)
    pad, reader, twist = rig.simulation.pads[0], rig.hand.reader, rig.hand.twist
    rng = np.random.default_rng(seed)
    raws = [pad.read(rng) for _ in range(32)]
    turn = iter(range(CYCLES + 1))

    def cycle() -> None:
        servo.step(reader.read(raws[next(turn) % len(raws)]), CYCLE, None, twist)

    def image() -> None:
        pad.contact()
        pad.read(rng)

    return {"servo_cycle_us": _median_us(cycle), "image_us": _median_us(image)}


def _median_us(call: Callable[[], None]) -> float:
    times = np.empty(CYCLES)
    for k in range(CYCLES):
        start = time.perf_counter_ns()
        call()
        times[k] = time.perf_counter_ns() - start
    return round(1e-3 * float(np.median(times)), 2)


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
    provenance
        Source of the figure for the footer.
    """
    slowest = max(row["response_time_s"] for row in rows)
    figure, (above, below) = new_chart(
        f"Position and pressure converge within {slowest:.2f} s in the mean",
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
