"""Shares of trials and their drawing."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from eyehand.apps.bench.shares import (
    draw_bars,
    draw_dotted,
    refused_pct,
    score_pct,
    share_pct,
    unclean_pct,
    worst,
)
from eyehand.apps.bench.sweep import SweepStep, Trial

STEP = SweepStep(
    1.0,
    (
        Trial(True, score=1.0),
        Trial(False, "dropped", score=0.5),
        Trial(True, "too wide", refused=True),
        Trial(False, "raised", clean=False),
    ),
)


def test_shares_count_trials_and_mean_score_skips_none():
    assert refused_pct(STEP) == unclean_pct(STEP) == 25.0
    assert share_pct(STEP, lambda trial: trial.passed) == 50.0
    assert score_pct(STEP) == 75.0
    assert score_pct(SweepStep(1.0, (Trial(True),))) is None


def test_worst_is_rounded_and_skips_none():
    assert worst([1.0, None, 1234.56], 3) == 1230.0
    assert worst([1.0, None, 0.12345], 2, min) == 0.12
    assert worst([None], 3) is None


def test_bars_are_stacked_and_curve_skips_none():
    axes = Figure().subplots()
    draw_bars(axes, [0, 1], [10.0, 20.0], "low", "k", 0.5)
    draw_bars(axes, [0, 1], [30.0, 40.0], "high", "k", 0.5, [10.0, 20.0])
    draw_dotted(axes, [0, 1, 2], [90.0, None, 70.0], "curve")
    tops = [
        float(bar.get_extents().transformed(axes.transData.inverted()).y1) for bar in axes.patches
    ]
    assert tops == pytest.approx([10.0, 20.0, 40.0, 60.0])
    (line,) = axes.lines
    np.testing.assert_allclose(np.asarray(line.get_xydata()), [[0.0, 90.0], [2.0, 70.0]])
