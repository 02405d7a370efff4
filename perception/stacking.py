"""What an object rests on: the support plane, or another object."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

from .perpendicular import perpendicular_pair

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .segmentation import Segmentation, SupportPlane
    from .superquadric import SuperquadricFit

CONTACT = 0.015
"""How far below a surface the visible bottom of what stands on it may seem to lie, m."""
OVERLAP = 0.3
"""Least share of an object's points over another in plan for it to stand on it."""
PLAN_POINTS = 100
"""Points that stand for an object in plan."""
REACH = 3
"""Pixels between segments that still touch in the image."""
FOOT = 0.03
"""Largest height of a fitted bottom over the support for the object to stand there, m."""
LOW, HIGH = 3.0, 97.0
"""Percentiles of a cloud's heights that stand for its visible bottom and top."""


class Surface(NamedTuple):
    """What lies under an object."""

    height: float
    """Height above the support plane, m."""
    label: int
    """Label of the object it belongs to, 0 for the support plane."""


def surface_below(
    label: int,
    clouds: dict[int, NDArray[np.float64]],
    support: SupportPlane | None,
    segmentation: Segmentation,
    box: tuple[slice, slice],
) -> Surface:
    """Find the surface under an object.

    An object that touches a segment in the image, shows nothing below its top, and lies over it
    in plan stands on it: a ball's own bottom is never seen. Everything else is taken to stand on
    the support plane: the bottom of an object behind another is hidden, not at its edge.

    Parameters
    ----------
    label, clouds
        The object, and all objects' points by label in the support plane's frame.
    support, segmentation
        Support plane, and the labels behind the clouds.
    box
        Rows and columns that hold the object.
    """
    table = Surface(0.0, 0)
    if support is None or not len(clouds[label]):
        return table
    bottom = float(np.percentile(support.height(clouds[label]), LOW))
    if bottom < CONTACT:
        return table
    rows, columns = (slice(max(s.start - REACH, 0), s.stop + REACH) for s in box)
    labels = segmentation.labels[rows, columns]
    mask = (labels == label).astype(np.uint8)
    ring = cv2.dilate(mask, np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)) > mask
    best = table
    for other in np.unique(labels[ring]).tolist():
        if other in (0, label) or not len(clouds[other]):
            continue
        top = float(np.percentile(support.height(clouds[other]), HIGH))
        above = bottom > top - CONTACT and top > best.height
        if above and _share_over(clouds[label], clouds[other], support) > OVERLAP:
            best = Surface(top, other)
    return best


def _share_over(
    upper: NDArray[np.float64], lower: NDArray[np.float64], support: SupportPlane
) -> float:
    """Share of the upper object's points that lie over the lower one's outline in plan."""
    axes = perpendicular_pair(support.normal)
    hull = cv2.convexHull((lower @ axes.T).astype(np.float32))
    plan = upper[:: max(len(upper) // PLAN_POINTS, 1)] @ axes.T
    inside = [cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0 for x, y in plan]
    return float(np.mean(inside))


def rests_on(
    cloud: NDArray[np.float64],
    fit: SuperquadricFit,
    below: Surface,
    support: SupportPlane | None,
) -> int | None:
    """Label of the object under this one, 0 for the support plane, None when unknown."""
    if support is None or not len(cloud):
        return None
    if below.label > 0:
        return below.label
    solid = fit.superquadric
    if solid is None or not fit:
        bottom = float(np.percentile(support.height(cloud), LOW))
    else:
        bottom = -float(solid.support(-support.normal)) + support.offset
    return 0 if bottom < FOOT else None
