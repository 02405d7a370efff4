"""OMPL plans, times its paths within the limits, and reaches goals."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.apps.motion.baseline_ompl import OmplMethod
from eyehand.apps.motion.reach_methods import BASELINE_PLANNED
from eyehand.apps.motion.reach_outcome import ReachOptions
from eyehand.apps.motion.reach_run import run_scene
from eyehand.data_synth.scenes import ReachingScene, make_reaching_scene

pytest.importorskip("ompl", reason="ompl is not installed: pip install 'eyehand[baselines]'")


@pytest.mark.parametrize("goal", ["position", "pose"])
def test_ompl_reaches_among_boxes_within_all_limits(goal):
    record = run_scene(BASELINE_PLANNED, 800, 5, ReachOptions(goal=goal))
    outcome = record.outcome
    assert outcome.success, record.reason
    assert outcome.min_clearance > 0.008
    assert max(outcome.peak_acceleration, outcome.peak_jerk) <= 1.0 + 1e-9
    assert len(record.paths) == 1


def test_goal_out_of_reach_is_named():
    scene = make_reaching_scene(3, boxes=0)
    far = ReachingScene(3, scene.start, np.array([3.0, 0.0, 0.5]), (), scene.witness, np.eye(3))
    method = OmplMethod(far, "position", 0.005)
    speed, status = method(far.start)
    assert (status, method.reason) == ("stuck", "no configuration reaches the goal")
    assert not speed.any()
    assert [path.found for path in method.paths] == [False, False, False]
