"""Relaxed motion: exact tests of equations 8 to 10."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.control.options import ControlOptions
from eyehand.control.relaxation import EPSILON, MAX_BETA, dynamic_beta, relaxed_rate
from eyehand.control.tasks import TaskRows

seeds = st.integers(0, 100_000)
DYNAMIC = ControlOptions()


def random_task(rng: np.random.Generator, size: float = 1.0) -> TaskRows:
    error = rng.normal(size=3)
    return TaskRows(
        "reach", np.zeros(3), size * error / np.linalg.norm(error), rng.normal(size=(3, 7)), 2.0
    )


@given(seed=seeds, beta=st.floats(0.0, 10.0))
def test_fixed_weight_follows_equations_8_and_9(seed, beta):
    rng = np.random.default_rng(seed)
    task, gradient = random_task(rng), rng.normal(size=7)
    rate, returned_beta = relaxed_rate(task, gradient, ControlOptions(beta=beta))
    assert returned_beta == beta
    assert np.allclose(rate, 2.0 * task.error - beta * (task.jacobian @ gradient), atol=1e-12)


@given(seed=seeds, push=st.floats(1e-6, 1e3), size=st.floats(0.0, 1.0))
def test_dynamic_weight_is_maximum_of_equation_10(seed, push, size):
    rng = np.random.default_rng(seed)
    task, gradient = random_task(rng, size), push * rng.normal(size=7)
    avoidance = task.jacobian @ gradient
    _, beta = relaxed_rate(task, gradient, DYNAMIC)
    goal_speed, avoidance_speed = float(np.linalg.norm(task.rate)), float(np.linalg.norm(avoidance))
    assert 0.0 <= beta <= MAX_BETA
    if goal_speed <= EPSILON:
        assert beta == 0.0
        return
    assert goal_speed - EPSILON >= beta * avoidance_speed - 1e-12
    if beta < MAX_BETA:
        assert goal_speed - EPSILON == pytest.approx(beta * avoidance_speed, rel=1e-12)


@given(seed=seeds, push=st.floats(1e-3, 1e3))
def test_dynamic_weight_keeps_progress_to_goal(seed, push):
    rng = np.random.default_rng(seed)
    task = random_task(rng, 0.1)
    rate, _ = relaxed_rate(task, push * rng.normal(size=7), DYNAMIC)
    # The error falls by at least epsilon per second. With eq. 10, the motion slows but never stops.
    assert rate @ task.error / np.linalg.norm(task.error) >= EPSILON - 1e-12


def test_dynamic_weight_is_zero_at_goal():
    at_goal = TaskRows("reach", np.zeros(3), np.zeros(3), np.eye(3))
    rate, beta = relaxed_rate(at_goal, np.full(3, 100.0), DYNAMIC)
    assert beta == 0.0
    assert np.array_equal(rate, np.zeros(3))


def test_dynamic_weight_is_continuous():
    speeds = np.linspace(0.0, 0.3, 30_001)
    betas = [dynamic_beta(v, 0.2) for v in speeds]
    assert np.all(np.diff(betas) >= 0.0)
    assert np.abs(np.diff(betas)).max() < 1e-5 / 0.2 * 1.001
    assert betas[0] == 0.0
    assert betas[-1] == 1.0


@pytest.mark.parametrize("beta", [0.5, 1.0, "dynamic"])
def test_avoidance_motion_points_away_from_obstacle(beta):
    # One joint: the distance grows with q. The cost falls along +q, so its gradient is negative.
    task = TaskRows("reach", np.zeros(1), np.array([-1.0]), np.eye(1))
    rate, returned_beta = relaxed_rate(task, np.array([-0.4]), ControlOptions(beta=beta))
    assert returned_beta > 0.0
    assert rate[0] > -1.0


def test_zero_gradient_does_not_change_rate():
    rng = np.random.default_rng(0)
    task = random_task(rng)
    for beta in (0.0, 2.0, "dynamic"):
        rate, _ = relaxed_rate(task, np.zeros(7), ControlOptions(beta=beta))
        assert np.array_equal(rate, task.rate)


def test_inactive_task_has_empty_rate():
    empty = TaskRows("bound", np.zeros(0), np.zeros(0), np.zeros((0, 7)))
    rate, beta = relaxed_rate(empty, np.ones(7), DYNAMIC)
    assert rate.shape == (0,)
    assert math.isfinite(beta)
