"""Height of a support that is learned from images with unknown scales."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping import CORRECTED_SCALE_ERROR, SupportMemory
from eyehand.perception import CameraIntrinsics, DepthFrame

HEIGHT = 0.6
SCALES = (1.06, 0.97, 1.02, 0.94)


def table(scale: float) -> DepthFrame:
    """Return an image of an empty table 0.6 m below a camera that looks straight down."""
    camera = CameraIntrinsics(270.0, 270.0, 159.5, 119.5, 320, 240)
    pose = RigidTransform.from_components([0, 0, HEIGHT], Rotation.from_rotvec([np.pi, 0, 0]))
    return DepthFrame(np.full((240, 320), scale * HEIGHT, np.float32), camera, pose)


def test_images_are_scaled_to_the_mean_height_of_the_support():
    memory = SupportMemory(0.03)
    found = [memory.corrected(table(scale)) for scale in SCALES]
    depths = [float(np.median(frame.depth)) for frame, _ in found]
    # The first image stays as it is. The last one has the mean of all scales.
    assert depths[0] == pytest.approx(SCALES[0] * HEIGHT, abs=2e-3)
    assert depths[-1] == pytest.approx(np.mean(SCALES) * HEIGHT, abs=3e-3)
    errors = [error for _, error in found]
    assert errors[0] == pytest.approx(np.hypot(0.03, CORRECTED_SCALE_ERROR))
    assert errors == sorted(errors, reverse=True)
    assert [frame.scale_error for frame, _ in found] == errors
    assert errors[-1] == pytest.approx(np.hypot(0.015, CORRECTED_SCALE_ERROR), abs=1e-3)


def test_image_without_support_is_left_as_it_is():
    memory = SupportMemory(0.03)
    memory.corrected(table(1.0))
    depth = np.zeros((240, 320), np.float32)
    depth[100:110, 100:110] = HEIGHT
    patch = replace(table(1.0), depth=depth)
    frame, error = memory.corrected(patch)
    assert frame is patch
    assert error == 0.03


def test_pose_of_the_camera_is_needed():
    with pytest.raises(InputError, match="needs T_world_camera"):
        SupportMemory(0.03).corrected(replace(table(1.0), T_world_camera=None))
