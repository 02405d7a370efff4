"""Find the objects that a segmentation at a lower resolution divides or joins differently."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STEP = 2
"""Step of the rows and columns of the second segmentation, px. It takes 0.3 times the time of
the first one, and its patches have other borders."""
MIN_SCALE = 0.7
"""Minimum width of the first image for a check, in reference widths. Half of a smaller image shows
too little: on 160 balls apart, a check warns about 0 at 640 px, 1 at 512, 7 at 424 and 46 at 320
px."""
MIN_DIVIDED = 0.1
"""Minimum share of an object that the other segmentation puts into a second object. On 128 objects
in point frames, 0.2 leaves 2 more failures without a warning, and 0.05 warns about 3 more right
objects."""
MIN_JOINED = 0.5
"""Minimum part of a neighbour that the other segmentation joins to an object, relative to the
larger one of both. With 0.1 it warns about 2 more right objects and finds no more failures."""
MIN_LOST = 0.5
"""Minimum share of an object that is no object in the other segmentation."""


def disputed_objects(labels: NDArray[np.int32], other: NDArray[np.int32]) -> list[int]:
    """Return the objects that another segmentation of the same pixels sees differently.

    Parameters
    ----------
    labels, other
        Objects of both segmentations (H, W), 0 = no object.
    """
    count, width = int(labels.max(initial=0)) + 1, int(other.max(initial=0)) + 2
    # The last column stays empty, so that each object has a second best.
    common = np.bincount((labels * width + other).ravel(), minlength=count * width)
    common = common.reshape(count, width)
    whole, lost = common.sum(axis=1), common[:, 0].copy()
    common[0] = common[:, 0] = 0
    disputed: list[int] = []
    for label in np.flatnonzero(whole[1:]) + 1:
        second, most = np.argsort(common[label], kind="stable")[-2:]
        beside = common[:, most].copy()
        beside[label] = 0
        joined = beside / np.maximum(whole, whole[label])
        if (
            lost[label] > MIN_LOST * whole[label]
            or common[label, second] > MIN_DIVIDED * whole[label]
            or joined.max() > MIN_JOINED
        ):
            disputed.append(int(label))
    return disputed
