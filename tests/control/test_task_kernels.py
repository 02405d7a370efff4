"""The tasks against their NumPy reference, in general postures and where directions are lost."""

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
"""Angles from or to a direction whose way is but rounding, in the task as in the kernel."""


def compiled(task: Task, state: RobotState):
    """Error, commanded rate, rows, side and unmet norm, as the control cycle computes them."""
    packed = pack_tasks((task,), len(state.q))
    assert packed is not None
    most = max(6, len(state.q))
    rate = np.full(most, np.nan)
    out = Output(
        np.full(most, np.nan), np.full(most, np.nan), np.full((most, len(state.q)), np.nan)
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
    found = max(m, 0)
    return m, out.error[:found], rate[:found], out.rows[:found], side, unmet


def check(task: Task, state: RobotState, tolerance: float = 1e-12) -> None:
    """Hold the control cycle and the task's own `at` to the NumPy reference."""
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


def any_tasks(rng: np.random.Generator, joints: int) -> list[Task]:
    """One of every kind, with points and axes off the frame's, gains and speeds of many sizes."""

    def some(size: float = 0.5):
        return size * rng.normal(size=3)

    def rates():
        return {"gain": rng.uniform(0.1, 10.0), "speed": rng.choice([0.06, 0.3, 2.0, np.inf])}

    pose = RigidTransform.from_components(some(), Rotation.random(rng=rng))
    return [
        Position(some(), some(0.1), **rates()),
        DistanceToPoint(some(), rng.uniform(0.0, 0.5), some(0.1), **rates()),
        DistanceToPoint(some(), 0.0, some(0.1), **rates()),
        DistanceToAxis(some(), some(), rng.uniform(0.01, 0.5), some(0.1), **rates()),
        DistanceToAxis(some(), some(), 0.0, some(0.1), **rates()),
        PointOnPlane(some(), rng.normal(), some(0.1), **rates()),
        Orientation(Rotation.random(rng=rng), **rates()),
        Pose(pose, some(0.1), **rates(), turn_speed=rng.uniform(0.1, 3.0)),
        AxisAlignment(some(), some(), **rates()),
        LookAt(some(), 0.0, some(), some(0.1), **rates()),
        LookAt(some(), rng.uniform(0.01, 3.0), some(), some(0.1), **rates()),
        JointCentring(int(rng.choice([2, 4, 6])), **rates()),
        JointCentring(2, rng.normal(size=joints), **rates()),
        Posture(rng.normal(size=joints), **rates()),
    ]


def bounded(rng: np.random.Generator, state: RobotState, tasks: list[Task]) -> list[Task]:
    """Intervals about those of one row: the value far inside, near a bound, or outside."""
    found: list[Task] = []
    for task in tasks:
        expected = task.at(state)
        if len(expected.value) != 1:
            continue
        value = float(expected.value[0])
        low, high = value + np.sort(rng.normal(size=2) * 10.0 ** rng.uniform(-3, 0.5))
        found += [
            Interval(task, low, high),
            Interval(task, -np.inf, high),
            Interval(task, low, np.inf),
            Interval(task, low, low),
        ]
    return found


@given(seed=seeds)
def test_every_kind_gives_the_task_of_its_reference(arm_state, mixed_state, seed):
    rng = np.random.default_rng(seed)
    for state in (arm_state(rng.uniform(-2.0, 2.0, 7)), mixed_state(rng.uniform(-0.9, 0.9, 8))):
        tasks = any_tasks(rng, len(state.q))
        for task in [*tasks, *bounded(rng, state, tasks)]:
            check(task, state)


@given(seed=seeds, angle=st.sampled_from(ANGLES))
def test_turns_agree_at_any_angle(arm_state, seed, angle):
    rng = np.random.default_rng(seed)
    state = arm_state(rng.uniform(-2.0, 2.0, 7))
    axis, eye = rng.normal(size=3), 0.1 * rng.normal(size=3)
    turn = rng.normal(size=3)
    if seed % 2:
        turn = np.eye(3)[seed % 3]
    away = Rotation.from_rotvec(angle * turn / np.linalg.norm(turn))
    now = Rotation.from_matrix(state.rotation)
    check(Orientation(away * now), state, 1e-11)
    across = np.cross(state.rotation @ axis, turn)
    across /= np.linalg.norm(across)
    aside = Rotation.from_rotvec(angle * across)
    if angle in DECIDED_BY_ROUNDING:
        return
    tolerance = 1e-9 if angle == 1e-6 else 1e-12
    check(AxisAlignment(axis, aside.apply(now.apply(axis))), state, tolerance)
    position, _ = state.point(eye)
    target = position + 0.3 * aside.apply(now.apply(axis)) / np.linalg.norm(axis)
    check(LookAt(target, 0.0, axis, eye), state, tolerance)
    check(LookAt(target, 0.01, axis, eye), state, tolerance)


def test_a_lost_direction_is_that_of_the_task(arm_state):
    q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
    state = arm_state(q)
    point = np.array([0.03, -0.05, 0.1])
    place = state.point(point)[0]
    straight = state.rotation[:, 2]
    check(Position(place, point), state)
    check(DistanceToPoint(place, 0.2, point), state)
    check(DistanceToAxis(place, np.array([1.0, 2.0, 0.5]), 0.2, point), state)
    check(DistanceToAxis(place, np.array([1.0, 2.0, 0.5]), 0.0, point), state)
    check(AxisAlignment(np.array([0.0, 0.0, 1.0]), straight), state)
    check(AxisAlignment(np.array([0.0, 0.0, 1.0]), -straight), state)
    for distance in (0.0, 9e-4, 2e-3):
        check(LookAt(place + distance * straight, point=point), state)
        check(LookAt(place - distance * straight, 0.3, point=point), state)


def test_centring_leaves_joints_without_a_range_alone(arm_state):
    state = arm_state(np.full(7, 0.3))
    lower, upper = state.lower.copy(), state.upper.copy()
    lower[2], upper[4] = -np.inf, np.inf
    loose = replace(state, lower=lower, upper=upper)
    check(JointCentring(4), loose)
    check(JointCentring(2, np.full(7, -0.2)), loose)


@dataclass(frozen=True, eq=False)
class _Own(Position):
    """A user's task that looks like a built-in one."""


def test_what_kernels_do_not_know_is_not_packed(arm_state):
    goal = np.zeros(3)
    known = Position(goal)
    assert pack_tasks((known, known), 7) is not None
    for task in (
        _Own(goal),
        Manipulability(0.1),
        Interval(Interval(DistanceToPoint(goal, 0.1), 0.0, 0.2), 0.0, 0.1),
        Interval(Manipulability(0.1), 0.0, 1.0),
    ):
        assert pack_tasks((known, task), 7) is None
    for task in (Posture(np.zeros(6)), JointCentring(2, np.zeros(8))):
        with pytest.raises(InputError, match="one number per joint"):
            pack_tasks((known, task), 7)


def test_an_interval_about_several_rows_does_not_fit(arm_state):
    state = arm_state(np.full(7, 0.3))
    assert compiled(Interval(Position(np.zeros(3)), 0.0, 1.0), state)[0] == MISFIT
