"""`eyehand experiment slip`: detect simulated and recorded slip (section 3.1 of the chapter)."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bench import add_footer, new_chart
from ..bench.chart_style import BLUE, GREEN, GREY, VERMILION, add_legend, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .slip_recordings import FEATURES, SETS, TRAINED, load_windows, slip_rows
from .slip_simulated import measure_simulated
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PUBLISHED_PCT = 82.56
"""Best share of right windows on unseen objects in the publication, from windows of 50 ms."""


def experiment_slip(data: Path | None = None, arguments: TrialArguments | None = None) -> int:
    """Detect slip by touch: in simulated grasps, or in recorded ones.

    Without --data, an object between two pads is loaded, pulled, twisted, shaken, knocked, gripped
    harder and softer. Detectors are trained on three kinds of objects and tested on three others.
    Prints the share of slips detected, the latency and the slide at detection, for pads with ranges
    of 5, 20 and 80 kPa. Runs 40 trials of each event for training and as many for the test, or 4
    with --quick and one pad.

    With --data, windows of 50 ms of the BioTac SP data set (Zapata-Impata and others, Sensors
    19:523, 2019) are classified: four directions, two rotations, no slip. A network is trained on
    one set of objects and tested on the others. --trials, --sensor and --quick have no effect.

    Writes slip.png and slip.csv.

    Parameters
    ----------
    data
        Folder of the recordings, with one folder per class: n, e, s, w, cw, aw, t.
    """
    if data is None:
        return run_trials(SLIP, measure_simulated, arguments)
    a = arguments or TrialArguments()
    recorded = Experiment("slip", partial(_measure, data))
    out = a.out or Path("out/experiment_slip")
    return run_experiment(recorded, seed=a.seed, out=out, json=a.json)


SLIP = Experiment("slip", measure_simulated, trials=40, quick_trials=4, min_trials=2)


def _measure(data: Path, plan: TrialPlan) -> ExperimentResult:
    windows = load_windows(data)
    rows = slip_rows(windows, [plan.seed])
    names = [name for name in SETS if name != TRAINED]
    table = result_table(
        rows,
        [
            ("", "{name}"),
            *((f"{name}: right", f"{{{name}_right_pct:.1f}} %") for name in names),
            *((f"{name}: area", f"{{{name}_auc:.3f}}") for name in names),
        ],
        title=f"recorded slip, trained on {TRAINED}: windows of 50 ms whose class is right (one "
        "of 7)",
        caption=f"published: {PUBLISHED_PCT} % on unseen objects; area: under the curve of slip "
        "against no slip",
    )
    footer = plan.provenance(f"{len(windows.labels)} windows of the BioTac SP data set")
    figure = _picture(rows, names)
    add_footer(figure, footer)
    return ExperimentResult(rows, table, figure, more={"published_right_pct": PUBLISHED_PCT})


def _picture(rows: list[dict[str, Any]], names: list[str]) -> Figure:
    figure, axes = new_chart(
        "Slip of unseen objects, from windows of 50 ms",
        f"share of windows with the right one of 7 classes; trained on {TRAINED}",
        height=5.0,
    )
    panel = axes[0]
    places = np.arange(len(names))
    width = 0.8 / len(FEATURES)
    for number, (row, colour) in enumerate(zip(rows, (VERMILION, BLUE, GREEN), strict=True)):
        heights = [row[f"{name}_right_pct"] for name in names]
        panel.bar(places + (number - 1) * width, heights, width, color=colour, label=row["name"])
    panel.axhline(PUBLISHED_PCT, color=GREY, label=f"published, {PUBLISHED_PCT} %")
    panel.set_xticks(places, names)
    # The legend stands above the bars.
    panel.set_ylim(0, 145)
    panel.set_yticks(range(0, 101, 20))
    label_axes(panel, "unseen objects", "right windows [%]")
    add_legend(panel, where="upper right")
    return figure
