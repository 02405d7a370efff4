"""mink reaches goals and keeps its limits."""

from __future__ import annotations

import numpy as np

from eyehand.apps.motion.baseline_mink import MinkOptions, run_mink
from eyehand.apps.motion.reach_outcome import ReachOptions
from eyehand.data_synth.scenes import make_reaching_scene


def test_mink_reaches_the_goal_within_its_speed_limit():
    scene = make_reaching_scene(4, boxes=0)
    outcome = run_mink(scene)
    assert outcome.success
    slow = run_mink(scene, MinkOptions(speed=0.1))
    assert slow.success
    assert slow.seconds > 1.5 * outcome.seconds


def test_mink_keeps_its_margin_among_boxes():
    scenes = [make_reaching_scene(seed) for seed in range(4)]
    outcomes = [run_mink(scene, reach=ReachOptions(time_limit=8.0)) for scene in scenes]
    assert sum(outcome.success for outcome in outcomes) >= 2
    assert min(outcome.min_clearance for outcome in outcomes) > 0.005
    assert all(np.isfinite(outcome.final_error) for outcome in outcomes)
