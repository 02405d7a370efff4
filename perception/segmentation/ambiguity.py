"""What geometry cannot tell is said, and cut only where something else tells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from .colour_cut import colour_cut
from .split_solids import split_mask

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions

FLAT = "two of its parts go over into one another without an edge"
HIDDEN = "its parts were joined behind something nearer"
COLOURED = "two plain colours meet on it along a straight edge"
CUT = "it was cut from its neighbour along a colour edge alone"
SOLIDS = "it was cut from its neighbour because two solids fit better than one"

Doubt = tuple[int, int, str]
"""Flat indices of a pixel on either part, and why the parts may be two objects."""


def settle_doubts(
    labels: NDArray[np.int32],
    doubts: list[Doubt],
    disparity: NDArray[np.float32],
    colour: NDArray[np.uint8] | None,
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Cut objects where colour or two solids speak for it, and name those left in doubt.

    Parameters
    ----------
    labels
        Objects 1..n, (H, W).
    doubts
        What the joining stages were not sure of.
    disparity
        (H, W), 1/m.
    colour
        (H, W, 3) uint8, or None.
    camera
        Its intrinsics.
    options
        ``colour_edges`` cuts along colour edges, ``split_solids`` by comparing fits; without
        them such objects are only named.

    Returns
    -------
    labels, ambiguous
        New labels, and label → reason.
    """
    ambiguous: dict[int, str] = {}
    flat = labels.ravel()
    for a, b, reason in doubts:
        if flat[a] == flat[b] > 0:
            ambiguous.setdefault(int(flat[a]), reason)
    if colour is None and not (options.split_solids and ambiguous):
        return labels, ambiguous
    labels = labels.copy()
    following = int(labels.max(initial=0))
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        if box is None:
            continue
        mask = labels[box] == label
        local = camera.cropped(*box)
        second = None
        reason = CUT
        if colour is not None:
            second = colour_cut(mask, disparity[box], colour[box], local, options)
            if second is not None and not options.colour_edges:
                ambiguous.setdefault(label, COLOURED)
                second = None
        if second is None and options.split_solids and label in ambiguous:
            second, reason = split_mask(mask, disparity[box], local, options), SOLIDS
        if second is None:
            continue
        following += 1
        labels[box][second] = following
        ambiguous[label] = ambiguous[following] = reason
    return labels, ambiguous
