"""The task stack: priorities, singular configurations, one-sided bounds."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from eyehand.control.stack import solve_stack
from eyehand.control.stack_kernels import DAMPING, LOST, NEAR_SINGULAR
from eyehand.control.tasks import AxisAlignment, DistanceToPoint, Orientation, Position, TaskRows
from eyehand.errors import InputError

from .stack_reference import damped_inverse, solve_reference

Array = NDArray[np.float64]
Q = np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1])
PRINTED = partial(solve_reference, printed=True)
seeds = st.integers(0, 100_000)


def task(rows, rate, side: int = 0, name: str = "task") -> TaskRows:
    rows, rate = np.atleast_2d(np.asarray(rows, float)), np.atleast_1d(np.asarray(rate, float))
    return TaskRows(name, np.zeros(len(rate)), rate, rows, side=side)


def rows_with(rng: np.random.Generator, singular: Array, joints: int) -> Array:
    left = np.linalg.qr(rng.normal(size=(len(singular), len(singular))))[0]
    right = np.linalg.qr(rng.normal(size=(joints, joints)))[0]
    return (left * singular) @ right[: len(singular)]


def regular_task(rng: np.random.Generator, count: int, joints: int) -> TaskRows:
    singular = rng.uniform(0.051, 2.0, count)
    return task(rows_with(rng, singular, joints), rng.normal(size=count))


def random_task(rng: np.random.Generator, above: TaskRows, joints: int) -> TaskRows:
    """Return a task that may be near-singular, or in conflict with the task above."""
    count = int(rng.integers(1, 4))
    rows = rows_with(rng, 10.0 ** rng.uniform(-9, 0.3, count), joints)
    if rng.random() < 0.3:
        nearly = 10.0 ** rng.uniform(-12, -1)
        rows[0] = above.jacobian[0] + nearly * rng.normal(size=joints)
    return task(rows, 3.0 * rng.normal(size=count))


# Priority


@given(seed=seeds)
def test_lower_priority_tasks_do_not_disturb_the_first(seed):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(4, 10))
    tasks = [regular_task(rng, int(rng.integers(1, 4)), joints)]
    for _ in range(rng.integers(1, 4)):
        tasks.append(random_task(rng, tasks[-1], joints))
    solution = solve_stack(tasks, free_motion=rng.normal(size=joints))
    leak = tasks[0].jacobian @ solution.velocity - tasks[0].rate
    assert np.abs(leak).max() < 1e-9
    assert solution.missing[0] < 1e-9


@given(seed=seeds)
def test_joint_speed_limits_scale_lower_levels_only(seed):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(4, 10))
    first = regular_task(rng, int(rng.integers(1, 4)), joints)
    tasks = [first]
    for _ in range(rng.integers(1, 4)):
        tasks.append(random_task(rng, tasks[-1], joints))
    alone = solve_stack([first]).velocity
    speed = np.abs(alone) * rng.uniform(1.0, 1.5, joints)
    solution = solve_stack(tasks, free_motion=rng.normal(size=joints), speed=speed)
    assert np.abs(first.jacobian @ solution.velocity - first.rate).max() < 1e-9
    assert np.all(np.abs(solution.velocity) <= speed + 1e-9)
    assert solution.scale[0] == 1.0
    assert all(0.0 <= scale <= 1.0 for scale in solution.scale)


def test_first_task_of_arm_is_not_disturbed(arm_state):
    rng = np.random.default_rng(4)
    tried = 0
    for _ in range(200):
        state = arm_state(rng.uniform(-1.9, 1.9, 7))
        first = Position(state.position + 0.1 * rng.normal(size=3)).at(state)
        if np.linalg.svd(first.jacobian, compute_uv=False)[-1] < 0.05:
            continue
        tried += 1
        lower = [
            Orientation(np.eye(3)).at(state),
            DistanceToPoint(rng.normal(size=3), 0.3).at(state),
            AxisAlignment(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])).at(state),
        ]
        tasks = [first, *lower[: rng.integers(1, 4)]]
        free = 5.0 * rng.normal(size=7)
        speed = np.maximum(np.abs(solve_stack([first]).velocity), state.speed)
        for limits in (None, speed):
            velocity = solve_stack(tasks, free_motion=free, speed=limits).velocity
            assert np.abs(first.jacobian @ velocity - first.rate).max() < 1e-9
    assert tried > 150


@given(seed=seeds)
def test_each_level_is_optimal_in_null_space_of_higher_levels(seed):
    rng = np.random.default_rng(seed)
    # Conflicting but regular: 3 + 3 rows on 5 joints.
    first, second = regular_task(rng, 3, 5), task(rng.normal(size=(3, 5)), rng.normal(size=3))
    solution = solve_stack([first, second])
    null = np.linalg.svd(first.jacobian)[2][3:].T
    inside = second.jacobian @ null
    if np.linalg.svd(inside, compute_uv=False)[-1] < 0.05:
        return
    start = np.linalg.pinv(first.jacobian) @ first.rate
    best = start + null @ np.linalg.lstsq(inside, second.rate - second.jacobian @ start)[0]
    assert np.allclose(solution.velocity, best, atol=1e-9)
    assert solution.missing[1] == pytest.approx(
        np.linalg.norm(second.rate - second.jacobian @ best), abs=1e-9
    )


@given(seed=seeds)
def test_free_motion_is_in_null_space_of_all_tasks(seed):
    rng = np.random.default_rng(seed)
    tasks, free = [regular_task(rng, 2, 7), regular_task(rng, 2, 7)], rng.normal(size=7)
    with_it, without = solve_stack(tasks, free_motion=free), solve_stack(tasks)
    step = with_it.velocity - without.velocity
    rows = np.concatenate([t.jacobian for t in tasks])
    null = np.linalg.svd(rows)[2][4:].T
    assert np.allclose(step, null @ null.T @ free, atol=1e-9)
    free = solve_reference(tasks).free
    assert np.allclose(free.T @ free, np.eye(3), atol=1e-12)
    assert np.abs(rows @ free).max() < 1e-9


# The printed form


@given(seed=seeds, count=st.integers(1, 4))
def test_printed_form_follows_equation_3(seed, count):
    rng = np.random.default_rng(seed)
    tasks = [regular_task(rng, 2, 8) for _ in range(count)]
    free = rng.normal(size=8)
    expected, projector = np.zeros(8), np.eye(8)
    for t in tasks:
        inverse = np.linalg.pinv(t.jacobian)
        expected += projector @ inverse @ t.rate
        projector = projector @ (np.eye(8) - inverse @ t.jacobian)
    velocity = solve_reference(tasks, free_motion=free, printed=True).velocity
    assert np.allclose(velocity, expected + projector @ free, atol=1e-9)


def test_third_task_disturbs_second_in_printed_form_only():
    rng = np.random.default_rng(2)
    worst = {"paper": 0.0, "strict": 0.0}
    for _ in range(50):
        tasks = [regular_task(rng, 2, 7) for _ in range(3)]
        for mode in ("paper", "strict"):
            solve = solve_stack if mode == "strict" else PRINTED
            moved = solve(tasks).velocity - solve(tasks[:2]).velocity
            worst[mode] = max(worst[mode], np.abs(tasks[1].jacobian @ moved).max())
            assert np.abs(tasks[0].jacobian @ moved).max() < 1e-9
    assert worst["paper"] > 0.1
    assert worst["strict"] < 1e-9


def test_second_task_has_error_in_printed_form_only():
    first, second = task([1.0, 1.0, 0.0], 1.0), task([0.0, 1.0, 0.0], 2.0)
    assert solve_stack([first, second]).missing[1] == pytest.approx(0.0, abs=1e-12)
    assert solve_reference([first, second], printed=True).missing[1] > 0.1


# Singular configurations


def test_speed_is_continuous_in_singular_value():
    sizes = np.concatenate(
        [[0.0], np.geomspace(LOST / 100.0, 0.2, 4000), [0.05, 0.0500001, LOST, 2.0 * LOST]]
    )
    sizes.sort()
    speeds = np.array(
        [solve_stack([task(np.diag([1.0, 1.0, size]), [0, 0, 1.0])]).velocity[2] for size in sizes]
    )
    assert speeds.max() <= 1.0 / NEAR_SINGULAR + 1e-9
    # The gain s / (s² + d² (1 - s²/e²)) with d = e is s/d² below e and 1/s above: slope 1/d².
    max_slope = 1.0 / DAMPING**2
    lost = LOST * max_slope
    assert np.all(np.abs(np.diff(speeds)) <= max_slope * np.diff(sizes) * (1.0 + 1e-6) + lost)
    assert lost < 1e-4


def test_velocity_of_stretching_arm_is_bounded_and_continuous():
    # A planar arm of three 0.3 m links moves outwards through its straight configuration.
    speed, step = 0.25, 1e-4
    velocities, undamped = [], []
    for bend in np.arange(-0.3, 0.3, step):
        angles = np.cumsum([0.5, bend, bend])
        links = 0.3 * np.stack([np.cos(angles), np.sin(angles)])
        tips = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]  # from each joint to the tip
        outward = tips[:, 0] / np.linalg.norm(tips[:, 0])
        one = task(np.stack([-tips[1], tips[0]]), speed * outward)
        velocities.append(solve_stack([one]).velocity)
        if abs(bend) < 10.0 * step:
            undamped.append(np.linalg.pinv(one.jacobian, rcond=1e-9) @ one.rate)
    assert np.linalg.norm(velocities, axis=1).max() <= speed / NEAR_SINGULAR
    # The slope of the gain is at most 1/d² per singular value. The singular value changes by at
    # most 1.3 m/rad here.
    max_slope = speed * 1.3 / DAMPING**2
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).max() < max_slope * step
    assert np.linalg.norm(undamped, axis=1).max() > 100.0  # without damping, the velocity diverges


def test_velocity_of_arm_is_bounded_near_singular_configurations(arm_state):
    rng = np.random.default_rng(6)
    min_singular_value = 1.0
    for _ in range(300):
        q = rng.uniform(-1.9, 1.9, 7)
        q[[3, 5]] = 10.0 ** rng.uniform(-7, -1, 2) * rng.choice([-1, 1], 2)
        state = arm_state(q)
        rate = rng.normal(size=6)
        rate *= 0.25 / np.linalg.norm(rate)
        min_singular_value = min(
            min_singular_value, np.linalg.svd(state.jacobian, compute_uv=False)[-1]
        )
        velocity = solve_stack([task(state.jacobian, rate)]).velocity
        assert np.linalg.norm(velocity) <= 0.25 / 0.05 + 1e-9
    assert min_singular_value < 0.01


def test_damped_directions_are_not_used_by_lower_tasks():
    first, second = task([0.019, 0.0, 0.0], 0.0), task([1.0, 0.0, 0.0], 1.0)
    solution = solve_stack([first, second], free_motion=np.ones(3))
    assert solution.velocity[0] == pytest.approx(0.0, abs=1e-12)
    assert solution.missing[1] == pytest.approx(1.0)


def test_damped_inverse_equals_pseudo_inverse_for_regular_rows():
    rows = np.random.default_rng(0).normal(size=(3, 7))
    inverse, right, rank = damped_inverse(rows)
    assert rank == 3
    assert np.allclose(inverse, np.linalg.pinv(rows), atol=1e-12)
    assert np.abs(rows @ right[:, rank:]).max() < 1e-12


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("mode", ["strict", "paper"])
def test_zero_rows_and_equal_rows_give_finite_velocity(mode, damping):
    same = np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 0.0]])
    tasks = [
        task(np.zeros((2, 3)), [1.0, 1.0]),
        task(same, [1.0, -1.0]),
        task(np.eye(3), np.ones(3)),
    ]
    printed = partial(solve_reference, printed=mode == "paper", damping=damping)
    for solve in (solve_stack, printed):
        solution = solve(tasks, free_motion=np.ones(3))
        assert np.all(np.isfinite(solution.velocity))
        assert solution.missing[0] == pytest.approx(np.sqrt(2.0))


def test_full_rank_task_leaves_no_freedom_for_lower_tasks():
    solution = solve_stack([task(np.eye(3), np.ones(3)), task([1.0, 0.0, 0.0], 5.0)])
    assert np.allclose(solution.velocity, 1.0)
    assert solution.scale == (1.0, 0.0)
    assert solution.missing[1] == pytest.approx(4.0)


# Joint speeds


def test_first_task_is_scaled_to_joint_speed_limits():
    solution = solve_stack([task(np.eye(3), [4.0, 2.0, -1.0])], speed=np.ones(3))
    assert np.allclose(solution.velocity, [1.0, 0.5, -0.25])
    assert solution.scale == (0.25,)
    assert solution.missing[0] == pytest.approx(0.75 * np.sqrt(21.0))


def test_saturated_joint_does_not_stop_independent_tasks():
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(2, 2)))[0]
    for push in (0.7, 1.0, 4.0):
        first = task([[1.0, 0.0, 0.0]], push)
        # By rounding, the second task uses 1e-17 of the joint that the first task saturates.
        rows = np.concatenate([np.full((2, 1), 1e-17), turn], axis=1)
        solution = solve_stack([first, task(rows, [0.1, 0.2])], speed=np.array([1.0, 2.0, 2.0]))
        assert solution.scale[1] == 1.0
        assert solution.missing[1] < 1e-9
    step = solve_stack(
        [task([[1.0, 0.0]], 1.0)], free_motion=np.array([0.0, 1.0]), speed=np.array([1.0, 2.0])
    )
    assert np.allclose(step.velocity, [1.0, 1.0])


def test_joint_with_zero_speed_does_not_move():
    solution = solve_stack(
        [task([[1.0, 1.0]], 1.0)], free_motion=np.ones(2), speed=np.array([0.0, 1.0])
    )
    assert abs(solution.velocity[0]) < 1e-12


# One-sided bounds


@pytest.mark.parametrize(("side", "other", "held"), [(1, 2.0, False), (1, 0.5, True)])
@pytest.mark.parametrize("mirror", [1, -1])
def test_bound_is_active_only_against_forbidden_direction(side, other, held, mirror):
    # The bound is >= 1 (or <= -1). The lower task commands `other`.
    bound = task([1.0, 0.0], mirror * 1.0, side=mirror * side)
    solution = solve_stack([bound, task([1.0, 0.0], mirror * other)])
    assert solution.dropped == (not held, False)
    assert solution.velocity[0] == pytest.approx(mirror * max(1.0, other))
    assert solution.missing[0] == pytest.approx(0.0, abs=1e-9)


@given(seed=seeds)
def test_feasible_bounds_are_not_violated(seed):
    rng = np.random.default_rng(seed)
    bounds = [
        task(rows_with(rng, np.array([1.0]), 7), rng.normal(), side=int(rng.choice([-1, 1])))
        for _ in range(3)
    ]
    solution = solve_stack([*bounds, regular_task(rng, 3, 7)], free_motion=rng.normal(size=7))
    rows = np.concatenate([b.jacobian for b in bounds])
    if np.linalg.svd(rows, compute_uv=False)[-1] < 0.05:
        return
    for bound, inactive in zip(bounds, solution.dropped[:3], strict=True):
        passed = bound.side * float((bound.jacobian @ solution.velocity - bound.rate)[0])
        assert passed > -1e-6
        assert inactive or passed == pytest.approx(0.0, abs=1e-6)


def test_bound_satisfied_through_another_bound_is_inactive():
    # Without bounds, both are violated. The active first bound also satisfies the second.
    first = task([1.0, 0.0], 1.0, side=1)
    second = task([1.0, 0.1], 0.5, side=1)
    solution = solve_stack([first, second, task([0.0, 1.0], 1.0)])
    assert solution.dropped == (False, True, False)
    assert np.allclose(solution.velocity, [1.0, 1.0])


# Empty and invalid stacks


@pytest.mark.parametrize("mode", ["strict", "paper"])
def test_inactive_tasks_have_no_effect(mode):
    rng = np.random.default_rng(1)
    empty = task(np.zeros((0, 7)), np.zeros(0))
    inactive_bound = TaskRows("bound", np.zeros(0), np.zeros(0), np.zeros((0, 7)), side=1)
    full, free, solve = (
        regular_task(rng, 3, 7),
        rng.normal(size=7),
        solve_stack if mode == "strict" else PRINTED,
    )
    with_it = solve([empty, full, inactive_bound], free_motion=free)
    without = solve([full], free_motion=free)
    assert np.array_equal(with_it.velocity, without.velocity)
    assert with_it.missing[::2] == (0.0, 0.0)
    assert with_it.scale == (1.0, 1.0, 1.0)
    only = solve([empty], free_motion=free)
    assert np.allclose(only.velocity, free)


def test_given_rates_replace_rates_of_tasks():
    one = task(np.eye(2), [1.0, 2.0])
    assert np.allclose(solve_stack([one], [np.array([3.0, 4.0])]).velocity, [3.0, 4.0])


def test_stack_rejects_invalid_input():
    one = task(np.eye(2), [1.0, 2.0])
    nan = np.array([np.nan, 0.0])
    with pytest.raises(InputError, match="at least one"):
        solve_stack([])
    with pytest.raises(InputError, match=r"same number of joints, got \[2, 3\]"):
        solve_stack([one, task(np.eye(3), np.ones(3))])
    with pytest.raises(InputError, match="rates need one row"):
        solve_stack([one], [np.ones(3)])
    with pytest.raises(InputError, match="rates need one row"):
        solve_stack([one], [])
    with pytest.raises(InputError, match="rate must be finite"):
        solve_stack([one], [nan])
    with pytest.raises(InputError, match=r"free_motion must be \(2,\)"):
        solve_stack([one], free_motion=np.ones(3))
    with pytest.raises(InputError, match="free_motion must be finite"):
        solve_stack([one], free_motion=nan)
    for speed in (np.ones(3), nan, np.array([-1.0, 1.0])):
        with pytest.raises(InputError, match="speed must be"):
            solve_stack([one], speed=speed)
