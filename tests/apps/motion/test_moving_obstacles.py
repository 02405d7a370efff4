"""Solids that move at the arm with untold velocity."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.apps.motion.moving_obstacles import MovingCase, _solids, moving_rows, moving_trial
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import ArmClearance, make_reaching_scene


@pytest.mark.parametrize("conveyor", [False, True])
def test_arm_leaves_within_its_acceleration_limits(conveyor):
    result = moving_trial(MovingCase(0, 0.25, conveyor, ReachingArm()))
    assert result.clearance >= 0.005
    assert result.peak_acceleration <= 1.0 + 1e-6


def test_standing_arm_would_be_hit():
    """The solids pass where the tool stands."""
    case = MovingCase(0, 0.25, False, ReachingArm())
    scene = make_reaching_scene(0, boxes=0)
    target = ArmClearance().tool(scene.start)
    solids, places, velocity = _solids(case, target, np.random.default_rng([0, 2]))
    checker = ArmClearance(solids)
    nearest = 1.0
    for time in np.arange(0.0, 3.0, 0.05):
        checker.move(solids[0].name, places[0] + time * velocity)
        nearest = min(nearest, checker.at(scene.start))
    assert nearest < 0.0


def test_rows_count_what_is_kept_and_named():
    rows = moving_rows(0, trials=1)
    names = [row["name"] for row in rows]
    assert names == [
        "any side 0.25 m/s",
        "any side 0.5 m/s",
        "conveyor 0.25 m/s",
        "conveyor 0.5 m/s",
    ]
    for row in rows:
        assert row["unnamed"] == 0
        assert (row["kept_pct"] == 100.0) == (row["min_clearance_mm"] >= 5.0)
