"""Task rows and robot states: commanded rates and invalid fields."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.control.robot_state import skew
from eyehand.control.tasks import TaskRows
from eyehand.errors import InputError


def one_row(error: float, **fields) -> TaskRows:
    return TaskRows("one", np.zeros(1), np.array([error]), np.ones((1, 7)), **fields)


@given(seed=st.integers(0, 100_000), speed=st.floats(1e-3, 10.0))
def test_rate_is_along_error_within_speed(seed, speed):
    error = np.random.default_rng(seed).normal(size=3)
    task = TaskRows("any", np.zeros(3), error, np.ones((3, 7)), gain=2.0, speed=speed)
    size = min(speed, 2.0 * float(np.linalg.norm(error)))
    assert task.rate == pytest.approx(size * error / np.linalg.norm(error))


def test_rate_without_speed_limit_and_without_rows():
    assert one_row(1e6, gain=2.0).rate == pytest.approx([2e6])
    assert TaskRows("none", np.zeros(0), np.zeros(0), np.zeros((0, 7))).rate.shape == (0,)


def test_unmet_counts_error_on_forbidden_side_only():
    assert one_row(-0.2).unmet == pytest.approx(0.2)
    assert one_row(0.2, side=1).unmet == pytest.approx(0.2)  # below its lower bound
    assert one_row(-0.2, side=1).unmet == 0.0
    assert one_row(-0.2, side=-1).unmet == pytest.approx(0.2)  # above its upper bound
    assert one_row(0.2, side=-1).unmet == 0.0


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"error": np.zeros(3)}, "must agree"),
        ({"jacobian": np.zeros(7)}, "must agree"),
        ({"error": np.array([np.nan])}, "error must be finite"),
        ({"jacobian": np.full((1, 7), np.inf)}, "jacobian must be finite"),
        ({"value": np.array(["a"])}, "value must be numbers"),
        ({"gain": 0.0}, "gain"),
        ({"gain": np.nan}, "gain"),
        ({"speed": -1.0}, "speed"),
        ({"speed": np.nan}, "speed"),
        ({"side": 2}, "side"),
        (
            {"value": np.zeros(2), "error": np.zeros(2), "jacobian": np.ones((2, 7)), "side": 1},
            "side",
        ),
    ],
)
def test_task_rows_reject_invalid_fields(fields, message):
    with pytest.raises(InputError, match=message):
        replace(one_row(0.1), **fields)


def test_robot_state_rejects_invalid_fields(arm_state):
    state = arm_state(np.zeros(7))
    with pytest.raises(InputError, match=r"jacobian \(6, n\)"):
        replace(state, jacobian=np.zeros((6, 6)))
    with pytest.raises(InputError, match="q must be finite"):
        replace(state, q=np.full(7, np.nan))


@given(seed=st.integers(0, 100_000))
def test_skew_equals_cross_product(seed):
    a, b = np.random.default_rng(seed).normal(size=(2, 3))
    assert skew(a) @ b == pytest.approx(np.cross(a, b))
