"""The image that all stages work on: reduced, filtered, as depth and as disparity."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from ..frame import CameraIntrinsics, DepthFrame
from .fill_gaps import fill_gaps

REFERENCE_WIDTH = 640
"""Width of the image for which all constants in pixels are given, px."""


class WorkingImage(NamedTuple):
    """One depth frame, or a part of it, as the stages use it; 0 = no reading."""

    depth: NDArray[np.float32]
    """(H, W), m."""
    disparity: NDArray[np.float32]
    """Inverse depth, (H, W), 1/m."""
    intrinsics: CameraIntrinsics
    """Camera of this image."""
    T_world_camera: RigidTransform | None = None
    """Pose of the camera, or None where it is unknown."""
    colour: NDArray[np.uint8] | None = None
    """(H, W, 3) RGB, or None."""
    noise: float = 0.0
    """Noise σ of disparity, 1/m."""
    scale: float = 1.0
    """Width of the whole image divided by ``REFERENCE_WIDTH``."""
    masked: NDArray[np.bool_] | None = None
    """Pixels masked on purpose, (H, W); None without a mask, and in a part of the image."""

    @property
    def pinhole(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy of the camera, px, for the compiled functions."""
        k = self.intrinsics
        return k.fx, k.fy, k.cx, k.cy

    def length(self, pixels: int) -> int:
        """Convert a length in px from the reference width to this image, at least 1."""
        return max(round(pixels * self.scale), 1)

    def area(self, pixels: int) -> int:
        """Convert an area in px from the reference width to this image, at least 1."""
        return scaled_area(pixels, self.scale)

    def points(self, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the points (N, 3) of pixels with readings, from disparity, camera frame, m."""
        z = 1.0 / self.disparity[rows, columns].astype(np.float64)
        k = self.intrinsics
        return np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])

    def cropped(self, window: tuple[slice, slice]) -> WorkingImage:
        """Return the part of the image in a window of rows and columns."""
        return self._replace(
            depth=np.ascontiguousarray(self.depth[window]),
            disparity=np.ascontiguousarray(self.disparity[window]),
            intrinsics=self.intrinsics.cropped(*window),
            colour=None if self.colour is None else np.ascontiguousarray(self.colour[window]),
            masked=None,
        )

    def reduced(self, step: int) -> WorkingImage:
        """Return every `step`-th row and column of the image."""
        part = slice(None, None, step), slice(None, None, step)
        return self._replace(
            depth=self.depth[part].copy(),
            disparity=self.disparity[part].copy(),
            intrinsics=self.intrinsics.reduced(step),
            colour=None if self.colour is None else self.colour[part].copy(),
            masked=None if self.masked is None else self.masked[part],
            scale=self.scale / step,
        )


def working_image(frame: DepthFrame, stride: int = 1, *, median: bool = False) -> WorkingImage:
    """Select every `stride`-th row and column, and optionally filter disparity by a 3x3 median.

    Before the median, single gaps are filled where many readings are missing (`fill_gaps`). All
    other pixels without a reading stay without one. A reading with too few neighbours for the
    median stays as it is. The noise is not measured here.
    """
    # The copies are writable: for the frame's read-only array all kernels would compile once more.
    depth = frame.depth[::stride, ::stride].copy()
    disparity = inverse(depth)
    if median:
        disparity = fill_gaps(disparity)
        filtered = cv2.medianBlur(disparity, 3)
        disparity = keep_gaps(disparity, np.asarray(filtered))
        depth = inverse(disparity)
    colour = None if frame.colour is None else frame.colour[::stride, ::stride].copy()
    masked = None if frame.masked is None else frame.masked[::stride, ::stride]
    camera = frame.intrinsics.reduced(stride)
    scale = image_scale(camera.width)
    return WorkingImage(
        depth, disparity, camera, frame.T_world_camera, colour, scale=scale, masked=masked
    )


@njit(cache=True, nogil=True, error_model="numpy")
def inverse(image):
    """Convert depth (H, W) float32 to disparity or back; 0 stays 0."""
    result = np.empty(image.shape, np.float32)
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            value = image[v, u]
            result[v, u] = np.float32(1.0) / value if value > 0 else np.float32(0.0)
    return result


@njit(cache=True, nogil=True)
def keep_gaps(image, filtered):
    """Return a filtered image (H, W), but where it or the image has no reading, the image."""
    result = np.empty(image.shape, np.float32)
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            value, other = image[v, u], filtered[v, u]
            result[v, u] = other if (value > 0) & (other > 0) else value
    return result


def image_scale(width: int) -> float:
    """Return the width of an image divided by the reference width."""
    return width / REFERENCE_WIDTH


def scaled_area(pixels: int, scale: float) -> int:
    """Convert an area in px from the reference width, at least 1."""
    return max(round(pixels * scale**2), 1)
