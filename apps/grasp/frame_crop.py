"""The part of a look that matters: a depth frame cut to where objects stand."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from .scenes import GRASPABLE_HEIGHT, WORK_AREA

if TYPE_CHECKING:
    from eyehand.perception import DepthFrame, Scene

MARGIN_PX = 8
"""Around what is kept."""
SHAPE = 4 / 3
"""Width over height of what is kept."""


def closeup(frame: DepthFrame, scene: Scene) -> tuple[DepthFrame, Scene]:
    """Cut a frame and its labels to the work area and all that was seen.

    Where the camera's place is unknown, or nothing is in view, frame and scene come back whole.
    """
    columns, rows = _kept(frame, scene)
    depth, k = frame.depth[rows, columns], frame.intrinsics
    if not (depth > 0).any():
        return frame, scene
    cut = replace(
        frame,
        depth=depth,
        colour=None if frame.colour is None else frame.colour[rows, columns],
        intrinsics=replace(
            k,
            cx=k.cx - columns.start,
            cy=k.cy - rows.start,
            width=depth.shape[1],
            height=depth.shape[0],
        ),
    )
    segmentation = scene.segmentation
    labels = segmentation.labels
    if labels.shape == frame.depth.shape:
        labels = np.where(np.isin(labels, [one.label for one in scene.objects]), labels, 0)
        segmentation = replace(segmentation, labels=labels[rows, columns])
    return cut, replace(scene, segmentation=segmentation)


def _kept(frame: DepthFrame, scene: Scene) -> tuple[slice, slice]:
    """Columns and rows that are kept."""
    height, width = frame.depth.shape
    whole = slice(0, width), slice(0, height)
    if frame.T_world_camera is None:
        return whole
    wide, long = WORK_AREA
    corners = np.array(
        list(product((-wide / 2, wide / 2), (-long / 2, long / 2), (0.0, GRASPABLE_HEIGHT[1])))
    )
    points = np.vstack([corners, *(one.points for one in scene.objects)])
    pixels = frame.intrinsics.project(frame.T_world_camera.inv().apply(points))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    if not len(pixels):
        return whole
    low, high = pixels.min(axis=0) - MARGIN_PX, pixels.max(axis=0) + MARGIN_PX
    middle, extent = (low + high) / 2, high - low
    half = max(extent[0], SHAPE * extent[1]) / 2 * np.array([1.0, 1.0 / SHAPE])
    # A region that would leave the image is moved into it, and cut where it is larger.
    half = np.minimum(half, np.array([width, height]) / 2)
    middle = np.clip(middle, half, np.array([width, height]) - half)
    (left, top), (right, bottom) = np.round(middle - half), np.round(middle + half)
    return slice(int(left), int(right)), slice(int(top), int(bottom))
