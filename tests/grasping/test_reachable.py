"""The look ahead agrees with the motion itself, and says why not."""

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


def test_legs_are_gone_one_after_the_other(robot):
    world = CollisionWorld(robot)
    over, at = np.array([0.5, 0.1, 0.4]), np.array([0.5, 0.1, 0.2])
    way = is_reachable(world, [[Position(over)], [Position(at)]], robot.home)
    assert way
    assert (way.leg, way.reason) == (1, "")
    assert np.linalg.norm(robot.at(way.q).position - at) < 5e-3
    assert 0.5 < way.seconds < 8.0


def test_what_is_out_of_reach_is_said_by_leg_and_reason(robot):
    world = CollisionWorld(robot)
    legs = [[Position(np.array([0.5, 0.1, 0.4]))], [Position(np.array([2.0, 0.0, 0.2]))]]
    way = is_reachable(world, legs, robot.home)
    assert not way
    assert way.leg == 1
    assert "off" in way.reason


def test_a_goal_inside_an_obstacle_is_not_reached(robot):
    block = Obstacle(
        "block", Box(np.array([0.1, 0.1, 0.1])), RigidTransform.from_translation([0.55, 0.0, 0.1])
    )
    way = is_reachable(
        CollisionWorld(robot, [block]), [[Position(np.array([0.55, 0.0, 0.1]))]], robot.home
    )
    assert not way
    assert "block" in way.reason


def test_joint_angles_that_do_not_fit_are_refused(robot):
    with pytest.raises(InputError, match="shape"):
        is_reachable(CollisionWorld(robot), [[Position(np.zeros(3))]], np.zeros(3))
