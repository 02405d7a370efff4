"""Posture tasks: gradients against finite differences, singular configurations, joint ranges."""

import numpy as np
import pytest

from eyehand.control.robot_model import RobotModel
from eyehand.control.tasks import JointCentring, Manipulability
from eyehand.control.tasks.manipulability import manipulability
from eyehand.data_synth import LBR_ARM
from eyehand.errors import InputError

from .task_reference import centring_cost

POINT = np.array([0.03, -0.05, 0.1])
ALL_ROWS = (0, 1, 2, 3, 4, 5)
ROW_SELECTIONS = (ALL_ROWS, (0, 1, 2), (3, 4, 5), (0, 2, 4), (5,))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("rows", ROW_SELECTIONS)
def test_jacobian_of_manipulability_equals_finite_differences(
    arm_state, check_jacobian, seed, rows
):
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, 7)
    if rows == (3, 4, 5) or manipulability(arm_state(q).jacobian, rows)[0] > 1e-3:
        check_jacobian(Manipulability(5.0, rows, POINT), q)


def test_jacobian_is_independent_of_joint_order():
    names = ["joint5", "joint1", "joint7", "joint3", "joint2", "joint6", "joint4"]
    robot, shuffled = (RobotModel.load(LBR_ARM, "tool", joints=order) for order in (None, names))
    order = [robot.joint_names.index(name) for name in names]
    q = np.random.default_rng(5).uniform(-1.5, 1.5, 7)
    task = Manipulability(5.0, (0, 1, 2), POINT)
    original, other = task.at(robot.at(q)), task.at(shuffled.at(q[order]))
    np.testing.assert_allclose(other.jacobian[0], original.jacobian[0, order], atol=1e-12)
    np.testing.assert_allclose(other.value, original.value, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("rows", ROW_SELECTIONS)
def test_jacobian_with_sliding_and_idle_joints(mixed_state, check_jacobian, seed, rows):
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, 8)
    check_jacobian(Manipulability(5.0, rows, POINT), q, state_at=mixed_state)
    state = mixed_state(q)
    assert np.all(state.jacobian[:, 3] == 0.0)
    assert manipulability(state.jacobian, rows)[1][3] == 0.0


def test_manipulability_is_root_of_determinant(arm_state):
    for seed in range(10):
        jacobian = arm_state(np.random.default_rng(seed).uniform(-2.0, 2.0, 7)).jacobian
        for rows in ROW_SELECTIONS:
            selected = jacobian[list(rows)]
            expected = np.sqrt(np.linalg.det(selected @ selected.T))
            assert manipulability(jacobian, rows)[0] == pytest.approx(expected)


def test_gradient_of_stretched_arm_is_finite():
    # Two stretched links in the plane: the direction along the arm is singular.
    jacobian = np.zeros((6, 2))
    jacobian[1] = [2.0, 1.0]
    jacobian[5] = 1.0
    measure, gradient = manipulability(jacobian, (0, 1))
    assert measure == pytest.approx(0.0, abs=1e-12)
    # sqrt(det) of two links of length 1 is |sin q2|: slope 1 on either side.
    assert np.abs(gradient) == pytest.approx([0.0, 1.0])


def test_gradient_with_several_singular_directions_is_zero(arm_state):
    measure, gradient = manipulability(np.zeros((6, 7)), ALL_ROWS)
    assert measure == 0.0
    assert np.all(gradient == 0.0)


def test_manipulability_is_a_lower_bound(arm_state):
    state = arm_state(np.array([0.3, 0.4, 0.1, -1.0, 0.2, 0.5, 0.1]))
    measure, _ = manipulability(state.jacobian, ALL_ROWS)
    assert len(Manipulability(measure / 2.0).at(state).value) == 0
    near = Manipulability(measure / 1.1).at(state)
    assert near.side == 1
    assert near.unmet == 0.0
    below = Manipulability(2.0 * measure).at(state)
    assert below.unmet == pytest.approx(0.5)
    q = state.q + 0.02 * below.jacobian[0] / np.linalg.norm(below.jacobian)
    assert manipulability(arm_state(q).jacobian, ALL_ROWS)[0] > measure


@pytest.mark.parametrize("power", [2, 4, 6])
def test_centring_descends_gradient_of_eq_5(arm_state, power):
    rng = np.random.default_rng(power)
    q = rng.uniform(-2.0, 2.0, 7)
    state = arm_state(q)
    rows = JointCentring(power, gain=0.5, speed=np.inf).at(state)
    middle, weights = (state.lower + state.upper) / 2.0, 1.0 / (state.upper - state.lower)
    for joint, shift in enumerate(1e-6 * np.eye(7)):
        ahead, _ = centring_cost(q + shift, middle, weights, power)
        behind, _ = centring_cost(q - shift, middle, weights, power)
        assert rows.rate[joint] == pytest.approx(-0.5 * (ahead - behind) / 2e-6, abs=1e-6)
    assert centring_cost(q, middle, weights, power)[0] == pytest.approx(
        float(np.sum(weights * (q - middle) ** power))
    )


def test_jacobian_of_centring_equals_finite_differences(arm_state, check_jacobian):
    check_jacobian(JointCentring(4), np.linspace(-1.0, 1.0, 7))


def test_centring_moves_to_reference_and_ignores_joints_without_range(arm_state):
    state = arm_state(np.linspace(-1.0, 1.0, 7))
    assert JointCentring(reference=state.q).at(state).error == pytest.approx(np.zeros(7))
    state.lower[2], state.upper[4] = -np.inf, np.inf
    state.lower[5] = state.upper[5]
    error = JointCentring().at(state).error
    assert np.all(error[[2, 4, 5]] == 0.0)
    assert np.all(error[[0, 1, 6]] != 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: JointCentring(3), "even whole number >= 2.*got 3"),
        (lambda: JointCentring(0), "even whole number"),
        (lambda: JointCentring(2.0), "even whole number"),  # pyright: ignore[reportArgumentType] - the invalid argument under test
        (lambda: JointCentring(reference=np.full(7, np.nan)), "reference must be finite"),
        (lambda: JointCentring(reference=np.eye(2)), r"reference must have shape \(n,\)"),
        (lambda: Manipulability(0.0), "goal must be > 0"),
        (lambda: Manipulability(np.nan), "goal"),
        (lambda: Manipulability(0.1, (0, 6)), "different numbers from 0 to 5"),
        (lambda: Manipulability(0.1, (0, 0)), "different numbers"),
        (lambda: Manipulability(0.1, ()), "different numbers"),
    ],
)
def test_posture_tasks_reject_invalid_fields(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_centring_rejects_reference_of_wrong_size(arm_state):
    with pytest.raises(InputError, match="one number per joint, 7, got 6"):
        JointCentring(reference=np.zeros(6)).at(arm_state(np.zeros(7)))
