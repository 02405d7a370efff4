"""Grippers read from MJCF and URDF files: made-up ones with known measures, and real ones."""

from __future__ import annotations

import json
import os
import shutil
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from gripper_files import (
    BOTH_WAYS,
    INDEPENDENT,
    ONE_JAW,
    SHORT_OF_CLOSING,
    SWAPPED,
    box,
    mesh_package,
    mimic_linkage,
    parallelogram,
    rack_and_pinion,
)

from eyehand.apps.main import main
from eyehand.errors import InputError
from eyehand.grasping.hands import FileChoices, ParallelHand, describe_hand, load_hand
from eyehand.grasping.hands.hand_files import read_hand
from eyehand.grasping.hands.robot_file.read_model import read_model
from eyehand.grasping.hands.robot_file.urdf_text import prepared_urdf

ROBOTS = Path(__file__).resolve().parents[4] / "shared" / "robots"
MM = 1e-3


def described(tmp_path: Path, text: str, suffix: str = ".xml", **choices) -> ParallelHand:
    path = tmp_path / f"gripper{suffix}"
    path.write_text(text)
    return describe_hand(path, FileChoices(**choices)).hand


def union(boxes) -> np.ndarray:
    """Return low and high corner of all boxes, (2, 3)."""
    return np.array(
        [np.min([box.low for box in boxes], axis=0), np.max([box.high for box in boxes], axis=0)]
    )


def test_rack_and_pinion_with_a_mimic_joint(tmp_path):
    hand = described(tmp_path, rack_and_pinion(), ".urdf")

    assert hand.stroke == pytest.approx(0.09)
    assert hand.min_opening == 0.0
    assert (hand.pad_width, hand.pad_height) == pytest.approx((0.02, 0.06))
    assert hand.finger_depth == pytest.approx(0.06)
    assert hand.mount_distance == pytest.approx(0.14)
    assert hand.force == (0.0, 30.0)
    np.testing.assert_allclose(
        union(hand.finger_boxes), [[0, -0.01, -0.06], [0.012, 0.01, 0]], atol=1e-4
    )
    np.testing.assert_allclose(
        union(hand.palm_boxes), [[-0.07, -0.03, -0.14], [0.07, 0.03, -0.06]], atol=1e-4
    )
    names = {joint.name: (joint.open, joint.closed) for joint in hand.joints}
    assert names == {"rack_joint": (0.045, 0.0), "follow_joint": (0.045, 0.0)}
    assert hand.middle_shift == (0.0, 0.0)


def test_jaws_of_unequal_length_are_reported(tmp_path):
    text = rack_and_pinion()
    k = text.index('<link name="right">')
    longer = text[k:].replace("-0.006 0 0.03", "-0.006 0 0.02").replace("0.02 0.06", "0.02 0.04")
    path = tmp_path / "hand.urdf"
    path.write_text(text[:k] + longer)
    assert any("one jaw is 20 mm longer" in remark for remark in describe_hand(path).remarks)


def test_two_motors_small_pads_and_a_camera(tmp_path):
    hand = described(tmp_path, INDEPENDENT)

    assert hand.stroke == pytest.approx(0.052)
    assert hand.min_opening == 0.0
    assert (hand.pad_width, hand.pad_height) == pytest.approx((0.016, 0.012))
    assert hand.finger_depth == pytest.approx(0.04)
    assert hand.force == (0.0, 25.0)
    # The pads are the innermost part, and the fingers lie 4 mm behind them.
    np.testing.assert_allclose(
        union(hand.finger_boxes), [[0, -0.01, -0.04], [0.014, 0.01, 0]], atol=1e-4
    )
    (camera,) = hand.camera_boxes
    np.testing.assert_allclose([camera.high[2], -camera.low[2]], [-0.03, 0.07], atol=1e-4)
    assert max(abs(value) for box in hand.palm_boxes for value in (box.low[1], box.high[1])) < 0.031
    assert {joint.name: joint.open for joint in hand.joints} == {"ja": 0.03, "jb": -0.03}


def test_parallelogram_with_closed_loops(tmp_path):
    hand = described(tmp_path, parallelogram())

    closed = -np.arcsin(0.022 / 0.06)
    stroke = 2 * (0.022 + 0.06 * np.sin(0.6))
    assert (hand.stroke, hand.min_opening) == pytest.approx((stroke, 0.0), abs=2e-4)
    assert hand.tip_advance == pytest.approx(0.06 * (np.cos(closed) - np.cos(0.6)), abs=2e-4)
    assert (hand.pad_width, hand.pad_height) == pytest.approx((0.02, 0.05), abs=4e-3)
    # The tips are farthest with upright rods.
    assert hand.mount_distance == pytest.approx(0.17, abs=1e-3)
    # 2 N m turn both rods, while the jaws close by the stroke.
    assert hand.force[1] == pytest.approx(2.0 * (0.6 - closed) / stroke, abs=0.1)
    (joint,) = [joint for joint in hand.joints if joint.name == "right_outer"]
    share = 2 * (0.022 + 0.06 * np.sin(0.2)) / stroke
    assert joint.at(share) == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize(
    ("text", "suffix"),
    [
        (rack_and_pinion(), ".urdf"),
        (INDEPENDENT, ".xml"),
        (parallelogram(), ".xml"),
        (ONE_JAW, ".xml"),
        (SWAPPED, ".xml"),
    ],
    ids=["rack", "independent", "parallelogram", "one jaw", "swapped"],
)
def test_boxes_hold_the_whole_gripper_open_and_closed(tmp_path, text, suffix):
    path = tmp_path / f"gripper{suffix}"
    path.write_text(text)
    found = describe_hand(path)
    hand = found.hand
    for triangles, opening in ((found.opened, hand.stroke), (found.closed, hand.min_opening)):
        points = triangles.reshape(-1, 3)
        boxes = np.concatenate([hand.jaw_boxes(opening), hand.fixed_boxes()])
        inside = (points[:, None] > boxes[:, 0] - MM / 2) & (points[:, None] < boxes[:, 1] + MM / 2)
        assert np.any(inside.all(axis=2), axis=1).all()


def test_linkage_of_mimic_joints_without_loops(tmp_path):
    path = tmp_path / "linkage.urdf"
    path.write_text(mimic_linkage())
    found = describe_hand(path)
    hand = found.hand

    # The pad's face is 23 mm inside a joint at 55 mm.
    assert hand.stroke == pytest.approx(0.064, abs=2e-4)
    assert hand.min_opening == 0.0
    assert hand.pad_width == pytest.approx(0.022)
    assert "--force LOW HIGH" in found.remarks[0]
    names = {joint.name for joint in hand.joints}
    assert {"left_drive", "right_drive", "left_tip", "right_tip"} <= names


def test_coupled_joints_stop_together_where_jaws_do_not_close(tmp_path):
    path = tmp_path / "short.urdf"
    path.write_text(SHORT_OF_CLOSING)
    hand = describe_hand(path).hand

    assert hand.min_opening == pytest.approx(0.016, abs=1e-3)
    closed = {joint.name: joint.closed for joint in hand.joints}
    assert closed["drive"] == pytest.approx(0.1)
    for name, factor in (("left_turn", -1), ("right_drive", -1), ("right_turn", 1)):
        assert closed[name] == pytest.approx(factor * closed["drive"], abs=1e-4)


def test_one_jaw_against_a_fixed_one_on_an_arm(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(ONE_JAW)
    found = describe_hand(path)
    hand = found.hand

    assert "--force LOW HIGH" in found.remarks[0]
    assert hand.middle_shift == pytest.approx((0.03, 0.0))
    np.testing.assert_allclose(hand.middle(0.02), [0.01, 0.0, 0.0])
    assert hand.stroke == pytest.approx(0.06)
    assert hand.min_opening == 0.0
    assert hand.finger_depth == pytest.approx(0.06, abs=1e-3)
    np.testing.assert_allclose(
        union(hand.finger_boxes), [[0, -0.012, -0.06], [0.008, 0.012, 0]], atol=1e-3
    )
    # The palm is 100 mm wide, and the tool frame moves by 30 mm in it.
    low, high = union(hand.palm_boxes)
    assert high[0] - low[0] == pytest.approx(0.13, abs=1e-3)
    assert hand.tool is not None
    assert hand.tool.body == "palm"
    assert hand.tool.position == pytest.approx((-0.036, 0, 0.07), abs=1e-4)


def test_swapped_axes_and_round_fingers_on_one_tendon(tmp_path):
    hand = described(tmp_path, SWAPPED)

    assert hand.stroke == pytest.approx(0.04)
    assert hand.force == (0.0, 8.0)
    assert hand.finger_depth == pytest.approx(0.05, abs=1e-3)
    assert hand.tool is not None
    assert hand.tool.position == pytest.approx((0.05, 0, 0))
    np.testing.assert_allclose(union(hand.finger_boxes)[1], [0.012, 0.006, 0.0], atol=2e-4)


def test_scaled_meshes_of_a_ros_package(tmp_path, monkeypatch):
    boxes = described(tmp_path, rack_and_pinion(), ".urdf")
    path = mesh_package(tmp_path)
    for arrange in ("above", "option", "variable"):
        used, choices = path, FileChoices()
        monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
        if arrange != "above":
            used = Path(shutil.copy(path, tmp_path / "moved.urdf"))
            with pytest.raises(InputError, match=r"package://rack/.* is missing; --package-dir"):
                describe_hand(used)
        if arrange == "option":
            choices = FileChoices(package_dirs=(tmp_path / "share",))
        if arrange == "variable":
            monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere{os.pathsep}{tmp_path / 'share'}")
        hand = describe_hand(used, choices).hand
        assert hand.finger_boxes == boxes.finger_boxes
        assert hand.palm_boxes == boxes.palm_boxes


def test_direction_in_doubt_is_asked_for(tmp_path):
    with pytest.raises(InputError, match=r"--tcp is needed: .* \+z or -z of the body 'bar'"):
        described(tmp_path, BOTH_WAYS.format(site=""))
    site = '<site name="grasp_site" pos="0 0 -.05"/>'
    by_site = described(tmp_path, BOTH_WAYS.format(site=site))
    by_axis = described(tmp_path, BOTH_WAYS.format(site=""), tcp="-z")
    for hand in (by_site, by_axis):
        assert hand.tool is not None
        assert hand.tool.position == pytest.approx((0, 0, -0.05))
    with pytest.raises(InputError, match=r"--tcp nowhere: .* it has bar, one, two"):
        described(tmp_path, BOTH_WAYS.format(site=""), tcp="nowhere")
    beside = rack_and_pinion().replace("0 0 0.04", "0 0 -0.04").replace("0 0 0.08", "0 0 0")
    with pytest.raises(InputError, match=r"behind the palm .*: --tcp must name a point at the fin"):
        described(tmp_path, beside, tcp="left")


def test_two_grippers_are_asked_for_by_body(tmp_path):
    one = INDEPENDENT.split("<worldbody>")[1].split("</worldbody>")[0]
    other = one.replace('"wrist"', '"second"').replace('name="a"', 'name="a2"')
    for name in ("b", "ja", "jb", "camera_mount"):
        other = other.replace(f'name="{name}"', f'name="{name}2"')
    other = other.replace('"second"', '"second" pos="0 1 0"')
    joint = '<joint name="elbow{}" axis="0 0 1" range="-90 90"/>'
    text = f"<mujoco><worldbody>{one}{other}</worldbody></mujoco>"
    text = text.replace('<body name="wrist">', '<body name="wrist">' + joint.format(1))
    text = text.replace('pos="0 1 0">', 'pos="0 1 0">' + joint.format(2))
    with pytest.raises(InputError, match=r"--palm is needed: 2 grippers.*second, wrist"):
        described(tmp_path, text)
    assert described(tmp_path, text, palm="wrist").stroke == pytest.approx(0.052)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("panda", "franka_emika_panda/hand.xml"),
        ("panda", "franka_emika_panda/panda.xml"),
        ("2f85", "robotiq_2f85/2f85.xml"),
    ],
)
def test_built_in_hand_equals_its_file(name, file):
    """Width, depth, pads, tool frame and outer boxes agree within 1 mm, and joint names exactly."""
    path = ROBOTS / file
    if not path.is_file():
        pytest.skip(f"no {path}")
    built_in, found = load_hand(name), describe_hand(path).hand
    for value in (
        "stroke",
        "min_opening",
        "finger_depth",
        "pad_width",
        "pad_height",
        "mount_distance",
        "tip_advance",
    ):
        assert getattr(built_in, value) == pytest.approx(getattr(found, value), abs=MM), value
    for opening in (0.0, found.stroke):
        hulls = [
            np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
            for boxes in (built_in.jaw_boxes(opening), found.jaw_boxes(opening))
        ]
        np.testing.assert_allclose(hulls[0], hulls[1], atol=MM)
    np.testing.assert_allclose(union(built_in.palm_boxes), union(found.palm_boxes), atol=MM)
    assert built_in.tool == found.tool
    assert [joint.name for joint in built_in.joints] == [joint.name for joint in found.joints]
    for joint, other in zip(built_in.joints, found.joints, strict=True):
        assert joint.at(0.5) == pytest.approx(other.at(0.5), abs=0.01)


def shadow_file() -> Path:
    spec = find_spec("gymnasium_robotics")
    if spec is None or spec.origin is None:
        pytest.skip("gymnasium_robotics is not installed")
    return Path(spec.origin).parent / "envs" / "assets" / "hand" / "reach.xml"


@pytest.mark.parametrize("name", ["allegro", "shadow"])
def test_fingers_of_a_hand_are_jaws(name):
    """Thumb and finger close along one line, with their joints inside the limits of the file."""
    path = ROBOTS / "wonik_allegro" / "right_hand.xml" if name == "allegro" else shadow_file()
    if not path.is_file():
        pytest.skip(f"no {path}")
    found, built_in = describe_hand(path), load_hand(name)
    hand = found.hand

    assert built_in.kind == hand.kind == "fingers"
    assert built_in.pre_shape == hand.pre_shape
    for value in ("stroke", "min_opening", "finger_depth", "tip_advance", "mount_distance"):
        assert getattr(built_in, value) == pytest.approx(getattr(hand, value), abs=MM), value
    model, _ = read_model(path)
    assert {joint.name for joint in hand.joints} == {joint.name for joint in built_in.joints}
    for joint in hand.joints:
        low, high = model.jnt_range[model.joint(joint.name).id]
        positions = [joint.at(share) for share in np.linspace(0.0, 1.0, 21)]
        assert low - 1e-4 <= min(positions) <= max(positions) <= high + 1e-4
    for triangles, opening in ((found.opened, hand.stroke), (found.closed, hand.min_opening)):
        points = triangles.reshape(-1, 3)
        boxes = np.concatenate([hand.jaw_boxes(opening), hand.fixed_boxes()])
        inside = (points[:, None] > boxes[:, 0] - 2 * MM) & (points[:, None] < boxes[:, 1] + 2 * MM)
        assert np.any(inside.all(axis=2), axis=1).mean() > 0.99


def test_fingers_that_pinch_are_named(tmp_path):
    path = ROBOTS / "wonik_allegro" / "right_hand.xml"
    if not path.is_file():
        pytest.skip(f"no {path}")
    with pytest.raises(InputError, match=r"--pinch nobody: .* the fingers are ff_base, mf_base"):
        describe_hand(path, FileChoices(pinch=("th_tip", "nobody")))
    with pytest.raises(InputError, match="of one finger"):
        describe_hand(path, FileChoices(pinch=("th_distal", "th_base")))


FINGER = """<body name="f{k}" pos="{x} {y} .03">
<joint type="slide" axis="{x} {y} 0" range="-.035 0"/>
<geom type="box" size=".01 .01 .03" pos="0 0 .03"/></body>"""
CENTRIC = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .05 .03"/>
{}</body></worldbody></mujoco>""".format(
    "".join(
        FINGER.format(k=k, x=x, y=y)
        for k, (x, y) in enumerate(((0.04, 0), (-0.04, 0), (0, 0.04), (0, -0.04)), start=1)
    )
)
CUP = """<mujoco><worldbody><body name="base"><geom type="cylinder" size=".03 .025"/>
<body name="bellows" pos="0 0 .05"><joint type="slide" axis="0 0 1" range="-.01 0"/>
<geom type="cylinder" size=".02 .015"/></body></body></worldbody></mujoco>"""


def test_four_jaws_around_a_point_and_a_suction_cup_are_refused(tmp_path):
    (tmp_path / "centric.xml").write_text(CENTRIC)
    with pytest.raises(InputError, match="more than two jaws around one point cannot be described"):
        describe_hand(tmp_path / "centric.xml", FileChoices(pinch=("f1", "f2")))
    (tmp_path / "cup.xml").write_text(CUP)
    with pytest.raises(InputError, match=r"Only one link moves: .* no gripper with jaws"):
        describe_hand(tmp_path / "cup.xml")


def test_motor_that_ends_before_its_joint_is_reported(tmp_path):
    file = tmp_path / "short.xml"
    for end, reported in ((".03", False), (".02", True)):
        limits = f'ctrllimited="true" ctrlrange="0 {end}"'
        file.write_text(INDEPENDENT.replace('joint="ja" kp', f'{limits} joint="ja" kp'))
        remarks = " ".join(describe_hand(file).remarks)
        assert ("moves it from 0 to 0.02, and its range is 0 to 0.03" in remarks) == reported


def test_hands_from_data_sheets_say_so():
    for name, stroke, force in (
        ("2f140", 0.14, (10.0, 125.0)),
        ("hande", 0.05, (20.0, 185.0)),
        ("wsg50", 0.11, (5.0, 80.0)),
    ):
        hand = load_hand(name)
        assert (hand.stroke, hand.force) == (stroke, force)
        assert not hand.checked
        assert "data sheet" in hand.source
        assert "Not checked against a file" in hand.notes


def test_command_writes_a_description_that_grasp_reads(tmp_path, capsys):
    source, output = tmp_path / "rack.urdf", tmp_path / "new" / "hand.json"
    source.write_text(rack_and_pinion())
    picture = tmp_path / "hand.png"
    with pytest.raises(SystemExit) as exit_info:
        main(["hand", "describe", str(source), "--output", str(output), "--picture", str(picture)])
    assert exit_info.value.code == 0
    assert capsys.readouterr().out == ""
    assert read_hand(output) == load_hand(output) == describe_hand(source).hand
    assert picture.stat().st_size > 1000
    with pytest.raises(SystemExit):
        main(["hand", "describe", str(source), "--force", "5", "20"])
    assert json.loads(capsys.readouterr().out)["force"] == [5, 20]


@pytest.mark.parametrize("limits", [(-27.7, 27.7), (0.0, 62.8), (-400.0, 400.0)])
def test_geared_motor_that_turns_often_is_no_joint_in_degrees(limits):
    text = rack_and_pinion().replace('prismatic"', 'revolute"')
    text = text.replace('lower="0" upper="0.045"', 'lower="{}" upper="{}"'.format(*limits))
    assert prepared_urdf(Path("a.urdf"), ElementTree.fromstring(text), ()).text


BAD = {
    "empty": ("", "is empty"),
    "no XML": ("hello", "no MJCF or URDF file"),
    "other XML": ("<sdf/>", "must be <mujoco> or <robot>, got <sdf>"),
    "no joint": ('<robot name="r"><link name="a"/></robot>', "no joint that moves"),
    "NaN": (INDEPENDENT.replace(".06 .03 .03", "nan .03 .03"), "size of <geom> must be finite"),
    "infinite": (rack_and_pinion(base='<box size="inf 1 1"/>'), "must be finite"),
    "negative": (rack_and_pinion(base='<box size="-1 1 1"/>'), "MuJoCo cannot read it"),
    "mesh": (rack_and_pinion(base='<mesh filename="a.stl"/>'), "the mesh a.stl of link 'base' is"),
    "xacro": ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:a/></robot>', "xacro"),
    "xacro value": (rack_and_pinion().replace('upper="0.045"', 'upper="${stroke/2}"'), "xacro"),
    "degrees": (
        rack_and_pinion().replace('prismatic"', 'revolute"').replace('"0.045"', '"40"'),
        "joint 'rack_joint' turns from 0 to 40 rad: write the limits",
    ),
    "no number": (
        rack_and_pinion().replace('prismatic"', 'revolute"').replace('"0.045"', '"1.2.3"'),
        "limits of a joint must be numbers, got 0, 1.2.3",
    ),
    "finger in mm": (rack_and_pinion(shape=box("12 20 60")), "left is 60 m long, at most 1 m"),
    "no range": (INDEPENDENT.replace('range="0 .03"', ""), "--range is needed: joint 'ja'"),
    "two parents": (
        rack_and_pinion().replace('<child link="right"/>', '<child link="left"/>'),
        "two parents",
    ),
    "loop": (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">'
        '<parent link="a"/><child link="b"/></joint><joint name="k" type="fixed">'
        '<parent link="b"/><child link="a"/></joint></robot>',
        "form a loop",
    ),
    "no shapes": (
        '<robot name="r"><link name="base"/><link name="left"/>'
        + '<joint name="j" type="revolute"><parent link="base"/><child link="left"/>'
        + '<axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>',
        "no shapes",
    ),
    "open loop": (
        parallelogram().replace(
            'inner_joint" axis="0 1 0" range="-1 1"', 'inner_joint" axis="0 1 0" range="-.05 .05"'
        ),
        "closed loops of the gripper leave gaps",
    ),
    "free wrist": (
        '<mujoco><worldbody><body name="a"><joint name="j" axis="0 0 1" range="-90 90"/>'
        '<geom size=".1"/></body></worldbody></mujoco>',
        "no gripper is found",
    ),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_bad_file_is_refused_in_one_line(tmp_path, capfd, text, message):
    path = tmp_path / ("robot.urdf" if text.startswith("<robot") else "robot.xml")
    path.write_text(text)
    assert message in refused(path, capfd)
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_fifo_folder_huge_and_binary_files_are_refused(tmp_path, capfd):
    fifo = tmp_path / "fifo.xml"
    os.mkfifo(fifo)
    huge = tmp_path / "huge.urdf"
    with huge.open("wb") as file:
        file.truncate(100_000_000)
    binary = tmp_path / "binary.xml"
    binary.write_bytes(bytes(range(256)) * 10)
    for path, message in (
        (fifo, "FIFO"),
        (tmp_path, "folder"),
        (huge, "100 MB"),
        (binary, "no MJCF or URDF"),
        (tmp_path / "none.xml", "there is no file"),
    ):
        assert message in refused(path, capfd)
    for path in (fifo, tmp_path, huge, binary):
        with pytest.raises(InputError) as error:
            read_hand(path)
        assert "\n" not in str(error.value)


def test_negative_axis_of_the_fingers_needs_no_equals_sign(tmp_path, capfd):
    path = tmp_path / "bar.xml"
    path.write_text(BOTH_WAYS.format(site=""))
    with pytest.raises(SystemExit) as exit_info:
        main(["hand", "describe", str(path), "--tcp", "-z"])
    printed = capfd.readouterr()

    assert exit_info.value.code == 0, printed.err
    assert json.loads(printed.out)["stroke"] > 0.0


def refused(path: Path, capfd) -> str:
    """Run the command, which must end with code 2, and return its only line."""
    with pytest.raises(SystemExit) as exit_info:
        main(["hand", "describe", str(path)])
    printed = capfd.readouterr()
    assert exit_info.value.code == 2, printed.err
    assert printed.out == ""
    (line,) = printed.err.strip().splitlines()
    return line
