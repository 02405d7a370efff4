"""Robot files that cannot be used: each raises an error of one line with the reason."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from eyehand.data_synth import LBR_ARM, import_mujoco
from eyehand.data_synth.cell import HAND, GraspRobot, GraspWorld, SimRobot
from eyehand.data_synth.cell.contact_record import ContactRecord
from eyehand.errors import InputError

PARTS = HAND.parent
ARM = LBR_ARM.read_text()
HOME = 'name="home" qpos="0 0.6'
BASE = '<body name="base" childclass="lbr">'
FLOATING = re.sub("<keyframe>.*</keyframe>", "", ARM, flags=re.DOTALL)
FLOATING = FLOATING.replace(BASE, BASE + "<freejoint/>")
URDF = '<robot name="r"><link name="tool"/></robot>'


def error_message(path, frame="tool") -> str:
    with pytest.raises(InputError) as error:
        GraspRobot.of_file(path, frame).measured_hand()
    message = str(error.value)
    assert "\n" not in message
    assert "None" not in message
    return message


def with_line(line, before="</mujoco>"):
    return ARM.replace(before, line + before, 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"robot\.xml is empty"),
        ("<html/>", r"root element must be .*<html>"),
        (ARM[:2000], r"no MJCF or URDF file: .*line \d+"),
        (with_line('<sensor><smell name="x"/></sensor>'), r"cannot read .*smell"),
        (
            with_line('<sensor><touch name="x" site="gone"/></sensor>'),
            r"compile .*robot\.xml: .*gone",
        ),
        (with_line('<asset><mesh name="m" file="gone.stl"/></asset>'), r"robot\.xml: .*gone\.stl"),
        (
            ARM.replace(HOME, 'name="home" qpos="0 9.6'),
            r"joint2 rests at 9.6 rad, must lie in \[-2",
        ),
        (FLOATING, r"has a free joint: the base of a robot must be fixed"),
        (re.sub('name="joint3"', "", ARM), r"cannot|without a name"),
        (
            re.sub('name="joint3"', 'name="joint3" type="slide"', ARM),
            r"joint3 .* is not a hinge",
        ),
        (
            re.sub("<position[^>]*joint3[^>]*/>", '<motor joint="joint3"/>', ARM),
            r"joint3 has no position servo",
        ),
        (ARM, r"the fingers of .* are not described: .*robot\.hand\.json"),
    ],
)
def test_invalid_mjcf_raises_with_reason(tmp_path, text, message):
    path = tmp_path / "robot.xml"
    path.write_text(text)
    assert re.search(message, error_message(path)), error_message(path)


def test_file_of_another_format_raises(tmp_path):
    (tmp_path / "robot.xml").write_bytes(np.random.default_rng(0).bytes(3000))
    (tmp_path / "robot.urdf").write_text(URDF)
    assert "no MJCF or URDF file" in error_message(tmp_path / "robot.xml")
    assert "<position> actuator" in error_message(tmp_path / "robot.urdf")
    assert "this is a folder" in error_message(tmp_path)
    assert "no such file" in error_message(tmp_path / "gone.xml")


def test_arm_joint_described_as_finger_joint_raises(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(ARM)
    finger = {"joints": {"joint3": [0.0, 1.0]}, "pads": ["base_shell"]}
    thumb = {"joints": {"other": [0.0, 1.0]}, "pads": ["link1_shell"]}
    described = {"fingers": {"middle": finger, "thumb": thumb}}
    path.with_suffix(".hand.json").write_text(json.dumps(described))
    assert "joint joint3 is described as a finger's" in error_message(path)


def test_unnamed_body_belongs_to_robot(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(ARM.replace("<worldbody>", '<worldbody><body><geom size="0.01"/></body>', 1))
    world = GraspWorld.build([], robot=GraspRobot.of_file(path, "tool"))
    model = world.copy_model()
    touch = ContactRecord(model, import_mujoco().MjData(model), world)
    (unnamed,) = (k for k in range(1, model.nbody) if not model.body(k).name)
    assert touch.robot[model.body_geomadr[unnamed]]


def test_simulation_failure_at_start_raises(monkeypatch):
    world, mujoco = GraspWorld.build([]), import_mujoco()

    def overflow(_model, _data):
        raise mujoco.FatalError("out of memory\nmax = 15728640")

    monkeypatch.setattr(mujoco, "mj_forward", overflow)
    with pytest.raises(InputError, match=r"this robot: out of memory max = 15728640"):
        SimRobot(world)


@pytest.mark.parametrize("hand", ["hand.xml", "servo_hand.xml"])
def test_hand_without_arm_raises(hand):
    message = error_message(PARTS / hand, "palm")
    assert "has no arm: no joint lies between its base and the hand's frame 'palm'" in message


def test_unknown_frame_raises_with_known_names():
    assert "there are tool" in error_message(LBR_ARM, "tol")
