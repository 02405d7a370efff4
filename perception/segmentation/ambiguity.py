"""Objects that geometry alone cannot separate: split them by other evidence, or report them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .colour_cut import colour_cut
from .options import SegmentationOptions
from .regions import relabel_with_reasons
from .split_solids import split_mask
from .working_image import WorkingImage

FLAT = "two of its parts meet without an edge"
HIDDEN = "its parts were joined behind an occluder"
NEARLY = "the evidence nearly joined it with its neighbour"
COAXIAL = "it and what is above or below it are round about one axis"
COLOURED = "two plain colours meet on it along a straight edge"
CUT = "it was split from its neighbour along a colour edge alone"
SCALES = "a lower resolution divides it, joins it with its neighbour or loses it"
SOLIDS = "it was split from its neighbour because two solids fit better than one"


class UncertainJoin(NamedTuple):
    """Two parts that were joined although they may be two objects, or the reverse."""

    pixel_a: int
    """Flat index of a pixel of the first part."""
    pixel_b: int
    """Flat index of a pixel of the second part."""
    reason: str
    """Why they may be two objects. With a reason in ``APART`` they are two and may be one."""


APART = (NEARLY, COAXIAL)


def resolve_ambiguity(
    labels: NDArray[np.int32],
    uncertain: list[UncertainJoin],
    image: WorkingImage,
    options: SegmentationOptions,
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Split objects by their colours or by fits of two solids, and report the ambiguous ones.

    Parameters
    ----------
    labels
        Objects 1..n by size, (H, W).
    uncertain
        Decisions of earlier stages that may be wrong.
    image
        Image of the objects.
    options
        ``colour_edges`` splits along colour edges, ``split_solids`` by fits of solids. Without
        them the objects are only reported.

    Returns
    -------
    labels, ambiguous
        New labels by size, and label → reason.
    """
    ambiguous: dict[int, str] = {}
    flat = labels.ravel()
    for a, b, reason in uncertain:
        if reason not in APART and flat[a] == flat[b] > 0:
            ambiguous.setdefault(int(flat[a]), reason)
    if image.colour is not None or (options.split_solids and ambiguous):
        labels = labels.copy()
        following = int(labels.max(initial=0))
        for label, box in enumerate(ndimage.find_objects(labels), start=1):
            if box is None:
                continue
            mask = labels[box] == label
            part, reason = _second_part(mask, image.cropped(box), label in ambiguous, options)
            if part is not None:
                following += 1
                labels[box][part] = following
                ambiguous[label] = ambiguous[following] = reason
            elif reason:
                ambiguous.setdefault(label, reason)
    flat = labels.ravel()
    for a, b, reason in uncertain:
        if reason in APART and flat[a] != flat[b] and min(flat[a], flat[b]) > 0:
            for label in (int(flat[a]), int(flat[b])):
                ambiguous.setdefault(label, reason)
    return relabel_with_reasons(labels, ambiguous) if ambiguous else (labels, ambiguous)


def _second_part(
    mask: NDArray[np.bool_], image: WorkingImage, ambiguous: bool, options: SegmentationOptions
) -> tuple[NDArray[np.bool_] | None, str]:
    """Return the part of an object to split off, or None; and the reason of its ambiguity or ""."""
    part = colour_cut(mask, image)
    if part is not None and options.colour_edges:
        return part, CUT
    reason = "" if part is None else COLOURED
    if options.split_solids and (ambiguous or reason):
        part = split_mask(mask, image, options.min_object)
        return part, reason if part is None else SOLIDS
    return None, reason
