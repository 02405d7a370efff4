"""`eyehand experiment grip`: grip laws on the same objects and disturbances (section 3.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth.pad import SENSORS

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREEN, GREY, ORANGE, VERMILION, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from .grip_trials import (
    LAG,
    LAWS,
    LOST_SLIDE,
    MAX_PRESSURE,
    GripResult,
    draw_grip_trial,
    run_law,
)
from .slip_training import trained_score
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from .arm_rig import SensorName

BOUND = "all-knowing"
"""The law that the others are judged against."""
DETECTOR = "with a shear array"
"""Detector of the alarms."""
TRAINING, QUICK_TRAINING = 60, 6
"""Trials of each event that train the detector."""
TRAINING_SEED = 8000
"""Seed of the detector's training: all runs have the same detector."""
_COLOURS = {
    "chapter": VERMILION,
    "pull + wrist": BLUE,
    "pull + lever": GREEN,
    "pull + shear": ORANGE,
}


def experiment_grip(arguments: TrialArguments | None = None) -> int:
    """Hold unknown objects with little force, while load is added and the hand shakes.

    Each object is grasped with 12 N on a table and lifted. Some laws estimate its friction on the
    way, by a small pull with eased grip. Then up to its weight is added within 10 to 60 ms, and the
    hand accelerates by up to 0.4 g. The laws: constant force; the chapter's, which decays and rises
    by 25 % at slip; the pull with the load from a force sensor in the wrist, from the shift of the
    centre of pressure, or from a shear array; and one that knows load and friction. All alarms come
    from a slip detector with a shear array, which is trained first on objects of other kinds.
    Prints the share of objects kept and the grip force over the least one. Writes grip.png and
    grip.csv. Runs 500 trials, or 10 with --quick.
    """
    return run_trials(GRIP, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    count = QUICK_TRAINING if plan.quick else TRAINING
    trained = trained_score(DETECTOR, count, TRAINING_SEED, SENSORS[sensor], MAX_PRESSURE)
    results: dict[str, list[GripResult]] = {law: [] for law in LAWS}
    for seed in plan.seeds():
        trial = draw_grip_trial(seed)
        for law in LAWS:
            results[law].append(run_law(law, trial, seed, SENSORS[sensor], trained))
    rows = [_row(law, results[law], results[BOUND]) for law in LAWS]
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("kept", "{kept_pct:.1f} %"),
            ("of those the all-knowing law keeps", "{kept_of_bound_pct:.1f} %"),
            ("force over the least", "{force_ratio:.2f}"),
            ("90 %", "{force_ratio_p90:.2f}"),
            ("slide, 90 %", "{slide_p90_mm:.2f} mm"),
            ("friction", "{friction_ratio:.2f} ({friction_low:.2f} to {friction_high:.2f})"),
        ],
        caption=f"lost: more than {1e3 * LOST_SLIDE:.0f} mm of slide after the lift; least force: "
        "load over sliding friction; friction: estimated over true sliding friction at the end, "
        f"median and middle half (static friction: 1.2); actuator lag {1e3 * LAG:.0f} ms",
    )
    provenance = plan.provenance(f"two pads of 20 kPa, sensor {sensor}")
    points = [
        {
            "trial": number,
            "law": law,
            "lost": int(result.lost),
            "slide_mm": round(1e3 * result.slide, 4),
            "force_ratio": round(result.force_ratio, 4),
        }
        for law in LAWS
        for number, result in enumerate(results[law])
    ]
    return ExperimentResult(rows, table, _picture(results, rows, provenance), points)


GRIP = Experiment("grip", _measure, trials=500, quick_trials=10)


def _row(law: str, results: Sequence[GripResult], bound: Sequence[GripResult]) -> dict[str, Any]:
    kept = np.array([not result.lost for result in results])
    possible = np.array([not result.lost for result in bound])
    ratios = [result.force_ratio for result in results]
    row: dict[str, Any] = {
        "name": law,
        "kept_pct": 100 * float(kept.mean()),
        "kept_of_bound_pct": 100 * float(kept[possible].mean()) if possible.any() else None,
        "force_ratio": float(np.median(ratios)),
        "force_ratio_p90": float(np.quantile(ratios, 0.9)),
        "slide_p90_mm": 1e3 * float(np.quantile([result.slide for result in results], 0.9)),
    }
    frictions = [result.friction for result in results if result.friction is not None]
    if frictions:
        low, middle, high = np.quantile(frictions, (0.25, 0.5, 0.75))
        row |= {
            "friction_ratio": float(middle),
            "friction_low": float(low),
            "friction_high": float(high),
        }
    return row


def _picture(
    results: Mapping[str, Sequence[GripResult]],
    rows: Sequence[Mapping[str, Any]],
    provenance: Provenance,
) -> Figure:
    figure, axes = new_chart(
        "Grip force over the least force, of each trial",
        "shares of objects kept in brackets; ticks: medians",
        height=4.6,
    )
    panel = axes[0]
    rng = np.random.default_rng(0)
    for place, (law, row) in enumerate(zip(LAWS, rows, strict=True)):
        ratios = np.array([result.force_ratio for result in results[law]])
        lost = np.array([result.lost for result in results[law]])
        heights = place + rng.uniform(-0.25, 0.25, len(ratios))
        colour = _COLOURS.get(law, GREY)
        panel.plot(ratios[~lost], heights[~lost], "o", color=colour, markersize=4, alpha=0.6)
        panel.plot(ratios[lost], heights[lost], "x", color=colour, markersize=6)
        panel.plot(2 * [row["force_ratio"]], [place - 0.38, place + 0.38], color=colour)
        # Labels of the axis would be cut off at the border of the picture.
        label = f"{law} ({row['kept_pct']:.0f} %)"
        panel.text(0.0, place - 0.42, label, transform=panel.get_yaxis_transform())
    panel.axvline(1.0, color=GREY, linewidth=1.0)
    panel.set_xscale("log")
    panel.set_xticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    panel.set_yticks([])
    panel.set_ylim(len(rows) - 0.5, -0.8)
    label_axes(panel, "mean grip force over the least one; crosses: lost", "")
    add_footer(figure, provenance)
    return figure
