"""`eyehand touch stress`: make touching harder until the servo breaks, and chart where."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from eyehand.apps.description_files import make_folder
from eyehand.apps.evaluation.chart_style import PEER, VERMILION, draw_curve
from eyehand.apps.evaluation.stress_chart import Telling, write_stress_chart
from eyehand.apps.evaluation.stress_run import (
    CHART_FILE,
    CHART_FILES,
    run_sweeps,
    stress_seeds,
    tell_stress,
)
from eyehand.apps.evaluation.stress_sweep import chosen_sweeps

from .stress_contact import ContactFigures
from .stress_gain_cases import gain_sweeps
from .stress_sensor_cases import sensor_sweeps
from .stress_touch_cases import contact_sweeps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from eyehand.apps.evaluation.stress_sweep import Step, Sweep

SEEDS, QUICK_SEEDS = 8, 1
"""Trials a value when no number is asked for."""
DIGITS = 4
"""Significant digits of measured figures."""


def touch_stress(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    seeds: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/stress_touch"),
    json: bool = False,
) -> int:
    """Make touching harder step by step until the tactile servo breaks, and chart where.

    Gains past the limit, fast landings with and without anti-windup, contacts lost while rolling,
    round ones with yaw on, rods exactly across, contacts at the border, blobs that swap, objects
    that come at the pad, light ones, thresholds in the noise, dead and saturated tactels. Past its
    limit each should end in a named outcome with the pad backed off; force that grows, or a pad
    that still presses after that, breaks it. Ends with exit code 1 when a bound is broken, and says
    which. Writes stress.png with stress.csv.

    Parameters
    ----------
    only
        Sweeps to run; all when not given.
    seeds
        Trials at each value; default 8, or 1 with --quick.
    seed
        The first seed; electronics, noise and directions follow from it alone.
    quick
        Try each sweep at its easiest value, its bound and its hardest value only.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    tried = stress_seeds(seeds, seed, QUICK_SEEDS if quick else SEEDS)
    sweeps = chosen_sweeps(touch_sweeps(), only or ())
    make_folder(out)
    results = run_sweeps(sweeps, tried, None, quick=quick)
    telling = touch_telling()
    write_stress_chart(out / CHART_FILE, results, telling, len(tried), seed)
    return tell_stress(results, telling, tried, CHART_FILES, out=out, json=json, quick=quick)


def touch_sweeps() -> tuple[Sweep[None], ...]:
    """All sweeps, in reading order."""
    return (*gain_sweeps(), *contact_sweeps(), *sensor_sweeps())


def touch_telling() -> Telling:
    """How the sweeps are told: what was held, what ended with a name, the worst forces."""
    return Telling(
        stage="touch",
        title="Where the tactile servo breaks",
        subtitle="Share of contacts that are held as they should",
        data="simulated 16 x 16 pad on a carrier with an arm's lag, default options",
        each="trial",
        figures=_figures,
        draw=_draw,
        keyed=True,
    )


def _figures(step: Step) -> dict[str, Any]:
    measured = [trial.picture for trial in step.trials if isinstance(trial.picture, ContactFigures)]

    def worst(name: str) -> float | None:
        values = [getattr(figures, name) for figures in measured]
        return float(f"{max(values):.{DIGITS}g}") if values else None

    names = sorted({figures.outcome for figures in measured if figures.outcome})
    return {
        "named_pct": round(_share(step, "refused"), 1),
        "unnamed_pct": round(_share(step, "unnamed"), 1),
        "outcomes": " ".join(names),
        "peak_force_n": worst("peak_force"),
        "peak_pressure_pa": worst("peak_pressure"),
        "growth_after_end": worst("growth"),
        "unclean": sum(not trial.clean for trial in step.trials),
    }


def _share(step: Step, what: str) -> float:
    """Of trials, %, that ended with a name, or that did neither that nor hold."""
    if what == "refused":
        count = sum(trial.refused for trial in step.trials)
    else:
        count = sum(not (trial.refused or trial.passed) for trial in step.trials)
    return 100 * count / len(step.trials)


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[Step]) -> None:
    look: dict[str, Any] = {"width": 0.82, "linewidth": 0, "zorder": 1.2}
    named = [_share(step, "refused") for step in steps]
    unnamed = [_share(step, "unnamed") for step in steps]
    axes.bar(places, named, color=PEER, alpha=0.45, label="ended with a name, backed off", **look)
    axes.bar(
        places,
        unnamed,
        bottom=named,
        color=VERMILION,
        alpha=0.6,
        label="missed without a name",
        **look,
    )
    draw_curve(axes, places, [100 * step.share for step in steps], "held")
