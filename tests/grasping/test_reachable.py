"""The reachability check: simulated motion, and reasons for failure."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control import Box, CollisionWorld, Obstacle, RobotModel
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError
from eyehand.grasping.reachable import is_reachable


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel.load(LBR_ARM, TOOL_SITE)


def test_legs_are_followed_in_order(robot):
    world = CollisionWorld(robot)
    over, at = np.array([0.5, 0.1, 0.4]), np.array([0.5, 0.1, 0.2])
    motion = is_reachable(world, [[Position(over)], [Position(at)]], robot.home)
    assert motion
    assert (motion.leg, motion.reason) == (1, "")
    assert np.linalg.norm(robot.at(motion.q).position - at) < 5e-3
    assert 0.5 < motion.seconds < 8.0


def test_unreachable_goal_is_reported_with_leg_and_reason(robot):
    world = CollisionWorld(robot)
    legs = [[Position(np.array([0.5, 0.1, 0.4]))], [Position(np.array([2.0, 0.0, 0.2]))]]
    motion = is_reachable(world, legs, robot.home)
    assert not motion
    assert motion.leg == 1
    assert "off" in motion.reason


def test_goal_inside_obstacle_is_not_reached(robot):
    block = Obstacle(
        "block", Box(np.array([0.1, 0.1, 0.1])), RigidTransform.from_translation([0.55, 0.0, 0.1])
    )
    motion = is_reachable(
        CollisionWorld(robot, [block]), [[Position(np.array([0.55, 0.0, 0.1]))]], robot.home
    )
    assert not motion
    assert "block" in motion.reason


def test_joint_angles_of_wrong_shape_are_rejected(robot):
    with pytest.raises(InputError, match="shape"):
        is_reachable(CollisionWorld(robot), [[Position(np.zeros(3))]], np.zeros(3))
