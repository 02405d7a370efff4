"""Files of grippers as their tools write them: parts, units, prefixes, mesh formats, couplings."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from gripper_files import rack_and_pinion

from eyehand.control import RobotModel
from eyehand.control.mujoco_binding import mujoco
from eyehand.errors import InputError
from eyehand.grasping import load_description
from eyehand.grasping.hands import FileChoices, describe_hand

HINGED = """<mujoco>{compiler}<worldbody><body name="base"><geom type="box" size=".05 .02 .01"/>
<body name="a" pos=".03 0 .01"><joint name="ja" axis="0 -1 0" range="0 {end}"/>
  <geom type="box" size=".003 .01 .03" pos=".003 0 .03"/></body>
<body name="b" pos="-.03 0 .01"><joint name="jb" axis="0 1 0" range="0 {end}"/>
  <geom type="box" size=".003 .01 .03" pos="-.003 0 .03"/></body>
</body></worldbody><equality><joint joint1="jb" joint2="ja"/></equality></mujoco>"""
"""MJCF: fingers of 60 mm, parallel and 60 mm apart when open, turn until their tips touch."""

FINGER = """<body name="{n}" pos="{x} 0 .02"><joint name="{n}_base" axis="0 {s} 0" range="-40 50"/>
  <geom type="capsule" size=".006" fromto="0 0 0 0 0 .04"/>
  <body name="{n}_tip" pos="0 0 .04"><joint name="{n}_bend" axis="0 {s} 0" range="-40 50"/>
    <geom type="capsule" size=".006" fromto="0 0 0 0 0 .03"/></body></body>"""
COUPLED = """<mujoco><worldbody><body name="palm"><geom type="box" size=".05 .03 .01"/>{fingers}
</body></worldbody><tendon><fixed name="bends"><joint joint="two_base" coef="1"/>
<joint joint="two_bend" coef="2"/></fixed></tendon><equality>
<joint joint1="one_bend" joint2="one_base" polycoef="0 -.5 0 0 0"/><tendon tendon1="bends"/>
</equality></mujoco>""".format(
    fingers=FINGER.format(n="one", x="-.03", s="1") + FINGER.format(n="two", x=".03", s="-1")
)
"""MJCF: two fingers of two links. The outer links turn back by half the angle of the inner ones."""


@pytest.mark.parametrize(
    "text", ["<mujocoinclude><body/></mujocoinclude>", "<mujoco><body/></mujoco>"]
)
def test_part_of_a_robot_names_the_file_that_includes_it(tmp_path, text):
    (tmp_path / "hand.xml").write_text(text)
    (tmp_path / "whole.xml").write_text('<mujoco><include file="hand.xml"/></mujoco>')

    with pytest.raises(InputError, match=r"another file includes: give that file, .*whole\.xml"):
        describe_hand(tmp_path / "hand.xml")


def test_tags_of_other_tools_and_half_an_inertia_are_left_out(tmp_path):
    path = tmp_path / "rack.urdf"
    extra = '<inertial><mass value="1"/></inertial><drake:hull drake:on="1"><box/></drake:hull>'
    path.write_text(rack_and_pinion().replace('<link name="left">', f'<link name="left">{extra}'))

    assert describe_hand(path).hand.stroke == pytest.approx(0.09)


LIMITED_ARM = """<robot name="arm"><link name="foot"/><link name="upper">
<inertial><mass value="1"/></inertial><collision><geometry>
<mesh filename="package://some_arm/meshes/upper.stl"/></geometry></collision></link>
<joint name="one" type="revolute"><parent link="foot"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="0.5" effort="9"/></joint>
<link name="flange"/><joint name="end" type="fixed"><parent link="upper"/><child link="flange"/>
<origin xyz="0 0 0.3"/></joint></robot>"""


def test_description_of_arm_and_gripper_keeps_limits_and_home(tmp_path):
    (tmp_path / "some_arm" / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.1, 0.1, 0.3)).export(tmp_path / "some_arm" / "meshes" / "upper.stl")
    (tmp_path / "away").mkdir()
    (path := tmp_path / "away" / "arm.urdf").write_text(LIMITED_ARM)
    (tmp_path / "rack.urdf").write_text(rack_and_pinion())

    arm = load_description(path, package_dirs=[tmp_path], home=[0.4])
    hand = load_description(tmp_path / "rack.urdf")
    arm.body("flange").add_frame().attach_body(hand.body("base"), "", "_of_hand")
    model = RobotModel.load(arm, "flange")
    assert (model.joint_names, model.speed.tolist(), model.home.tolist()) == (
        ("one",),
        [0.5],
        [0.4],
    )
    np.testing.assert_allclose(model.at([0.0]).position, [0.0, 0.0, 0.3], atol=1e-12)

    world = mujoco.MjSpec()  # MuJoCo compiles no spec that was attached, so this comes last.
    world.worldbody.add_frame().attach_body(arm.body("foot"), "robot/", "")
    assert RobotModel.load(world, "robot/flange").speed.tolist() == [0.5]
    with pytest.raises(InputError, match="home must be finite numbers, one for each of one"):
        load_description(path, package_dirs=[tmp_path], home=[0.4, 0.0])


@pytest.mark.parametrize("suffix", ["glb", "ply"])
def test_meshes_of_other_formats(tmp_path, suffix):
    path = tmp_path / "rack.urdf"
    trimesh.creation.box((0.012, 0.02, 0.06)).export(tmp_path / f"finger.{suffix}")
    path.write_text(rack_and_pinion(shape=f'<mesh filename="finger.{suffix}"/>'))
    hand = describe_hand(path).hand

    assert hand.stroke == pytest.approx(0.09)
    assert (hand.pad_width, hand.pad_height) == pytest.approx((0.02, 0.06))

    (tmp_path / f"finger.{suffix}").write_bytes(b"glTF no mesh")
    with pytest.raises(InputError, match=rf"finger\.{suffix} cannot be read"):
        describe_hand(path)


def test_file_without_unit_of_angles_is_read_in_rad_where_degrees_cannot_be_meant(tmp_path):
    strokes = []
    for compiler, end in (("", "0.8"), ('<compiler angle="radian"/>', "0.8"), ("", "45.84")):
        path = tmp_path / "hinged.xml"
        path.write_text(HINGED.format(compiler=compiler, end=end))
        found = describe_hand(path)
        strokes.append(found.hand.stroke)
        assert any("read in rad" in one for one in found.remarks) == (not strokes[1:])
    # The pads enclose 60° when their tips touch, but they are parallel when open.
    assert strokes == pytest.approx([0.06] * 3, abs=1e-4)


def test_fingers_that_pinch_keep_the_ratios_of_their_joints(tmp_path):
    path = tmp_path / "coupled.xml"
    path.write_text(COUPLED)
    hand = describe_hand(path, FileChoices(pinch=("one", "two"))).hand
    joints = {joint.name: (joint.open, *joint.between) for joint in hand.joints}

    assert hand.stroke > 0.03
    for finger in ("one", "two"):
        base, bend = (np.array(joints[f"{finger}_{part}"]) for part in ("base", "bend"))
        np.testing.assert_allclose(bend, -0.5 * base, atol=1e-4)


def test_two_arms_are_no_hand(tmp_path):
    joint = '<joint name="{n}" axis="0 1 0" range="-90 90"/>'
    link = '<body name="{n}" pos="0 0 {z}">' + joint + "{inner}</body>"
    shape = '<geom type="capsule" size=".03" fromto="0 0 0 0 0 .3"/>'
    arms = ""
    for side, x in (("left", -0.2), ("right", 0.2)):
        inner = shape
        for number in (3, 2, 1):
            inner = shape + link.format(n=f"{side}{number}", z=0.3, inner=inner)
        arms += f'<body pos="{x} 0 0">{inner}</body>'
    path = tmp_path / "torso.xml"
    path.write_text(f'<mujoco><worldbody><body name="torso">{arms}</body></worldbody></mujoco>')

    with pytest.raises(InputError, match=r"no gripper is found: .* as of an arm"):
        describe_hand(path)


TURNING_JAW = """<mujoco><worldbody><body name="palm">
<geom type="box" size=".05 .02 .005" pos=".07 0 -.005"/><body name="mover">
<joint name="jaw" axis="0 1 0" range="-90 0"/>
<geom type="box" size=".05 .02 .005" pos=".07 0 .005"/></body></body></worldbody>
<actuator><motor joint="jaw" ctrlrange="-{torque} {torque}"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("torque", "force", "remark"),
    [
        (2, 0, "compare it with the data sheet; --force"),
        (6, 0, "compare it with"),
        (60, 40, "not credible"),
    ],
)
def test_jaw_that_turns_by_90_degrees_and_its_force(tmp_path, torque, force, remark):
    path = tmp_path / "jaw.xml"
    path.write_text(TURNING_JAW.format(torque=torque))
    found = describe_hand(path)

    # At the widest usable angle of 45°, the tips are 85 mm apart.
    assert 0.02 < found.hand.stroke < 0.085
    assert found.hand.min_opening == 0.0
    # 6 Nm at 45° over a way of about 30 mm are about 150 N.
    assert found.hand.force[1] == pytest.approx(
        force or torque * np.pi / 4 / found.hand.stroke, rel=0.15
    )
    said = " ".join(one for one in found.remarks if "closing force" in one)
    assert remark in said


def test_flat_meshes_and_impossible_inertias_are_read(tmp_path):
    flat = trimesh.Trimesh(
        [[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0], [0.01, 0.01, 0]], [[0, 1, 2], [1, 3, 2]]
    )
    flat.export(tmp_path / "tag.stl")
    inertia = '<inertia ixx="-1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    tag = '<collision><geometry><mesh filename="tag.stl"/></geometry></collision>'
    more = f'<link name="left"><inertial><mass value="1"/>{inertia}</inertial>{tag}'
    path = tmp_path / "rack.urdf"
    path.write_text(rack_and_pinion().replace('<link name="left">', more))

    assert describe_hand(path).hand.stroke == pytest.approx(0.09)


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ('type="hinge" axis="0 0 1" range="-90 90"', "moves by less than 2 mm, as the flange"),
        ('type="hinge" axis="0 0 1" limited="false"', "turns without limits, as the wrist"),
        ('type="hinge" axis="1 0 0" range="0 90"', "whose gripper is in another file"),
    ],
)
def test_arm_without_gripper_is_said_to_be_one(tmp_path, joint, message):
    path = tmp_path / "arm.xml"
    path.write_text(
        '<mujoco><worldbody><body name="link"><geom size=".03"/><body name="flange" pos="0 0 .1">'
        f'<joint name="last" {joint}/><geom type="cylinder" size=".03 .02"/></body></body>'
        "</worldbody></mujoco>"
    )
    with pytest.raises(InputError, match=f"no gripper is found: .*{message}"):
        describe_hand(path)


@pytest.mark.parametrize(
    ("fold", "width", "message"),
    [
        ("0 1.2", 0.009, "no posture within the joint ranges"),
        ("-1.2 1.2", 0.001, "no flat pads that face each other"),
    ],
)
def test_fingers_that_do_not_pinch_are_refused_with_the_reason(tmp_path, fold, width, message):
    finger = (
        '<body name="{0}" pos="{1} 0 .03"><geom type="box" size=".008 .009 .025" pos="0 0 .025"/>'
        '<joint name="{0}1" axis="0 {2} 0" range="-.3 1.2"/>'
        '<body name="{0}_tip" pos="0 0 .05"><joint name="{0}2" axis="0 {2} 0" range="{3}"/>'
        '<geom type="box" size=".007 {4} .02" pos="0 0 .02"/></body></body>'
    )
    path = tmp_path / "hand.xml"
    fingers = "".join(
        finger.format(name, x, side, fold, width)
        for name, x, side in (("thumb", -0.05, 1), ("left", 0.05, -1), ("right", 0.05, -1))
    )
    path.write_text(
        '<mujoco><compiler angle="radian"/><worldbody><body name="palm">'
        f'<geom type="box" size=".05 .04 .03"/>{fingers}</body></worldbody></mujoco>'
    )
    with pytest.raises(InputError, match=f"no gripper is found: .*{message}"):
        describe_hand(path)


def test_pads_that_pass_beside_each_other_are_reported(tmp_path):
    jaw = (
        '<body name="{side}" pos="{x} 0 0"><joint type="slide" axis="{x} 0 0" range="0 .03"/>'
        '<geom type="box" size=".005 .01 .03" pos="0 0 .03"/>'
        '<geom type="box" size=".01 .01 .004" pos="{inside} 0 {z}"/></body>'
    )
    jaws = [("left", -0.025, 0.015, 0.055), ("right", 0.025, -0.015, 0.04)]
    bodies = "".join(jaw.format(side=s, x=x, inside=inside, z=z) for s, x, inside, z in jaws)
    palm = f'<body><geom type="box" size=".06 .02 .01"/>{bodies}</body>'
    text = f"<mujoco><worldbody>{palm}</worldbody></mujoco>"
    for nubs, said in ((text, True), (text.replace("0 0.04", "0 0.055"), False)):
        path = tmp_path / "jaws.xml"
        path.write_text(nubs)
        found = describe_hand(path)
        assert found.hand.stroke == pytest.approx(0.06)
        assert any("closed pads are 7 mm apart" in one for one in found.remarks) == said


def test_finger_that_no_motor_moves_is_named(tmp_path):
    path = tmp_path / "spring.xml"
    finger = """<body name="{n}" pos="0 {y} .04"><joint name="{n}_slide" type="slide"
    axis="0 {s} 0" range="0 .028"/><geom type="box" size=".01 .002 .03" pos="0 0 .01"/></body>"""
    both = finger.format(n="a", y=".03", s="-1") + finger.format(n="b", y="-.03", s="1")
    path.write_text(
        f'<mujoco><worldbody><body name="hand"><geom type="box" size=".03 .05 .02"/>{both}</body>'
        '</worldbody><actuator><motor joint="a_slide"/></actuator></mujoco>'
    )

    with pytest.raises(
        InputError, match=r"nothing opposes the jaw 'a', no motor, .* moves b_slide"
    ):
        describe_hand(path)


def test_answered_question_is_not_asked_again(tmp_path):
    path = tmp_path / "sides.xml"
    finger = """<body name="{n}" pos="0 {y} 0"><geom type="box" size=".05 .04 .05"/>
    <joint name="{n}_hinge" axis="0 0 1" pos="0 {back} 0" range="{turn}"/></body>"""
    both = finger.format(n="a", y=".07", back="-.07", turn="-.4 0")
    both += finger.format(n="b", y="-.07", back=".07", turn="0 .4")
    path.write_text(
        '<mujoco><compiler angle="radian"/><worldbody><body name="hand">'
        f'<geom type="box" size=".07 .07 .07"/>{both}</body></worldbody></mujoco>'
    )

    with pytest.raises(InputError, match=r"--tcp is needed: .* \+y or -y"):
        describe_hand(path)
    with pytest.raises(InputError, match="one jaw does not reach beside the other"):
        describe_hand(path, FileChoices(tcp="+y"))
