"""The files that a robot's file names, and special files among them."""

import os

import pytest

from eyehand.control import RobotModel
from eyehand.data_synth.cell import GraspRobot
from eyehand.errors import InputError, named_files
from eyehand.grasping.hands import describe_hand


def read_for_control(path):
    return RobotModel.load(path, "tool")


def read_for_simulation(path):
    return GraspRobot.of_file(path, "palm")


@pytest.mark.parametrize("read", [read_for_control, read_for_simulation, describe_hand])
@pytest.mark.parametrize(
    "text",
    [
        '<mujoco><include file="pipe.xml"/></mujoco>',
        '<mujoco><compiler meshdir="m"/><asset><mesh name="a" file="pipe.stl"/></asset></mujoco>',
        '<mujoco><include file="part.xml"/></mujoco>',
    ],
    ids=["include", "mesh", "include of an include"],
)
def test_robot_with_fifo_is_refused_at_once(tmp_path, read, text):
    (tmp_path / "m").mkdir()
    os.mkfifo(tmp_path / "pipe.xml")
    os.mkfifo(tmp_path / "m" / "pipe.stl")
    (tmp_path / "part.xml").write_text('<mujoco><include file="pipe.xml"/></mujoco>')
    robot = tmp_path / "robot.xml"
    robot.write_text(text)
    with pytest.raises(InputError, match="FIFO or device"):
        read(robot)


def test_named_files_are_listed_in_order_of_reading(tmp_path):
    (tmp_path / "m").mkdir()
    (tmp_path / "m" / "arm.stl").write_text("arm")
    (tmp_path / "hand.xml").write_text('<mujoco><include file="robot.xml"/></mujoco>')
    robot = tmp_path / "robot.xml"
    robot.write_text(
        '<mujoco><compiler meshdir="m"/><include file="hand.xml"/>'
        '<asset><mesh file="arm.stl"/><mesh file="none.stl"/></asset></mujoco>'
    )
    assert named_files(robot) == [tmp_path / "hand.xml", tmp_path / "m" / "arm.stl", robot]
