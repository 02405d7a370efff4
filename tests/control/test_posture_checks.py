"""Inputs of a controller: positions outside the limits are refused, and jumps are reported."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control import ApproachController, Box, CollisionWorld, Obstacle, RobotModel, Sphere
from eyehand.control.posture_checks import BEYOND_LIMITS, JUMP, JUMP_CYCLES
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM
from eyehand.errors import InputError

GOAL = np.array([0.45, 0.25, 0.5])


@pytest.fixture
def controller() -> ApproachController:
    return ApproachController(CollisionWorld(RobotModel.load(LBR_ARM, "tool")), [Position(GOAL)])


@pytest.mark.parametrize("offset", [1e6, -1e6, 57.3])
def test_position_far_outside_its_limits_is_refused(controller, offset):
    q = controller.robot.home
    with pytest.raises(InputError, match=r"joint \w+ must be in \[.*\] rad or m, or at most 0.5"):
        controller.step(q + offset)
    assert controller.step(q).status == "moving"


def test_position_a_little_outside_its_limits_returns(controller):
    q = controller.robot.home.copy()
    q[1] = controller.robot.upper[1] + 0.5 * BEYOND_LIMITS
    for _ in range(100):
        step = controller.step(q)
        q = q + controller.options.dt * step.velocity
    assert q[1] < controller.robot.upper[1] + 0.4 * BEYOND_LIMITS


def test_complex_positions_are_refused(controller):
    with pytest.raises(InputError, match="real numbers"):
        controller.step(controller.robot.home + 1j)


def test_jump_is_reported_and_braked_and_the_motion_goes_on(controller):
    q = controller.robot.home.copy()
    for _ in range(60):
        q = q + controller.options.dt * controller.step(q).velocity
    speed = np.abs(controller.velocity).max()
    assert speed > 0.05
    limit = JUMP_CYCLES * controller.options.dt * controller.robot.speed[2] + JUMP
    near = q + 0.9 * limit * np.eye(7)[2]
    assert controller.step(near).status == "moving"
    far = near - 1.5 * limit * np.eye(7)[2]
    step = controller.step(far)
    assert step.status == "infeasible"
    assert "jumped by" in step.reason
    assert np.abs(step.velocity).max() < speed
    assert controller.step(far).status == "moving"


def test_restart_allows_another_posture(controller):
    controller.step(controller.robot.home)
    controller.restart()
    assert controller.step(controller.robot.home + 0.3).status == "moving"


@pytest.mark.parametrize("depth", [0.004, 0.03])
def test_obstacle_put_into_the_margin_or_the_arm_has_a_named_status(depth):
    robot = RobotModel.load(LBR_ARM, "tool")
    place = RigidTransform.from_translation
    world = CollisionWorld(robot, [Obstacle("ball", Sphere(0.05), place([0.0, 0.0, 3.0]))])
    controller = ApproachController(world, [Position(robot.at(robot.home).position)])
    assert controller.step(robot.home).status in ("moving", "reached")
    # The ball comes down on the arm until it is nearer than the margin by `depth`.
    high, low = 3.0, 0.3
    for _ in range(50):
        middle = 0.5 * (high + low)
        world.move("ball", place([0.0, 0.0, middle]), np.zeros(6))
        near = world.proximity(robot.home).distance.min(initial=1.0) < 0.01 - depth
        high, low = (high, middle) if near else (middle, low)
    step = controller.step(robot.home)
    assert step.status == ("too_near" if depth < 0.01 else "contact")
    assert "ball" in step.reason
    assert not step


def test_start_inside_the_margin_is_no_violation():
    robot = RobotModel.load(LBR_ARM, "tool")
    tool = robot.at(robot.home).position
    world = CollisionWorld(
        robot,
        [
            Obstacle(
                "box",
                Box(np.full(3, 0.1)),
                RigidTransform.from_translation(tool + np.array([0.22, 0, 0])),
            )
        ],
    )
    gap = world.proximity(robot.home).distance.min()
    world.move(
        "box",
        RigidTransform.from_translation(tool + np.array([0.22 - gap + 0.006, 0, 0])),
        np.zeros(6),
    )
    controller = ApproachController(world, [Position(tool - np.array([0.1, 0, 0]))])
    assert controller.step(robot.home).status == "moving"
