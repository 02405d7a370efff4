"""A hand frame that is not the gripper's tool frame is refused before the first motion."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.control import RobotModel
from eyehand.errors import InputError
from eyehand.grasping import load_hand
from eyehand.grasping.hand_frame_check import check_hand_frame

HAND = load_hand("panda")
ARM = """
<mujoco><worldbody><body name="wrist" pos="0 0 0.5">
  <joint name="lift" type="slide" axis="0 0 1" range="-1 1"/><geom size="0.03" mass="1"/>
  <site name="tool" pos="0 0 0.1"/>
  <site name="turned" pos="0 0 0.1" euler="0 0 90"/>
  <site name="short" pos="0 0 0.06"/>
  <site name="near" pos="0 0 0.09"/>
  <body pos="{left} 0 0.08"><geom type="box" size="0.005 0.01 0.02"/></body>
  <body pos="{right} 0 0.08"><geom type="box" size="0.005 0.01 0.02"/></body>
</body></worldbody></mujoco>
"""


HINGED = """
<mujoco><worldbody><body name="wrist" pos="0 0 0.5">
  <joint name="lift" type="slide" axis="0 0 1" range="-1 1"/><geom size="0.03" mass="1"/>
  <site name="tool" pos="0 0 0.1"/>
  <body euler="0 {left} 0"><geom type="box" size="0.002 0.01 0.05" pos="-0.002 0 0.05"/></body>
  <body euler="0 {right} 0"><geom type="box" size="0.002 0.01 0.05" pos="0.002 0 0.05"/></body>
</body></worldbody></mujoco>
"""
"""Two jaws of 100 mm that turn about the wrist."""


def test_jaws_that_turn_are_accepted():
    angle = np.degrees(np.arcsin(0.04 / 0.1))
    opened, closed = (
        RobotModel.load(HINGED.format(left=-turn, right=turn), "tool", joints=["lift"])
        for turn in (angle, 0.0)
    )
    check_hand_frame("tool", HAND, opened, closed)


def model(frame: str, width: float) -> RobotModel:
    half = 0.5 * width + 0.005
    return RobotModel.load(ARM.format(left=-half, right=half), frame, joints=["lift"])


def check(frame: str, opened: float = HAND.stroke, closed: float = 0.0) -> None:
    check_hand_frame(frame, HAND, model(frame, opened), model(frame, closed))


def test_tool_frame_is_accepted(caplog):
    check("tool")
    assert not caplog.records


def test_description_whose_jaws_do_not_move_is_not_judged(caplog):
    check("turned", closed=HAND.stroke)
    assert "do not move with the width" in caplog.text


@pytest.mark.parametrize(
    ("frame", "opened", "words"),
    [
        ("near", HAND.stroke, "end at z = 10 mm of robot.hand_frame"),
        ("tool", 0.9 * HAND.stroke, "close by 72 mm, robot.hand by 80 mm"),
    ],
)
def test_small_difference_gives_a_warning(frame, opened, words, caplog):
    check(frame, opened)
    assert words in caplog.text


@pytest.mark.parametrize(
    ("frame", "opened", "words"),
    [
        ("turned", HAND.stroke, "close by 0 mm along x of this frame, robot.hand by 80 mm"),
        ("wrist", HAND.stroke, "the fingertips end at z = 100 mm of this frame, expected 0"),
        ("short", HAND.stroke, "the fingertips end at z = 40 mm"),
        ("tool", 0.5 * HAND.stroke, "close by 40 mm along x"),
    ],
)
def test_wrong_frame_is_refused_with_its_distance(frame, opened, words):
    with pytest.raises(InputError, match=words):
        check(frame, opened)
