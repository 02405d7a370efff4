"""Robots by name, and the grippers that their files contain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth.cell import GraspWorld, SimRobot, make_robot
from eyehand.data_synth.cell.jaw_mechanism import find_jaws
from eyehand.data_synth.cell.robot_names import FOLDER_VARIABLE, robot_file
from eyehand.errors import InputError
from eyehand.grasping import JawCommand, JawReading

ROBOTS = Path(__file__).resolve().parents[3].parent / "shared" / "robots"
needs_files = pytest.mark.skipif(not ROBOTS.is_dir(), reason=f"no robot files in {ROBOTS}")


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Name the folder of the robots' files."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(FOLDER_VARIABLE, str(ROBOTS))


@needs_files
@pytest.mark.parametrize(
    ("file", "stroke", "force", "distance"),
    [
        ("franka_emika_panda/panda.xml", 0.080, 50.0, 0.1123),
        ("franka_emika_panda/hand.xml", 0.080, 50.0, 0.1123),
        # 0.1737 m from the mounting face, 10.8 mm before the body that carries the jaws. The pads
        # touch at 0.774 rad of 0.8 rad.
        ("robotiq_2f85/2f85.xml", 0.0854, 45.3, 0.1629),
    ],
)
def test_gripper_is_found_by_constraints_and_tendons(file, stroke, force, distance):
    found = find_jaws(ROBOTS / file)

    assert found.stroke == pytest.approx(stroke, abs=1e-4)
    assert found.force == pytest.approx(force, rel=0.01)
    assert found.T_root_tool.translation[2] == pytest.approx(distance, abs=1e-3)
    assert found.T_root_tool.rotation.as_matrix()[:, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert np.diff(found.widths).min() > 0


@needs_files
def test_two_fingers_of_a_hand_are_jaws_with_a_motor_for_each_joint():
    found = find_jaws(ROBOTS / "wonik_allegro/right_hand.xml")

    assert len(found.motors) == len(found.joints) == 16
    assert found.jaws[0][0].startswith("mf")
    assert found.jaws[1][0].startswith("th")
    # The motors of both fingers close the jaws; those of the bent fingers do not.
    moved = {name[:2] for name, slope in zip(found.motors, found.slopes[5], strict=True) if slope}
    assert moved == {"mf", "th"}
    path = np.gradient(found.lengths, found.widths, axis=0)
    assert np.sum(path * found.slopes, axis=1) == pytest.approx(1.0, abs=0.25)


@needs_files
def test_arm_without_hand_has_no_gripper():
    with pytest.raises(InputError, match="contains no gripper: give --hand"):
        make_robot(str(ROBOTS / "universal_robots_ur5e/ur5e.xml"))


@needs_files
@pytest.mark.parametrize(
    ("arm", "hand", "joints"),
    [("panda", "", 7), ("ur5e", "2f85", 6), ("iiwa14", "2f85", 7), ("panda", "allegro", 7)],
)
def test_arm_rests_outside_image_while_gripper_follows_width(arm, hand, joints):
    kind = make_robot(arm, hand)
    robot = SimRobot(GraspWorld.build((), robot=kind))
    still = np.zeros(joints)
    reading = robot.read()

    assert len(kind.joints) == joints
    for width in (0.03, 0.07):
        for _ in range(250):
            reading = robot.step(still, JawCommand(width, 20.0))
        assert isinstance(reading.hand, JawReading)
        assert reading.hand.width == pytest.approx(width, abs=1e-3)
    assert np.abs(reading.q - kind.home).max() < 1e-3
    # The tray, the edge of the table and the floor behind it give no reading.
    assert robot.capture().valid.mean() > 0.88
    assert not robot.take_contacts()


def test_mount_in_degrees_is_refused():
    with pytest.raises(InputError, match=r"roll, pitch and yaw of --mount must be in rad, got"):
        make_robot("ur5e", "2f85", (0.0, 0.0, 0.01, 0.0, 0.0, 90.0))


@needs_files
def test_files_are_as_good_as_names():
    whole = make_robot(str(ROBOTS / "franka_emika_panda/panda.xml"))
    named = make_robot("panda")
    assert whole.joints == named.joints
    assert whole.jaws is not None
    assert whole.jaws.stroke == pytest.approx(0.08, abs=1e-3)
    turned = make_robot("ur5e", "2f85", (0.0, 0.0, 0.01, 0.0, 0.0, 1.0))
    assert turned.mount is not None
    assert turned.mount.translation[2] == 0.01


@needs_files
def test_gripper_of_a_urdf_gets_a_motor(tmp_path):
    """One slide with a limit of effort, and one that mimics it."""
    box = '<collision><geometry><box size=".01 .02 .06"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{box}</link>' for name in ("base", "left", "right"))
    joints = "".join(
        f'<joint name="{name}" type="prismatic"><parent link="base"/><child link="{name}"/>'
        f'<origin xyz="{sign * 0.005} 0 .06"/><axis xyz="{sign} 0 0"/>'
        f'<limit lower="0" upper=".04" effort="25" velocity="1"/>{more}</joint>'
        for name, sign, more in (("left", 1, ""), ("right", -1, '<mimic joint="left"/>'))
    )
    (tmp_path / "jaws.urdf").write_text(f'<robot name="jaws">{links}{joints}</robot>')
    robot = make_robot("ur5e", "jaws.urdf")

    assert robot.mechanism.motors == ("left_motor",)
    assert robot.mechanism.stroke == pytest.approx(0.08)
    assert robot.mechanism.force == pytest.approx(12.5)


FLOATING = """<mujoco><worldbody><body name="float"><freejoint/><geom size=".01"/>
<body name="palm"><joint name="lift" type="slide" axis="0 0 1" range="-1 1"/>
<geom type="box" size=".05 .02 .02"/>
<body name="a" pos="0 0 .02"><joint name="ja" type="slide" axis="1 0 0" range="0 .03"/>
  <geom type="box" size=".005 .01 .005" pos=".005 0 .01"/>
  <body name="tip"><joint name="still" type="hinge" axis="0 1 0" range="-9 9"/>
    <geom type="box" size=".005 .01 .03" pos=".005 0 .02"/></body></body>
<body name="b" pos="0 0 .02"><joint name="jb" type="slide" axis="-1 0 0" range="0 .03"
  armature="900"/>
  <geom type="box" size=".005 .01 .025" pos="-.005 0 .025"/></body>
</body></body></worldbody>
<equality><joint joint1="still" joint2="ja" polycoef="0 0 0 0 0"/></equality>
<actuator><motor joint="ja" ctrllimited="true" ctrlrange="-20 20"/>
<motor joint="jb" ctrllimited="true" ctrlrange="-20 20"/><motor joint="lift"/></actuator>
</mujoco>"""
"""A gripper that floats in its file; a tip reaches 10 mm into the palm."""


@needs_files
def test_floating_gripper_with_rough_shapes_is_fixed_to_the_arm(tmp_path):
    (tmp_path / "floating.xml").write_text(FLOATING)
    robot = make_robot("ur5e", "floating.xml")
    model = robot.compiled()

    assert robot.hand_joints == ("hand_ja", "hand_still", "hand_jb")
    assert robot.mechanism.overlaps == {("palm", "tip")}
    assert model.nexclude == 1
    # Without the inertia of a motor, such light jaws cannot be driven with their full force.
    # With 900 kg they would hardly move.
    np.testing.assert_allclose(
        [model.dof_armature[model.joint(f"hand_{j}").dofadr[0]] for j in ("ja", "jb")], [0.5, 50.0]
    )


@needs_files
def test_hand_that_points_into_the_arm_is_refused(tmp_path):
    (tmp_path / "floating.xml").write_text(FLOATING)
    with pytest.raises(InputError, match=r"70 mm behind the arm's flange.*half a turn"):
        make_robot("ur5e", "floating.xml", (0.0, 0.0, 0.0, np.pi, 0.0, 0.0))
    with pytest.raises(InputError, match=r"behind the arm's flange: turn the hand with --mount$"):
        make_robot("ur5e", "floating.xml", (0.0, 0.0, 0.0, 0.0, 2.0, 0.0))


@needs_files
def test_hand_that_points_sideways_is_accepted(tmp_path):
    (tmp_path / "floating.xml").write_text(FLOATING)
    make_robot("ur5e", "floating.xml", (0.0, 0.0, 0.0, 0.0, 1.571, 0.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("pand",), "valid names are lbr, panda, ur5e, iiwa14.*did you mean panda"),
        (("ur5e",), "has no hand of its own: give --hand panda, 2f85, allegro"),
        (("lbr", "2f58"), "there is no hand '2f58'.*did you mean 2f85"),
        (("ur5e", "shadow"), "'shadow' can be planned for, but no place on an arm was tested"),
        (("panda", "own"), "goes with the arm 'lbr' only"),
        (("panda", "panda", (0.0, 1.0)), "must be 6 numbers"),
    ],
)
def test_unknown_robot_is_one_line_with_valid_names(arguments, message):
    with pytest.raises(InputError, match=message) as error:
        make_robot(*arguments)
    assert "\n" not in str(error.value)


def test_missing_files_name_extra_and_folder(monkeypatch, tmp_path):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    with pytest.raises(InputError, match=f"{FOLDER_VARIABLE}=.*there is no franka"):
        robot_file("franka_emika_panda/panda.xml")
    monkeypatch.delenv(FOLDER_VARIABLE)
    monkeypatch.setitem(__import__("sys").modules, "mujoco_menagerie", None)
    with pytest.raises(InputError, match=r"eyehand\[robots\].*EYEHAND_ROBOTS"):
        robot_file("franka_emika_panda/panda.xml")


def test_offline_package_is_one_line(monkeypatch):
    class Offline:
        class MenagerieError(Exception):
            pass

        def get(self, _name):
            raise self.MenagerieError("cannot reach\nthe server")

    monkeypatch.delenv(FOLDER_VARIABLE)
    monkeypatch.setitem(__import__("sys").modules, "mujoco_menagerie", Offline())
    with pytest.raises(
        InputError, match="cannot download the files of franka_emika_panda: cannot reach the"
    ):
        robot_file("franka_emika_panda/panda.xml")
