"""Tests of the geoms of a robot as posed points."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.control import LinkVolumes
from eyehand.control.mujoco_binding import mujoco
from eyehand.errors import InputError

ROBOT = """
<mujoco>
  <worldbody>
    <geom name="table" type="box" size="1 1 .1"/>
    <body name="post"><geom type="box" size=".1 .1 .1"/></body>
    <body name="base">
      <geom type="box" size=".1 .2 .3" contype="0" conaffinity="0"/>
      <body name="arm" pos="0 0 .3">
        <joint name="a" axis="0 0 1" range="-1 2"/>
        <geom type="cylinder" size=".1 .2"/>
        <body name="hand" pos=".5 0 0">
          <joint name="b" type="slide" axis="1 0 0" range="0 .2"/>
          <geom type="sphere" size=".1"/>
          <geom type="capsule" size=".1 .2"/>
          <geom type="ellipsoid" size=".1 .2 .3"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def support(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the extents of the hull of points along directions."""
    return (points @ directions.T).max(axis=0)


def test_geoms_of_the_robot_count_and_their_hulls_contain_them():
    links = LinkVolumes(ROBOT)
    assert links.joint_names == ("a", "b")
    box, cylinder, sphere, capsule, ellipsoid = links.points
    along = np.random.default_rng(0).normal(size=(2000, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    radial, axial = np.hypot(along[:, 0], along[:, 1]), np.abs(along[:, 2])
    exact = {
        "box": (box, np.abs(along) @ [0.1, 0.2, 0.3], 1.0),
        "cylinder": (cylinder, 0.1 * radial + 0.2 * axial, 1.02),
        "sphere": (sphere, np.full(len(along), 0.1), 1.02),
        "capsule": (capsule, 0.1 + 0.2 * axial, 1.02),
        "ellipsoid": (ellipsoid, np.linalg.norm(along * [0.1, 0.2, 0.3], axis=1), 1.02),
    }
    for name, (points, size, growth) in exact.items():
        found = support(points, along)
        assert (found >= size - 1e-9).all(), name
        assert (found <= growth * size + 1e-9).all(), name


def test_poses_follow_the_joints_and_other_joints_stay_at_home():
    links = LinkVolumes(ROBOT)
    poses = links.poses([np.pi / 2])
    np.testing.assert_allclose(poses[0], np.eye(4), atol=1e-12)
    # Home is the middle of the limits: 0.1 m for the slide joint.
    np.testing.assert_allclose(poses[2][:3, 3], [0.0, 0.6, 0.3], atol=1e-9)
    np.testing.assert_allclose(links.poses([0.0, 0.0])[2][:3, 3], [0.5, 0.0, 0.3], atol=1e-9)


def test_poses_equal_those_of_mujoco():
    links = LinkVolumes(ROBOT)
    model = mujoco.MjModel.from_xml_string(ROBOT)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3, 0.1
    mujoco.mj_kinematics(model, data)
    poses = links.poses([0.3, 0.1])
    np.testing.assert_allclose(poses[:, :3, 3], data.geom_xpos[2:], atol=1e-12)
    np.testing.assert_allclose(poses[:, :3, :3].reshape(-1, 9), data.geom_xmat[2:], atol=1e-12)


@pytest.mark.parametrize(
    ("q", "message"),
    [([], "1 to 2 numbers for a, b, got 0"), ([0.0] * 3, "got 3"), ([np.nan], "finite")],
)
def test_invalid_posture_is_rejected(q, message):
    with pytest.raises(InputError, match=message):
        LinkVolumes(ROBOT).poses(q)


def test_robot_without_body_or_joint_is_rejected():
    with pytest.raises(InputError, match="holds no body"):
        LinkVolumes("<mujoco/>")
    with pytest.raises(InputError, match="at least one controlled joint"):
        LinkVolumes("<mujoco><worldbody><body name='a'/></worldbody></mujoco>")
