"""The visible parts of a support plane, and the evidence for and against it."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .above_support import SUPPORT_SIGMAS
from .connected_parts import connected_parts
from .result import SupportPlane
from .working_image import WorkingImage

LOCATE_WIDTH = 320
"""Columns of the reduced image in which the parts of a plane are found."""
MIN_PART = 0.0015
"""Minimum area of a part of a support, m². Smaller parts are accidental intersections."""
MAX_PARTS = 16
"""Maximum number of parts, the heaviest first. It bounds the time in clutter."""
MIN_DEPTH = 0.3
"""Nearer pixels weigh no more than those at this depth, m. Otherwise a gripper in front of the lens
would outweigh the table."""
BELOW_BANDS = 2.0
"""Depth below a plane, in bands, from which a reading contradicts it."""
BELOW_MIN = 0.01
"""The same in m. Both must hold."""
MIN_SLANT = 0.05
"""Minimum cosine between the viewing ray and the normal that is used for areas."""


class Support(NamedTuple):
    """A plane that objects may stand on, and its visible parts."""

    plane: SupportPlane
    """The plane, camera frame."""
    hull: NDArray[np.float32]
    """Convex hull of the visible parts in plan coordinates, (K, 2), m."""
    axes: NDArray[np.float64]
    """Axes of the plan coordinates as rows, (2, 3), camera frame."""
    depth: float
    """Median depth at which the scatter of the plane was measured, m."""
    area: float = 0.0
    """Visible area, m²."""
    wave: float = 0.0
    """Height that the waves of the plane reach, divided by squared depth, 1/m."""
    score: float = 0.0
    """Weight of the readings on the plane minus that of the readings below it, within its hull."""
    share_below: float = 0.0
    """Weight of the readings below the plane within its hull, divided by that of those on it."""
    runner_up: Support | None = None
    """The rejected plane with the best score, for the first support."""
    foot_margin: float | None = None
    """Minimum distance of an object's foot inside the hull, m, if walls bound the support. If None,
    objects may overhang it."""


class _PlaneView(NamedTuple):
    """A plane in the reduced image; all arrays (H, W)."""

    on: NDArray[np.uint8]
    """1 where a reading lies on the plane."""
    below: NDArray[np.float32]
    """Weights of the readings below the plane."""
    weight: NDArray[np.float32]
    """Weight of each pixel: its solid angle over the squared depth of the plane there."""
    area: NDArray[np.float32]
    """Area of each pixel on the plane, m²."""


def locate_support(plane: SupportPlane, depth: float, image: WorkingImage) -> Support | None:
    """Find the visible parts of a plane; None if it has none.

    Clutter cuts a table into parts. The heaviest part comes first. Another part is added if it
    weighs more than the readings below the plane that the convex hull of all parts then gains.
    Such readings show that the plane does not continue there.

    Parameters
    ----------
    plane
        The plane in the camera frame.
    depth
        Median depth of its readings, m.
    image
        The whole image.
    """
    stride = -(-image.intrinsics.width // LOCATE_WIDTH)
    view = _view_plane(plane, depth, image, stride)
    labels, sizes, boxes = connected_parts(view.on)
    weights, areas = sum_parts(labels, len(sizes), view.weight, view.area)
    order = np.argsort(-weights, kind="stable")[:MAX_PARTS]
    order = order[(areas[order] >= MIN_PART) & (weights[order] > 0)]
    if not len(order):
        return None
    kept = [int(order[0])]
    hull = _image_hull(labels, kept[0], boxes[kept[0]])
    contradicted = bool(view.below.any())
    against = _weight_below(hull, view) if contradicted else 0.0
    for part in order[1:]:
        both = np.concatenate([hull, _image_hull(labels, int(part), boxes[part])])
        larger = np.asarray(cv2.convexHull(both), np.int32)
        more = _weight_below(larger, view) if contradicted else 0.0
        if weights[part] > more - against:
            kept.append(int(part))
            hull, against = larger, more
    axes = perpendicular_pair(plane.normal)
    weight = float(weights[kept].sum())
    return Support(
        plane,
        _to_plan(hull, plane, axes, image, stride),
        axes,
        depth,
        area=float(areas[kept].sum()),
        score=weight - against,
        share_below=against / weight,
    )


def _view_plane(plane: SupportPlane, depth: float, image: WorkingImage, stride: int) -> _PlaneView:
    k = image.intrinsics.reduced(stride)
    z = np.ascontiguousarray(image.depth[::stride, ::stride])
    nx, ny, nz = plane.normal
    slope_u = (nx * (np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    slope_v = (ny * (np.arange(k.height) - k.cy) / k.fy + nz).astype(np.float32)
    # The scatter of a plane grows with z², the noise of one reading on it with z.
    scatter = SUPPORT_SIGMAS * plane.tolerance / max(depth, 1e-6) ** 2
    noise = SUPPORT_SIGMAS * image.noise * abs(plane.offset)
    on, below, weight, area = weigh_readings(
        z, (slope_u, slope_v), plane.offset, (scatter, noise), 1.0 / (k.fx * k.fy)
    )
    on = cv2.morphologyEx(on, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)).astype(np.uint8)
    return _PlaneView(on, below, weight, area)


@njit(cache=True, nogil=True, error_model="numpy")
def weigh_readings(depth, slopes, offset, spread, solid_angle):
    """Compute the fields of `_PlaneView` for one plane.

    Parameters
    ----------
    depth
        (H, W) float32, m; 0 = no reading.
    slopes
        Parts of n·ray that depend on the column (W,) and on the row (H,).
    offset
        Offset of the plane, m.
    spread
        Half width of the band: its part per z², 1/m, and its part per z.
    solid_angle
        Solid angle of a pixel, sr.
    """
    rows, columns = depth.shape
    slope_u, slope_v = slopes
    on = np.empty((rows, columns), np.uint8)
    below = np.empty((rows, columns), np.float32)
    weight = np.empty((rows, columns), np.float32)
    area = np.empty((rows, columns), np.float32)
    max_weight = solid_angle / MIN_DEPTH**2
    for v in range(rows):
        row, on_row, below_row = depth[v], on[v], below[v]
        weight_row, area_row = weight[v], area[v]
        slope_here = np.float64(slope_v[v])
        # Without branches the compiler handles several pixels at once.
        for u in range(columns):
            slope = np.float64(slope_u[u]) + slope_here
            z = np.float64(row[u])
            seen = (z > 0) & (slope <= -1e-3)
            height = z * slope + offset
            band = max(spread[0] * z * z, spread[1] * z)
            # The plane is -offset / slope deep here.
            inverse = slope / offset
            value = min(solid_angle * inverse * inverse, max_weight)
            lies_on = seen & (abs(height) < band)
            lies_below = seen & (not lies_on) & (height < -max(BELOW_BANDS * band, BELOW_MIN))
            on_row[u] = lies_on
            below_row[u] = value if lies_below else 0.0
            weight_row[u] = value if lies_on else 0.0
            spanned = solid_angle / (inverse * inverse * max(-slope, MIN_SLANT))
            area_row[u] = spanned if lies_on else 0.0
    return on, below, weight, area


@njit(cache=True, nogil=True)
def sum_parts(labels, count, weight, area):
    """Return the sums of weight and area (H, W) over each label 1..`count` - 1, 0 for label 0."""
    weights, areas = np.zeros(count), np.zeros(count)
    rows, columns = labels.shape
    for v in range(rows):
        # A run of equal labels needs no access to the sums.
        present, total, spanned = 0, 0.0, 0.0
        for u in range(columns):
            label = labels[v, u]
            if label != present:
                weights[present], areas[present] = total, spanned
                present, total, spanned = label, weights[label], areas[label]
            if label > 0:
                total += weight[v, u]
                spanned += area[v, u]
        weights[present], areas[present] = total, spanned
    return weights, areas


def _image_hull(labels: NDArray[np.int32], part: int, box: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the convex hull (K, 1, 2) of a part in the image from its box."""
    return np.asarray(cv2.convexHull(row_ends(labels, part, box)), np.int32)


@njit(cache=True, nogil=True)
def row_ends(labels, part, box):
    """Return the first and last pixel of a part in each row of its box, (N, 2) column, row."""
    top, left, bottom, right = box
    ends = np.empty((2 * (bottom - top), 2), np.int32)
    count = 0
    for v in range(top, bottom):
        first, last = left, right - 1
        while first < right and labels[v, first] != part:
            first += 1
        if first == right:
            continue
        while labels[v, last] != part:
            last -= 1
        ends[count, 0], ends[count, 1] = first, v
        ends[count + 1, 0], ends[count + 1, 1] = last, v
        count += 2
    return ends[:count]


def _weight_below(hull: NDArray[np.int32], view: _PlaneView) -> float:
    """Return the weight of the readings below the plane inside a hull."""
    left, top, width, height = cv2.boundingRect(hull)
    inside = np.zeros((height, width), np.uint8)
    cv2.fillConvexPoly(inside, hull - np.array([left, top]), 1)
    return float((view.below[top : top + height, left : left + width] * inside).sum())


def _to_plan(
    hull: NDArray[np.int32],
    plane: SupportPlane,
    axes: NDArray[np.float64],
    image: WorkingImage,
    stride: int,
) -> NDArray[np.float32]:
    """Convert a hull from pixels to plan coordinates. A projection keeps convexity."""
    k = image.intrinsics.reduced(stride)
    pixels = hull.reshape(-1, 2)
    rays = np.column_stack(
        [(pixels[:, 0] - k.cx) / k.fx, (pixels[:, 1] - k.cy) / k.fy, np.ones(len(pixels))]
    )
    on_plane = rays * (-plane.offset / (rays @ plane.normal))[:, None]
    return (on_plane @ axes.T).astype(np.float32)
