"""`eyehand experiment cop`: the centre of pressure of a thin probe between tactels (Fig. 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import (
    Experiment,
    ExperimentResult,
    Provenance,
    TrialPlan,
    add_footer,
    new_chart,
    result_table,
)
from ..bench.chart_style import BLUE, GREY, INK, LINE, VERMILION, add_legend, label_axes
from .probe_path import ProbePath, follow_probe
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from .arm_rig import SensorName

POINTS = 51
"""Number of points along each path that the chart and its CSV file show."""


def experiment_cop(arguments: TrialArguments | None = None) -> int:
    """Move a 2 mm probe from one tactel to the next, and compare its estimated and true position.

    The arm slides its pad along a fixed probe over 5 mm while the servo keeps 1 kPa. The true
    positions come from the arm's joints. Writes cop.png, like Fig. 5, and cop.csv. Runs 20 trials,
    or 2 with --quick.
    """
    return run_trials(COP, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    paths = [follow_probe(seed, sensor) for seed in plan.seeds()]
    row = probe_row(paths)
    table = result_table(
        [row],
        [
            ("", "2 mm probe, error"),
            ("rms", "{error_rms_mm:.3f} mm"),
            ("maximum", "{error_max_mm:.3f} mm"),
            ("along the path, rms", "{along_rms_mm:.3f} mm"),
            ("worst path, rms", "{worst_path_rms_mm:.3f} mm"),
            ("force", "{force_n:.2f} N"),
        ],
        caption="the chapter's Fig. 5 shows a curve without numbers",
    )
    data = "2 mm probe at 1 kPa, 16 × 16 tactels of 5 mm, simulated arm and pad"
    return ExperimentResult([row], table, _picture(paths, plan.provenance(data)), _points(paths))


COP = Experiment("cop", _measure, unit="path", trials=20, quick_trials=2)


def probe_row(paths: Sequence[ProbePath]) -> dict[str, Any]:
    """Return the position errors over all readings of all paths, mm, and the mean force, N."""
    errors = 1e3 * np.concatenate([path.error for path in paths])
    along = 1e3 * np.concatenate([path.estimated[:, 0] - path.real[:, 0] for path in paths])
    return {
        "name": "probe",
        "error_rms_mm": float(np.sqrt(np.mean(errors**2))),
        "error_max_mm": float(errors.max()),
        "along_rms_mm": float(np.sqrt(np.mean(along**2))),
        "worst_path_rms_mm": max(float(np.sqrt(np.mean(p.error**2))) * 1e3 for p in paths),
        "force_n": float(np.mean(np.concatenate([path.force for path in paths]))),
    }


def _points(paths: Sequence[ProbePath]) -> list[dict[str, Any]]:
    return [
        {
            "way": number,
            "real_x_mm": round(1e3 * float(path.real[k, 0]), 4),
            "estimated_x_mm": round(1e3 * float(path.estimated[k, 0]), 4),
            "real_y_mm": round(1e3 * float(path.real[k, 1]), 4),
            "estimated_y_mm": round(1e3 * float(path.estimated[k, 1]), 4),
            "error_mm": round(1e3 * float(path.error[k]), 4),
        }
        for number, path in enumerate(paths)
        for k in _shown(path)
    ]


def _shown(path: ProbePath) -> np.ndarray:
    """Return the indices of the readings that the chart and the CSV file show."""
    return np.linspace(0, len(path.real) - 1, POINTS).round().astype(int)


def _picture(paths: Sequence[ProbePath], provenance: Provenance) -> Figure:
    row = probe_row(paths)
    figure, (left, right) = new_chart(
        "A probe between tactels is located to hundredths of a millimetre",
        f"2 mm probe moved over 5 mm; error {row['error_rms_mm']:.3f} mm rms, "
        f"{row['error_max_mm']:.3f} mm at most",
        columns=2,
        height=5.0,
    )
    ends = np.array([-2.5, 2.5])
    left.plot(ends, ends, color=GREY, linewidth=LINE, label="true")
    for number, path in enumerate(paths):
        true, estimated = 1e3 * path.real[:, 0], 1e3 * path.estimated[:, 0]
        first = number == 0
        if first:
            k = _shown(path)
            left.plot(true[k], estimated[k], ".", color=VERMILION, markersize=5, label="estimated")
        right.plot(
            true,
            estimated - true,
            color=VERMILION if first else BLUE,
            linewidth=1.6 if first else 0.7,
            alpha=1.0 if first else 0.35,
            zorder=3 if first else 2,
            label={0: "path at the left", 1: "other paths"}.get(number),
        )
    right.axhline(0.0, color=INK, linewidth=0.8)
    high = 1.5 * max(float(np.abs(p.estimated - p.real)[:, 0].max()) for p in paths) * 1e3
    right.set_ylim(-high, high)
    for axes, y, panel in (
        (left, "estimated position [mm]", "Estimated position"),
        (right, "estimated minus true [mm]", "Error along the path"),
    ):
        label_axes(axes, "true position [mm]; tactels are at both ends", y, panel=panel)
        axes.set_xticks([-2.5, 0, 2.5], ["−2.5", "0", "2.5"])
        add_legend(axes, where="upper left")
    add_footer(figure, provenance)
    return figure
