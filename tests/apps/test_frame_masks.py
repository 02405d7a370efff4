"""Masks of `perceive`: an image, a region, and the robot at its posture."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.frame_masks import FrameMasks, _load_robot
from eyehand.apps.main import main
from eyehand.control.mujoco_binding import mujoco
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, read_frame, segment, write_frame

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"
ROBOTS = Path(os.environ.get("EYEHAND_DATA", "../shared/data")).resolve().parent / "robots"
PANDA = ROBOTS / "franka_emika_panda" / "panda.xml"
Q = [0.0, 0.3, 0.0, -2.0, 0.0, 2.4, 0.8]
FINGERS = 0.04
"""Home of the fingers, m."""
BASE = RigidTransform.from_translation([0.1, 0.2, 0.0])
CAMERA = CameraIntrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)
OBJECTS = ((0.55, -0.1), (0.8, -0.05), (0.6, 0.5), (0.85, 0.4), (0.9, 0.18))


def camera_pose() -> RigidTransform:
    """Return the pose of a camera that sees the table and the arm behind it."""
    eye, target = np.array([1.4, 0.2, 0.9]), np.array([0.65, 0.2, 0.05])
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    axes = np.column_stack([x, np.cross(z, x), z])
    return RigidTransform.from_components(eye, Rotation.from_matrix(axes))


def robot_scene(path: Path) -> np.ndarray:
    """Write a frame of a table with five objects and a Panda; return its labels (H, W).

    1 is the table, 2 to 6 are the objects, -1 is the robot.
    """
    spec = mujoco.MjSpec()
    frame = spec.worldbody.add_frame(pos=BASE.translation)
    panda = mujoco.MjSpec.from_file(str(PANDA))
    panda.option.integrator = spec.option.integrator
    spec.attach(panda, frame=frame)
    box = mujoco.mjtGeom.mjGEOM_BOX
    spec.worldbody.add_geom(name="1", type=box, size=[0.5, 0.5, 0.02], pos=[0.7, 0.2, -0.02])
    for number, (x, y) in enumerate(OBJECTS, start=2):
        spec.worldbody.add_geom(
            name=str(number), type=box, size=[0.03, 0.025, 0.04], pos=[x, y, 0.04]
        )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = [*Q, FINGERS, FINGERS]
    mujoco.mj_forward(model, data)
    pose = camera_pose()
    rays = CAMERA.rays().reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    along = pose.rotation.apply(rays / lengths[:, None])
    hit, distance = np.zeros(len(rays), np.int32), np.zeros(len(rays))
    shown = np.array([1, 1, 1, 0, 1, 1], np.uint8)
    mujoco.mj_multiRay(
        model,
        data,
        pose.translation.reshape(3, 1),
        along.reshape(-1, 1),
        shown,
        1,
        -1,
        hit,
        distance,
        None,
        len(rays),
        10.0,
    )
    depth = np.where(hit >= 0, distance / lengths, 0.0).reshape(240, 320)
    rng = np.random.default_rng(0)
    depth += 0.0012 * depth**2 * rng.standard_normal(depth.shape)
    write_frame(path, DepthFrame(depth.astype(np.float32), CAMERA, pose))
    names = [model.geom(geom).name for geom in range(model.ngeom)]
    numbers = [int(name) if name.isdigit() else -1 for name in names]
    return np.array([*numbers, 0])[hit].reshape(240, 320)


@pytest.mark.skipif(not PANDA.is_file(), reason=f"no robot at {PANDA}")
def test_robot_is_in_no_object_and_the_objects_stay(tmp_path: Path):
    truth = robot_scene(tmp_path / "a.npz")
    assert (truth == -1).sum() > 3000
    frame = read_frame(tmp_path / "a.npz")
    assert (segment(frame).labels[truth == -1] > 0).any()
    masks = FrameMasks(robot=PANDA, q=Q, robot_pose=[*BASE.translation, 1.0, 0.0, 0.0, 0.0])
    rng = np.random.default_rng(1)
    for trial in range(5):
        # The second to last poses are wrong by 1 cm and 1°.
        turn, shift = (axis / np.linalg.norm(axis) for axis in rng.standard_normal((2, 3)))
        error = RigidTransform.from_components(
            0.01 * shift, Rotation.from_rotvec(np.radians(1.0) * turn)
        )
        pose = camera_pose() * error if trial else camera_pose()
        moved = DepthFrame(frame.depth, CAMERA, pose)
        labels = segment(masks.applied(moved)).labels
        assert not (labels[truth == -1] > 0).any()
        for number in range(2, 7):
            label = np.bincount(labels[truth == number]).argmax()
            both = (labels == label) & (truth == number)
            assert label > 0
            assert both.sum() > 0.88 * ((labels == label) | (truth == number)).sum()
        assert labels.max() == len(OBJECTS)


@pytest.mark.skipif(not PANDA.is_file(), reason=f"no robot at {PANDA}")
def test_perceive_masks_the_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    truth = robot_scene(tmp_path / "a.npz")
    _load_robot.cache_clear()
    numbers = " ".join(map(str, [-0.0, *Q[1:]]))
    base = " ".join(map(str, [*BASE.translation, 1.0, 0.0, 0.0, 0.0]))
    with pytest.raises(SystemExit) as exit_info:
        main(
            [
                *("perceive", str(tmp_path / "a.npz"), "--out", str(tmp_path)),
                *("--robot", str(PANDA), "--q", numbers, "--robot-pose", *base.split()),
            ]
        )
    assert exit_info.value.code == 0
    said = capsys.readouterr().err
    assert "finger_joint1, finger_joint2 stay at the home posture" in said
    assert "% of the readings" in said
    labels = cv2.imread(str(tmp_path / "labels.png"), cv2.IMREAD_UNCHANGED)
    assert labels is not None
    assert labels.max() == len(OBJECTS)
    assert not labels[truth == -1].any()


def test_mask_image_removes_its_pixels_and_their_margin(tmp_path: Path):
    frame = read_frame(SAMPLE)
    image = np.zeros(frame.depth.shape, np.uint8)
    image[200:300, 100:200] = 1
    cv2.imwrite(str(tmp_path / "m.png"), image)
    kept = FrameMasks(mask=tmp_path / "m.png").applied(frame).depth
    assert not kept[197:303, 97:203].any()
    outside = np.ones(kept.shape, bool)
    outside[197:303, 97:203] = False
    np.testing.assert_array_equal(kept[outside], frame.depth[outside])


def test_only_a_rectangle_or_a_box_is_segmented():
    frame = read_frame(SAMPLE)
    kept = FrameMasks(region=[100.0, 50.0, 400.0, 300.0]).applied(frame).depth
    np.testing.assert_array_equal(kept[50:300, 100:400], frame.depth[50:300, 100:400])
    assert np.count_nonzero(kept) == np.count_nonzero(frame.depth[50:300, 100:400])
    pose = frame.T_world_camera
    assert pose is not None
    low, high = np.array([-0.2, -0.1, -0.05]), np.array([0.3, 0.2, 0.5])
    kept = FrameMasks(region=[*low, *high]).applied(frame)
    points = pose.apply(frame.points()[frame.valid].astype(float))
    expected = ((points >= low) & (points <= high)).all(axis=1)
    assert 0 < expected.sum() < expected.size
    np.testing.assert_array_equal(kept.depth[frame.valid] > 0, expected)


def test_given_camera_pose_replaces_that_of_the_file():
    numbers = [0.1, 0.2, 0.9, 0.0, 1.0, 0.0, 0.0]
    frame = FrameMasks(camera_pose=numbers).applied(read_frame(SAMPLE))
    assert frame.T_world_camera is not None
    np.testing.assert_allclose(frame.T_world_camera.translation, numbers[:3])
    np.testing.assert_allclose(frame.T_world_camera.apply([0.0, 0.0, 0.9]), [0.1, 0.2, 0.0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"robot": "x.xml"}, "--robot needs --q"),
        ({"q": [0.0]}, "--q needs --robot"),
        ({"robot": "x.xml", "q": [0.0, -90.0]}, "--q must be in rad"),
        ({"robot_pose": [0.0] * 7}, "--robot-pose needs --robot"),
        ({"region": [1.0, 2.0, 3.0]}, "--region needs 4 numbers u0 v0 u1 v1"),
        ({"region": [1.0, 2.0, 1.0, 9.0]}, "lower corner before the upper one"),
        ({"region": [0.0, 0.0, 2.0, 2.0]}, "the masks leave no reading"),
        ({"region": [0.0, 0.0, 10.0, 5000.0]}, "must lie in the image of"),
        ({"camera_pose": [0.0] * 6}, "x y z qw qx qy qz, got 6"),
        ({"camera_pose": [0.0] * 7}, "--camera-pose.quat_wxyz has length 0, expected 1: got"),
        ({"camera_pose": [0.0] * 6 + [np.nan]}, "x y z qw qx qy qz, got 7: .*nan"),
        ({"mask": SAMPLE.with_name("absent.png")}, "no such file"),
        ({"robot": "absent.xml", "q": [0.0]}, "no such file: absent.xml"),
    ],
)
def test_invalid_masks_are_rejected(options: dict[str, Any], message: str):
    paths: dict[str, Any] = {
        name: Path(value) for name, value in options.items() if isinstance(value, str)
    }
    with pytest.raises(InputError, match=message):
        FrameMasks(**options | paths).applied(read_frame(SAMPLE))


def test_mask_of_other_size_and_robot_without_a_pose_are_rejected(tmp_path: Path):
    frame = read_frame(SAMPLE)
    cv2.imwrite(str(tmp_path / "m.png"), np.ones((3, 4), np.uint8))
    with pytest.raises(InputError, match=r"m\.png: the mask is 4x3 px, expected 640x480 px"):
        FrameMasks(mask=tmp_path / "m.png").applied(frame)
    out = tmp_path / "out"
    with pytest.raises(SystemExit):
        main(["perceive", str(SAMPLE), "--mask", str(tmp_path / "m.png"), "--out", str(out)])
    assert not out.exists()
    with pytest.raises(InputError, match="--robot needs the camera's pose"):
        FrameMasks(robot=PANDA, q=Q).applied(DepthFrame(frame.depth, frame.intrinsics))


@pytest.mark.parametrize("numbers", [["-1,-2,3"], ["-1 -2 3"], ["-1", "-2", "3"]])
def test_numbers_are_read_quoted_or_not(numbers: list[str], capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as exit_info:
        main(["perceive", str(SAMPLE), "--region", *numbers, "--json"])
    assert exit_info.value.code == 2
    assert "got [-1.0, -2.0, 3.0]" in capsys.readouterr().err
