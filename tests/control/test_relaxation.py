"""Relaxed motion: equations 8 to 10, exactly."""

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


def reach(rng: np.random.Generator, size: float = 1.0) -> TaskRows:
    error = rng.normal(size=3)
    return TaskRows(
        "reach", np.zeros(3), size * error / np.linalg.norm(error), rng.normal(size=(3, 7)), 2.0
    )


@given(seed=seeds, beta=st.floats(0.0, 10.0))
def test_a_fixed_weight_is_equations_8_and_9(seed, beta):
    rng = np.random.default_rng(seed)
    task, gradient = reach(rng), rng.normal(size=7)
    rate, told = relaxed_rate(task, gradient, ControlOptions(beta=beta))
    assert told == beta
    assert np.allclose(rate, 2.0 * task.error - beta * (task.jacobian @ gradient), atol=1e-12)


@given(seed=seeds, push=st.floats(1e-6, 1e3), size=st.floats(0.0, 1.0))
def test_a_dynamic_weight_is_the_largest_that_equation_10_allows(seed, push, size):
    rng = np.random.default_rng(seed)
    task, gradient = reach(rng, size), push * rng.normal(size=7)
    avoidance = task.jacobian @ gradient
    _, beta = relaxed_rate(task, gradient, DYNAMIC)
    goal, away = float(np.linalg.norm(task.rate)), float(np.linalg.norm(avoidance))
    assert 0.0 <= beta <= MAX_BETA
    if goal <= EPSILON:
        assert beta == 0.0
        return
    assert goal - EPSILON >= beta * away - 1e-12
    if beta < MAX_BETA:
        assert goal - EPSILON == pytest.approx(beta * away, rel=1e-12)


@given(seed=seeds, push=st.floats(1e-3, 1e3))
def test_with_a_dynamic_weight_the_way_to_the_goal_outruns_avoidance(seed, push):
    rng = np.random.default_rng(seed)
    task = reach(rng, 0.1)
    rate, _ = relaxed_rate(task, push * rng.normal(size=7), DYNAMIC)
    # So the error falls at least by epsilon a second, whatever repels: eq. 10 creeps, never stops.
    assert rate @ task.error / np.linalg.norm(task.error) >= EPSILON - 1e-12


def test_at_the_goal_nothing_holds_the_task_off():
    there = TaskRows("reach", np.zeros(3), np.zeros(3), np.eye(3))
    rate, beta = relaxed_rate(there, np.full(3, 100.0), DYNAMIC)
    assert beta == 0.0
    assert np.array_equal(rate, np.zeros(3))


def test_the_weight_is_continuous_on_the_way_to_the_goal():
    speeds = np.linspace(0.0, 0.3, 30_001)
    betas = [dynamic_beta(v, 0.2) for v in speeds]
    assert np.all(np.diff(betas) >= 0.0)
    assert np.abs(np.diff(betas)).max() < 1e-5 / 0.2 * 1.001
    assert betas[0] == 0.0
    assert betas[-1] == 1.0


@pytest.mark.parametrize("beta", [0.5, 1.0, "dynamic"])
def test_the_sign_repels(beta):
    # One joint, the distance grows with it: cost falls along +q, so its gradient is negative.
    task = TaskRows("reach", np.zeros(1), np.array([-1.0]), np.eye(1))
    rate, told = relaxed_rate(task, np.array([-0.4]), ControlOptions(beta=beta))
    assert told > 0.0
    assert rate[0] > -1.0


def test_nothing_near_bends_nothing():
    rng = np.random.default_rng(0)
    task = reach(rng)
    for beta in (0.0, 2.0, "dynamic"):
        rate, _ = relaxed_rate(task, np.zeros(7), ControlOptions(beta=beta))
        assert np.array_equal(rate, task.rate)


def test_a_released_task_is_left_alone():
    empty = TaskRows("bound", np.zeros(0), np.zeros(0), np.zeros((0, 7)))
    rate, beta = relaxed_rate(empty, np.ones(7), DYNAMIC)
    assert rate.shape == (0,)
    assert math.isfinite(beta)
