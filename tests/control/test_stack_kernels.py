"""The compiled stack against the NumPy reference, and against what priority means."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.control.stack_kernels import Levels, orthogonalise, solve_levels
from eyehand.control.tasks import TaskRows

from .stack_reference import solve_reference

JOINTS = 7
seeds = st.integers(0, 100_000)


def compiled(tasks, free_motion, speed):
    most = max(6, JOINTS)
    rates, rows = np.full((len(tasks), most), np.nan), np.full((len(tasks), most, JOINTS), np.nan)
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


def any_stack(rng, *, smallest=-3.0):
    """Up to five tasks: some near-singular, some of one side, some released, some of full rank."""
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
def test_it_is_the_plain_stack(seed, limited):
    rng = np.random.default_rng(seed)
    tasks = any_stack(rng)
    free_motion = rng.normal(size=JOINTS)
    speed = rng.uniform(0.2, 2.0, JOINTS) if limited else np.full(JOINTS, np.inf)
    plain = solve_reference(tasks, free_motion=free_motion, speed=speed)
    # A direction of singular value s is known to rounding / s in either form; the least is 1e-3,
    # and less where a task is nearly one above it.
    remaining = np.eye(JOINTS)
    least = 1.0
    for one, gone in zip(tasks, plain.dropped, strict=True):
        if gone or not len(one.error):
            continue
        _, sizes, right = np.linalg.svd(one.jacobian @ remaining)
        kept = sizes[sizes > 1e-12]
        least = min([least, *kept.tolist()])
        remaining = remaining @ right[len(kept) :].T
        if remaining.shape[1] == 0:
            break
    velocity = compiled(tasks, free_motion, speed)
    assert np.all(np.isfinite(velocity))
    if least > 1e-5:
        np.testing.assert_allclose(velocity, plain.velocity, atol=1e-9 * max(1.0, 1e-3 / least))


@given(seed=seeds)
def test_lower_tasks_do_not_leak_into_upper_ones(seed):
    rng = np.random.default_rng(seed)
    upper = TaskRows(
        "upper", np.zeros(3), rng.normal(size=3), rows_with(rng, rng.uniform(0.051, 2.0, 3))
    )
    free, loose = 10.0 * rng.normal(size=JOINTS), np.full(JOINTS, np.inf)
    lower = any_stack(rng, smallest=-9.0)
    velocity = compiled([upper, *lower], free, loose)
    assert np.abs(upper.jacobian @ velocity - upper.rate).max() < 1e-9


@given(seed=seeds)
def test_joint_speeds_are_kept(seed):
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.05, 0.5, JOINTS)
    velocity = compiled(any_stack(rng, smallest=-9.0), 10.0 * rng.normal(size=JOINTS), speed)
    assert np.all(np.abs(velocity) <= speed + 1e-9)


def test_a_lost_direction_asks_for_nothing():
    rows = np.zeros((2, JOINTS))
    rows[0, 0], rows[1, 0] = 1.0, 1.0 + 1e-12
    task = TaskRows("twice", np.zeros(2), np.array([0.1, -0.1]), rows)
    velocity = compiled([task], np.zeros(JOINTS), np.ones(JOINTS))
    assert np.abs(velocity).max() < 1e-9


@given(seed=seeds, count=st.integers(1, 7))
def test_rotated_rows_are_orthogonal_and_as_long_as_the_singular_values(seed, count):
    rng = np.random.default_rng(seed)
    rows = rows_with(rng, 10.0 ** rng.uniform(-6, 1, count))
    extra = rng.normal(size=count)
    turned = np.column_stack([rows, extra])
    orthogonalise(turned, JOINTS)
    sizes = np.linalg.norm(turned[:, :JOINTS], axis=1)
    np.testing.assert_allclose(np.sort(sizes)[::-1], np.linalg.svd(rows)[1], rtol=1e-8, atol=1e-14)
    units = turned[:, :JOINTS] / sizes[:, None]
    assert np.abs(units @ units.T - np.eye(count)).max() < 1e-13
    # What is beyond is turned along: the products of rows and it stay.
    np.testing.assert_allclose(rows.T @ extra, turned[:, :JOINTS].T @ turned[:, -1], atol=1e-13)
