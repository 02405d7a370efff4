"""Test that every baseline solves a simple scene and finds nothing on an empty table."""

import numpy as np
import pytest

from eyehand.apps.segmentation.baselines import BASELINES, Baseline
from eyehand.apps.segmentation.score import score_segmentation
from eyehand.data_synth.render import StagedObject, StagedScene, staged_frame
from eyehand.data_synth.scenes import staged_solids as shapes

BALLS = StagedScene(
    (
        StagedObject(shapes.ball(0.05), (-0.1, 0.0, 0.0)),
        StagedObject(shapes.ball(0.06), (0.1, 0.02, 0.0)),
    )
)


@pytest.mark.parametrize("baseline", BASELINES, ids=lambda baseline: baseline.name)
def test_separates_two_balls(baseline: Baseline):
    frame, truth = staged_frame(BALLS)
    labels = baseline.run(frame, baseline.settings[len(baseline.settings) // 2])
    assert labels.shape == frame.depth.shape
    assert labels.dtype == np.int32
    score = score_segmentation(labels, truth)
    assert score.predicted_count == score.truth_count == 2
    assert score.f > 0.95


@pytest.mark.parametrize("baseline", BASELINES, ids=lambda baseline: baseline.name)
def test_finds_nothing_on_empty_table(baseline: Baseline):
    frame, _ = staged_frame(StagedScene(()))
    assert not baseline.run(frame, baseline.settings[0]).any()


def test_every_baseline_has_reason_and_settings():
    for baseline in BASELINES:
        assert baseline.why
        assert "\n" not in baseline.why
        assert len(set(baseline.settings)) == len(baseline.settings) >= 3
