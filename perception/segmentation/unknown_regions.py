"""Find the regions of a support without readings: transparent, shiny or dark things."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from ..frame import CameraIntrinsics
from .above_support import SUPPORT_SIGMAS
from .block_heights import BLOCK, LOWEST
from .hull_depth import depth_in_hull
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
"""Minimum share of the support among the readings of the ring around a region, or of its near half.
Before a shadow stands the object that casts it."""
MIN_READ = 0.5
"""Minimum share of the ring with readings. The shadows of other things may hide the rest."""
MIN_INSIDE = 0.02
"""Minimum distance of a region's foot from the edge of the support, m. Beyond an edge the camera
often reads nothing."""
MIN_SLOPE = 1e-3
"""Minimum slope at which a ray meets the support. Less steep rays count as this steep."""
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
    tops: NDArray[np.float32], image: WorkingImage, support: Support, *, walls: bool = False
) -> tuple[UnknownRegion, ...]:
    """Find the regions without readings in the middle of a support, largest first.

    Parameters
    ----------
    tops
        Heights of the blocks above the support, from :func:`~.block_heights.block_heights`.
    image
        The whole image. What is masked in it is no region.
    support
        The support.
    walls
        Whether walls stand on the support. As they cast long shadows, the whole ring must then show
        the support.
    """
    empty = tops <= LOWEST
    band = max(2 * SUPPORT_SIGMAS * support.plane.tolerance, MIN_BAND)
    on_support = np.abs(tops) <= band
    hidden = (empty & ~_shadows(tops, band, image, support)).astype(np.uint8)
    if image.masked is not None:
        hidden[_any_in_blocks(image.masked, image.length(BLOCK))] = 0
    core = cv2.morphologyEx(hidden, cv2.MORPH_OPEN, np.ones((MIN_WIDTH,) * 2, np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=8)
    rows, columns = tops.shape
    regions: list[tuple[float, UnknownRegion]] = []
    for part in range(1, count):
        left, top, width, height = (int(value) for value in stats[part, :4])
        if left < 2 or top < 2 or left + width > columns - 2 or top + height > rows - 2:
            continue
        window = slice(top - 2, top + height + 2), slice(left - 2, left + width + 2)
        corner = left - 2, top - 2
        mask = (labels[window] == part).astype(np.uint8)
        # The ring keeps a distance of one block from the region, because edges have no readings.
        inner = cv2.dilate(mask, np.ones((3, 3), np.uint8))
        ring = cv2.dilate(inner, np.ones((3, 3), np.uint8)) > inner
        foot = _block_plan(mask > 0, corner, image, support)
        inside = np.asarray(depth_in_hull(foot, support.hull))
        if inside.max() < MIN_INSIDE:
            continue
        foot = foot[inside > 0]
        middle = foot.mean(axis=0)
        # A thing hides what lies behind it: the near half of the ring is enough.
        near = _block_plan(ring, corner, image, support) @ middle <= middle @ middle
        shown, read = on_support[window][ring], ~empty[window][ring]
        if walls:
            share = float(np.mean(shown))
        else:
            share = max(_share(shown[near], read[near]), _share(shown, read))
        if share < MIN_SUPPORT_RING:
            continue
        area, region = _bounded_region(_blocks(inner > 0, corner), foot, image, support)
        if MIN_AREA <= area <= MAX_AREA:
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


def _any_in_blocks(mask: NDArray[np.bool_], side: int) -> NDArray[np.bool_]:
    """Mark the blocks of side x side px that contain a pixel of a mask (H, W)."""
    rows, columns = (np.arange(0, size, side) for size in mask.shape)
    return np.logical_or.reduceat(np.logical_or.reduceat(mask, rows, axis=0), columns, axis=1)


def _share(shown: NDArray[np.bool_], read: NDArray[np.bool_]) -> float:
    """Return the share of blocks (N,) that show the support among those with readings."""
    return float(np.mean(shown[read])) if np.mean(read) >= MIN_READ else 0.0


def _blocks(mask: NDArray[np.bool_], corner: tuple[int, int]) -> NDArray[np.intp]:
    """Return columns and rows (N, 2) of the blocks of a mask whose first block is `corner`."""
    return np.argwhere(mask)[:, ::-1] + corner


def _block_plan(
    mask: NDArray[np.bool_], corner: tuple[int, int], image: WorkingImage, support: Support
) -> NDArray[np.float64]:
    """Return where the rays through the middles of blocks meet the support, in plan (N, 2), m."""
    middles = ((_blocks(mask, corner) + 0.5) * image.length(BLOCK)).astype(np.float64)
    return _in_plan(_rays(middles, image.intrinsics), support)


def _rays(pixels: NDArray[np.float64], k: CameraIntrinsics) -> NDArray[np.float64]:
    """Return the viewing rays (N, 3) of depth 1 through corners of pixels (N, 2)."""
    x, y = (pixels[:, 0] - 0.5 - k.cx) / k.fx, (pixels[:, 1] - 0.5 - k.cy) / k.fy
    return np.column_stack([x, y, np.ones(len(pixels))])


def _in_plan(rays: NDArray[np.float64], support: Support) -> NDArray[np.float64]:
    """Return where rays (N, 3) meet the support, in plan (N, 2), m. Level rays meet it far away."""
    slope = np.minimum(rays @ support.plane.normal, -MIN_SLOPE)
    return rays @ support.axes.T * (-support.plane.offset / slope)[:, None]


def _bounded_region(
    places: NDArray[np.intp], foot: NDArray[np.float64], image: WorkingImage, support: Support
) -> tuple[float, UnknownRegion]:
    """Return the area on the support, m², and the region of blocks (N, 2).

    `foot` are the middles of the blocks over the support in plan (K, 2), m.
    """
    side, plane = image.length(BLOCK), support.plane
    corners = (places[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])).reshape(-1, 2) * side
    outline = cv2.convexHull(corners.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    rays = _rays(outline, image.intrinsics)
    plan = _in_plan(rays, support)
    # The foot of a thing lies over the support, and the ray over its top meets the far side. The
    # plan coordinates of the camera are 0.
    middle = foot.mean(axis=0)
    away = middle / max(float(np.linalg.norm(middle)), 1e-9)
    ranges = plan @ away
    steepness = plane.offset / np.maximum(np.linalg.norm(plan, axis=1), 1e-6)
    height = min(float(np.ptp(ranges) * steepness.max()), MAX_HEIGHT)
    # Beyond the edge of the support there is nothing of the thing.
    within = ranges[np.asarray(depth_in_hull(plan, support.hull)) > 0]
    slope = np.minimum(rays @ plane.normal, -MIN_SLOPE)
    farthest = max(np.max(foot @ away), np.max(within, initial=0.0))
    reach = farthest / np.maximum(rays @ support.axes.T @ away, 1e-9)
    base = rays * np.minimum(-plane.offset / slope, reach)[:, None]
    top = rays * np.minimum((height - plane.offset) / slope, reach)[:, None]
    area = float(cv2.contourArea(cv2.convexHull(foot.astype(np.float32))))
    return area, UnknownRegion(outline - 0.5, np.vstack([base, top]), height)
