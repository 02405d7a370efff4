"""`eyehand experiment force-closure`: grasp quality as a controlled task (section 2)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREEN, GREY, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .closure_objects import SHAPES
from .closure_trial import (
    LOAD,
    MAX_SLIP,
    METHODS,
    ClosureResult,
    ClosureTrial,
    draw_closure_trial,
    run_closure_trial,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

ALL = "all"
"""Name of the rows over all shapes."""
LABELS = {"off": "no task", "seen": "task, centre seen", "felt": "task, centre felt"}
"""Name of each method in table and chart."""
_COLOURS = {"off": GREY, "seen": GREEN, "felt": BLUE}


def experiment_force_closure(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Improve grasps after contact, by null-space motions of the arm.

    The hand grips a box, a cylinder, a bottle or a hammer up to 20 mm and 20° beside the best
    place. Then the pads slide along the object with little force: the palm moves the opposing axis
    to the centre of mass, at most 15 mm, and turns the row of fingers to the touched face, at most
    10°. Manipulability and the middle of the joint ranges come below these tasks. The centre of
    mass is the one that a camera would estimate from the shape, or the one that the wrist feels
    when it raises the object by 6 mm. Then the object is lifted, pulled down and shaken. Prints the
    remaining torque, the tilt while lifting and the share of objects kept, with and without the
    task. Writes force-closure.png and force-closure.csv.

    Parameters
    ----------
    trials
        Number of trials, >= 1; default: 40, or 4 with --quick.
    seed
        Trial k draws its object and its first grasp from seed + k.
    quick
        Run few trials, for a first look.
    out
        Output folder; default: out/experiment_force-closure.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    return run_experiment(FORCE_CLOSURE, trials=trials, seed=seed, quick=quick, out=out, json=json)


def _measure(plan: TrialPlan) -> ExperimentResult:
    trials = [(seed, draw_closure_trial(seed)) for seed in plan.seeds()]
    results = {
        method: [run_closure_trial(trial, method) for _, trial in trials] for method in METHODS
    }
    names = [shape.name for shape in SHAPES] + [ALL]
    rows = [
        _row(name, method, chosen)
        for name in names
        for method in METHODS
        if (
            chosen := [
                result
                for (_, trial), result in zip(trials, results[method], strict=True)
                if name in (trial.shape.name, ALL)
            ]
        )
    ]
    table = result_table(
        rows,
        [
            ("object", "{name}"),
            ("", "{label}"),
            ("centre off the axis", "{offset_mm:.1f} mm"),
            ("turn", "{turn_deg:.1f}°"),
            ("torque", "{torque_mnm:.0f} mNm"),
            ("margin", "{margin:.2f}"),
            ("tilt, 90 %", "{tilt_p90_deg:.1f}°"),
            ("lifted", "{lifted_pct:.0f} %"),
            ("kept", "{kept_pct:.0f} %"),
            ("time", "{seconds:.1f} s"),
            ("cycle", "{cycle_us:.0f} µs"),
        ],
        left=("",),
        caption="medians; torque: weight times distance from the axis; margin: share of the pads' "
        f"friction that is left; kept: below {1e3 * MAX_SLIP:.0f} mm of slide under {LOAD:g} times "
        "the weight and a shake",
    )
    points = [
        {
            "seed": seed,
            "object": trial.shape.name,
            "method": method,
            "mass_kg": round(trial.mass, 3),
            "friction": round(trial.friction, 3),
            "first_offset_mm": round(1e3 * trial.offset, 2),
            "first_turn_deg": round(float(np.degrees(trial.angle)), 2),
            "offset_mm": round(1e3 * result.offset, 2),
            "turn_deg": round(float(np.degrees(result.turn)), 2),
            "torque_mnm": round(1e3 * result.torque, 2),
            "tilt_deg": round(float(np.degrees(result.tilt)), 2),
            "kept": int(result.kept),
        }
        for method in METHODS
        for (seed, trial), result in zip(trials, results[method], strict=True)
    ]
    provenance = plan.provenance("simulated hand with tendons")
    return ExperimentResult(rows, table, _picture(trials, results, provenance), points)


FORCE_CLOSURE = Experiment("force-closure", _measure, trials=40, quick_trials=4)


def _row(name: str, method: str, results: Sequence[ClosureResult]) -> dict[str, Any]:
    def quantile(key: str, scale: float, share: float = 0.5) -> float | None:
        values = scale * np.array([getattr(result, key) for result in results])
        known = values[np.isfinite(values)]
        return float(np.quantile(known, share)) if len(known) else None

    degrees = float(np.degrees(1.0))
    return {
        "name": name,
        "method": method,
        "label": LABELS[method],
        "trials": len(results),
        "offset_mm": quantile("offset", 1e3),
        "turn_deg": quantile("turn", degrees),
        "torque_mnm": quantile("torque", 1e3),
        "margin": quantile("margin", 1.0),
        "tilt_deg": quantile("tilt", degrees),
        "tilt_p90_deg": quantile("tilt", degrees, 0.9),
        "lifted_pct": 100.0 * float(np.mean([result.lifted for result in results])),
        "kept_pct": 100.0 * float(np.mean([result.kept for result in results])),
        "seconds": quantile("seconds", 1.0),
        "cycle_us": quantile("cycle_us", 1.0),
    }


def _picture(
    trials: Sequence[tuple[int, ClosureTrial]],
    results: Mapping[str, Sequence[ClosureResult]],
    provenance: Provenance,
) -> Figure:
    figure, axes = new_chart(
        "Residual of the grasp at the lift, by that of the first grip",
        "left: torque about the opposing axis; right: tilt while lifting; crosses: lost",
        columns=2,
    )
    for method in METHODS:
        found = results[method]
        kept = np.array([result.kept for result in found])
        pairs = (
            ([1e3 * r.torque for r in results["off"]], [1e3 * r.torque for r in found]),
            ([np.degrees(abs(t.angle)) for _, t in trials], [np.degrees(r.tilt) for r in found]),
        )
        for panel, (before, after) in zip(axes, pairs, strict=True):
            x, y = np.array(before), np.array(after)
            panel.plot(
                x[kept], y[kept], "o", color=_COLOURS[method], markersize=4, label=LABELS[method]
            )
            panel.plot(x[~kept], y[~kept], "x", color=_COLOURS[method], markersize=6)
    label_axes(axes[0], "torque without the task, mNm", "torque, mNm")
    label_axes(axes[1], "turn of the first grasp, degrees", "tilt while lifting, degrees")
    axes[0].legend(frameon=False)
    add_footer(figure, provenance)
    return figure
