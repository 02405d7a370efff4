"""One depth frame in, one label per object out."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import cv2
import numpy as np

from .grow import grow_patches
from .local_planes import fit_local_planes
from .merge import merge_patches
from .options import SegmentationOptions
from .result import Segmentation
from .smooth_patches import linked_pixels, plane_normals, smooth_patches
from .support_plane import Support, find_support

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import DepthFrame


MIDDLE_PIXELS = 400
"""Pixels that stand for an object when its middle is looked for."""


def segment(frame: DepthFrame, options: SegmentationOptions | None = None) -> Segmentation:
    """Segment a depth frame into objects without any model of them.

    Parameters
    ----------
    frame
        Depth frame of any size.
    options
        Thresholds; the defaults suit structured-light and stereo cameras at 0.4-2 m.

    Returns
    -------
    Segmentation
        Labels (H, W) int32, largest object first, the support plane in the camera frame, the
        frame's own noise and the seconds of every stage. A frame without objects gives zeros;
        without a support plane everything that is a smooth solid counts as an object.
    """
    options = (options or SegmentationOptions()).scaled(frame.intrinsics.width)
    clock = _Stages()
    disparity = np.divide(1.0, frame.depth, out=np.zeros_like(frame.depth), where=frame.valid)
    clock.done("disparity")
    planes = fit_local_planes(disparity, options)
    clock.done("local_planes")
    normals = plane_normals(planes, frame.intrinsics)
    linked = linked_pixels(planes, normals, options)
    clock.done("links")
    support = find_support(frame, disparity, planes, options)
    clock.done("support")
    above = _above(frame, support, options)
    patches = smooth_patches(linked * above, options.min_patch)
    clock.done("patches")
    patches, planes = grow_patches(disparity, planes, patches, above, options)
    clock.done("grow")
    objects = merge_patches(patches, disparity, planes, frame.intrinsics, options)
    clock.done("merge")
    labels = _order(objects, support, frame, options)
    clock.done("order")
    return Segmentation(labels, support.plane if support else None, planes.noise, clock.seconds)


class _Stages:
    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def done(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now


def _above(
    frame: DepthFrame, support: Support | None, options: SegmentationOptions
) -> NDArray[np.bool_]:
    if support is None:
        return frame.valid
    # A depth camera's errors grow with z²: so does the height that tells an object from a wave.
    growth = np.square(frame.depth * np.float32(1.0 / support.depth))
    waves = growth * np.float32(options.plane_sigmas * support.plane.tolerance)
    return support.height > np.maximum(waves, np.float32(options.min_height))


def _order(
    objects: NDArray[np.int32],
    support: Support | None,
    frame: DepthFrame,
    options: SegmentationOptions,
) -> NDArray[np.int32]:
    """Number objects by size, dropping what is too small or does not stand on the support."""
    flat = np.flatnonzero(objects)
    labels = objects.ravel()[flat]
    sizes = np.bincount(labels, minlength=1)
    by_label = flat[np.argsort(labels, kind="stable")]
    ends = np.cumsum(sizes)
    renumber = np.zeros(len(sizes), np.int32)
    following = 1
    for label in np.argsort(-sizes, kind="stable"):
        if sizes[label] < options.min_object:
            break
        pixels = by_label[ends[label] - sizes[label] : ends[label]]
        if support is not None and not _stands_on(pixels, frame, support, options):
            continue
        renumber[label] = following
        following += 1
    return renumber[objects]


def _stands_on(
    pixels: NDArray[np.intp], frame: DepthFrame, support: Support, options: SegmentationOptions
) -> bool:
    """Whether the middle of an object (flat pixel indices) lies over the support's hull."""
    k = frame.intrinsics
    rows, columns = np.divmod(pixels[:: max(pixels.size // MIDDLE_PIXELS, 1)], k.width)
    z = frame.depth[rows, columns].astype(np.float64)
    points = np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])
    middle = np.median(points @ support.axes.T, axis=0)
    inside = cv2.pointPolygonTest(support.hull, (float(middle[0]), float(middle[1])), True)
    return inside > -options.hull_margin
