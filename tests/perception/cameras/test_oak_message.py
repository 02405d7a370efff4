"""Tests of converting OAK messages to frames and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak_message import (
    depth_frame,
    intrinsics_from_transformation,
    metres_from_raw16,
)
from eyehand.perception.frame import CameraIntrinsics, DepthFrame

from .oak_frames import image_messages

if TYPE_CHECKING:
    from collections.abc import Callable

    Frames = Callable[..., list[DepthFrame]]

load_depthai()
import depthai as dai  # noqa: E402 - depthai prints to stdout unless load_depthai came first

RAW16 = dai.ImgFrame.Type.RAW16


def transformation(k: CameraIntrinsics) -> dai.ImgTransformation:
    return dai.ImgTransformation(k.width, k.height, k.matrix.tolist())


def test_every_raw16_value_round_trips_through_float32() -> None:
    raw = np.arange(65536, dtype=np.uint16).reshape(256, 256)

    metres = metres_from_raw16(raw)

    assert metres.dtype == np.float32
    assert np.array_equal(metres, (np.arange(65536) / 1000).astype(np.float32).reshape(256, 256))
    assert np.array_equal(np.rint(1000.0 * metres.astype(np.float64)), raw)


def test_frame_round_trips_through_message(frames: Frames, pose: RigidTransform) -> None:
    (frame,) = frames(1, colour=True)

    depth, colour = image_messages(frame, 1.5)
    back = depth_frame(depth, colour, pose)

    assert depth.getType() == RAW16
    assert depth.getTimestamp().total_seconds() == 1.5
    assert back is not None
    assert np.array_equal(back.depth, frame.depth)
    assert back.colour is not None
    assert frame.colour is not None
    assert np.array_equal(back.colour, frame.colour)
    assert back.T_world_camera is pose


def test_row_padding_is_removed(camera: CameraIntrinsics) -> None:
    pixels = np.arange(1, 48 * 64 + 1, dtype=np.uint16).reshape(48, 64)
    padded = np.full((48, 80), 9999, np.uint16)
    padded[:, :64] = pixels
    message = dai.ImgFrame()
    message.setType(RAW16)
    message.setSize(64, 48)
    message.setStride(160)
    message.setTransformation(transformation(camera))
    message.setData(padded.tobytes())

    back = depth_frame(message)

    assert back is not None
    assert np.array_equal(back.depth, metres_from_raw16(pixels))


@pytest.mark.parametrize("kind", ["BGR888p", "BGR888i", "RGB888p", "RGB888i"])
def test_colour_layouts_are_converted_to_rgb(frames: Frames, kind: str) -> None:
    (frame,) = frames(1, colour=True)
    assert frame.colour is not None
    depth, _ = image_messages(frame, 0.0)
    colour = dai.ImgFrame()
    colour.setCvFrame(
        np.ascontiguousarray(frame.colour[..., ::-1]), getattr(dai.ImgFrame.Type, kind)
    )

    back = depth_frame(depth, colour)

    assert back is not None
    assert back.colour is not None
    assert np.array_equal(back.colour, frame.colour)


def test_image_without_reading_gives_no_frame(frames: Frames) -> None:
    depth, _ = image_messages(frames(1)[0], 0.0)
    depth.setData(bytes(2 * 48 * 64))

    assert depth_frame(depth) is None


def test_scaled_and_cropped_image_has_matching_intrinsics(camera: CameraIntrinsics) -> None:
    scaled = transformation(camera)
    scaled.addScale(0.5, 0.5)
    scaled.setSize(32, 24)
    scaled.addCrop(4, 2, 20, 16)

    k = intrinsics_from_transformation(scaled)

    assert (k.width, k.height) == (20, 16)
    expected = (camera.fx / 2, camera.fy / 2, camera.cx / 2 - 4, camera.cy / 2 - 2)
    np.testing.assert_allclose((k.fx, k.fy, k.cx, k.cy), expected, rtol=1e-6)


def test_distorted_image_is_rejected(camera: CameraIntrinsics) -> None:
    distorted = transformation(camera)
    distorted.setDistortionCoefficients([0.0, -0.11, 0.02, 0.0])
    with pytest.raises(InputError, match=r"lens distortion \(largest coefficient 0\.11\)"):
        intrinsics_from_transformation(distorted)

    distorted.setDistortionCoefficients([0.0] * 14)
    assert intrinsics_from_transformation(distorted).width == camera.width


def test_rotated_or_mirrored_image_is_rejected(camera: CameraIntrinsics) -> None:
    rotated = transformation(camera)
    rotated.addRotation(1.0, dai.Point2f(32, 24))
    with pytest.raises(InputError, match="rotated or skewed"):
        intrinsics_from_transformation(rotated)

    mirrored = transformation(camera)
    mirrored.addFlipHorizontal()
    with pytest.raises(InputError, match="focal lengths must be"):
        intrinsics_from_transformation(mirrored)


def test_image_without_intrinsics_is_rejected() -> None:
    with pytest.raises(InputError, match="no camera intrinsics"):
        intrinsics_from_transformation(dai.ImgTransformation())
    with pytest.raises(InputError, match="no camera intrinsics"):
        intrinsics_from_transformation(dai.ImgTransformation(64, 48))


def test_incomplete_image_is_rejected(camera: CameraIntrinsics) -> None:
    message = dai.ImgFrame()
    message.setType(RAW16)
    message.setSize(64, 48)
    message.setTransformation(transformation(camera))
    message.setData(bytes(100))

    with pytest.raises(InputError, match="cannot be read") as caught:
        depth_frame(message)
    assert "\n" not in str(caught.value)


def test_colour_image_is_no_depth(frames: Frames) -> None:
    _, colour = image_messages(frames(1, colour=True)[0], 0.0)
    assert colour is not None

    with pytest.raises(InputError, match="holds RGB888i images, expected RAW16"):
        depth_frame(colour)


def test_colour_of_other_size_is_rejected(frames: Frames) -> None:
    depth, _ = image_messages(frames(1)[0], 0.0)
    colour = dai.ImgFrame()
    colour.setCvFrame(np.zeros((10, 12, 3), np.uint8), dai.ImgFrame.Type.BGR888i)

    with pytest.raises(InputError, match=r"colour must be \(48, 64, 3\)"):
        depth_frame(depth, colour)
