"""Tests of the warnings about the frame itself."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import CameraIntrinsics, DepthFrame, frame_faults, segment

CAMERA = CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
SHAPE = (480, 640)


def kinds(depth, camera=CAMERA):
    """Return the kinds of the warnings about the frame of a depth image."""
    warnings = segment(DepthFrame(depth.astype(np.float32), camera)).warnings
    return [w.kind for w in warnings if w.kind in ("camera", "noise", "constant")]


def noisy(rng, sigma):
    """Return a flat wall at 1 m with noise."""
    return 1.0 + sigma * rng.standard_normal(SHAPE)


@pytest.mark.parametrize(
    "draw",
    [
        lambda rng: rng.uniform(0.5, 2.0, SHAPE),
        lambda rng: rng.integers(0, 65536, SHAPE) / 1000,
        lambda rng: rng.uniform(0.5, 2.0, SHAPE) * (rng.random(SHAPE) > 0.4),
        lambda rng: noisy(rng, 0.05),
    ],
    ids=["uniform", "16 bit", "40 % holes", "normal"],
)
def test_image_of_noise_is_warned_about(draw):
    assert kinds(draw(np.random.default_rng(0))) == ["noise"]


def test_noisy_wall_is_no_image_of_noise():
    assert kinds(noisy(np.random.default_rng(0), 0.01)) == []


@pytest.mark.parametrize(("share", "expected"), [(0.0, ["constant"]), (0.001, [])])
def test_constant_image_is_warned_about(share, expected):
    depth = np.where(np.random.default_rng(0).random(SHAPE) < share, 1.001, 1.0)
    depth[:100] = 0.0
    assert kinds(depth) == expected


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"cx": -3.0}, "principal point (-3, 239.5) px is not inside the image of 640 x 480 px"),
        ({"cy": 480.0}, "principal point"),
        ({"cx": 0.0, "cy": 0.0}, "principal point (0, 0) px is not inside"),
        ({"fx": 20.0, "fy": 20.0}, "field of view is 172.8°"),
        ({"fx": 9000.0, "fy": 9000.0}, "field of view is 4.1°"),
        (
            {"fx": 262.5, "fy": 262.5, "cx": 159.5, "cy": 119.5},
            "(159.5, 119.5) px belong to an image 0.5 times as large, not to 640 x 480 px",
        ),
        (
            {"fx": 1050.0, "fy": 1050.0, "cx": 639.5, "cy": 479.5},
            "belong to an image 2 times as large",
        ),
        (
            {"cx": 239.5, "cy": 319.5},
            "(239.5, 319.5) px is the middle of the image of 640 x 480 px if",
        ),
        ({"fx": 1050.0}, "fx = 1050 px and fy = 525 px differ too much"),
    ],
)
def test_implausible_camera_is_warned_about(changed, message):
    intrinsics = {"fx": 525.0, "fy": 525.0, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}
    depth = noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    warning = segment(DepthFrame(depth, CameraIntrinsics(**intrinsics | changed))).warnings[0]
    assert warning.kind == "camera"
    assert message in warning.message


@pytest.mark.parametrize(("cx", "expected"), [(460.0, False), (110.0, True), (600.0, True)])
def test_principal_point_far_from_the_middle_is_warned_about(cx, expected):
    camera = CameraIntrinsics(600.0, 600.0, cx, 239.5, 640, 480)
    depth = noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    found = [w.kind for w in frame_faults(DepthFrame(depth, camera))]
    assert found == ["principal_point"] * expected


@pytest.mark.parametrize(("factor", "expected"), [(1.0, False), (2.0, False), (5.0, True)])
def test_depth_in_another_unit_is_warned_about(factor, expected):
    depth = factor * noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    found = [w.message for w in segment(DepthFrame(depth, CAMERA)).warnings if w.kind == "far"]
    assert bool(found) == expected
    assert all("median at 5.0 m" in message and "depth_scale_mm" in message for message in found)


@pytest.mark.parametrize(("factor", "expected"), [(0.09, True), (0.15, False)])
def test_depth_that_is_too_near_is_warned_about(factor, expected):
    depth = factor * noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    found = [w.message for w in segment(DepthFrame(depth, CAMERA)).warnings if w.kind == "near"]
    assert bool(found) == expected
    assert all("median at 0.09 m" in message and "depth_scale_mm" in message for message in found)


def test_inverted_pose_is_warned_about():
    turn = Rotation.from_euler("x", 220, degrees=True)  # looks at the table obliquely from above
    pose = RigidTransform.from_components([0.0, -1.0, 1.2], turn)
    height = pose.rotation.apply(CAMERA.rays().reshape(-1, 3))[:, 2].reshape(SHAPE)
    depth = 1.2 / np.maximum(-height, 0.1) + 0.001 * np.random.default_rng(0).random(SHAPE)
    for T_world_camera, expected in ((pose, []), (pose.inv(), ["pose", "no_support"])):
        frame = DepthFrame(depth.astype(np.float32), CAMERA, T_world_camera)
        warnings = segment(frame).warnings
        assert [w.kind for w in warnings if w.kind in ("pose", "no_support")] == expected


@pytest.mark.parametrize(("degrees", "expected"), [(0.0, False), (2.0, False), (12.0, True)])
def test_support_that_tilts_in_the_world_is_warned_about(degrees, expected):
    down = Rotation.from_euler("x", 180 + degrees, degrees=True)
    depth = noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    pose = RigidTransform.from_components([0.4, 0.0, 1.0], down)
    warnings = segment(DepthFrame(depth, CAMERA, pose)).warnings
    found = [one for one in warnings if one.kind == "support_tilted"]
    assert bool(found) == expected
    assert all("tilted by 12.0° in the world" in one.message for one in found)


@pytest.mark.parametrize(("distance", "expected"), [(19.0, False), (549.0, True)])
def test_camera_far_from_the_origin_is_warned_about(distance, expected):
    down = Rotation.from_euler("x", 180, degrees=True)
    depth = noisy(np.random.default_rng(0), 0.001).astype(np.float32)
    pose = RigidTransform.from_components([0.0, 0.0, distance], down)
    found = [w for w in frame_faults(DepthFrame(depth, CAMERA, pose)) if w.kind == "pose"]
    assert bool(found) == expected
