"""The compiled stack against the NumPy reference, and its priorities."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.control.stack_kernels import Levels, orthogonalise, solve_levels
from eyehand.control.tasks import TaskRows

from .stack_reference import solve_reference

JOINTS = 7
seeds = st.integers(0, 100_000)


def solve_compiled(tasks, free_motion, speed):
    max_rows = max(6, JOINTS)
    rates, rows = (
        np.full((len(tasks), max_rows), np.nan),
        np.full((len(tasks), max_rows, JOINTS), np.nan),
    )
    for k, one in enumerate(tasks):
        rates[k, : len(one.error)], rows[k, : len(one.error)] = one.rate, one.jacobian
    sizes = np.array([len(one.error) for one in tasks])
    sides = np.array([one.side for one in tasks])
    velocity = np.empty(JOINTS)
    levels = Levels(sizes, sides, rates, rows)
    count = len(tasks)
    solve_levels(levels, free_motion, speed, velocity, np.empty(count), np.empty(count, np.bool_))
    return velocity


def rows_with(rng, singular):
    left = np.linalg.qr(rng.normal(size=(len(singular), len(singular))))[0]
    right = np.linalg.qr(rng.normal(size=(JOINTS, JOINTS)))[0]
    return (left * singular) @ right[: len(singular)]


def random_stack(rng, *, smallest=-3.0):
    """Return up to five tasks: some near-singular, one-sided, inactive, or of full rank."""
    tasks = []
    for k in range(int(rng.integers(1, 6))):
        count = int(rng.choice([0, 1, 1, 1, 2, 3, 3, 6, 7]))
        rows = rows_with(rng, 10.0 ** rng.uniform(smallest, 0.3, count))
        if count and tasks and len(tasks[0].error) and rng.random() < 0.2:
            rows[0] = tasks[0].jacobian[0]
        side = int(rng.choice([-1, 0, 1])) if count == 1 else 0
        rate = rng.normal(size=count) * 10.0 ** rng.uniform(-2, 0.5)
        tasks.append(TaskRows(f"task {k}", np.zeros(count), rate, rows, side=side))
    return tasks


@given(seed=seeds, limited=st.booleans())
def test_compiled_stack_equals_reference(seed, limited):
    rng = np.random.default_rng(seed)
    tasks = random_stack(rng)
    free_motion = rng.normal(size=JOINTS)
    speed = rng.uniform(0.2, 2.0, JOINTS) if limited else np.full(JOINTS, np.inf)
    reference = solve_reference(tasks, free_motion=free_motion, speed=speed)
    # Both forms compute a direction of singular value s to rounding / s. The smallest value is
    # 1e-3, or less where a task almost equals one above it.
    remaining = np.eye(JOINTS)
    min_singular_value = 1.0
    for one, inactive in zip(tasks, reference.dropped, strict=True):
        if inactive or not len(one.error):
            continue
        _, sizes, right = np.linalg.svd(one.jacobian @ remaining)
        nonzero = sizes[sizes > 1e-12]
        min_singular_value = min([min_singular_value, *nonzero.tolist()])
        remaining = remaining @ right[len(nonzero) :].T
        if remaining.shape[1] == 0:
            break
    velocity = solve_compiled(tasks, free_motion, speed)
    assert np.all(np.isfinite(velocity))
    if min_singular_value > 1e-5:
        np.testing.assert_allclose(
            velocity, reference.velocity, atol=1e-9 * max(1.0, 1e-3 / min_singular_value)
        )


@given(seed=seeds)
def test_lower_priority_tasks_do_not_disturb_higher_ones(seed):
    rng = np.random.default_rng(seed)
    upper = TaskRows(
        "upper", np.zeros(3), rng.normal(size=3), rows_with(rng, rng.uniform(0.051, 2.0, 3))
    )
    free, no_limit = 10.0 * rng.normal(size=JOINTS), np.full(JOINTS, np.inf)
    lower = random_stack(rng, smallest=-9.0)
    velocity = solve_compiled([upper, *lower], free, no_limit)
    assert np.abs(upper.jacobian @ velocity - upper.rate).max() < 1e-9


@given(seed=seeds)
def test_joint_speed_limits_are_kept(seed):
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.05, 0.5, JOINTS)
    velocity = solve_compiled(
        random_stack(rng, smallest=-9.0), 10.0 * rng.normal(size=JOINTS), speed
    )
    assert np.all(np.abs(velocity) <= speed + 1e-9)


def test_singular_direction_gives_no_motion():
    rows = np.zeros((2, JOINTS))
    rows[0, 0], rows[1, 0] = 1.0, 1.0 + 1e-12
    task = TaskRows("twice", np.zeros(2), np.array([0.1, -0.1]), rows)
    velocity = solve_compiled([task], np.zeros(JOINTS), np.ones(JOINTS))
    assert np.abs(velocity).max() < 1e-9


@given(seed=seeds, count=st.integers(1, 7))
def test_orthogonalised_rows_have_lengths_of_singular_values(seed, count):
    rng = np.random.default_rng(seed)
    rows = rows_with(rng, 10.0 ** rng.uniform(-6, 1, count))
    extra = rng.normal(size=count)
    rotated = np.column_stack([rows, extra])
    orthogonalise(rotated, JOINTS)
    sizes = np.linalg.norm(rotated[:, :JOINTS], axis=1)
    np.testing.assert_allclose(np.sort(sizes)[::-1], np.linalg.svd(rows)[1], rtol=1e-8, atol=1e-14)
    units = rotated[:, :JOINTS] / sizes[:, None]
    assert np.abs(units @ units.T - np.eye(count)).max() < 1e-13
    # The extra column is rotated too: its products with the rows are unchanged.
    np.testing.assert_allclose(rows.T @ extra, rotated[:, :JOINTS].T @ rotated[:, -1], atol=1e-13)
