"""Crop a depth frame to the work area and its objects."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from .scenes import GRASPABLE_HEIGHT, WORK_AREA

if TYPE_CHECKING:
    from eyehand.perception import DepthFrame, Scene

MARGIN_PX = 8
"""Margin around the work area and the objects, px."""
ASPECT = 4 / 3
"""Width over height of the cropped frame."""


def crop_to_objects(frame: DepthFrame, scene: Scene) -> tuple[DepthFrame, Scene]:
    """Crop a frame and the labels of its scene to the work area and all objects.

    Return both unchanged if the camera pose is unknown or the cropped part has no reading.
    """
    columns, rows = _crop_window(frame, scene)
    depth = frame.depth[rows, columns]
    if not (depth > 0).any():
        return frame, scene
    cut = replace(
        frame,
        depth=depth,
        colour=None if frame.colour is None else frame.colour[rows, columns],
        masked=None if frame.masked is None else frame.masked[rows, columns],
        intrinsics=frame.intrinsics.cropped(rows, columns),
    )
    segmentation = scene.segmentation
    labels = segmentation.labels
    if labels.shape == frame.depth.shape:
        labels = np.where(np.isin(labels, [item.label for item in scene.objects]), labels, 0)
        segmentation = replace(segmentation, labels=labels[rows, columns])
    return cut, replace(scene, segmentation=segmentation)


def _crop_window(frame: DepthFrame, scene: Scene) -> tuple[slice, slice]:
    """Return the columns and rows to keep."""
    height, width = frame.depth.shape
    whole = slice(0, width), slice(0, height)
    if frame.T_world_camera is None:
        return whole
    wide, long = WORK_AREA
    corners = np.array(
        list(product((-wide / 2, wide / 2), (-long / 2, long / 2), (0.0, GRASPABLE_HEIGHT[1])))
    )
    points = np.vstack([corners, *(item.points for item in scene.objects)])
    pixels = frame.intrinsics.project(frame.T_world_camera.inv().apply(points))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    if not len(pixels):
        return whole
    low, high = pixels.min(axis=0) - MARGIN_PX, pixels.max(axis=0) + MARGIN_PX
    middle, extent = (low + high) / 2, high - low
    half = max(extent[0], ASPECT * extent[1]) / 2 * np.array([1.0, 1.0 / ASPECT])
    # Shift the window into the image. Clip it if it is larger than the image.
    half = np.minimum(half, np.array([width, height]) / 2)
    middle = np.clip(middle, half, np.array([width, height]) - half)
    (left, top), (right, bottom) = np.round(middle - half), np.round(middle + half)
    return slice(int(left), int(right)), slice(int(top), int(bottom))
