"""`evaluate motion --arm`: arms of others reach among boxes that suit their reach."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.main import main
from eyehand.apps.motion import evaluate
from eyehand.apps.motion.arm_choice import (
    carry_hand,
    choose_arm,
    reaching_robot,
    report_visual_gap,
    robot_with_hand,
)
from eyehand.apps.motion.reach_outcome import ReachOptions
from eyehand.apps.motion.reach_run import run_scene
from eyehand.control import RobotModel
from eyehand.data_synth import LBR_ARM, ReachingArm
from eyehand.data_synth.cell.robot_names import FOLDER_VARIABLE
from eyehand.data_synth.scenes import ArmClearance, make_reaching_scene
from eyehand.errors import InputError

ROBOTS = Path(__file__).resolve().parents[3].parent / "shared" / "robots"
needs_files = pytest.mark.skipif(not ROBOTS.is_dir(), reason=f"no robot files in {ROBOTS}")
every_arm = pytest.mark.parametrize("name", ["panda", "iiwa14", "ur5e"])


@pytest.fixture(autouse=True)
def folder(monkeypatch):
    """Name the folder of the robots' files."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(ROBOTS))


def test_the_included_arm_is_the_default():
    assert choose_arm() == choose_arm("lbr") == ReachingArm()
    flange = choose_arm(str(LBR_ARM), "link7")
    assert (flange.frame, len(flange.joints)) == ("link7", 7)


@needs_files
@every_arm
def test_scene_suits_the_arm(name):
    arm = choose_arm(name)
    robot = reaching_robot(arm)
    reaches = []
    for seed in range(3):
        scene = make_reaching_scene(seed, arm=arm)
        clearance = ArmClearance(scene.obstacles, arm)
        assert len(scene.start) == robot.n
        assert min(clearance.at(scene.start), clearance.at(scene.witness)) >= 0.02
        # The evaluation and the controller agree on the frame.
        np.testing.assert_allclose(clearance.tool(scene.witness), scene.goal, atol=1e-12)
        np.testing.assert_allclose(robot.at(scene.witness).position, scene.goal, atol=1e-9)
        reaches += [np.linalg.norm(box.T_world_shape.translation) for box in scene.obstacles]
    assert 0.3 < np.median(reaches) < 1.2


@needs_files
@every_arm
def test_arm_reaches_among_boxes_within_its_limits(name):
    record = run_scene("default + planner", 801, 5, ReachOptions(arm=choose_arm(name)))
    outcome = record.outcome
    assert outcome.success, record.reason
    assert outcome.min_clearance > 0.0095
    assert max(outcome.peak_acceleration, outcome.peak_jerk) < 1.0 + 1e-6


@needs_files
def test_published_limits_of_the_panda_are_used():
    robot = reaching_robot(choose_arm("panda"))
    np.testing.assert_array_equal(robot.acceleration, [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
    np.testing.assert_array_equal(robot.jerk, 500.0 * robot.acceleration)


@needs_files
def test_arm_with_a_hand_keeps_its_fingers_at_home():
    file = ROBOTS / "franka_emika_panda" / "panda.xml"
    arm = choose_arm(str(file), "hand")
    assert arm.joints == tuple(f"joint{k}" for k in range(1, 8))
    scene = make_reaching_scene(0, boxes=2, arm=arm)
    assert len(scene.start) == 7
    assert run_scene("default + planner", 0, 2, ReachOptions(arm=arm)).outcome.contacts == 0


@needs_files
@pytest.mark.parametrize(("arm", "hand"), [("panda", "panda"), ("ur5e", "2f85"), ("lbr", "own")])
def test_arm_carries_a_rigid_open_hand(arm, hand, tmp_path):
    joined = robot_with_hand(arm, hand, None)
    assert joined is not None
    chosen = carry_hand(arm, joined, tmp_path / "robot.xml")
    robot = reaching_robot(chosen)
    assert robot.joint_names == joined.joints
    # The pads and their distance are those of the robot that picks.
    picks = RobotModel.load(
        joined.description(joined.home, joined.open_drives, RigidTransform.identity()),
        joined.frame,
        joints=joined.joints,
    )
    np.testing.assert_allclose(
        robot.at(joined.home).position, picks.at(joined.home).position, atol=1e-6
    )
    without = choose_arm(arm)
    beyond = robot.at(joined.home).position - reaching_robot(without).at(joined.home).position
    assert np.linalg.norm(beyond) > 0.05
    scene = make_reaching_scene(0, boxes=1, arm=chosen)
    assert ArmClearance(scene.obstacles, chosen).at(scene.start) >= 0.02


@needs_files
def test_mount_moves_the_hand(tmp_path):
    places = []
    for shift in (0.0, 0.03):
        joined = robot_with_hand("ur5e", "2f85", [0.0, 0.0, shift, 0.0, 0.0, 0.0])
        assert joined is not None
        robot = reaching_robot(carry_hand("ur5e", joined, tmp_path / f"{shift}.xml"))
        places.append(robot.at(joined.home).position)
    assert np.linalg.norm(places[1] - places[0]) == pytest.approx(0.03)
    with pytest.raises(InputError, match="--mount needs --hand"):
        robot_with_hand("ur5e", "", [0.0] * 6)


@needs_files
def test_command_names_the_arm_and_runs_the_baseline(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(evaluate, "QUICK_MOVING", 1)
    with pytest.raises(SystemExit) as exit_info:
        main(
            [
                *("evaluate", "motion", "--arm", "ur5e", "--hand", "2f85"),
                *("--quick", "--scenes", "1"),
                *("--boxes", "1", "--only", "default", "--only", "mink"),
                *("--out", str(tmp_path), "--json"),
            ]
        )
    assert not exit_info.value.code
    report = json.loads(capsys.readouterr().out)
    assert (report["arm"], report["hand"]) == ("ur5e", "2f85")
    rows = {row["name"]: row for row in report["rows"]}
    assert rows["default"]["contacts"] == 0
    assert rows["mink"]["peak_acceleration_pct"] > 100


@pytest.mark.parametrize(
    ("arm", "frame", "message"),
    [
        ("pandaa", "", "there is no arm 'pandaa': valid names are lbr, panda, ur5e, iiwa14"),
        ("lbr", "flunge", "unknown frame 'flunge'; there are sites tool"),
        (str(LBR_ARM), "", "unknown frame 'attachment_site'"),
    ],
)
def test_unknown_arm_or_frame_is_refused(arm, frame, message):
    with pytest.raises(InputError, match=message):
        choose_arm(arm, frame)


def test_neighbours_are_for_the_included_arm():
    arm = choose_arm(str(LBR_ARM), "link7")
    with pytest.raises(InputError, match="neighbours fits the included arm only"):
        make_reaching_scene(0, place="neighbours", arm=arm)


@needs_files
def test_links_outside_their_collision_shapes_are_reported(capsys):
    report_visual_gap(reaching_robot(choose_arm()))
    assert not capsys.readouterr().err
    report_visual_gap(reaching_robot(choose_arm("ur5e")))
    assert "26.5 mm nearer than the margin" in capsys.readouterr().err
