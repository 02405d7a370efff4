"""Position tasks: Jacobians against finite differences, singular points, and invalid fields."""

import numpy as np
import pytest

from eyehand.control.tasks import DistanceToAxis, DistanceToPoint, PointOnPlane, Position
from eyehand.errors import InputError

POINT = np.array([0.03, -0.05, 0.1])


def tasks(rng: np.random.Generator):
    a, b = rng.normal(size=(2, 3))
    return [
        Position(a),
        Position(a, POINT),
        DistanceToPoint(a, 0.2, POINT),
        DistanceToAxis(a, b, 0.2, POINT),
        DistanceToAxis(a, b, 0.0, POINT),
        PointOnPlane(b, 0.3, POINT),
    ]


@pytest.mark.parametrize("seed", range(20))
def test_jacobian_equals_finite_differences(arm_state, check_jacobian, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.0, 2.0, 7)
    for task in tasks(rng):
        check_jacobian(task, q)


def test_values_and_errors_match_geometry(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    position = state.position + state.rotation @ POINT
    centre = position + np.array([0.0, 3.0, 4.0])
    distance = DistanceToPoint(centre, 2.0, POINT).at(state)
    assert distance.value == pytest.approx([5.0])
    assert distance.error == pytest.approx([-3.0])
    axis_distance = DistanceToAxis(centre, np.array([0.0, 0.0, 7.0]), 1.0, POINT).at(state)
    assert axis_distance.value == pytest.approx([3.0])
    assert axis_distance.error == pytest.approx([-2.0])
    on_axis = DistanceToAxis(centre, np.array([0.0, 0.0, 7.0]), 0.0, POINT).at(state)
    assert on_axis.value.shape == (2,)
    assert np.linalg.norm(on_axis.error) == pytest.approx(3.0)
    plane = PointOnPlane(np.array([0.0, 2.0, 0.0]), float(position[1]) + 0.1, POINT).at(state)
    assert plane.error == pytest.approx([0.1])
    assert Position(centre, POINT).at(state).error == pytest.approx([0.0, 3.0, 4.0])


def test_commanded_speed_is_speed_of_point(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    task = DistanceToPoint(state.position + 2.0, 0.1, speed=0.07).at(state)
    motion = np.linalg.pinv(task.jacobian) @ task.rate
    direction = np.ones(3) / np.sqrt(3.0)
    assert direction @ (state.jacobian[:3] @ motion) == pytest.approx(0.07)


def test_jacobian_is_not_zero_on_centre_or_axis(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    for task in (
        DistanceToPoint(state.position, 0.1),
        DistanceToAxis(state.position, np.array([0.0, 0.0, 1.0]), 0.1),
    ):
        rows = task.at(state)
        assert rows.error == pytest.approx([0.1])
        assert np.linalg.norm(rows.jacobian) > 0.1
        ahead = arm_state(state.q + 1e-3 * np.linalg.pinv(rows.jacobian)[:, 0])
        assert task.at(ahead).value[0] > 0.9e-3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Position(np.zeros(2)), r"goal must have shape \(3,\), got \(2,\)"),
        (lambda: Position(np.array([0.0, np.nan, 0.0])), "goal must be finite"),
        (lambda: Position(np.zeros(3), point=np.zeros((3, 1))), "point must have shape"),
        (lambda: Position(np.zeros(3), gain=-1.0), "gain"),
        (lambda: Position(np.zeros(3), speed=0.0), "speed"),
        (lambda: Position(np.zeros(3), gain="3"), "gain must be a number"),  # pyright: ignore[reportArgumentType] - the invalid argument under test
        (lambda: DistanceToPoint(np.zeros(3), "1"), "distance must be a number"),  # pyright: ignore[reportArgumentType] - the invalid argument under test
        (lambda: DistanceToPoint(np.zeros(3), -0.1), r"distance must be finite and in \[0, inf\]"),
        (lambda: DistanceToPoint(np.zeros(3), np.inf), "distance"),
        (lambda: DistanceToAxis(np.zeros(3), np.zeros(3), 0.1), "direction must be a direction"),
        (lambda: DistanceToAxis(np.zeros(3), np.ones(3), np.nan), "distance"),
        (lambda: PointOnPlane(np.zeros(3), 0.1), "normal must be a direction"),
        (lambda: PointOnPlane(np.ones(3), np.nan), "offset"),
    ],
)
def test_position_tasks_reject_invalid_fields(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_task_copies_its_arrays_and_makes_them_read_only():
    goal = np.zeros(3)
    task = Position(goal)
    goal[0] = np.nan
    assert np.all(task.goal == 0.0)
    with pytest.raises(ValueError, match="read-only"):
        task.goal[0] = 1.0
