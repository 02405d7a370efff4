"""Find the surface under each object: the support plane or another object."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

from .perpendicular import perpendicular_pair
from .segmentation.median import quantile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .segmentation import Segmentation, SupportPlane
    from .superquadric import SuperquadricFit

CONTACT_TOLERANCE = 0.015
"""Maximum depth of an object's visible bottom below the surface that it stands on, m. Noise and
rounded edges shift the bottom."""
MIN_OVERLAP = 0.3
"""Minimum share of an object's points above another object in plan for it to stand on it."""
PLAN_POINTS = 100
"""Number of points that are tested per object in plan."""
REACH_PX = 3
"""Maximum distance of two segments that touch in the image, px."""
MAX_BOTTOM_HEIGHT = 0.03
"""Maximum height of the fitted bottom of an object that stands on the support plane, m."""
BOTTOM_SHARE, TOP_SHARE = 0.03, 0.97
"""Quantiles of a cloud's heights that stand for its visible bottom and top. Outliers lie beyond
them."""


class SurfaceBelow(NamedTuple):
    """The surface under an object."""

    height: float
    """Height above the support plane, m."""
    label: int
    """Label of the object that the surface belongs to, 0 for the support plane."""


def find_surface_below(
    label: int,
    clouds: dict[int, NDArray[np.float64]],
    support: SupportPlane | None,
    segmentation: Segmentation,
    box: tuple[slice, slice],
) -> SurfaceBelow:
    """Find the surface under an object.

    An object stands on another one if both segments touch in the image, if no point of it lies
    below the other's top, and if it lies above the other in plan. Every other object is assumed to
    stand on the support plane: an object in front may hide its bottom.

    Parameters
    ----------
    label
        Label of the object.
    clouds
        Points (N, 3) of all objects by label, m, in the support plane's frame.
    support
        The support plane, or None.
    segmentation
        The segmentation that the clouds come from.
    box
        Rows and columns of the image that contain the object.
    """
    table = SurfaceBelow(0.0, 0)
    if support is None or not len(clouds[label]):
        return table
    bottom = quantile(support.height(clouds[label]), BOTTOM_SHARE)
    if bottom < CONTACT_TOLERANCE:
        return table
    rows, columns = (slice(max(s.start - REACH_PX, 0), s.stop + REACH_PX) for s in box)
    labels = segmentation.labels[rows, columns]
    mask = (labels == label).astype(np.uint8)
    ring = cv2.dilate(mask, np.ones((2 * REACH_PX + 1, 2 * REACH_PX + 1), np.uint8)) > mask
    highest = table
    for other in np.unique(labels[ring]).tolist():
        if other in (0, label) or not len(clouds[other]):
            continue
        top = quantile(support.height(clouds[other]), TOP_SHARE)
        above = bottom > top - CONTACT_TOLERANCE and top > highest.height
        if above and _share_above(clouds[label], clouds[other], support) > MIN_OVERLAP:
            highest = SurfaceBelow(top, other)
    return highest


def rests_on(
    cloud: NDArray[np.float64],
    fit: SuperquadricFit,
    below: SurfaceBelow,
    support: SupportPlane | None,
) -> int | None:
    """Return the label of the object under this one, 0 for the support plane, None if unknown."""
    if support is None or not len(cloud):
        return None
    if below.label > 0:
        return below.label
    solid = fit.superquadric
    if solid is None or not fit:
        bottom = quantile(support.height(cloud), BOTTOM_SHARE)
    else:
        parts = fit.parts or (solid,)
        bottom = support.offset - max(float(part.support(-support.normal)) for part in parts)
    return 0 if bottom < MAX_BOTTOM_HEIGHT else None


def _share_above(
    upper: NDArray[np.float64], lower: NDArray[np.float64], support: SupportPlane
) -> float:
    """Return the share of the upper object's points inside the lower one's outline in plan."""
    axes = perpendicular_pair(support.normal)
    hull = cv2.convexHull((lower @ axes.T).astype(np.float32))
    plan = upper[:: max(len(upper) // PLAN_POINTS, 1)] @ axes.T
    inside = [cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0 for x, y in plan]
    return float(np.mean(inside))
