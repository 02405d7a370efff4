"""The task kernels against the NumPy reference, in general and singular configurations."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.robot_state import RobotState
from eyehand.control.tasks import (
    AxisAlignment,
    DistanceToAxis,
    DistanceToPoint,
    Interval,
    JointCentring,
    LookAt,
    Manipulability,
    Orientation,
    PointOnPlane,
    Pose,
    Position,
    Posture,
    Task,
)
from eyehand.control.tasks.kernel_task import Frame, Output
from eyehand.control.tasks.registry import MISFIT, evaluate_task, pack_tasks
from eyehand.errors import InputError

from .task_reference import reference

seeds = st.integers(0, 100_000)
ANGLES = [0.0, 1e-12, 1e-9, 1e-6, 0.02, 1.0, 3.0, np.pi - 1e-9, np.pi]
DECIDED_BY_ROUNDING = (1e-12, 1e-9, np.pi - 1e-9)
"""Angles at which rounding decides the direction of rotation, in the task and in the kernel."""


def compiled(task: Task, state: RobotState):
    """Evaluate a task as the control cycle does.

    Return the row count, error, commanded rate, rows, side and unmet norm.
    """
    packed = pack_tasks((task,), len(state.q))
    assert packed is not None
    max_rows = max(6, len(state.q))
    rate = np.full(max_rows, np.nan)
    out = Output(
        np.full(max_rows, np.nan),
        np.full(max_rows, np.nan),
        np.full((max_rows, len(state.q)), np.nan),
    )
    frame = Frame(
        state.q,
        np.column_stack([state.lower, state.upper, state.speed]),
        state.position,
        state.rotation.ravel(),
        np.ascontiguousarray(state.jacobian),
        np.empty((6, len(state.q))),
    )
    m, side, unmet = evaluate_task(packed[0], frame, out, rate)
    count = max(m, 0)
    return m, out.error[:count], rate[:count], out.rows[:count], side, unmet


def check(task: Task, state: RobotState, tolerance: float = 1e-12) -> None:
    """Compare the kernel and the task's `at` with the NumPy reference."""
    m, error, rate, rows, side, unmet = compiled(task, state)
    expected, own = reference(task, state), task.at(state)
    assert m == len(expected.error), task
    np.testing.assert_allclose(error, expected.error, atol=tolerance, err_msg=task.name)
    np.testing.assert_allclose(rate, expected.rate, atol=10 * tolerance, err_msg=task.name)
    np.testing.assert_allclose(rows, expected.jacobian, atol=10 * tolerance, err_msg=task.name)
    assert side == expected.side
    assert unmet == pytest.approx(expected.unmet, abs=tolerance)
    np.testing.assert_allclose(own.value, expected.value, atol=tolerance, err_msg=task.name)
    np.testing.assert_array_equal(own.error, error)
    np.testing.assert_array_equal(own.jacobian, rows)
    np.testing.assert_allclose(own.rate, rate, atol=tolerance)
    assert own.side == side


def random_tasks(rng: np.random.Generator, joints: int) -> list[Task]:
    """Return one task of every kind, with random points, axes, gains and speeds."""

    def vector(size: float = 0.5):
        return size * rng.normal(size=3)

    def rates():
        return {"gain": rng.uniform(0.1, 10.0), "speed": rng.choice([0.06, 0.3, 2.0, np.inf])}

    pose = RigidTransform.from_components(vector(), Rotation.random(rng=rng))
    return [
        Position(vector(), vector(0.1), **rates()),
        DistanceToPoint(vector(), rng.uniform(0.0, 0.5), vector(0.1), **rates()),
        DistanceToPoint(vector(), 0.0, vector(0.1), **rates()),
        DistanceToAxis(vector(), vector(), rng.uniform(0.01, 0.5), vector(0.1), **rates()),
        DistanceToAxis(vector(), vector(), 0.0, vector(0.1), **rates()),
        PointOnPlane(vector(), rng.normal(), vector(0.1), **rates()),
        Orientation(Rotation.random(rng=rng), **rates()),
        Pose(pose, vector(0.1), **rates(), turn_speed=rng.uniform(0.1, 3.0)),
        AxisAlignment(vector(), vector(), **rates()),
        LookAt(vector(), 0.0, vector(), vector(0.1), **rates()),
        LookAt(vector(), rng.uniform(0.01, 3.0), vector(), vector(0.1), **rates()),
        JointCentring(int(rng.choice([2, 4, 6])), **rates()),
        JointCentring(2, rng.normal(size=joints), **rates()),
        Posture(rng.normal(size=joints), **rates()),
    ]


def interval_tasks(rng: np.random.Generator, state: RobotState, tasks: list[Task]) -> list[Task]:
    """Return intervals around the tasks of one row: value inside, at a bound, or outside."""
    count: list[Task] = []
    for task in tasks:
        expected = task.at(state)
        if len(expected.value) != 1:
            continue
        value = float(expected.value[0])
        low, high = value + np.sort(rng.normal(size=2) * 10.0 ** rng.uniform(-3, 0.5))
        count += [
            Interval(task, low, high),
            Interval(task, -np.inf, high),
            Interval(task, low, np.inf),
            Interval(task, low, low),
        ]
    return count


@given(seed=seeds)
def test_kernels_equal_reference_for_every_task_kind(arm_state, mixed_state, seed):
    rng = np.random.default_rng(seed)
    for state in (arm_state(rng.uniform(-2.0, 2.0, 7)), mixed_state(rng.uniform(-0.9, 0.9, 8))):
        tasks = random_tasks(rng, len(state.q))
        for task in [*tasks, *interval_tasks(rng, state, tasks)]:
            check(task, state)


@given(seed=seeds, angle=st.sampled_from(ANGLES))
def test_orientation_kernels_equal_reference_at_any_angle(arm_state, seed, angle):
    rng = np.random.default_rng(seed)
    state = arm_state(rng.uniform(-2.0, 2.0, 7))
    axis, eye = rng.normal(size=3), 0.1 * rng.normal(size=3)
    turn = rng.normal(size=3)
    if seed % 2:
        turn = np.eye(3)[seed % 3]
    rotation = Rotation.from_rotvec(angle * turn / np.linalg.norm(turn))
    current = Rotation.from_matrix(state.rotation)
    check(Orientation(rotation * current), state, 1e-11)
    across = np.cross(state.rotation @ axis, turn)
    across /= np.linalg.norm(across)
    aside = Rotation.from_rotvec(angle * across)
    if angle in DECIDED_BY_ROUNDING:
        return
    tolerance = 1e-9 if angle == 1e-6 else 1e-12
    check(AxisAlignment(axis, aside.apply(current.apply(axis))), state, tolerance)
    position, _ = state.point(eye)
    target = position + 0.3 * aside.apply(current.apply(axis)) / np.linalg.norm(axis)
    check(LookAt(target, 0.0, axis, eye), state, tolerance)
    check(LookAt(target, 0.01, axis, eye), state, tolerance)


def test_kernels_equal_reference_at_singular_points(arm_state):
    q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
    state = arm_state(q)
    point = np.array([0.03, -0.05, 0.1])
    position = state.point(point)[0]
    straight = state.rotation[:, 2]
    check(Position(position, point), state)
    check(DistanceToPoint(position, 0.2, point), state)
    check(DistanceToAxis(position, np.array([1.0, 2.0, 0.5]), 0.2, point), state)
    check(DistanceToAxis(position, np.array([1.0, 2.0, 0.5]), 0.0, point), state)
    check(AxisAlignment(np.array([0.0, 0.0, 1.0]), straight), state)
    check(AxisAlignment(np.array([0.0, 0.0, 1.0]), -straight), state)
    for distance in (0.0, 9e-4, 2e-3):
        check(LookAt(position + distance * straight, point=point), state)
        check(LookAt(position - distance * straight, 0.3, point=point), state)


def test_centring_ignores_joints_without_range(arm_state):
    state = arm_state(np.full(7, 0.3))
    lower, upper = state.lower.copy(), state.upper.copy()
    lower[2], upper[4] = -np.inf, np.inf
    loose = replace(state, lower=lower, upper=upper)
    check(JointCentring(4), loose)
    check(JointCentring(2, np.full(7, -0.2)), loose)


@dataclass(frozen=True, eq=False)
class _CustomPosition(Position):
    """A user's task that is derived from a built-in one."""


def test_unsupported_tasks_are_not_packed(arm_state):
    goal = np.zeros(3)
    known = Position(goal)
    assert pack_tasks((known, known), 7) is not None
    for task in (
        _CustomPosition(goal),
        Manipulability(0.1),
        Interval(Interval(DistanceToPoint(goal, 0.1), 0.0, 0.2), 0.0, 0.1),
        Interval(Manipulability(0.1), 0.0, 1.0),
    ):
        assert pack_tasks((known, task), 7) is None
    for task in (Posture(np.zeros(6)), JointCentring(2, np.zeros(8))):
        with pytest.raises(InputError, match="one number per joint"):
            pack_tasks((known, task), 7)


def test_interval_of_several_rows_is_misfit(arm_state):
    state = arm_state(np.full(7, 0.3))
    assert compiled(Interval(Position(np.zeros(3)), 0.0, 1.0), state)[0] == MISFIT
