"""Interval tasks: inactive inside, active at a bound, and recovery from outside."""

import numpy as np
import pytest

from eyehand.control.robot_state import RobotState
from eyehand.control.tasks import DistanceToPoint, Interval, LookAt, PointOnPlane, Position
from eyehand.errors import InputError

Q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
UP = np.array([0.0, 0.0, 1.0])
PUSH = 0.1


def height(**fields) -> PointOnPlane:
    return PointOnPlane(UP, 0.0, gain=2.0, speed=0.1, **fields)


@pytest.mark.parametrize(
    ("low", "high", "rows", "side", "rate"),
    [
        (-1.0, 1.0, 0, 0, 0.0),  # far inside
        (-1.0, 0.02, 1, -1, 0.04),  # near the upper bound: limits the upward speed
        (-0.02, 1.0, 1, 1, -0.04),
        (-1.0, -0.02, 1, -1, -0.04),  # above the upper bound: must decrease
        (0.02, 1.0, 1, 1, 0.04),
        (0.5, 1.0, 1, 1, 0.1),  # far below: full speed
        (-np.inf, 0.02, 1, -1, 0.04),
        (-0.02, np.inf, 1, 1, -0.04),
        (-0.01, 0.02, 1, 1, -0.02),  # the lower bound is closer
        (0.03, 0.03, 1, 0, 0.06),  # equal bounds: a goal
    ],
)
def test_rows_side_and_rate_follow_from_closer_bound(arm_state, low, high, rows, side, rate):
    state = arm_state(Q)
    z = float(state.position[2])
    found = Interval(height(), z + low, z + high).at(state)
    assert len(found.value) == rows
    assert found.side == side
    assert found.rate == pytest.approx([rate] * rows)
    outside = max(low, -high, 0.0)
    assert found.unmet == pytest.approx(outside)


def test_value_driven_to_bound_stops_without_velocity_jump():
    # An external motion raises the value at the task's speed. The rate limits it, as in the stack.
    z, speeds = 0.0, []
    task = Interval(height(), -1.0, 0.2)
    for _ in range(800):
        rows = task.at(_state_at_height(z))
        speeds.append(min(PUSH, float(rows.rate[0])) if rows.side else PUSH)
        z += 0.005 * speeds[-1]
    assert 0.199 < z < 0.2
    # The speed falls from the task's speed to zero by at most gain × dt × speed per cycle.
    assert np.abs(np.diff(speeds)).max() <= 0.1 * 2.0 * 0.005 + 1e-12


def test_rows_are_derivatives_of_bounded_task(arm_state, check_jacobian):
    for seed in range(10):
        rng = np.random.default_rng(seed)
        q = rng.uniform(-2.0, 2.0, 7)
        centre = rng.normal(size=3)
        check_jacobian(Interval(DistanceToPoint(centre, 0.0), 9.0, 10.0), q)
        check_jacobian(Interval(DistanceToPoint(centre, 0.0), 0.0, 0.01), q)


def test_interval_of_inactive_task_is_inactive(arm_state):
    state = arm_state(Q)
    ahead = state.position + 0.5 * state.rotation[:, 2]
    rows = Interval(LookAt(ahead, 1.0), 0.2, 0.4).at(state)
    assert rows.jacobian.shape == (0, 7)


def test_name_defaults_to_name_of_task():
    assert Interval(height(), 0.0, 1.0).name == "point on plane"
    assert Interval(height(name="tip"), 0.0, 1.0).name == "tip"
    assert Interval(height(), 0.0, 1.0, "clear of the table").name == "clear of the table"


def test_interval_rejects_invalid_fields(arm_state):
    with pytest.raises(InputError, match="low <= high"):
        Interval(height(), 1.0, 0.0)
    with pytest.raises(InputError, match="low <= high"):
        Interval(height(), np.nan, 0.0)
    with pytest.raises(InputError, match="finite bound"):
        Interval(height(), -np.inf, np.inf)
    with pytest.raises(InputError, match="low <= high"):
        Interval(height(), np.inf, np.inf)
    with pytest.raises(InputError, match="1 row, position has 3"):
        Interval(Position(np.zeros(3)), 0.0, 1.0).at(arm_state(Q))


def _state_at_height(z: float) -> RobotState:
    jacobian = np.zeros((6, 1))
    jacobian[2] = 1.0
    one = np.ones(1)
    return RobotState(z * one, z * UP, np.eye(3), jacobian, -one, one, 0.0 * one, one)
