"""The compiled quadratic program: optimal by its own conditions, the solver's answer, or none."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from eyehand.control.qp_kernels import GIVEN_UP, solve_qp
from eyehand.control.safety import _nearest
from eyehand.control.safety_kernels import SafetyRows, allowed

seeds = st.integers(0, 100_000)


def solve(nominal, hessian, rows: SafetyRows):
    n = len(nominal)
    velocity, held, strength = np.empty(n), np.zeros(n, np.int64), np.zeros(n)
    count = solve_qp(nominal, hessian.copy(), rows, velocity, held, strength)
    return count, velocity, held[: max(count, 0)], strength[: max(count, 0)]


def case(seed: int, joints: int, *, feasible: bool = True):
    rng = np.random.default_rng(seed)
    pairs = int(rng.integers(0, 31))
    tasks = rng.normal(size=(rng.integers(0, 6), joints))
    high = rng.uniform(0.1, 2.0, joints)
    low = -rng.uniform(0.0, 2.0, joints)
    rows = rng.normal(size=(pairs, joints)) * 10.0 ** rng.uniform(-3, 0, (pairs, 1))
    if pairs > 3 and rng.random() < 0.5:
        rows[1], rows[2] = rows[0], -0.5 * rows[0]
    inside = rng.uniform(0.5 * low, 0.5 * high)
    least = rows @ inside - rng.uniform(0.0, 0.1, pairs) * np.linalg.norm(rows, axis=1)
    if not feasible:
        least += rng.uniform(0.0, 0.5, pairs)
    nominal = 3.0 * rng.normal(size=joints)
    return nominal, np.eye(joints) + 20.0 * tasks.T @ tasks, SafetyRows(low, high, rows, least)


@given(seed=seeds, joints=st.integers(1, 9))
def test_bounds_are_kept_and_forces_balance(seed, joints):
    nominal, hessian, rows = case(seed, joints)
    count, velocity, held, strength = solve(nominal, hessian, rows)
    assert count != GIVEN_UP
    assert allowed(velocity, rows)
    assert np.all(strength > -1e-9)
    # Stationary: the pull back to the nominal velocity is the sum of the bounds' pushes.
    push = np.zeros(joints)
    for which, much in zip(held, strength, strict=True):
        if which < joints:
            middle = 0.5 * (rows.low[which] + rows.high[which])
            push[which] += much * (1.0 if velocity[which] < middle else -1.0)
        else:
            push += much * rows.rows[which - joints]
    scale = 1.0 + np.abs(hessian @ nominal).max()
    np.testing.assert_allclose(hessian @ (velocity - nominal), push, atol=1e-10 * scale)


@given(seed=seeds, joints=st.integers(2, 9))
def test_it_is_the_solvers_answer(seed, joints):
    nominal, hessian, rows = case(seed, joints)
    velocity = solve(nominal, hessian, rows)[1]
    other = _nearest(nominal, hessian, rows)[0]
    assert other is not None
    np.testing.assert_allclose(velocity, other, atol=1e-7)


@given(seed=seeds)
def test_what_cannot_be_kept_is_given_up(seed):
    nominal, hessian, rows = case(seed, 7, feasible=False)
    count, velocity, _, _ = solve(nominal, hessian, rows)
    # The largest room that some velocity leaves to all rows: below zero, none keeps them.
    bounds = [*zip(rows.low, rows.high, strict=True), (None, 1.0)]
    grown = np.column_stack([-rows.rows, np.ones(len(rows.least))])
    best = linprog(-np.eye(8)[7], grown, -rows.least, bounds=bounds)
    room = -best.fun
    if room > 1e-7:
        assert count != GIVEN_UP
        assert allowed(velocity, rows)
    elif room < -1e-7:
        assert count == GIVEN_UP or not allowed(velocity, rows)


def test_an_allowed_nominal_velocity_stays():
    rows = SafetyRows(-np.ones(3), np.ones(3), np.ones((1, 3)), np.array([-1.0]))
    nominal = np.array([0.1, -0.2, 0.3])
    count, velocity, _, _ = solve(nominal, np.eye(3), rows)
    assert count == 0
    assert np.array_equal(velocity, nominal)


def test_a_joint_that_must_stand_still_does():
    rows = SafetyRows(np.zeros(2), np.zeros(2), np.zeros((0, 2)), np.zeros(0))
    count, velocity, _, _ = solve(np.array([1.0, -1.0]), np.eye(2), rows)
    assert count == 2
    assert np.array_equal(velocity, np.zeros(2))


def test_a_row_without_effect_is_no_bound_unless_it_must_grow():
    for least, answer in ((-0.1, 1), (0.1, GIVEN_UP)):
        rows = SafetyRows(-np.ones(2), np.ones(2), np.zeros((1, 2)), np.array([least]))
        assert solve(np.array([2.0, 0.0]), np.eye(2), rows)[0] == answer
