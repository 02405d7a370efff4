"""The simulated robot: motion, contact, perception, and faults."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control import CollisionWorld, RobotModel
from eyehand.data_synth.cell import GraspCell, GraspRobot, GraspWorld, SimRobot
from eyehand.data_synth.scenes import TabletopObject
from eyehand.errors import InputError
from eyehand.grasping.hands import GripOptions, HandCommand, HandModel
from eyehand.grasping.hands.closing import Closing
from eyehand.grasping.hands.hand_state import finger_reading
from eyehand.grasping.robot import Robot
from eyehand.perception.superquadric import Superquadric

ABOVE_BOX = (-0.274, 1.138, 0.328, -1.277, -0.42, 0.791, -1.399)
"""Joint angles, rad: the palm points straight down, at a height of 0.130 m and x = y = 0.05 m."""


def ball(name: str, position: tuple[float, float, float], radius: float = 0.03) -> TabletopObject:
    shape = Superquadric(
        np.full(3, radius), (1.0, 1.0), RigidTransform.from_translation(position), "sphere"
    )
    return TabletopObject(name, shape, 0.1, (0.8, 0.3, 0.2))


@pytest.fixture(scope="module")
def world() -> GraspWorld:
    return GraspWorld.build([ball("ball_1", (0.05, 0.02, 0.03))])


def test_reading_has_sizes_of_hand_model(world: GraspWorld):
    robot: Robot = SimRobot(world)
    reading = robot.read()
    hand, sensed = robot.hand, finger_reading(reading.hand)
    assert isinstance(hand, HandModel)
    assert len(robot.joints) == len(reading.q) == 7
    assert sensed.excursions.shape == sensed.tensions.shape == (len(hand.drives),)
    assert sensed.angles.shape == (len(hand.joints),)
    assert sensed.forces.shape == (len(hand.pads),)
    assert len(sensed.tips) == len(hand.fingers)
    assert np.allclose(sensed.excursions, 0.0, atol=1e-6)
    assert reading.fault == ""


def test_robot_at_rest_does_not_move_or_touch_objects(world: GraspWorld):
    robot = SimRobot(world)
    reading = robot.read()
    start = reading.q
    for _ in range(100):
        reading = robot.step(np.zeros(7))
    assert np.isclose(reading.time, 0.4)
    assert np.abs(reading.q - start).max() < 2e-3
    assert robot.take_contacts() == set()
    assert not robot.is_lifted("ball_1")
    assert not robot.is_in_tray("ball_1")
    assert np.allclose(robot.object_pose("ball_1").translation, [0.05, 0.02, 0.03], atol=1e-3)


def test_commanded_velocity_is_tracked_without_lag(world: GraspWorld):
    robot = SimRobot(world)
    start = robot.read()
    goal, errors = start.q.copy(), []
    for k in range(250):
        velocity = 0.4 * np.sin(2 * np.pi * k / 250) * np.array([1, -1, 1, 1, 1, 1, 1.0])
        goal += robot.period * velocity
        errors.append(np.abs(robot.step(velocity).q - goal).max())
    assert max(errors) < 0.01


def test_control_avoids_the_pedestal(world: GraspWorld):
    robot = SimRobot(world)
    model = RobotModel.load(robot.description(np.zeros(5)), robot.hand_frame, joints=robot.joints)
    pairs = CollisionWorld(model, ()).pair_names
    parts = {one for one, other in pairs if other == "pedestal"}
    assert "hand_palm_pad" in parts
    assert "link1_shell" in parts


def test_description_contains_pose_of_robot(world: GraspWorld):
    robot = SimRobot(world)
    model = RobotModel.load(robot.description(np.zeros(5)), robot.hand_frame, joints=robot.joints)
    assert np.allclose(model.home, robot.read().q)
    assert np.array_equal(model.speed[:3].round(3), [1.71, 1.71, 1.745])
    palm = robot.data.site("robot_hand_palm")
    state = model.at(robot.read().q)
    assert np.allclose(state.position, palm.xpos, atol=1e-6)
    assert np.allclose(state.rotation.ravel(), palm.xmat, atol=1e-6)


def test_hand_reaches_commanded_tendon_excursions(world: GraspWorld):
    robot = SimRobot(world)
    hand = robot.hand
    assert isinstance(hand, HandModel)
    goal = hand.excursions_at(0.06)
    command = HandCommand(("position",) * len(hand.drives), goal)
    reading = robot.read()
    for _ in range(250):
        reading = robot.step(np.zeros(7), command)
    sensed = finger_reading(reading.hand)
    assert np.abs(sensed.excursions - goal).max() < 1e-3
    posture = robot.world.robot.posture(goal)
    assert np.abs(sensed.angles - posture).max() < 0.06


def test_robot_grasps_lifts_and_senses_object():
    shape = Superquadric(
        np.array([0.025, 0.025, 0.04]),
        (0.1, 0.1),
        RigidTransform.from_translation([0.05, 0.05, 0.04]),
        "box",
    )
    box = TabletopObject("box_1", shape, 0.3, (0.9, 0.6, 0.2))
    robot = SimRobot(GraspWorld.build([box], robot=GraspRobot(rest=ABOVE_BOX)))
    still = np.zeros(7)
    # The hand starts open above the box, with the fingertips at the height of its centre.
    assert isinstance(robot.hand, HandModel)
    closing = Closing(robot.hand, "precision", 0.09, GripOptions())
    reading = robot.read()
    while closing.state not in ("holding", "empty") and reading.time < 3.5:
        reading = robot.step(still, closing.step(reading.hand, robot.period))
    assert closing.state == "holding"
    assert robot.take_contacts() == {"box_1"}

    model = RobotModel.load(robot.description(np.zeros(5)), robot.hand_frame, joints=robot.joints)
    start = model.at(reading.q).position[2]
    up = np.array([0.0, 0.0, 0.15, 0.0, 0.0, 0.0])
    for _ in range(150):
        rates = np.asarray(np.linalg.pinv(model.at(reading.q).jacobian) @ up, dtype=np.float64)
        reading = robot.step(rates, closing.step(reading.hand, robot.period))
    assert robot.is_lifted("box_1")
    assert abs(model.at(reading.q).position[2] - start - 0.09) < 0.003
    assert robot.object_pose("box_1").translation[2] > 0.115
    sensed = finger_reading(reading.hand)
    for finger, image in zip(robot.hand.fingers, sensed.tips, strict=True):
        pad = sensed.forces[robot.hand.pads.index(f"{finger}_distal")]
        assert pad > 1.0
        assert np.isclose(image.pressures.sum() * image.array.area, pad, rtol=0.1)

    wrenches = []
    for _ in range(150):
        reading = robot.step(still, closing.step(reading.hand, robot.period))
        assert reading.wrench is not None
        wrenches.append(reading.wrench)
    # The palm points straight down, and the box hangs below its middle.
    force, torque = np.split(np.mean(wrenches[50:], axis=0), 2)
    assert np.allclose(force, [0.0, 0.0, 0.3 * 9.81], atol=0.1)
    assert np.allclose(torque, 0.0, atol=0.03)


def test_wrist_measures_nothing_but_noise_with_an_empty_hand(world: GraspWorld):
    robot = SimRobot(world)
    wrenches = np.array([robot.step(np.zeros(7)).wrench for _ in range(200)])
    assert np.abs(wrenches.mean(axis=0)).max() < 0.02
    assert np.allclose(wrenches.std(axis=0), [0.06] * 3 + [0.002] * 3, rtol=0.25)


def test_capture_shows_object_without_robot_and_tray(world: GraspWorld):
    robot = SimRobot(world)
    frame = robot.capture()
    assert frame.T_world_camera is not None
    valid = frame.depth > 0
    points = frame.T_world_camera.apply(frame.intrinsics.rays()[valid] * frame.depth[valid, None])
    cell = GraspCell()
    assert not cell.is_over_tray(points).any()
    on_table = np.all(np.abs(points[:, :2]) < [0.6, 0.4], axis=1)
    high = points[on_table & (points[:, 2] > 0.005)]
    assert len(high) > 300
    centre = robot.object_pose("ball_1").translation
    assert np.abs(np.linalg.norm(high - centre, axis=1) - 0.03).max() < 0.002
    again = robot.capture()
    assert np.array_equal(frame.depth, again.depth)


def test_non_finite_command_stops_robot_permanently(world: GraspWorld):
    robot = SimRobot(world)
    reading = robot.step(np.full(7, np.nan))
    assert "not finite" in reading.fault
    later = robot.step(np.full(7, 0.5))
    assert later.fault == reading.fault
    assert np.array_equal(later.q, reading.q)


def test_failed_simulation_reports_fault_and_finite_reading(world: GraspWorld):
    robot = SimRobot(world)
    robot.data.qvel[-1] = 1e12
    reading = robot.step(np.zeros(7))
    assert "simulation failed" in reading.fault
    assert np.isfinite(reading.q).all()
    assert robot.step(np.zeros(7)).time == reading.time


def test_robot_rejects_invalid_arguments(world: GraspWorld):
    robot = SimRobot(world)
    with pytest.raises(InputError, match="velocity"):
        robot.step(np.zeros(6))
    with pytest.raises(InputError, match="object must be one of"):
        robot.object_pose("box_9")
    with pytest.raises(InputError, match="seed"):
        SimRobot(world, seed=-1)
