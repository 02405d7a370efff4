"""Streams of depthai image messages, and their conversion to depth frames."""

from __future__ import annotations

import time
from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, DepthFrame
from .depthai_import import load_depthai, queue_closed_error

if TYPE_CHECKING:
    import depthai as dai
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

UNITS_PER_METRE = 1000.0
"""A RAW16 depth pixel counts millimetres."""

SKEW_TOLERANCE = 1e-4
"""Off-diagonal terms of the camera matrix, relative to the focal length, that are still float32
noise: at the edge of a 90 degree view they move a pixel by 1e-4 of half the image's width."""

DEPTH, COLOUR = "depth", "colour"
"""Names of the two messages in a pair."""

QUEUE_SIZE = 2
"""Pairs in the queue: the one being read and the next one."""

POLL_S = 0.1
"""Duration of one wait inside depthai, s. Ctrl-C takes effect only between waits."""


def depth_frame(
    depth: dai.ImgFrame,
    colour: dai.ImgFrame | None = None,
    T_world_camera: RigidTransform | None = None,
) -> DepthFrame | None:
    """Convert a RAW16 image message, and the colour image registered to it, to a depth frame.

    Parameters
    ----------
    depth : depthai.ImgFrame
        RAW16 image in mm, 0 = no reading, whose transformation carries the camera.
    colour : depthai.ImgFrame, optional
        Colour image of any type that depthai converts, of the same size.
    T_world_camera : RigidTransform, optional
        Pose of the camera, copied into the frame.

    Returns
    -------
    DepthFrame or None
        Depth in m: the float32 nearest to the whole millimetres. None if no pixel holds a
        reading, which a covered lens brings about.

    Raises
    ------
    InputError
        If the image is not RAW16, lacks pixels or intrinsics, or is distorted, rotated or
        flipped; if colour has another size.
    """
    load_depthai()
    import depthai as dai

    kind = depth.getType()
    if kind != dai.ImgFrame.Type.RAW16:
        raise InputError(f"the stream holds {kind.name} images, expected RAW16 depth images in mm")
    try:
        raw = depth.getFrame()
        bgr = None if colour is None else colour.getCvFrame()
    except RuntimeError as error:
        fault = " ".join(str(error).split())
        raise InputError(f"an image message cannot be read ({fault})") from error
    intrinsics = intrinsics_from_transformation(depth.transformation)
    if not raw.any():
        return None
    return DepthFrame(
        depth=metres_from_raw16(raw),
        intrinsics=intrinsics,
        T_world_camera=T_world_camera,
        colour=None if bgr is None else np.ascontiguousarray(bgr[..., ::-1]),
    )


def metres_from_raw16(raw: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Convert whole mm to m. Each result is the float32 nearest to the exact value."""
    # Divide, because a product with 0.001 is not always the float32 nearest to the true value.
    return raw.astype(np.float32) / np.float32(UNITS_PER_METRE)


def intrinsics_from_transformation(transformation: dai.ImgTransformation) -> CameraIntrinsics:
    """Read the pinhole camera that an image message carries, after all its crops and scalings.

    Raises
    ------
    InputError
        If there is none, or the image is distorted, rotated or flipped.
    """
    width, height = transformation.getSize()
    K = np.asarray(transformation.getIntrinsicMatrix(), dtype=np.float64)
    if not transformation.isValid() or np.array_equal(K, np.eye(3)):
        raise InputError("an image message carries no camera intrinsics")
    distortion = np.abs(transformation.getDistortionCoefficients())
    if distortion.size and distortion.max() > 0:
        raise InputError(
            f"the depth image has lens distortion (largest coefficient {distortion.max():.3g}): "
            "take it from an undistorted output"
        )
    skew = max(abs(K[0, 1]), abs(K[1, 0]))
    if not np.allclose(K[2], [0.0, 0.0, 1.0]) or skew > SKEW_TOLERANCE * abs(K[0, 0]):
        raise InputError(f"the depth image is rotated or skewed: camera matrix {K.tolist()}")
    fx, fy, cx, cy = (float(x) for x in (K[0, 0], K[1, 1], K[0, 2], K[1, 2]))
    return CameraIntrinsics(fx, fy, cx, cy, width, height)


def paired(
    pipeline: dai.Pipeline,
    depth: dai.Node.Output,
    colour: dai.Node.Output | None,
    tolerance_s: float,
) -> dai.MessageQueue:
    """Return a queue of message groups whose depth and colour were taken together.

    Old pairs are dropped, so that a slow reader gets the newest pair.

    Parameters
    ----------
    pipeline : depthai.Pipeline
        The pipeline to add the pairing to; not started yet.
    depth, colour : depthai.Node.Output
        The outputs to pair. Without colour the groups hold depth alone.
    tolerance_s : float
        Largest difference of the two time stamps, s.
    """
    import depthai as dai

    sync = pipeline.create(dai.node.Sync)
    sync.setRunOnHost(True)
    sync.setSyncThreshold(timedelta(seconds=tolerance_s))
    for name, output in ((DEPTH, depth), (COLOUR, colour)):
        if output is not None:
            output.link(sync.inputs[name])
            sync.inputs[name].setBlocking(False)
    return sync.out.createOutputQueue(maxSize=QUEUE_SIZE, blocking=False)


def next_pair(queue: dai.MessageQueue, timeout_s: float) -> dai.MessageGroup | None:
    """Wait for the next pair; None when none comes within the time or the stream has ended."""
    import depthai as dai

    closed = queue_closed_error()
    deadline = time.monotonic() + timeout_s
    while (left := deadline - time.monotonic()) > 0:
        try:
            message = queue.get(timedelta(seconds=min(left, POLL_S)))
        except closed:
            return None
        if isinstance(message, dai.MessageGroup):
            return message
    return None


def images(pair: dai.MessageGroup) -> tuple[dai.ImgFrame, dai.ImgFrame | None]:
    """Return the depth image of a pair, and its colour image or None.

    Raises
    ------
    InputError
        If one of them is some other message.
    """
    colour = _image(pair, COLOUR) if COLOUR in pair.getMessageNames() else None
    return _image(pair, DEPTH), colour


def _image(pair: dai.MessageGroup, name: str) -> dai.ImgFrame:
    import depthai as dai

    message = pair[name]
    if not isinstance(message, dai.ImgFrame):
        raise InputError(
            f"the {name} stream holds {type(message).__name__} messages, expected images"
        )
    return message
