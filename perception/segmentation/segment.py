"""One depth frame in, one label per object out."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from .above_support import above_support, candidate_window
from .ambiguity import settle_doubts
from .convexity import pixels_by_label
from .frame_noise import frame_noise
from .grow_patches import grow_patches
from .join_floating import join_floating
from .join_fragments import join_fragments
from .join_occluded import join_occluded
from .join_open import join_open
from .local_planes import fit_local_planes
from .merge_patches import merge_patches
from .options import SegmentationOptions
from .regions import largest_regions
from .result import Segmentation
from .smooth_patches import linked_pixels, plane_normals, smooth_patches
from .support_plane import find_supports
from .supported_regions import standing_regions
from .upsample import upsample_labels
from .working_image import inverse, view_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import DepthFrame
    from .support_plane import Support
    from .working_image import View


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
        frame's own noise, the seconds of every stage, and what is ambiguous. At most 200 objects,
        the largest. A frame without objects gives zeros; without a support plane everything that
        is a smooth solid counts as an object.
    """
    options = options or SegmentationOptions()
    clock = _Stages()
    view = view_of(frame, options.stride, median=options.median)
    options = options.scaled(view.intrinsics.width)
    clock.done("view")
    noise = frame_noise(view.disparity, options)
    clock.done("noise")
    supports = find_supports(view, noise, options)
    clock.done("support")
    above = above_support(view, supports, options)
    window = candidate_window(above, options)
    clock.done("above")
    labels = np.zeros(view.depth.shape, np.int32)
    ambiguous: dict[int, str] = {}
    if window is not None:
        labels[window], ambiguous = _segment_window(
            view, above, window, noise, supports, options, clock
        )
    if options.stride > 1:
        labels = upsample_labels(labels, inverse(frame.depth), options.stride)
        labels, ambiguous = _renumbered(labels, ambiguous)
        clock.done("upsample")
    planes = tuple(support.plane for support in supports)
    return Segmentation(
        labels, planes[0] if planes else None, noise, clock.seconds, ambiguous, planes[1:]
    )


def _segment_window(
    view: View,
    above: NDArray[np.bool_],
    window: tuple[slice, slice],
    noise: float,
    supports: list[Support],
    options: SegmentationOptions,
    clock: _Stages,
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Label the part of the image that holds all candidates."""
    depth = np.ascontiguousarray(view.depth[window])
    q = np.ascontiguousarray(view.disparity[window])
    above = np.ascontiguousarray(above[window])
    camera = view.intrinsics.cropped(*window)
    planes = fit_local_planes(q, noise, options)
    clock.done("local_planes")
    linked = linked_pixels(planes, plane_normals(planes, camera), options)
    clock.done("links")
    patches = smooth_patches(linked * above, options.min_patch)
    clock.done("patches")
    patches, planes = grow_patches(q, planes, patches, above, options)
    clock.done("grow")
    labels, doubts = merge_patches(patches, q, planes, camera, options)
    clock.done("merge")
    labels = standing_regions(labels, depth, camera, supports, options.min_patch, options)
    pieces = labels
    labels = largest_regions(labels, options.min_object)
    clock.done("stand")
    if supports:
        labels = join_floating(labels, q, planes, camera, supports[0].plane, options)
    labels = largest_regions(labels, 1)
    clock.done("floating")
    if options.join_open:
        labels = join_open(labels, q, planes, camera, options)
    labels = largest_regions(labels, 1)
    clock.done("open")
    if options.join_occluded:
        labels, hidden = join_occluded(labels, q, planes, camera, options)
        doubts += hidden
    labels = largest_regions(labels, 1)
    clock.done("occluded")
    # Crumbs take no part in the joins above, but belong to something.
    crumbs = (labels == 0) & (pieces > 0)
    labels = np.where(crumbs, pieces + labels.max(initial=0), labels)
    labels = join_fragments(largest_regions(labels, 1), q, planes, options)
    labels = largest_regions(labels, options.min_object)
    clock.done("fragments")
    colour = None if view.colour is None else view.colour[window]
    labels, ambiguous = settle_doubts(labels, doubts, q, colour, camera, options)
    if ambiguous:
        labels, ambiguous = _renumbered(labels, ambiguous)
    clock.done("doubts")
    return labels, ambiguous


def _renumbered(
    labels: NDArray[np.int32], names: dict[int, str]
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Number labels by size again, and what is known of them with them."""
    ordered = largest_regions(labels, 1)
    order, starts = pixels_by_label(labels, int(labels.max(initial=0)))
    new = {
        label: int(ordered.flat[order[starts[label]]])
        for label in names
        if label + 1 < len(starts) and starts[label] < starts[label + 1]
    }
    return ordered, {new[label]: names[label] for label in sorted(new, key=new.__getitem__)}


class _Stages:
    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def done(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now
