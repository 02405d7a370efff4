"""The chart of a pad that turns with an edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREY, INK, LINE, VERMILION, add_legend, label_axes
from .edge_run import ALIGN_SECONDS, EdgeRun

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure


HEIGHT = 5.0
"""Height of the figure, inches."""


def edge_picture(runs: Sequence[EdgeRun], seed: int) -> Figure:
    """Draw the alignment of all trials, and one pad that follows the turning edge."""
    figure, (left, right) = new_chart(
        "The pad turns with an object's edge",
        "only pressure and rotation are controlled, P = diag(0, 0, 1, 0, 0, 1); true angles",
        columns=2,
        height=HEIGHT,
    )
    for number, run in enumerate(runs):
        early = (run.times >= run.landing) & (run.times < ALIGN_SECONDS)
        left.plot(
            run.times[early] - run.landing,
            run.errors_deg[early],
            color=BLUE,
            linewidth=1.4,
            alpha=0.8,
            label=None if number else "each trial",
        )
    left.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
    label_axes(left, "time since touch [s]", "angle of pad to edge [°]", panel="Alignment")
    add_legend(left, where="lower right")
    run = runs[0]
    late = run.times >= ALIGN_SECONDS
    times = run.times[late] - ALIGN_SECONDS
    edge = run.edge_deg[late] - run.edge_deg[late][0]
    right.plot(times, edge, color=INK, linewidth=1.2, linestyle=(0, (4, 3)), label="edge", zorder=4)
    right.plot(times, edge + run.errors_deg[late], color=VERMILION, linewidth=LINE, label="pad")
    label_axes(right, "time [s]", "direction [°]", panel="The edge turns")
    right.set_ylim(top=1.35 * float(np.abs(edge).max()))
    add_legend(right, where="upper right")
    add_footer(
        figure,
        Provenance("box edge on the simulated 16 × 16 pad and arm", seed, len(runs), "trial"),
    )
    return figure
