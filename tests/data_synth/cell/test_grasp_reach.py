"""The hand can point straight down and sideways all over the work area, and down into the tray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.control import RobotModel
from eyehand.data_synth.cell import WORK_AREA_M, GraspCell, GraspRobot

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEPS = 150
DAMPING = 1e-4
LEAST_OBJECT_M = 0.03
"""Middles of objects are half of this inside the work area."""
MIDDLE = np.array([0.0, 0.6, 0.0, -1.5, 0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def arm() -> RobotModel:
    robot = GraspRobot()
    place = GraspCell().T_world_base
    return RobotModel.load(
        robot.description(robot.home, np.zeros(5), place), robot.frame, joints=robot.joints
    )


def reaches(arm: RobotModel, place: NDArray, out: NDArray, closing: NDArray) -> bool:
    """Whether damped least squares bring the palm there, from any of a few starts."""
    goal = np.column_stack([closing, np.cross(out, closing), out])
    rng = np.random.default_rng(0)
    for attempt in range(8):
        q = MIDDLE.copy()
        q[0] = np.arctan2(-place[0], place[1] - GraspCell().T_world_base.translation[1])
        q += min(attempt, 1) * rng.normal(0.0, 0.6, 7)
        q[6] += min(attempt, 1) * rng.uniform(-2.0, 2.0)
        for _ in range(STEPS):
            state = arm.at(np.clip(q, arm.lower, arm.upper))
            turn = Rotation.from_matrix(goal @ state.rotation.T).as_rotvec()
            error = np.concatenate([place - state.position, turn])
            if np.abs(error).max() < 1e-3:
                return True
            error *= min(1.0, 0.3 / np.abs(error).max())
            jacobian = state.jacobian
            q = state.q + jacobian.T @ np.linalg.solve(
                jacobian @ jacobian.T + DAMPING * np.eye(6), error
            )
    return False


def corners() -> list[tuple[float, float]]:
    x, y = 0.5 * np.array(WORK_AREA_M) - 0.5 * LEAST_OBJECT_M
    return [(sx * x, sy * y) for sx in (-1, 0, 1) for sy in (-1, 0, 1)]


@pytest.mark.parametrize("height", [0.10, 0.24, 0.38])
def test_the_palm_looks_down_anywhere(arm: RobotModel, height: float):
    down = np.array([0.0, 0.0, -1.0])
    for x, y in corners():
        place = np.array([x, y, height])
        axes = [np.array([np.cos(a), np.sin(a), 0.0]) for a in (0.0, np.pi / 2)]
        # A box can be taken with the thumb on either side.
        assert all(reaches(arm, place, down, a) or reaches(arm, place, down, -a) for a in axes), (
            place
        )


@pytest.mark.parametrize("height", [0.06, 0.12])
def test_the_palm_looks_sideways_from_somewhere(arm: RobotModel, height: float):
    for x, y in corners():
        found = 0
        for angle in np.arange(8) * np.pi / 4:
            out = np.array([np.cos(angle), np.sin(angle), 0.0])
            place = np.array([x, y, height]) - 0.06 * out
            side = np.cross([0.0, 0.0, 1.0], out)
            found += reaches(arm, place, out, side) or reaches(arm, place, out, -side)
            if found == 2:
                break
        assert found == 2, (x, y)


def test_the_palm_looks_down_into_the_tray(arm: RobotModel):
    cell, down = GraspCell(), np.array([0.0, 0.0, -1.0])
    for sx in (-0.25, 0.25):
        for sy in (-1 / 3, 0.0, 1 / 3):
            place = np.add(cell.tray_centre, [sx * cell.tray_size[0], sy * cell.tray_size[1], 0.2])
            assert reaches(arm, place, down, np.array([1.0, 0.0, 0.0])), place
