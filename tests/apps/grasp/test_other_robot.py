"""Robots in one MJCF file, with a hand description beside it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.grasp.bench.trial import GraspTrial, make_cell, run_trial
from eyehand.data_synth import LBR_ARM, import_mujoco
from eyehand.data_synth.arms import PALM_BEFORE_FLANGE_M
from eyehand.data_synth.cell import GraspRobot, grasp_robot, match_options
from eyehand.errors import InputError
from eyehand.grasping import HandModel

ASSETS = Path(grasp_robot.__file__).parent / "assets"
PREFIX = "servo_"


@pytest.fixture(scope="module")
def robot_file(tmp_path_factory):
    """The LBR-like arm with a hand of position servos, written to one file."""
    mujoco = import_mujoco()
    path = tmp_path_factory.mktemp("robot") / "servo_robot.xml"
    spec = mujoco.MjSpec.from_file(str(LBR_ARM))
    hand = mujoco.MjSpec.from_file(str(ASSETS / "servo_hand.xml"))
    for root in hand.worldbody.bodies:
        root.pos = [0.0, 0.0, PALM_BEFORE_FLANGE_M]
    match_options(spec, hand)
    spec.attach(hand, prefix=PREFIX, site=next(s for s in spec.sites if s.name == "tool"))
    spec.compile()
    path.write_text(spec.to_xml())
    told = json.loads((ASSETS / "servo_hand.hand.json").read_text())
    for finger in told["fingers"].values():
        finger["joints"] = {PREFIX + name: ends for name, ends in finger["joints"].items()}
        finger["pads"] = [PREFIX + name for name in finger["pads"]]
    told["palm"] = [PREFIX + name for name in told["palm"]]
    path.with_suffix(".hand.json").write_text(json.dumps(told))
    return path


def trial(path, **more):
    return GraspTrial("single", 3, known=True, robot=str(path), hand_frame=f"{PREFIX}palm", **more)


def test_arm_and_hand_joints_are_separated(robot_file):
    robot = GraspRobot.of_file(robot_file, f"{PREFIX}palm")

    assert len(robot.joints) == 7
    assert robot.hand_joints[0] == f"{PREFIX}left_knuckle"
    assert robot.drives == ("left", "right", "thumb")
    hand = robot.measured_hand()
    assert isinstance(hand, HandModel)
    half = robot.posture(hand.excursions_at(0.05))
    assert half.shape == (6,)
    assert (half > robot.posture(hand.excursions_at(0.08))).all()
    # Opened as wide as it goes, the posture is what the file calls open.
    np.testing.assert_allclose(robot.posture(np.zeros(3)), [-0.55, 0.15] * 3)


def test_wrist_of_a_hand_that_keeps_still_is_no_arm_joint(robot_file, tmp_path):
    spec = import_mujoco().MjSpec.from_file(str(robot_file))
    spec.body(f"{PREFIX}hand").add_joint(name="wrist", axis=[0, 1, 0], range=[-0.5, 0.5])
    spec.compile()
    path = tmp_path / "wrist.xml"
    path.write_text(spec.to_xml())
    description = json.loads(robot_file.with_suffix(".hand.json").read_text())
    path.with_suffix(".hand.json").write_text(json.dumps({**description, "still": {"wrist": 0.0}}))

    robot = GraspRobot.of_file(path, f"{PREFIX}palm")

    assert robot.joints == GraspRobot.of_file(robot_file, f"{PREFIX}palm").joints
    assert "wrist" in robot.hand_joints


def test_other_robot_puts_object_into_tray(robot_file):
    result = run_trial(trial(robot_file))

    assert result.placed == 1, result
    assert result.picks[-1].outcome == "placed"
    assert result.picks[-1].touched_before == 0


def test_requested_friction_applies_to_pads(robot_file):
    _, robot = make_cell(trial(robot_file, friction=0.6))

    pad = robot.model.geom(f"robot_{PREFIX}left_tip")
    assert pad.friction[0] == 0.6
    assert pad.priority == 1


def test_missing_hand_description_names_expected_file(robot_file, tmp_path):
    path = tmp_path / "alone.xml"
    path.write_text(robot_file.read_text())

    with pytest.raises(InputError, match=r"alone\.hand\.json"):
        make_cell(trial(path))


def test_unknown_hand_frame_is_named_in_error(robot_file):
    with pytest.raises(InputError, match="no site or body 'plam'"):
        make_cell(GraspTrial("single", 3, robot=str(robot_file), hand_frame="plam"))


def test_servo_hand_attaches_to_default_arm():
    robot = GraspRobot(
        hand=ASSETS / "servo_hand.xml",
        frame="hand_palm",
        fingers=grasp_robot.description_beside(ASSETS / "servo_hand.xml"),
    )

    assert len(robot.joints) == 7
    hand = robot.measured_hand()
    assert isinstance(hand, HandModel)
    assert hand.max_opening > 0.1
    assert robot.posture(np.zeros(3)).shape == (6,)


def test_tendon_robot_in_one_file_equals_arm_and_hand_files(tmp_path):
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(LBR_ARM))
    hand = mujoco.MjSpec.from_file(str(ASSETS / "hand.xml"))
    for root in hand.worldbody.bodies:
        root.pos = [0.0, 0.0, PALM_BEFORE_FLANGE_M]
    match_options(spec, hand)
    spec.attach(hand, prefix=PREFIX, site=next(s for s in spec.sites if s.name == "tool"))
    spec.compile()
    path = tmp_path / "tendons.xml"
    # Names of tendons and pads mean something: they are those of the hand's own file.
    path.write_text(re.sub(rf'(?<!class=)"{PREFIX}', '"', spec.to_xml()))
    one, two = GraspRobot.of_file(path, "palm"), GraspRobot()

    found, known = one.measured_hand(), two.measured_hand()
    assert isinstance(found, HandModel)
    assert isinstance(known, HandModel)

    assert found.drives == known.drives
    np.testing.assert_allclose(found.openings, known.openings)
    np.testing.assert_allclose(found.reaches, known.reaches, atol=1e-5)
    np.testing.assert_allclose(found.excursions, known.excursions, atol=1e-5)
    pulled = known.excursions_at(0.06)
    np.testing.assert_allclose(one.posture(pulled), two.posture(pulled), atol=1e-3)
    result = run_trial(GraspTrial("single", 3, known=True, robot=str(path), hand_frame="palm"))
    assert result.placed == 1, result
