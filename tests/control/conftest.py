"""Fixtures of the control tests: an arm with seven joints, built from an MJCF text."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from eyehand.control import Box, CollisionWorld, Obstacle, RobotModel
from eyehand.control.robot_state import RobotState
from eyehand.control.tasks import Task
from eyehand.data_synth import LBR_ARM, TOOL_SITE, import_mujoco
from eyehand.data_synth.scenes import ReachingScene

mujoco = import_mujoco()

ARM = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="link1" pos="0 0 0.15">
      <joint name="j1" axis="0 0 1" range="-2.9 2.9"/><geom size="0.05"/>
      <body name="link2" pos="0 0 0.19">
        <joint name="j2" axis="0 1 0" range="-2.0 2.0"/><geom size="0.05"/>
        <body name="link3" pos="0 0 0.21" euler="0.2 0 0">
          <joint name="j3" {third} axis="0 0 1" range="-2.9 2.9"/><geom size="0.05"/>
          <body name="branch" pos="0 0.1 0">
            <joint name="aside" axis="1 0 0" range="-1 1"/><geom size="0.02"/>
          </body>
          <body name="link4" pos="0.02 0 0.19">
            <joint name="j4" axis="0 -1 0" range="-2.0 2.0"/><geom size="0.05"/>
            <body name="link5" pos="0 0 0.21">
              <joint name="j5" axis="0 0 1" range="-2.9 2.9"/><geom size="0.05"/>
              <body name="link6" pos="0 0.03 0.19" euler="0 0 0.3">
                <joint name="j6" axis="0 1 0" range="-2.0 2.0"/><geom size="0.05"/>
                <body name="link7" pos="0.08 0 0.08">
                  <joint name="j7" axis="0 0 1" range="-3.0 3.0"/><geom size="0.05"/>
                  <site name="hand" pos="0.03 0.01 0.12" euler="0.1 0.4 0.2"/>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
"""An arm with seven joints on skew axes, and a branch that does not move the hand."""

HOME = np.array([0.1, 0.4, -0.2, -1.2, 0.3, 0.8, 0.0])


def boxes_world(scene: ReachingScene) -> CollisionWorld:
    """Return the world of the LBR arm and the boxes of a scene."""
    boxes = [
        Obstacle(one.name, Box(np.array(one.size)), one.T_world_shape) for one in scene.obstacles
    ]
    return CollisionWorld(RobotModel.load(LBR_ARM, TOOL_SITE), boxes)


def _arm(third: str, *, branch: bool) -> Callable[[NDArray[np.float64]], RobotState]:
    model = mujoco.MjModel.from_xml_string(ARM.format(third=third))
    data = mujoco.MjData(model)
    site = model.site("hand").id
    used = [i for i in range(model.njnt) if branch or model.joint(i).name != "aside"]

    def state(q: NDArray[np.float64]) -> RobotState:
        data.qpos[used] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        jacobian = np.zeros((6, model.nv))
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        return RobotState(
            q=np.array(q, dtype=np.float64),
            position=data.site_xpos[site].copy(),
            rotation=data.site_xmat[site].reshape(3, 3).copy(),
            jacobian=jacobian[:, used],
            lower=model.jnt_range[used, 0].copy(),
            upper=model.jnt_range[used, 1].copy(),
            home=np.insert(HOME, 3, 0.0) if branch else HOME.copy(),
            speed=np.full(len(used), 2.0),
        )

    return state


@pytest.fixture(scope="session")
def arm_state() -> Callable[[NDArray[np.float64]], RobotState]:
    """Return a function from joint angles (7,) to the state of the arm."""
    return _arm('type="hinge"', branch=False)


@pytest.fixture(scope="session")
def mixed_state() -> Callable[[NDArray[np.float64]], RobotState]:
    """Return the same for (8,): the third joint slides, and the branch joint is controlled."""
    return _arm('type="slide"', branch=True)


@pytest.fixture(scope="session")
def check_jacobian(arm_state) -> Callable[..., None]:
    """Return a check of a task's Jacobian against central differences of its value, to 1e-6."""

    def check(
        task: Task, q: NDArray[np.float64], *, state_at=arm_state, step: float = 1e-6
    ) -> None:
        rows = task.at(state_at(q))
        for joint, shift in enumerate(step * np.eye(len(q))):
            slope = (task.at(state_at(q + shift)).value - task.at(state_at(q - shift)).value) / (
                2.0 * step
            )
            assert np.abs(slope - rows.jacobian[:, joint]).max() < 1e-6

    return check
