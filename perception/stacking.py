"""What an object rests on: the support plane, or another object."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .segmentation import Segmentation, SupportPlane
    from .superquadric import SuperquadricFit

CONTACT = 0.015
"""Largest gap between a bottom and the surface below for it to rest there, m."""
LOW, HIGH = 3.0, 97.0
"""Percentiles of a cloud's heights that stand for its visible bottom and top."""


def resting_height(
    label: int,
    clouds: dict[int, NDArray[np.float64]],
    support: SupportPlane | None,
    segmentation: Segmentation,
) -> float:
    """Height above the support plane of the surface under an object, m.

    An object whose visible bottom lies at the top of a segment that it touches in the image
    stands on that one; everything else is taken to stand on the support plane, hidden bottom
    included.
    """
    if support is None or not len(clouds[label]):
        return 0.0
    bottom = float(np.percentile(support.height(clouds[label]), LOW))
    if bottom < CONTACT:
        return 0.0
    mask = segmentation.mask(label).astype(np.uint8)
    ring = cv2.dilate(mask, np.ones((7, 7), np.uint8)) > mask
    best = 0.0
    for other in np.unique(segmentation.labels[ring]):
        if other in (0, label) or not len(clouds[int(other)]):
            continue
        top = float(np.percentile(support.height(clouds[int(other)]), HIGH))
        if abs(bottom - top) < CONTACT and top > best:
            best = top
    return best


def rests_on(
    label: int,
    fits: dict[int, SuperquadricFit],
    clouds: dict[int, NDArray[np.float64]],
    support: SupportPlane | None,
    floors: dict[int, float],
) -> int | None:
    """Label of the object under this one, 0 for the support plane, None when unknown."""
    if support is None or not len(clouds[label]):
        return None
    if floors[label] > 0.0:
        tops = {
            other: float(np.percentile(support.height(cloud), HIGH))
            for other, cloud in clouds.items()
            if other != label and len(cloud)
        }
        return min(tops, key=lambda other: abs(tops[other] - floors[label]))
    solid = fits[label].superquadric
    if solid is None:
        bottom = float(np.percentile(support.height(clouds[label]), LOW))
    else:
        bottom = -float(solid.support(-support.normal)) + support.offset
    return 0 if bottom < 2 * CONTACT else None
