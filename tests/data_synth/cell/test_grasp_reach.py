"""Reach of the palm: downwards and sideways in the work area, and downwards over the tray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.control import RobotModel
from eyehand.data_synth.cell import GraspCell, GraspRobot
from eyehand.data_synth.cell.grasp_cell import WORK_AREA_M

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEPS = 150
DAMPING = 1e-4
MIN_OBJECT_M = 0.03
"""Smallest object. Object centres lie half of this inside the work area."""
START = np.array([0.0, 0.6, 0.0, -1.5, 0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def arm() -> RobotModel:
    robot = GraspRobot()
    T_world_base = GraspCell().T_world_base
    return RobotModel.load(
        robot.description(robot.home, np.zeros(5), T_world_base), robot.frame, joints=robot.joints
    )


def is_reachable(arm: RobotModel, position: NDArray, out: NDArray, closing: NDArray) -> bool:
    """Return whether damped least squares reach the palm pose from one of several starts."""
    goal = np.column_stack([closing, np.cross(out, closing), out])
    rng = np.random.default_rng(0)
    for attempt in range(8):
        q = START.copy()
        q[0] = np.arctan2(-position[0], position[1] - GraspCell().T_world_base.translation[1])
        q += min(attempt, 1) * rng.normal(0.0, 0.6, 7)
        q[6] += min(attempt, 1) * rng.uniform(-2.0, 2.0)
        for _ in range(STEPS):
            state = arm.at(np.clip(q, arm.lower, arm.upper))
            turn = Rotation.from_matrix(goal @ state.rotation.T).as_rotvec()
            error = np.concatenate([position - state.position, turn])
            if np.abs(error).max() < 1e-3:
                return True
            error *= min(1.0, 0.3 / np.abs(error).max())
            jacobian = state.jacobian
            q = state.q + jacobian.T @ np.linalg.solve(
                jacobian @ jacobian.T + DAMPING * np.eye(6), error
            )
    return False


def corners() -> list[tuple[float, float]]:
    x, y = 0.5 * np.array(WORK_AREA_M) - 0.5 * MIN_OBJECT_M
    return [(sx * x, sy * y) for sx in (-1, 0, 1) for sy in (-1, 0, 1)]


@pytest.mark.parametrize("height", [0.10, 0.24, 0.38])
def test_palm_can_point_down_in_whole_work_area(arm: RobotModel, height: float):
    down = np.array([0.0, 0.0, -1.0])
    for x, y in corners():
        position = np.array([x, y, height])
        axes = [np.array([np.cos(a), np.sin(a), 0.0]) for a in (0.0, np.pi / 2)]
        # A box can be grasped with the thumb on either side.
        assert all(
            is_reachable(arm, position, down, a) or is_reachable(arm, position, down, -a)
            for a in axes
        ), position


@pytest.mark.parametrize("height", [0.06, 0.12])
def test_palm_can_point_sideways_from_two_directions(arm: RobotModel, height: float):
    for x, y in corners():
        found = 0
        for angle in np.arange(8) * np.pi / 4:
            out = np.array([np.cos(angle), np.sin(angle), 0.0])
            position = np.array([x, y, height]) - 0.06 * out
            side = np.cross([0.0, 0.0, 1.0], out)
            found += is_reachable(arm, position, out, side) or is_reachable(
                arm, position, out, -side
            )
            if found == 2:
                break
        assert found == 2, (x, y)


def test_palm_can_point_down_over_tray(arm: RobotModel):
    cell, down = GraspCell(), np.array([0.0, 0.0, -1.0])
    for sx in (-0.25, 0.25):
        for sy in (-1 / 3, 0.0, 1 / 3):
            position = np.add(
                cell.tray_centre, [sx * cell.tray_size[0], sy * cell.tray_size[1], 0.2]
            )
            assert is_reachable(arm, position, down, np.array([1.0, 0.0, 0.0])), position
