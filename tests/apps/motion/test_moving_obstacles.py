"""Solids that move towards the arm. The controller does not receive their velocity."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.apps.motion import moving_obstacles
from eyehand.apps.motion.moving_obstacles import (
    MovingCase,
    MovingResult,
    NoLineError,
    _line,
    _solids,
    moving_rows,
    moving_trial,
)
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import ArmClearance, make_reaching_scene


@pytest.mark.parametrize("conveyor", [False, True])
def test_arm_leaves_within_its_acceleration_limits(conveyor):
    result = moving_trial(MovingCase(0, 0.25, conveyor, ReachingArm()))
    assert result.clearance >= 0.005
    assert result.peak_acceleration <= 1.0 + 1e-6


def test_posture_without_a_free_line_is_left_out(monkeypatch):
    """The UR5e holds its tool too near to its base at seed 91002."""

    def trial(case):
        if case.seed == 2:
            raise NoLineError("found no line")
        return MovingResult(0.01, False, 0.5)

    monkeypatch.setattr(moving_obstacles, "moving_trial", trial)
    assert [row["trials"] for row in moving_rows(0, 4)] == [3, 3, 3, 3]
    with pytest.raises(NoLineError):
        moving_rows(2, 1)


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


@pytest.mark.parametrize("seed", [90002, 90018, 90019])
def test_solids_do_not_pass_through_the_base(seed):
    """The first line drawn for each of these seeds does."""
    arm = ReachingArm()
    case = MovingCase(seed, 0.5, True, arm)
    target = ArmClearance().tool(make_reaching_scene(seed, boxes=0).start)
    draws = np.random.default_rng([seed, 2])
    solids, places, velocity = _solids(case, target, np.random.default_rng([seed, 2]))
    first, direction = _line(case, target, draws)
    assert any(_axis_distance(solid, direction) < 0.16 for solid in first)
    for solid, place in zip(solids, places, strict=True):
        np.testing.assert_allclose(solid.T_world_shape.translation, place)
        assert _axis_distance(solid, velocity / 0.5) > 0.155


def _axis_distance(solid, direction) -> float:
    """Return the least distance of a solid on its way from the lower 0.42 m of the first axis."""
    axis = np.zeros((200, 3))
    axis[:, 2] = np.linspace(0.0, 0.42, len(axis))
    travel = np.linspace(0.0, 0.6 + 0.3 + 2 * 0.5, 400)
    seen = axis[None] - travel[:, None, None] * direction
    local = solid.T_world_shape.inv().apply(seen.reshape(-1, 3))
    return float(np.linalg.norm(np.maximum(np.abs(local) - solid.size, 0.0), axis=1).min())


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
