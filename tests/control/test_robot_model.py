"""The robot model: poses and Jacobians against finite differences, loading, and errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.control.mujoco_binding import mujoco
from eyehand.control.robot_model import RobotModel
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike

ARM = """
<mujoco><compiler angle="radian"/>
<worldbody>
  <body name="base"><geom name="foot" type="cylinder" size=".1 .05"/>
  <body name="rail" pos="0 0 .1"><joint name="rail" type="slide" axis="1 0 0" range="-.2 .4"/>
  <geom size=".05"/>
  <body name="turn" pos="0 0 .2" euler=".2 0 .1"><joint name="turn" axis="0 0 1" range="-2 1"/>
  <geom type="capsule" size=".04 .1"/>
  <body name="lift" pos=".1 0 .2"><joint name="lift" axis="0 1 0" pos="0 .02 0"/>
  <geom type="capsule" size=".04 .1"/>
  <body name="hand" pos="0 0 .2" euler="0 .3 0"><joint name="wrist" axis="0 0 1" range="-1 1"/>
  <geom type="box" size=".03 .05 .02"/><site name="tool" pos=".02 0 .1" euler="0 .4 .2"/>
  </body></body></body></body></body>
  <body name="loose" pos="1 0 0"><freejoint name="loose"/><geom size=".1"/></body>
</worldbody></mujoco>
"""

URDF = """
<robot name="r"><link name="base"/>
<link name="arm"><collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>
<link name="tip"><collision><geometry><mesh filename="meshes/wedge.obj"/></geometry></collision>
</link><link name="tool"/>
<joint name="a" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2" velocity="2.5" effort="1"/></joint>
<joint name="b" type="revolute"><parent link="arm"/><child link="tip"/><axis xyz="0 1 0"/>
<origin xyz="0 0 .3"/><limit lower="-1" upper="1" velocity="0" effort="1"/></joint>
<joint name="f" type="fixed"><parent link="tip"/><child link="tool"/><origin xyz="0 0 .1"/></joint>
</robot>
"""
WEDGE = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel.load(ARM, "tool")


@pytest.mark.parametrize("frame", ["tool", "hand", "turn"])
def test_frame_jacobian_equals_finite_differences(frame: str) -> None:
    robot = RobotModel.load(ARM, frame)
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = rng.uniform(-1, 1, robot.n)
        state = robot.at(q)
        step = 1e-5
        for column in range(robot.n):
            move = step * np.eye(robot.n)[column]
            ahead, behind = robot.at(q + move), robot.at(q - move)
            linear = (ahead.position - behind.position) / (2 * step)
            turn = Rotation.from_matrix(ahead.rotation @ behind.rotation.T).as_rotvec()
            expected = np.concatenate([linear, turn / (2 * step)])
            np.testing.assert_allclose(state.jacobian[:, column], expected, atol=1e-8)


def test_kernel_equals_numpy_reference(robot: RobotModel) -> None:
    data = mujoco.MjData(robot.model)
    site = robot.model.site("tool").id
    for seed in range(5):
        q = np.random.default_rng(seed).uniform(-1, 1, robot.n)
        state = robot.at(q)
        data.qpos[:] = robot.home_qpos
        data.qpos[robot.joint_table[:, 0]] = q
        mujoco.mj_kinematics(robot.model, data)
        axis = data.xaxis[robot.joints] * robot.moves[robot.frame_body][:, None]
        turning = axis * robot.hinge[:, None]
        arms = data.site_xpos[site] - data.xanchor[robot.joints]
        linear = np.cross(turning, arms) + axis * ~robot.hinge[:, None]
        expected = np.vstack([linear.T, turning.T])
        np.testing.assert_allclose(state.jacobian, expected, atol=1e-14)
        np.testing.assert_allclose(state.position, data.site_xpos[site], atol=1e-14)
        rotation = data.site_xmat[site].reshape(3, 3)
        np.testing.assert_allclose(state.rotation, rotation, atol=1e-14)


def test_jacobian_equals_mujoco(robot: RobotModel) -> None:
    q = np.array([0.1, -0.4, 0.7, 0.2])
    state = robot.at(q)
    data = mujoco.MjData(robot.model)
    data.qpos[:4] = q
    mujoco.mj_forward(robot.model, data)
    linear, turn = np.zeros((3, robot.model.nv)), np.zeros((3, robot.model.nv))
    mujoco.mj_jacSite(robot.model, data, linear, turn, robot.model.site("tool").id)
    np.testing.assert_allclose(state.jacobian, np.vstack([linear, turn])[:, :4], atol=1e-14)
    np.testing.assert_allclose(state.position, data.site("tool").xpos, atol=1e-15)


def test_point_jacobian_equals_jacobian_of_body_point(robot: RobotModel) -> None:
    q = np.array([0.1, -0.4, 0.7, 0.2])
    point = np.array([0.02, -0.03, 0.05])
    row = robot.point_jacobian(q, "lift", point)
    lift = RobotModel.load(ARM, "lift")
    position, expected = lift.at(q).point(point)
    np.testing.assert_allclose(row, expected, atol=1e-14)
    assert np.all(row[:, 3] == 0.0)
    assert position.shape == (3,)


def test_state_is_not_overwritten_by_later_calls(robot: RobotModel) -> None:
    q = np.zeros(robot.n)
    state = robot.at(q)
    copies = state.position.copy(), state.jacobian.copy(), state.rotation.copy()
    q += 0.3
    robot.at(q)
    assert np.all(state.q == 0.0)
    for before, after in zip(copies, (state.position, state.jacobian, state.rotation), strict=True):
        np.testing.assert_array_equal(before, after)


def test_default_limits_home_and_speed(robot: RobotModel) -> None:
    assert robot.joint_names == ("rail", "turn", "lift", "wrist")
    np.testing.assert_array_equal(robot.lower, [-0.2, -2.0, -np.inf, -1.0])
    np.testing.assert_array_equal(robot.upper, [0.4, 1.0, np.inf, 1.0])
    np.testing.assert_allclose(robot.home, [0.1, -0.5, 0.0, 0.0])
    np.testing.assert_array_equal(robot.speed, [0.5, 1.5, 1.5, 1.5])


def test_uncontrolled_joints_stay_at_home() -> None:
    full_robot = RobotModel.load(ARM, "tool")
    partial_robot = RobotModel.load(ARM, "tool", joints=["lift", "turn"])
    q = full_robot.home.copy()
    q[[2, 1]] = 0.5, 0.3
    a, b = full_robot.at(q), partial_robot.at([0.5, 0.3])
    np.testing.assert_allclose(a.position, b.position, atol=1e-15)
    np.testing.assert_allclose(a.jacobian[:, [2, 1]], b.jacobian, atol=1e-15)
    assert partial_robot.joint_names == ("lift", "turn")


def test_home_and_speed_are_read_from_file() -> None:
    text = ARM.replace(
        "</mujoco>",
        '<custom><numeric name="joint_speed" data=".1 1 2 3"/></custom><keyframe>'
        '<key name="home" qpos=".1 .2 .3 .4 1 0 0 1 0 0 0"/></keyframe></mujoco>',
    )
    robot = RobotModel.load(text, "tool", joints=["turn", "wrist"])
    np.testing.assert_allclose(robot.home, [0.2, 0.4])
    np.testing.assert_allclose(robot.speed, [1.0, 3.0])
    given = RobotModel.load(text, "tool", home=[0.0, 0.1, 0.2, 0.3], speed=2.0)
    np.testing.assert_allclose(given.home, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(given.speed, 2.0)


def test_a_number_with_the_name_of_a_joint_is_no_speed_limit() -> None:
    numbers = '<numeric name="turn" data=".1"/><numeric name="joint_speed.wrist" data=".2"/>'
    text = ARM.replace("</mujoco>", f"<custom>{numbers}</custom></mujoco>")
    robot = RobotModel.load(text, "tool", joints=["turn", "wrist"])
    np.testing.assert_allclose(robot.speed, [1.5, 0.2])


def test_urdf_with_meshes_keeps_fixed_links_and_speed_limits(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(WEDGE)
    path = tmp_path / "robot.urdf"
    path.write_text(URDF)
    robot = RobotModel.load(path, "tool")
    np.testing.assert_allclose(robot.speed, [2.5, 1.5])
    np.testing.assert_allclose(robot.at([0.3, 0.0]).position, [0.0, 0.0, 0.4], atol=1e-15)
    assert robot.model.ngeom == 2


def test_load_mjcf_with_relative_meshes_and_mjspec(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(WEDGE)
    text = (
        '<mujoco><compiler meshdir="meshes"/><asset><mesh name="w" file="wedge.obj"/></asset>'
        '<worldbody><body name="arm"><joint name="a" axis="0 0 1"/><geom type="mesh" mesh="w"/>'
        "</body></worldbody></mujoco>"
    )
    path = tmp_path / "robot.xml"
    path.write_text(text)
    assert RobotModel.load(str(path), "arm").n == 1
    assert RobotModel.load(mujoco.MjSpec.from_file(str(path)), "arm").model.nmesh == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frame": "tol"}, "unknown frame 'tol'.*sites tool.*bodies base"),
        ({"joints": ["elbow"]}, "unknown joint 'elbow'.*rail, turn, lift, wrist"),
        ({"joints": ["loose"]}, "free or ball joint.*rail, turn, lift, wrist"),
        ({"joints": []}, "at least one controlled joint"),
        ({"joints": ["turn", "turn"]}, "must differ"),
        ({"joints": "turn"}, "list of names"),
        ({"home": [0.0]}, r"home must have shape \(4,\)"),
        ({"home": [0.0, 2.0, 0.0, 0.0]}, r"home of joint turn must be in \[-2, 1\]"),
        ({"home": [0.0, float("nan"), 0.0, 0.0]}, "home must be finite"),
        ({"speed": 0.0}, "must be > 0"),
        ({"speed": [1.0, 2.0]}, r"speed must have shape \(4,\)"),
    ],
)
def test_invalid_options_raise_with_valid_values(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        RobotModel.load(ARM, **{"frame": "tool", **options})


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("/nowhere/arm.xml", "no such file"),
        ("<mujoco><wordbody/></mujoco>", "cannot read the XML text"),
        ("<mujoco", "cannot read the XML text"),
        ("<mujoco/>", "at least one controlled joint"),
    ],
)
def test_unreadable_files_raise_in_one_line(source: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        RobotModel.load(source, "tool")
    assert "\n" not in str(caught.value)


def test_urdf_with_declared_encoding_is_read(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    head = '<?xml version="1.0" encoding="iso-8859-1"?><!-- Straße -->'
    text = head + URDF.replace('<mesh filename="meshes/wedge.obj"/>', '<sphere radius=".1"/>')
    path.write_bytes(text.encode("iso-8859-1"))
    np.testing.assert_array_equal(RobotModel.load(path, "tool").speed, [2.5, 1.5])


@pytest.mark.parametrize("name", ["arm.mjcf", "arm.URDF"])
def test_unknown_file_suffix_raises(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(ARM)
    with pytest.raises(InputError, match=r"must end in \.xml or \.urdf"):
        RobotModel.load(tmp_path / name, "tool")


@pytest.mark.parametrize("q", [[0.0], [0.0, 0.0, 0.0, float("nan")], "abcd", np.zeros((1, 4))])
def test_invalid_joint_positions_are_rejected(robot: RobotModel, q: ArrayLike) -> None:
    with pytest.raises(InputError, match="q must"):
        robot.at(q)


def test_point_jacobian_rejects_unknown_body_and_invalid_point(robot: RobotModel) -> None:
    with pytest.raises(InputError, match="bodies base, rail, turn"):
        robot.point_jacobian(robot.home, "elbow", np.zeros(3))
    with pytest.raises(InputError, match=r"point must have shape \(3,\)"):
        robot.point_jacobian(robot.home, "lift", np.zeros(2))


PACKAGED = """<robot name="r"><link name="base"/><link name="tip"><collision><geometry>
<mesh filename="package://some_arm/meshes/part.obj"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="1"/></joint></robot>"""
CORNERS = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize("given", ["package_dirs", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_package_paths_are_resolved(tmp_path, monkeypatch, given):
    folder = tmp_path / ("share" if given == "AMENT_PREFIX_PATH" else "") / "some_arm"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "part.obj").write_text(CORNERS)
    source = tmp_path / "arm.urdf"
    source.write_text(PACKAGED)
    if given != "package_dirs":
        monkeypatch.setenv(given, str(tmp_path))
    dirs = [tmp_path] if given == "package_dirs" else []
    robot = RobotModel.load(source, "tip", package_dirs=dirs)
    assert robot.model.nmesh == 1
    np.testing.assert_array_equal(robot.speed, [2.0])


def test_missing_package_is_named(monkeypatch):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    with pytest.raises(InputError, match=r"package 'some_arm'.*must be in a folder.*none"):
        RobotModel.load(PACKAGED, "tip")


def test_complex_numbers_are_refused():
    robot = RobotModel.load(LBR_ARM, TOOL_SITE)
    with pytest.raises(InputError, match="real numbers"):
        robot.checked(np.zeros(7, dtype=complex))
    with pytest.raises(InputError, match="q must be 7 numbers"):
        robot.checked([1j] * 7)


GRIPPER = """<mujoco><worldbody><body name="arm"><joint name="a" axis="0 0 1"/><geom size=".1"/>
<body name="left"><joint name="l" type="slide"/><geom size=".1"/></body>
<body name="right"><joint name="r" type="slide"/><geom size=".1"/></body></body></worldbody>
{coupling}</mujoco>"""


@pytest.mark.parametrize(
    ("coupling", "joints"),
    [
        ("", ("a", "l", "r")),
        ('<equality><joint joint1="l" joint2="r"/></equality>', ("a",)),
        (
            '<tendon><fixed><joint joint="l" coef=".5"/><joint joint="r" coef=".5"/></fixed>'
            "</tendon>",
            ("a",),
        ),
    ],
)
def test_joints_of_grippers_are_not_controlled(coupling, joints):
    source = GRIPPER.format(coupling=coupling)
    assert RobotModel.load(source, "arm").joint_names == joints
    assert RobotModel.load(source, "arm", joints=["l"]).joint_names == ("l",)


def test_acceleration_limits_come_from_argument_file_or_default():
    own = RobotModel.load(LBR_ARM, TOOL_SITE)
    np.testing.assert_array_equal(own.acceleration, np.full(7, 15.0))
    np.testing.assert_array_equal(own.jerk, np.full(7, 7500.0))
    panda = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])
    given = RobotModel.load(LBR_ARM, TOOL_SITE, acceleration=panda, jerk=500.0 * panda)
    np.testing.assert_array_equal(given.limits()[:, 3:], np.column_stack([panda, 500.0 * panda]))
    default = RobotModel.load(GRIPPER.format(coupling=""), "arm")
    np.testing.assert_array_equal(default.acceleration, [7.5, 2.5, 2.5])
    np.testing.assert_array_equal(default.jerk, 500.0 * default.acceleration)
    with pytest.raises(InputError, match="acceleration limits must be > 0"):
        RobotModel.load(LBR_ARM, TOOL_SITE, acceleration=0.0)
