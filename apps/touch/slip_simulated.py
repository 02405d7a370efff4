"""The simulated part of `eyehand experiment slip`: detection on pads of three ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth.pad import SENSORS

from ..bench import ExperimentResult, TrialPlan, add_footer, new_chart, result_table
from ..bench.chart_style import BLUE, GREEN, GREY, VERMILION, add_legend, label_axes
from ..console import tracked
from .slip_bound import BOUND_ERRORS, bound_name, observed_slides
from .slip_detection import (
    CLEAR_SLIDE,
    DETECTORS,
    FALSE_SHARE,
    LONG_SLIDE,
    alarm_level,
    detection_row,
    has_slip,
    judge_alarms,
    score_trials,
    train_detector,
)
from .slip_training import SEED_GAP, all_of, left_out_level, slip_trials
from .slip_trials import EVENTS, TEST_SHAPES, TRAIN_SHAPES, UNSEEN_PADS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .arm_rig import SensorName
    from .slip_trials import SlipTrial

RANGES, QUICK_RANGES = (5e3, 20e3, 80e3), (20e3,)
"""Ranges of the pads, Pa."""
CHARTED = 20e3
"""Range of the pad whose rates are drawn, Pa."""
TRAIN_FACTOR = 3
"""Trials of each event for training, over those of the test."""
_COLOURS = (VERMILION, BLUE, GREEN)


def measure_simulated(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    """Train all detectors on three kinds of objects, and test them on three others."""
    ranges = QUICK_RANGES if plan.quick else RANGES
    rows: list[dict[str, Any]] = []
    curves = {}
    for top in tracked(ranges, "pads", len(ranges)):
        model = SENSORS[sensor]
        known = slip_trials(TRAIN_SHAPES, TRAIN_FACTOR * plan.trials, plan.seed, model, top)
        fresh = plan.seed + SEED_GAP
        tests = slip_trials(TEST_SHAPES, plan.trials, fresh, model, top, UNSEEN_PADS)
        training, unseen = all_of(known), all_of(tests)
        for name in DETECTORS:
            tested = score_trials(name, train_detector(name, training, plan.seed), unseen)
            level = left_out_level(name, known, plan.seed)
            rows.append({"name": name, "range_kpa": top / 1e3, **_rates(unseen, tested, level)})
            if top == CHARTED:
                curves[name] = _curve(unseen, tested)
        for error in BOUND_ERRORS:
            level = alarm_level(training, observed_slides(training, model.wait, error, plan.seed))
            seen = observed_slides(unseen, model.wait, error, fresh)
            row = {"name": bound_name(error), "range_kpa": top / 1e3}
            rows.append(row | _rates(unseen, seen, level))
    table = result_table(
        rows,
        [
            ("", "{name}"),
            ("range", "{range_kpa:.0f} kPa"),
            ("detected", "{detected_pct:.1f} %"),
            (f"over {1e3 * CLEAR_SLIDE:g} mm", "{clear_detected_pct:.1f} %"),
            (f"over {1e3 * LONG_SLIDE:g} mm", "{long_detected_pct:.1f} %"),
            ("knocks", "{false_knocks_pct:.1f} %"),
            ("latency", "{latency_ms:.1f} ms"),
            ("99 %", "{latency_p99_ms:.1f} ms"),
            ("slide", "{slide_mm:.2f} mm"),
            ("99 %", "{slide_p99_mm:.2f} mm"),
            ("level of left-out kinds", "{carried_detected_pct:.1f} / {carried_false_pct:.1f} %"),
        ],
        title=f"simulated slip of unseen objects, with false alarms in "
        f"{100 * FALSE_SHARE:.0f} % of the trials without slip",
        caption="over: of the slips with a longer final slide; knocks: knocks and accelerations "
        "without slip that raise an alarm; latency: after 0.1 mm of true slide, negative before "
        "it; level of left-out kinds: detected and false "
        "alarms with the level that holds for the trained kinds, each left out once; bound: an "
        "observer who knows the slide, as late as the sensor, with an error of each judgement",
    )
    footer = plan.provenance(f"{len(EVENTS)} events, {', '.join(TEST_SHAPES)}; sensor {sensor}")
    figure, axes = new_chart(
        "Slip of unseen objects on the 20 kPa pad",
        f"trained on {', '.join(TRAIN_SHAPES)}, tested on {', '.join(TEST_SHAPES)}",
        height=5.0,
    )
    _draw(axes[0], curves)
    add_footer(figure, footer)
    return ExperimentResult(rows, table, figure)


def _rates(
    trials: Sequence[SlipTrial], scores: Sequence[NDArray[np.float64]], level: float
) -> dict[str, Any]:
    """Return the rates with the level of these trials, and as ``carried_…`` with a given one."""
    own = detection_row(trials, judge_alarms(trials, scores, alarm_level(trials, scores)))
    carried = detection_row(trials, judge_alarms(trials, scores, level))
    return own | {f"carried_{key}": value for key, value in carried.items()}


def _curve(
    trials: Sequence[SlipTrial], scores: Sequence[NDArray[np.float64]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return false alarms and detected slips, %, over the alarm level."""
    slips = np.array([has_slip(trial) for trial in trials])
    levels = np.unique([s.max() for s in scores])
    judged = [judge_alarms(trials, scores, float(level)) for level in levels]
    return (
        np.array([100 * alarms.alarmed[~slips].mean() for alarms in judged]),
        np.array([100 * alarms.detected[slips].mean() for alarms in judged]),
    )


def _draw(panel: Axes, curves: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> None:
    for (name, (false, detected)), colour in zip(curves.items(), _COLOURS, strict=False):
        panel.step(false, detected, color=colour, label=name, where="post")
    panel.axvline(100 * FALSE_SHARE, color=GREY, linewidth=1.0)
    panel.set_xlim(0, 30)
    panel.set_ylim(0, 102)
    label_axes(panel, "trials without slip that raise an alarm [%]", "slips detected in time [%]")
    add_legend(panel, where="lower right")
