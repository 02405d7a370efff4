"""The compiled quadratic program: optimality conditions, agreement with a solver, failures."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from eyehand.control.qp_kernels import GIVEN_UP, solve_qp
from eyehand.control.safety import _solve_hard
from eyehand.control.safety_kernels import SafetyRows, satisfies

seeds = st.integers(0, 100_000)


def solve_case(nominal, hessian, rows: SafetyRows):
    n = len(nominal)
    velocity, active, multipliers = np.empty(n), np.zeros(n, np.int64), np.zeros(n)
    count = solve_qp(nominal, hessian.copy(), rows, velocity, active, multipliers)
    return count, velocity, active[: max(count, 0)], multipliers[: max(count, 0)]


def random_case(seed: int, joints: int, *, feasible: bool = True):
    rng = np.random.default_rng(seed)
    pairs = int(rng.integers(0, 31))
    tasks = rng.normal(size=(rng.integers(0, 6), joints))
    high = rng.uniform(0.1, 2.0, joints)
    low = -rng.uniform(0.0, 2.0, joints)
    rows = rng.normal(size=(pairs, joints)) * 10.0 ** rng.uniform(-3, 0, (pairs, 1))
    if pairs > 3 and rng.random() < 0.5:
        rows[1], rows[2] = rows[0], -0.5 * rows[0]
    inside = rng.uniform(0.5 * low, 0.5 * high)
    min_rates = rows @ inside - rng.uniform(0.0, 0.1, pairs) * np.linalg.norm(rows, axis=1)
    if not feasible:
        min_rates += rng.uniform(0.0, 0.5, pairs)
    nominal = 3.0 * rng.normal(size=joints)
    return nominal, np.eye(joints) + 20.0 * tasks.T @ tasks, SafetyRows(low, high, rows, min_rates)


@given(seed=seeds, joints=st.integers(1, 9))
def test_solution_satisfies_bounds_and_stationarity(seed, joints):
    nominal, hessian, rows = random_case(seed, joints)
    count, velocity, active, multipliers = solve_case(nominal, hessian, rows)
    assert count != GIVEN_UP
    assert satisfies(velocity, rows)
    assert np.all(multipliers > -1e-9)
    # Stationarity: the gradient of the objective is the weighted sum of the active constraints.
    constraint_force = np.zeros(joints)
    for index, multiplier in zip(active, multipliers, strict=True):
        if index < joints:
            middle = 0.5 * (rows.low[index] + rows.high[index])
            constraint_force[index] += multiplier * (1.0 if velocity[index] < middle else -1.0)
        else:
            constraint_force += multiplier * rows.rows[index - joints]
    scale = 1.0 + np.abs(hessian @ nominal).max()
    np.testing.assert_allclose(hessian @ (velocity - nominal), constraint_force, atol=1e-10 * scale)


@given(seed=seeds, joints=st.integers(2, 9))
def test_solution_equals_reference_solver(seed, joints):
    nominal, hessian, rows = random_case(seed, joints)
    velocity = solve_case(nominal, hessian, rows)[1]
    other = _solve_hard(nominal, hessian, rows)[0]
    assert other is not None
    np.testing.assert_allclose(velocity, other, atol=1e-7)


@given(seed=seeds)
def test_infeasible_problems_are_given_up(seed):
    nominal, hessian, rows = random_case(seed, 7, feasible=False)
    count, velocity, _, _ = solve_case(nominal, hessian, rows)
    # The largest slack that all rows can have at once. Below zero, the problem is infeasible.
    bounds = [*zip(rows.low, rows.high, strict=True), (None, 1.0)]
    rows_with_slack = np.column_stack([-rows.rows, np.ones(len(rows.min_rates))])
    best = linprog(-np.eye(8)[7], rows_with_slack, -rows.min_rates, bounds=bounds)
    slack = -best.fun
    if slack > 1e-7:
        assert count != GIVEN_UP
        assert satisfies(velocity, rows)
    elif slack < -1e-7:
        assert count == GIVEN_UP or not satisfies(velocity, rows)


def test_feasible_nominal_velocity_is_returned():
    rows = SafetyRows(-np.ones(3), np.ones(3), np.ones((1, 3)), np.array([-1.0]))
    nominal = np.array([0.1, -0.2, 0.3])
    count, velocity, _, _ = solve_case(nominal, np.eye(3), rows)
    assert count == 0
    assert np.array_equal(velocity, nominal)


def test_joint_with_zero_bounds_does_not_move():
    rows = SafetyRows(np.zeros(2), np.zeros(2), np.zeros((0, 2)), np.zeros(0))
    count, velocity, _, _ = solve_case(np.array([1.0, -1.0]), np.eye(2), rows)
    assert count == 2
    assert np.array_equal(velocity, np.zeros(2))


def test_zero_row_is_ignored_unless_it_is_infeasible():
    # The third rate is within the tolerance of the solver, and above what the row can reach.
    for min_rates, answer in ((-0.1, 1), (0.1, GIVEN_UP), (5e-11, 1)):
        rows = SafetyRows(-np.ones(2), np.ones(2), np.zeros((1, 2)), np.array([min_rates]))
        assert solve_case(np.array([2.0, 0.0]), np.eye(2), rows)[0] == answer
