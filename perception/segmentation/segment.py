"""Segment one depth frame: the stages in their order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..frame import DepthFrame
from .above_support import above_support, candidate_window
from .ambiguity import SCALES, UncertainJoin, resolve_ambiguity
from .cut_necks import cut_necks
from .find_background import StageClock, find_background
from .find_sheets import find_sheets
from .floating_regions import remove_floating
from .frame_checks import check_frame, check_pose, check_tilt
from .furniture_walls import find_faces, remove_faces
from .grow_patches import grow_patches
from .join_coaxial import join_coaxial
from .join_floating import join_floating
from .join_fragments import join_fragments
from .join_open import fill_mouths, join_open
from .join_patches import join_patches
from .join_rims import join_rims
from .local_planes import fit_local_planes
from .measure_container import FoundContainer
from .options import SegmentationOptions
from .regions import relabel_by_size, relabel_with_reasons
from .remove_attached import remove_attached
from .remove_container_parts import remove_container_parts
from .remove_steep import remove_steep
from .remove_walls import remove_walls
from .result import Segmentation
from .scale_check import MIN_SCALE, STEP, disputed_objects
from .scene_warnings import find_warnings, lost_warnings
from .select_objects import select_objects
from .smooth_patches import MIN_PATCH, label_patches, linked_pixels
from .support_extent import Support
from .unknown_regions import find_unknown
from .unreached_readings import continued_share, unreached_share
from .upsample import upsample_labels
from .working_image import REFERENCE_WIDTH, WorkingImage, inverse


def segment(frame: DepthFrame, options: SegmentationOptions | None = None) -> Segmentation:
    """Segment a depth frame into objects, without models of them.

    Parameters
    ----------
    frame
        Depth frame of any size.
    options
        Options of all stages.

    Returns
    -------
    Segmentation
        Labels (H, W) int32, largest object first; the support planes in the camera frame; the
        measured noise; the times of the stages; the ambiguous objects; warnings. At most 200
        objects are kept, the largest ones. A frame without objects gives zeros. Without a support
        plane every smooth solid counts as an object.
    """
    clock = StageClock()
    background = find_background(frame, options or SegmentationOptions(), clock)
    image, stride, options = background.image, background.stride, background.options
    supports, found = background.supports, background.containers
    unknown = ()
    faults = () if supports else check_pose(image, options, background.profile)
    if background.planes:
        first, tops = background.planes[0], background.tops
        unknown = find_unknown(tops, image, first, walls=bool(found))
    clock.finish("unknown" if supports else "support")
    above = above_support(image, supports, options.max_range)
    if supports and not found:
        above = remove_faces(above, image, find_faces(background.readings, supports))
    for one in found:
        above = remove_walls(above, image, one)
    window = candidate_window(above, image.area(MIN_PATCH))
    clock.finish("candidates")
    labels, lost = np.zeros(image.depth.shape, np.int32), np.zeros(image.depth.shape, np.bool_)
    ambiguous: dict[int, str] = {}
    if window is not None:
        candidates = np.ascontiguousarray(above[window])
        labels[window], lost[window], ambiguous = _segment_candidates(
            image.cropped(window), candidates, (supports, found), options, clock
        )
    labels, ambiguous = _label_readings(labels, ambiguous, frame, stride)
    if stride > 1:
        clock.finish("upsample")
    planes = [support.plane for support in supports]
    if planes:
        faults = check_tilt(planes[0], image.T_world_camera)
    containers = tuple(one.container for one in found)
    sheets = find_sheets(labels[::stride, ::stride], image)
    unreached = unreached_share(image, supports)
    continued = continued_share(image, supports[0]) if supports else 0.0
    warnings = find_warnings(
        labels, ambiguous, supports, containers, above, unreached, sheets, continued
    )
    return Segmentation(
        labels,
        planes[0] if planes else None,
        image.noise,
        clock.seconds,
        ambiguous,
        tuple(planes[1:]),
        containers,
        (*check_frame(frame, image), *faults, *warnings, *lost_warnings(lost, image, stride)),
        tuple(region.enlarged(stride) for region in unknown),
    )


def _label_readings(
    labels: NDArray[np.int32], ambiguous: dict[int, str], frame: DepthFrame, stride: int
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Return the labels of the frame's own readings, from those of the working image.

    The working image has values also in gaps of the frame.
    """
    if stride > 1:
        labels = upsample_labels(labels, inverse(frame.depth), stride)
    elif (filled := (labels > 0) & (frame.depth == 0)).any():
        labels[filled] = 0
    else:
        return labels, ambiguous
    return relabel_with_reasons(labels, ambiguous)


def _segment_candidates(
    image: WorkingImage,
    candidates: NDArray[np.bool_],
    background: tuple[list[Support], list[FoundContainer]],
    options: SegmentationOptions,
    clock: StageClock,
) -> tuple[NDArray[np.int32], NDArray[np.bool_], dict[int, str]]:
    """Label the objects among the candidate pixels (H, W).

    `background` are the supports and the containers. Returns the objects, a mask of the lost
    readings that may be objects, and the ambiguous objects.
    """
    labels, lost, uncertain = _divide_candidates(image, candidates, background, options, clock)
    labels, ambiguous = resolve_ambiguity(labels, uncertain, image, options)
    clock.finish("ambiguity")
    if options.scale_check and image.scale >= MIN_SCALE and labels.any():
        coarse, _, _ = _divide_candidates(
            image.reduced(STEP),
            candidates[::STEP, ::STEP].copy(),
            background,
            options.scaled(REFERENCE_WIDTH // STEP),
            StageClock(),
        )
        for label in disputed_objects(labels[::STEP, ::STEP], coarse):
            ambiguous.setdefault(label, SCALES)
        clock.finish("scale_check")
    return labels, lost, ambiguous


def _divide_candidates(
    image: WorkingImage,
    candidates: NDArray[np.bool_],
    background: tuple[list[Support], list[FoundContainer]],
    options: SegmentationOptions,
    clock: StageClock,
) -> tuple[NDArray[np.int32], NDArray[np.bool_], list[UncertainJoin]]:
    """Divide the candidate pixels (H, W) into objects.

    Returns the objects, a mask of the lost readings that may be objects, and uncertain decisions.
    """
    supports, containers = background
    min_patch = image.area(MIN_PATCH)
    planes = fit_local_planes(image, options)
    clock.finish("local_planes")
    linked = linked_pixels(image, planes)
    clock.finish("links")
    patches = cut_necks(label_patches(linked * candidates, min_patch), image)
    clock.finish("patches")
    patches, planes = grow_patches(image, planes, patches, candidates, options.window)
    clock.finish("grow")
    labels, uncertain = join_patches(
        patches, image, planes, options.window, options.min_object, hidden=options.join_occluded
    )
    clock.finish("join")
    if supports and options.join_open:
        labels = join_rims(labels, candidates, image, supports[0].plane)
    pieces = select_objects(labels, image, supports, min_patch, options.max_extent)
    standing = remove_floating(pieces, image, supports)
    lost, pieces = (pieces > 0) & (standing == 0), standing
    kept = relabel_by_size(pieces, options.min_object)
    labels = remove_attached(kept, labels, image, planes)
    labels = remove_container_parts(labels, image, containers)
    if labels is not kept:
        pieces[(kept > 0) & (labels == 0)] = 0
    clock.finish("select")
    if supports:
        labels = join_floating(labels, image, planes, supports[0].plane)
    clock.finish("floating")
    if options.join_open:
        labels = fill_mouths(labels, image, planes)
        labels = join_open(labels, image, planes)
    clock.finish("open")
    labels = join_fragments(labels, pieces, image, planes, options.min_object)
    labels, steep = remove_steep(labels, image, planes, supports[0].plane if supports else None)
    clock.finish("fragments")
    if supports:
        labels, coaxial = join_coaxial(labels, image, planes, supports[0].plane)
        uncertain += coaxial
        clock.finish("coaxial")
    return labels, lost | steep, uncertain
