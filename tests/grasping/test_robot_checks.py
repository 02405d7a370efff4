"""Robot classes with a mistake are refused in one line before they move."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.grasping import (
    ArmReading,
    Cell,
    JawReading,
    JoinedRobot,
    PickOptions,
    Tray,
    clear_table,
    load_hand,
)
from eyehand.grasping.robot_checks import check_start
from eyehand.perception import CameraIntrinsics, DepthFrame

from .fake_robot import HAND, FakeRobot

TRAY = Tray(np.array([0.43, -0.19, 0.006]), (0.25, 0.36), 0.07)


def no_scene(frame):
    pytest.fail("no image is perceived")


def refusal(robot) -> str:
    with pytest.raises(InputError) as error:
        Cell(robot, no_scene, TRAY)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    ("member", "value", "words"),
    [
        ("hand", "panda", "robot.hand must be of type HandModel or ParallelHand, got str"),
        ("hand_frame", None, "robot.hand_frame must be of type str"),
        ("joints", "joint1", "must be the names of the arm's joints"),
        ("period", 4.0, "robot.period must be 0 to 1 s, got 4.0"),
        ("capture", 3, "FakeRobot.capture must be a method, got 3"),
        ("description", lambda _: None, "robot.description(): robot: the source must be a path"),
        ("read", lambda: (0.0, [0.0]), "robot.read() must be of type RobotReading, got tuple"),
    ],
)
def test_wrong_member_is_named(member, value, words):
    robot = FakeRobot()
    setattr(robot, member, value)

    assert words in refusal(robot)


def test_missing_members_are_listed():
    class Empty:
        hand = None

    assert refusal(Empty()).startswith("Empty lacks hand_frame, joints, period, description, capt")
    assert refusal(FakeRobot) == "Robot: FakeRobot is a class, pass an object of it"


def test_missing_members_of_a_driver_are_listed():
    with pytest.raises(InputError, match="object lacks joints, period, read, step: eyehand"):
        JoinedRobot(object(), object(), object(), lambda _: "", "palm")  # pyright: ignore[reportArgumentType]


def test_arm_whose_step_returns_nothing_is_named():
    state = ArmReading(0.0, np.zeros(1), np.zeros(1))
    arm = SimpleNamespace(
        joints=("a",), period=0.01, read=lambda: state, step=lambda velocity: None
    )
    hand = SimpleNamespace(model=None, read=lambda: JawReading(0.05), move=lambda command: None)
    camera = SimpleNamespace(capture=lambda: None)
    robot = JoinedRobot(arm, hand, camera, lambda _: "", "palm")  # pyright: ignore[reportArgumentType]
    with pytest.raises(DeviceError, match=r"arm: .*what step\(\) returns .* ArmReading, got None"):
        robot.step(np.zeros(1))
    assert robot.read().time == 0.0


@pytest.mark.parametrize(
    ("q", "words"),
    [
        (np.degrees, "its limits are .* angles must be in rad, not in degrees"),
        (lambda q: q[::-1] + 2.0, "check the order of robot.joints, the signs and the zero"),
        (lambda q: q[:-1], r"read\(\).q must be . finite numbers"),
        (lambda q: q * np.nan, r"read\(\).q must be . finite numbers"),
    ],
)
def test_wrong_joint_angles_are_refused(q, words, monkeypatch):
    robot = FakeRobot()
    reading = replace(robot.read(), q=q(robot.q))
    monkeypatch.setattr(robot, "read", lambda: reading)

    with pytest.raises(InputError, match=words):
        Cell(robot, no_scene, TRAY)


def test_description_without_a_rest_posture_is_refused(monkeypatch):
    robot = FakeRobot()
    spec = robot.description(np.array(HAND.excursions[-1])).copy()
    spec.delete(spec.key("home"))
    monkeypatch.setattr(robot, "description", lambda _: spec)

    assert "no keyframe 'home'" in refusal(robot)


def test_wrong_widths_and_efforts_are_refused(monkeypatch):
    robot = FakeRobot()
    cell = Cell(robot, no_scene, TRAY)
    model = cell.model(cell.hand.posture(cell.hand.max_opening))
    monkeypatch.setattr(robot, "hand", load_hand("panda"))

    for reading, words in (
        (JawReading(80.0), "write it in m, not in mm"),
        (JawReading(None), "hand.width must be a number, got None"),  # pyright: ignore
        (JawReading(0.08, "12"), "hand.effort must be a number, got '12'"),  # pyright: ignore
    ):
        with pytest.raises(InputError, match=words):
            check_start(replace(robot.read(), hand=reading), robot, model)


def test_frame_without_a_pose_ends_clearing():
    robot = FakeRobot()
    camera = CameraIntrinsics(100.0, 100.0, 15.5, 11.5, 32, 24)
    robot.capture = lambda: DepthFrame(np.ones((24, 32), np.float32), camera)

    report = clear_table(Cell(robot, no_scene, TRAY))

    assert "frame without a pose: pass DepthFrame(depth, intrinsics, T_world" in report.stop_reason


@pytest.mark.parametrize(
    "sizes",
    [{"size": (25.0, 36.0)}, {"size": (250.0, 360.0)}, {"wall_height": 60.0}],
    ids=["cm", "mm", "wall"],
)
def test_tray_larger_than_the_arm_is_refused(sizes):
    with pytest.raises(InputError, match="give them in m, not in mm"):
        Cell(FakeRobot(), no_scene, replace(TRAY, **sizes))


def test_tray_longer_than_the_arm_is_accepted():
    Cell(FakeRobot(), no_scene, replace(TRAY, size=(0.8, 1.2)))


def test_two_trays_are_refused():
    trays: Any = (TRAY, TRAY)
    with pytest.raises(InputError, match="tray must be of type Tray, got tuple"):
        Cell(FakeRobot(), no_scene, trays)


def test_tray_out_of_reach_is_refused():
    tray = replace(TRAY, centre=np.array([430.0, -190.0, 6.0]))
    with pytest.raises(InputError, match=r"is 47\d m from the base of the arm, which reaches 1"):
        Cell(FakeRobot(), no_scene, tray)


@pytest.mark.parametrize(
    "option", [{"lift_height": 100.0}, {"speed": "0.3"}, {"carry_speed": -1.0}]
)
def test_pick_options_out_of_range_are_refused(option):
    with pytest.raises(InputError, match=f"pick option {next(iter(option))} must be 0 to"):
        PickOptions(**option)
