"""`eyehand experiment roll`: roll a tilted pad flat onto a face, and follow the face (Fig. 9)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREEN, GREY, RULE, VERMILION, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from .roll_trial import DISPLACED, DISPLACING, PRESSURE, SECONDS, RollTrial, roll_once, roll_row
from .servo_run import lasting
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from .arm_rig import SensorName


def experiment_roll(arguments: TrialArguments | None = None) -> int:
    """Land on a face tilted by 6°, roll the pad flat, and follow the face when it turns by 12°.

    Times count until the true tilt stays below 1°. Writes roll.png, like Fig. 9, and roll.csv. Runs
    20 trials, or 1 with --quick.
    """
    return run_trials(ROLL, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    done = [roll_once(seed, sensor) for seed in plan.seeds()]
    lasted, counts = lasting(done)
    row = roll_row(lasted) | counts
    lines = [
        {
            "name": name,
            "time_s": row[f"time_{key}_s"],
            "slowest_s": row[f"slowest_{key}_s"],
            "tilt_deg": row[tilt],
        }
        for name, key, tilt in (
            ("landing at 6°", "to_flat", "settled_tilt_deg"),
            ("face turned by 12°", "to_flat_again", "settled_tilt_again_deg"),
        )
    ]
    table = result_table(
        lines,
        [
            ("", "{name}"),
            ("below 1° after", "{time_s:.3f} s"),
            ("slowest", "{slowest_s:.3f} s"),
            ("remaining tilt, maximum", "{tilt_deg:.2f}°"),
        ],
        caption=f"contacts lost: {row['contact_losses']} of {row['trials']} landings; ended early, "
        f"and not in the figures: {row['ended_early']} {row['outcomes']}; "
        "chapter (Fig. 9): flat after 4 s",
    )
    provenance = plan.provenance("rigid face 60 × 60 mm, simulated arm and pad")
    return ExperimentResult([row], table, _picture(lasted, row, provenance), _points(lasted[0]))


ROLL = Experiment("roll", _measure, unit="landing", trials=20, quick_trials=1)


def _picture(trials: Sequence[RollTrial], row: Mapping[str, Any], provenance: Provenance) -> Figure:
    figure, panels = new_chart(
        f"A pad that lands tilted is flat after {row['slowest_to_flat_s']:.2f} s at most",
        "grey: the goals, and tilts below 1°; from 1.2 s the face turns by 12° the other way, "
        "within 0.4 s",
        rows=3,
        height=8.2,
    )
    names = ("Tilt of pad against face", "Centre of pressure along the lean", "Pressure")
    units = ("[°]", "[mm]", "[kPa]")
    goals = (0.0, 0.0, 1.0)
    for number, (axes, name, unit, goal, colour) in enumerate(
        zip(panels, names, units, goals, (VERMILION, BLUE, GREEN), strict=True)
    ):
        for first, trial in reversed([(k == 0, trial) for k, trial in enumerate(trials)]):
            values = (
                np.degrees(trial.tilt),
                1e3 * trial.across,
                trial.run.averaged / PRESSURE,
            )[number]
            axes.plot(
                trial.run.time,
                values,
                color=colour,
                linewidth=2.0 if first else 0.8,
                alpha=1.0 if first else 0.3,
            )
        axes.axvspan(DISPLACED, DISPLACED + DISPLACING, color=RULE, alpha=0.6, zorder=0, lw=0)
        axes.axhline(goal, color=GREY, linewidth=1.0, zorder=1)
        axes.set_xlim(0.0, SECONDS)
        label_axes(axes, "time since the landing [s]" if number == 2 else "", unit, panel=name)
    panels[0].axhspan(-1, 1, color=RULE, alpha=0.6, zorder=0, lw=0)
    add_footer(figure, provenance)
    return figure


def _points(trial: RollTrial) -> list[dict[str, Any]]:
    run = trial.run
    return [
        {
            "time_s": round(float(run.time[k]), 4),
            "tilt_deg": round(float(np.degrees(trial.tilt[k])), 4),
            "across_mm": round(1e3 * float(trial.across[k]), 4),
            "pressure_kpa": round(1e-3 * float(run.averaged[k]), 5),
            "area_mm2": round(1e6 * float(run.area[k]), 1),
            "force_n": round(float(run.force[k]), 5),
        }
        for k in range(0, len(run.time), 2)
    ]
