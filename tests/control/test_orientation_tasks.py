"""Orientation tasks: Jacobians against finite differences, opposite axes, half turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.robot_state import RobotState
from eyehand.control.tasks import AxisAlignment, LookAt, Orientation, Pose, Position
from eyehand.errors import InputError

POINT = np.array([0.03, -0.05, 0.1])
AXIS = np.array([0.3, -0.2, 1.0])
seeds = st.integers(0, 100_000)


def rotating_state(rotation: Rotation, angular: np.ndarray | None = None) -> RobotState:
    """Return the state of a body that rotates freely about its origin."""
    angular = np.eye(3) if angular is None else angular
    n = angular.shape[1]
    jacobian = np.concatenate([np.zeros((3, n)), angular])
    zeros, ones = np.zeros(n), np.ones(n)
    return RobotState(zeros, np.zeros(3), rotation.as_matrix(), jacobian, -ones, ones, zeros, ones)


@pytest.mark.parametrize("seed", range(20))
def test_jacobian_equals_finite_differences(arm_state, check_jacobian, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.0, 2.0, 7)
    goal = Rotation.random(rng=rng)
    pose = RigidTransform.from_components(rng.normal(size=3), goal)
    target = rng.normal(size=3)
    for task in (
        Orientation(goal),
        Pose(pose),
        Pose(pose, POINT),
        AxisAlignment(AXIS, rng.normal(size=3)),
        LookAt(target, 0.0, AXIS, POINT),
        LookAt(target, 0.01, AXIS, POINT),
    ):
        check_jacobian(task, q)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, 1e-2, 3.0])
def test_jacobian_holds_at_small_and_large_rotations(arm_state, check_jacobian, angle):
    q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
    rotation = Rotation.from_matrix(arm_state(q).rotation)
    rotated = Rotation.from_rotvec(angle * np.array([0.36, 0.48, 0.8])) * rotation
    check_jacobian(Orientation(rotated), q)
    check_jacobian(AxisAlignment(AXIS, rotated.apply(AXIS)), q)


@given(seed=seeds, angle=st.sampled_from([0.0, 1e-12, 1e-6, 1.0, 3.0, np.pi - 1e-9, np.pi]))
def test_orientation_error_is_the_smallest_rotation(seed, angle):
    rng = np.random.default_rng(seed)
    start, axis = Rotation.random(rng=rng), rng.normal(size=3)
    goal = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)) * start
    found = Orientation(goal).at(rotating_state(start))
    turn, rows = found.error, found.jacobian
    assert np.linalg.norm(turn) == pytest.approx(angle, abs=1e-7)
    assert (Rotation.from_rotvec(turn) * start * goal.inv()).magnitude() < 1e-7
    assert turn == pytest.approx((goal * start.inv()).as_rotvec(), abs=1e-7) or angle > 3.1
    # The commanded rotation is about the axis of the error.
    assert np.linalg.solve(rows, turn) == pytest.approx(turn, abs=1e-9)


def test_half_turn_rotates_about_axis_with_positive_largest_coordinate():
    for axis in np.vstack([np.eye(3), -np.eye(3), [[0.6, -0.8, 0.0]]]):
        rows = Orientation(Rotation.from_rotvec(np.pi * axis)).at(
            rotating_state(Rotation.identity())
        )
        assert np.linalg.norm(rows.error) == pytest.approx(np.pi)
        assert rows.error[np.argmax(np.abs(axis))] > 3.0 * np.abs(axis).max()
        assert np.all(np.isfinite(rows.jacobian))


@given(seed=seeds)
def test_orientation_rotates_about_a_fixed_axis(seed):
    rng = np.random.default_rng(seed)
    rotation, goal = Rotation.random(2, rng=rng)
    task = Orientation(goal, gain=1.0, speed=np.inf)
    start = task.at(rotating_state(rotation)).error
    for _ in range(40):
        rows = task.at(rotating_state(rotation))
        assert np.cross(rows.error, start) == pytest.approx(np.zeros(3), abs=1e-7)
        rotation = Rotation.from_rotvec(0.3 * np.linalg.solve(rows.jacobian, rows.rate)) * rotation
    assert (rotation * goal.inv()).magnitude() < 1e-5


@given(seed=seeds)
def test_alignment_leaves_rotation_about_axis_free(seed):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(rng=rng)
    task = AxisAlignment(AXIS, rng.normal(size=3), gain=1.0, speed=np.inf)
    for _ in range(60):
        rows = task.at(rotating_state(rotation))
        axis = rotation.apply(AXIS / np.linalg.norm(AXIS))
        assert rows.jacobian.shape == (2, 3)
        assert rows.jacobian @ axis == pytest.approx(np.zeros(2), abs=1e-9)
        rotation = Rotation.from_rotvec(0.2 * np.linalg.pinv(rows.jacobian) @ rows.rate) * rotation
    assert rotation.apply(AXIS) @ task.goal > (1.0 - 1e-9) * np.linalg.norm(AXIS)


@pytest.mark.parametrize("hinge", [0, 1])
def test_opposite_axes_turn_about_available_joint(hinge):
    # With a single joint, one of the two perpendicular directions cannot move.
    z = np.array([0.0, 0.0, 1.0])
    rotation = Rotation.identity()
    task = AxisAlignment(z, -z, gain=1.0, speed=np.inf)
    angular = np.eye(3)[:, [hinge]]
    assert np.linalg.norm(task.at(rotating_state(rotation, angular)).error) == pytest.approx(np.pi)
    for _ in range(80):
        rows = task.at(rotating_state(rotation, angular))
        assert np.all(np.isfinite(rows.jacobian))
        assert np.abs(rows.jacobian).max() < 101.0
        step = angular @ np.linalg.pinv(rows.jacobian) @ rows.rate
        rotation = Rotation.from_rotvec(0.2 * step) * rotation
    assert rotation.apply(z) @ -z > 1.0 - 1e-9


def test_translation_of_camera_changes_view_direction(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    frozen = RobotState(
        **{**vars(state), "jacobian": np.vstack([state.jacobian[:3], np.zeros((3, 7))])}
    )
    ahead = state.position + 0.2 * state.rotation[:, 2]
    rows = LookAt(ahead).at(frozen)
    assert np.linalg.norm(rows.error) == pytest.approx(0.0, abs=1e-7)
    # A lateral speed of 1 m/s turns the view direction by 1 / distance, rad/s.
    assert np.linalg.norm(rows.jacobian, 2) == pytest.approx(
        np.linalg.norm(state.rotation.T[:2] @ state.jacobian[:3], 2) / 0.2
    )


def test_cone_is_active_only_at_its_boundary(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    for angle, rows, unmet in (
        (0.0, 0, 0.0),
        (0.35, 1, 0.0),
        (0.7, 1, 0.1),
        (np.pi, 1, np.pi - 0.6),
    ):
        view = state.rotation @ [np.sin(angle), 0.0, np.cos(angle)]
        found = LookAt(state.position + 0.5 * view, 0.6, gain=3.0).at(state)
        assert len(found.value) == rows
        assert found.side == -rows
        assert found.unmet == pytest.approx(unmet, abs=1e-9)


def test_target_at_camera_origin_deactivates_look_at(arm_state):
    state = arm_state(np.zeros(7))
    assert LookAt(state.position).at(state).jacobian.shape == (0, 7)
    assert LookAt(state.position + 1e-4, 0.2).at(state).jacobian.shape == (0, 7)


def test_pose_keeps_both_speed_limits_and_contains_position_rows(arm_state):
    q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
    state = arm_state(q)
    for shift, turn in ((1.0, 0.1), (0.01, 2.0), (0.001, 0.001)):
        goal = RigidTransform.from_components(
            state.position + np.array([0.0, shift, 0.0]),
            Rotation.from_rotvec([turn, 0.0, 0.0]) * Rotation.from_matrix(state.rotation),
        )
        rows = Pose(goal, speed=0.2, turn_speed=0.9, gain=3.0).at(state)
        share = min(1.0, 0.2 / (3.0 * shift), 0.9 / (3.0 * turn))
        assert rows.rate == pytest.approx(share * 3.0 * np.array([0, shift, 0, turn, 0, 0]))
        position = Position(goal.translation).at(state)
        assert rows.jacobian[:3] == pytest.approx(position.jacobian)
        assert rows.error[:3] == pytest.approx(position.error)


def test_goals_can_be_matrices(arm_state):
    state = arm_state(np.ones(7))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = state.rotation, state.position
    assert np.abs(Pose(matrix).at(state).error).max() < 1e-9
    assert np.abs(Orientation(state.rotation).at(state).error).max() < 1e-9


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Orientation(np.eye(4)), r"goal must have shape \(3, 3\)"),
        (lambda: Orientation(np.diag([1.0, 1.0, -1.0])), "goal must be a rotation"),
        (lambda: Orientation(2.0 * np.eye(3)), "goal must be a rotation"),
        (lambda: Orientation(np.full((3, 3), np.nan)), "goal must be finite"),
        (lambda: Orientation(Rotation.identity(2)), "goal must have shape"),
        (lambda: Pose(np.eye(3)), r"goal must have shape \(4, 4\)"),
        (lambda: Pose(np.diag([1.0, 2.0, 1.0, 1.0])), "rotation"),
        (lambda: Pose(np.eye(4), turn_speed=0.0), "speed"),
        (lambda: AxisAlignment(np.zeros(3), np.ones(3)), "axis must be a direction"),
        (lambda: AxisAlignment(np.ones(3), np.array([np.inf, 0, 0])), "goal must be finite"),
        (lambda: LookAt(np.ones(2)), "target must have shape"),
        (lambda: LookAt(np.ones(3), -0.1), "half_angle"),
        (lambda: LookAt(np.ones(3), 4.0), r"half_angle must be finite and in \[0, 3.14159\]"),
        (lambda: LookAt(np.ones(3), axis=np.zeros(3)), "axis must be a direction"),
    ],
)
def test_orientation_tasks_reject_invalid_fields(make, message):
    with pytest.raises(InputError, match=message):
        make()
