"""`eyehand experiment cop`: a probe's place between tactels, felt against real (Fig. 5)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table

from ..bench.chart_style import (
    BLUE,
    GREY,
    INK,
    LINE,
    VERMILION,
    Provenance,
    add_footer,
    add_legend,
    label_axes,
    new_chart,
)
from ..console import tracked
from ..output_files import make_folder
from .probe_path import ProbePath, follow_probe
from .trials import tell_trials, trial_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

TRIALS, QUICK_TRIALS = 20, 2
"""Ways, each on a pad of its own."""
PLACES = 51
"""Points along the way that the picture and its table show."""


def experiment_cop(
    *,
    trials: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_cop"),
    json: bool = False,
) -> int:
    """Lead a 2 mm probe from one tactel to the next, and compare felt with real places.

    The arm slides its pad along a fixed probe over 5 mm while the servo keeps 1 kPa. Real places
    come from the arm's joints. Writes cop.png, after Fig. 5, and cop.csv.

    Parameters
    ----------
    trials
        Ways, >= 1; default: 20.
    seed
        Way k has a pad, a noise and a place across that follow from seed + k.
    quick
        2 ways: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    count = trial_count(trials, QUICK_TRIALS if quick else TRIALS, seed)
    make_folder(out)
    paths = [follow_probe(seed + k) for k in tracked(range(count), "ways", count)]
    row = probe_row(paths)
    made = Provenance(
        "2 mm probe at 1 kPa, 16 × 16 tactels of 5 mm, simulated arm and pad", seed, count, "way"
    )
    tell_trials(
        "experiment cop",
        [row],
        _table(row),
        _picture(paths, made),
        _points(paths),
        seed=seed,
        trials=count,
        out=out,
        json=json,
    )
    return 0


def probe_row(paths: Sequence[ProbePath]) -> dict[str, Any]:
    """Sum up the ways: errors over all readings of all of them, mm."""
    errors = 1e3 * np.concatenate([path.error for path in paths])
    along = 1e3 * np.concatenate([path.estimated[:, 0] - path.real[:, 0] for path in paths])
    return {
        "name": "probe",
        "error_rms_mm": float(np.sqrt(np.mean(errors**2))),
        "error_max_mm": float(errors.max()),
        "along_rms_mm": float(np.sqrt(np.mean(along**2))),
        "worst_way_rms_mm": max(float(np.sqrt(np.mean(p.error**2))) * 1e3 for p in paths),
        "force_n": float(np.mean(np.concatenate([path.force for path in paths]))),
    }


def _points(paths: Sequence[ProbePath]) -> list[dict[str, Any]]:
    rows = []
    for number, path in enumerate(paths):
        for k in np.linspace(0, len(path.real) - 1, PLACES).round().astype(int):
            rows.append(
                {
                    "way": number,
                    "real_x_mm": round(1e3 * float(path.real[k, 0]), 4),
                    "estimated_x_mm": round(1e3 * float(path.estimated[k, 0]), 4),
                    "real_y_mm": round(1e3 * float(path.real[k, 1]), 4),
                    "estimated_y_mm": round(1e3 * float(path.estimated[k, 1]), 4),
                    "error_mm": round(1e3 * float(path.error[k]), 4),
                }
            )
    return rows


def _picture(paths: Sequence[ProbePath], made: Provenance) -> Figure:
    row = probe_row(paths)
    figure, (left, right) = new_chart(
        "Between tactels, a probe is placed to hundredths of a millimetre",
        f"2 mm probe led over 5 mm; error {row['error_rms_mm']:.3f} mm rms, "
        f"{row['error_max_mm']:.3f} mm at most",
        columns=2,
        height=5.0,
    )
    ends = np.array([-2.5, 2.5])
    left.plot(ends, ends, color=GREY, linewidth=LINE, label="real")
    for number, path in enumerate(paths):
        real, felt = 1e3 * path.real[:, 0], 1e3 * path.estimated[:, 0]
        shown = np.linspace(0, len(real) - 1, PLACES).round().astype(int)
        name = "estimated" if number == 0 else None
        if number == 0:
            left.plot(real[shown], felt[shown], ".", color=VERMILION, markersize=5, label=name)
        right.plot(
            real,
            felt - real,
            color=VERMILION if number == 0 else BLUE,
            linewidth=1.6 if number == 0 else 0.7,
            alpha=1.0 if number == 0 else 0.35,
            zorder=3 if number == 0 else 2,
            label="way at the left" if number == 0 else ("others" if number == 1 else None),
        )
    right.axhline(0.0, color=INK, linewidth=0.8)
    high = 1.5 * max(float(np.abs(p.estimated - p.real)[:, 0].max()) for p in paths) * 1e3
    right.set_ylim(-high, high)
    label_axes(
        left, "real place [mm]; tactels are at both ends", "place [mm]", panel="Felt and real"
    )
    label_axes(
        right,
        "real place [mm]; tactels are at both ends",
        "estimated less real [mm]",
        panel="Error along the way",
    )
    left.set_xticks([-2.5, 0, 2.5], ["−2.5", "0", "2.5"])
    right.set_xticks([-2.5, 0, 2.5], ["−2.5", "0", "2.5"])
    add_legend(left, where="upper left")
    add_legend(right, where="upper left")
    add_footer(figure, made)
    return figure


def _table(row: dict[str, Any]) -> Table:
    table = Table(box=box.SIMPLE, caption="paper: Fig. 5, a curve without figures")
    for heading in ("", "rms", "largest", "along the way, rms", "worst way, rms", "force"):
        table.add_column(heading, justify="left" if not heading else "right")
    table.add_row(
        "2 mm probe, error",
        f"{row['error_rms_mm']:.3f} mm",
        f"{row['error_max_mm']:.3f} mm",
        f"{row['along_rms_mm']:.3f} mm",
        f"{row['worst_way_rms_mm']:.3f} mm",
        f"{row['force_n']:.2f} N",
    )
    return table
