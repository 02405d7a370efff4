"""Image messages as an OAK camera would make them of depth frames."""

from __future__ import annotations

from datetime import timedelta
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.cameras import load_depthai
from eyehand.perception.frame import DepthFrame

if TYPE_CHECKING:
    import depthai as dai


def image_messages(frame: DepthFrame, time_s: float) -> tuple[dai.ImgFrame, dai.ImgFrame | None]:
    """Return RAW16 depth in mm and, if present, colour, with the camera of the frame."""
    load_depthai()
    import depthai as dai

    raw = np.rint(1000.0 * frame.depth.astype(np.float64)).astype(np.uint16)
    depth = _message(dai.ImgFrame.Type.RAW16, raw, frame, time_s)
    if frame.colour is None:
        return depth, None
    return depth, _message(dai.ImgFrame.Type.RGB888i, frame.colour, frame, time_s)


def _message(
    kind: dai.ImgFrame.Type, pixels: np.ndarray, frame: DepthFrame, time_s: float
) -> dai.ImgFrame:
    import depthai as dai

    height, width = pixels.shape[:2]
    k = frame.intrinsics
    message = dai.ImgFrame()
    message.setType(kind)
    message.setSize(width, height)
    message.setStride(width * pixels.itemsize * (pixels.shape[2] if pixels.ndim == 3 else 1))
    # setSourceSize resets the transformation, so it comes first.
    message.setSourceSize(width, height)
    message.setTransformation(dai.ImgTransformation(k.width, k.height, k.matrix.tolist()))
    message.setData(np.ascontiguousarray(pixels).tobytes())
    message.setTimestamp(timedelta(seconds=time_s))
    message.setTimestampDevice(timedelta(seconds=time_s))
    return message
