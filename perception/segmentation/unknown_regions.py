"""Find the regions of a support without readings: transparent, shiny or dark things."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from .above_support import SUPPORT_SIGMAS
from .block_heights import BLOCK, LOWEST
from .support_extent import Support
from .working_image import WorkingImage

BASELINE = 0.075
"""Distance between the two eyes of a camera, or between its eye and projector, m. It bounds the
width of the shadow that an object casts on the image."""
MIN_WIDTH = 3
"""Minimum width of a region, blocks. Narrower ones are edges and accidental dropout."""
MIN_AREA = 4e-4
"""Minimum area of a region on the support, m²: 2 x 2 cm."""
MAX_AREA = 0.06
"""Maximum area of a region on the support, m²: 0.3 x 0.2 m. Larger ones are out of reach of the
camera's projector, or a hole of the table."""
MIN_BAND = 0.012
"""Minimum height of a block above the support, m. The highest of its readings counts."""
MIN_SUPPORT_RING = 0.7
"""Minimum share of the ring around a region that shows the support. Beside a shadow stands the
object that casts it."""
MAX_HEIGHT = 0.3
"""Maximum height of what a region may hide, m."""
MAX_SHADOW = 16
"""Maximum width of a shadow, blocks. It bounds the time."""
MAX_REGIONS = 16
"""Maximum number of regions, the largest first."""


@dataclass(frozen=True)
class UnknownRegion:
    """A region of a support where the camera reads nothing. Something may stand there."""

    outline: NDArray[np.float64]
    """Convex outline in the image, columns and rows (K, 2), px."""
    corners: NDArray[np.float64]
    """Points (2 K, 3) whose convex hull holds all that the region may hide, m: on the support, then
    at `height` above it, on the rays through the outline."""
    height: float
    """Maximum height of what the region may hide above the support, m."""

    def enlarged(self, stride: int) -> UnknownRegion:
        """Return the region of the whole frame, for one in every `stride`-th row and column."""
        return replace(self, outline=stride * self.outline)

    def moved(self, T_a_b: RigidTransform) -> UnknownRegion:
        """Return the region in frame a, for a region in frame b."""
        return replace(self, corners=T_a_b.apply(self.corners))


def find_unknown(
    tops: NDArray[np.float32], image: WorkingImage, support: Support
) -> tuple[UnknownRegion, ...]:
    """Find the regions without readings in the middle of a support, largest first.

    Parameters
    ----------
    tops
        Heights of the blocks above the support, from :func:`~.block_heights.block_heights`.
    image
        The whole image.
    support
        The support.
    """
    empty = tops <= LOWEST
    band = max(2 * SUPPORT_SIGMAS * support.plane.tolerance, MIN_BAND)
    on_support = np.abs(tops) <= band
    hidden = (empty & ~_shadows(tops, band, image, support)).astype(np.uint8)
    core = cv2.morphologyEx(hidden, cv2.MORPH_OPEN, np.ones((MIN_WIDTH,) * 2, np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=8)
    rows, columns = tops.shape
    regions: list[tuple[float, UnknownRegion]] = []
    for part in range(1, count):
        left, top, width, height = (int(value) for value in stats[part, :4])
        if left < 2 or top < 2 or left + width > columns - 2 or top + height > rows - 2:
            continue
        window = slice(top - 2, top + height + 2), slice(left - 2, left + width + 2)
        mask = (labels[window] == part).astype(np.uint8)
        # The ring keeps a distance of one block from the region, because edges have no readings.
        inner = cv2.dilate(mask, np.ones((3, 3), np.uint8))
        ring = cv2.dilate(inner, np.ones((3, 3), np.uint8)) > inner
        if np.mean(on_support[window][ring]) < MIN_SUPPORT_RING:
            continue
        places = np.argwhere(inner)[:, ::-1] + [left - 2, top - 2]
        area, region = _bounded_region(places, image, support)
        if region is not None and MIN_AREA <= area <= MAX_AREA:
            regions.append((area, region))
    regions.sort(key=lambda item: -item[0])
    return tuple(region for _, region in regions[:MAX_REGIONS])


def _shadows(
    tops: NDArray[np.float32], band: float, image: WorkingImage, support: Support
) -> NDArray[np.bool_]:
    """Mark the blocks that the shadow of a reading above the support may reach."""
    z, side = support.depth, image.length(BLOCK)
    shadow = np.zeros(tops.shape, np.uint8)
    above = tops > band
    # A block of height h is nearer by at most h. It hides at most f B h / (z (z - h)) px.
    nearer = np.minimum(np.where(above, tops, 0.0), 0.8 * z)
    widths = image.intrinsics.fx * BASELINE * nearer / (z * (z - nearer)) / side
    reaches = np.minimum(np.ceil(widths), MAX_SHADOW).astype(np.intp)
    for reach in np.unique(reaches[above]).tolist():
        kernel = np.ones((3, 2 * reach + 1), np.uint8)
        casting = (above & (reaches == reach)).astype(np.uint8)
        shadow |= np.asarray(cv2.dilate(casting, kernel), np.uint8)
    return shadow > 0


def _bounded_region(
    places: NDArray[np.intp], image: WorkingImage, support: Support
) -> tuple[float, UnknownRegion | None]:
    """Return the area on the support, m², and the region of blocks (N, 2); None if outside."""
    k, side, plane = image.intrinsics, image.length(BLOCK), support.plane
    corners = (places[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])).reshape(-1, 2) * side
    outline = cv2.convexHull(corners.astype(np.float32)).reshape(-1, 2).astype(np.float64) - 0.5
    rays = np.column_stack(
        [(outline[:, 0] - k.cx) / k.fx, (outline[:, 1] - k.cy) / k.fy, np.ones(len(outline))]
    )
    slope = rays @ plane.normal
    if slope.max() > -1e-3:
        return 0.0, None
    base = rays * (-plane.offset / slope)[:, None]
    plan = (base @ support.axes.T).astype(np.float32)
    middle = plan.mean(axis=0)
    if cv2.pointPolygonTest(support.hull, (float(middle[0]), float(middle[1])), False) < 0:
        return 0.0, None
    # The foot of a thing lies in the region, and the ray over its top meets the far side. The plan
    # coordinates of the camera are 0.
    away = middle / max(float(np.linalg.norm(middle)), 1e-9)
    steepness = plane.offset / np.maximum(np.linalg.norm(plan, axis=1), 1e-6)
    height = min(float(np.ptp(plan @ away) * steepness.max()), MAX_HEIGHT)
    top = rays * ((height - plane.offset) / slope)[:, None]
    return float(cv2.contourArea(plan)), UnknownRegion(outline, np.vstack([base, top]), height)
