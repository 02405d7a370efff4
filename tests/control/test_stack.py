"""Task Jacobians against finite differences, and priority as a matter of arithmetic."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from eyehand.control import Task, axis_alignment, distance_to_point, position, solve_stack
from eyehand.errors import InputError

seeds = st.integers(0, 100_000)


@given(seed=seeds)
def test_the_distance_row_is_the_rate_of_the_distance(seed):
    rng = np.random.default_rng(seed)
    point, centre, J, dq = (
        rng.normal(size=3),
        rng.normal(size=3),
        rng.normal(size=(3, 7)),
        rng.normal(size=7),
    )
    task = distance_to_point(point, J, centre, 0.2)
    h = 1e-6
    ahead = np.linalg.norm(point + h * J @ dq - centre)
    behind = np.linalg.norm(point - h * J @ dq - centre)
    assert task.jacobian @ dq == pytest.approx((ahead - behind) / (2 * h), abs=1e-6)
    assert task.error[0] == pytest.approx(0.2 - np.linalg.norm(point - centre))


@given(seed=seeds)
def test_axis_alignment_turns_the_axis_onto_the_goal(seed):
    rng = np.random.default_rng(seed)
    axis, goal = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    for _ in range(60):
        velocity = solve_stack([axis_alignment(axis, np.eye(3), goal)])
        assert abs(velocity @ axis) < 1e-9  # the angle about the axis stays free
        axis = Rotation.from_rotvec(0.2 * velocity).apply(axis)
    assert axis @ goal > 0.999


def test_opposite_axes_still_turn():
    task = axis_alignment(np.array([0.0, 0.0, 1.0]), np.eye(3), np.array([0.0, 0.0, -1.0]))
    assert np.linalg.norm(task.error) == pytest.approx(np.pi)


@given(seed=seeds)
def test_lower_tasks_never_move_the_first(seed):
    rng = np.random.default_rng(seed)
    first = position(rng.normal(size=3), rng.normal(size=(3, 7)), rng.normal(size=3))
    second = distance_to_point(rng.normal(size=3), rng.normal(size=(3, 7)), np.zeros(3), 0.1)
    third = position(rng.normal(size=3), rng.normal(size=(3, 7)), rng.normal(size=3))
    velocity = solve_stack([first, second, third])
    assert np.allclose(first.jacobian @ velocity, first.error, atol=1e-9)
    assert np.allclose(second.jacobian @ velocity, second.error, atol=1e-7)


def test_speeds_neither_jump_nor_run_away_at_a_singularity():
    speeds = []
    for size in (0.06, 0.0501, 0.0499, 0.03, 0.0201, 0.0199, 1e-3, 1e-6, 0.0):
        J = np.diag([1.0, 1.0, size])
        speeds.append(np.linalg.norm(solve_stack([position(np.zeros(3), J, np.ones(3))])))
    assert max(speeds) < 25.0
    assert abs(speeds[1] - speeds[2]) < 0.3
    assert abs(speeds[4] - speeds[5]) < 0.3


def test_damped_directions_are_closed_to_lower_tasks():
    first = Task("held", np.zeros(1), np.zeros(1), np.array([[0.019, 0.0, 0.0]]))
    second = Task("pulls", np.zeros(1), np.ones(1), np.array([[1.0, 0.0, 0.0]]))
    assert np.allclose(first.jacobian @ solve_stack([first, second]), 0.0)


def test_bad_stacks_and_tasks_are_refused():
    with pytest.raises(InputError, match="at least one"):
        solve_stack([])
    with pytest.raises(InputError, match="must agree"):
        Task("odd", np.zeros(2), np.zeros(3), np.zeros((3, 7)))
    with pytest.raises(InputError, match="finite"):
        Task("nan", np.zeros(1), np.array([np.nan]), np.zeros((1, 7)))
    with pytest.raises(InputError, match="same number of joints"):
        solve_stack([Task("a", np.zeros(1), np.zeros(1), np.ones((1, n))) for n in (6, 7)])
    with pytest.raises(InputError, match="gain"):
        solve_stack([Task("a", np.zeros(1), np.zeros(1), np.ones((1, 7)))], gain=float("nan"))
    with pytest.raises(InputError, match="axis"):
        axis_alignment(np.zeros(3), np.eye(3), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match="centre"):
        distance_to_point(np.zeros(3), np.eye(3), np.zeros(3), 0.1)
