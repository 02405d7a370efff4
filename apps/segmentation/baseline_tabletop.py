"""Detect the table and clean the labels: the first and last step of all baselines.

Open3D's RANSAC detects the table on every fourth row and column. The full cloud takes ten times as
long and gave no better plane on the compared frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import cv2
import numpy as np

from ..open3d_import import import_open3d

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import CameraIntrinsics, DepthFrame

PLANE_STRIDE = 4
"""Distance of the rows and columns used to detect the plane, px."""
PLANE_BAND_M = 0.01
"""Inlier distance of the plane."""
PLANE_ITERATIONS = 300
"""RANSAC iterations."""
CLEARANCE_M = 0.004
"""Height above the plane at which objects start. The best of 4, 8 and 12 mm for most baselines:
more cuts off low objects, less keeps table noise."""
OUTSIDE_M = 0.01
"""Maximum distance of object points outside the hull of the table."""
MIN_OBJECT_PX = 400
"""Smaller segments are noise: the best of 100, 200, 400 and 800 for most baselines."""
STEP_SHARE = 0.008
"""A step in depth by more than this fraction of the depth is an edge."""
NORMAL_WINDOW = 7
"""Window of the normals, px: the largest of OpenCV's least squares."""
RIM_PX = 6
"""Unlabelled pixels join the nearest segment within this distance."""


@dataclass(frozen=True)
class Tabletop:
    """The support plane of a frame and the pixels above it."""

    points: NDArray[np.float32]
    """Organised cloud in the camera frame, (H, W, 3), m."""
    above: NDArray[np.bool_]
    """Mask of the pixels above the table, (H, W)."""
    up: NDArray[np.float64]
    """Normal of the table towards the camera, (3,)."""


def find_tabletop(frame: DepthFrame, clearance: float = CLEARANCE_M) -> Tabletop:
    """Detect the support plane and the pixels above it. Without a plane there are no such pixels.

    Parameters
    ----------
    frame
        Depth frame.
    clearance
        Minimum height of object points above the plane at 1 m, m. It grows with depth squared.
    """
    points = frame.points()
    coarse = points[::PLANE_STRIDE, ::PLANE_STRIDE]
    valid = coarse[..., 2] > 0
    cloud = coarse[valid].astype(np.float64)
    nothing = np.zeros(frame.depth.shape, bool)
    if len(cloud) < 3:
        return Tabletop(points, nothing, np.array([0.0, 0.0, -1.0]))
    o3d = import_open3d()
    o3d.utility.random.seed(0)
    pcd = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud))
    plane, inliers = pcd.segment_plane(PLANE_BAND_M, 3, PLANE_ITERATIONS)
    # The camera at the origin is above the table.
    plane = np.asarray(plane) * (1.0 if plane[3] > 0 else -1.0)
    up, offset = plane[:3], plane[3]
    height = points @ up.astype(np.float32) + np.float32(offset)
    above = frame.valid & (height > clearance * np.maximum(frame.depth, 1.0) ** 2)
    on_plane = np.zeros(valid.shape, np.uint8)
    on_plane[valid] = np.isin(np.arange(len(cloud)), inliers)
    above &= _over_table(points, above, coarse, on_plane, up)
    return Tabletop(points, above, up)


def normals_of(frame: DepthFrame) -> NDArray[np.float32]:
    """Return unit normals towards the camera by OpenCV's FALS, (H, W, 3); 0 = none."""
    points = np.dstack([frame.points(), np.ones_like(frame.depth)])
    points[~frame.valid] = np.nan
    normals = np.asarray(_normal_estimator(frame.intrinsics).apply(points), np.float32)
    return np.nan_to_num(normals[..., :3])


@lru_cache(maxsize=4)
def _normal_estimator(camera: CameraIntrinsics) -> cv2.RgbdNormals:
    """Return the estimator of a camera, cached: its tables take ten times as long as a frame."""
    return cv2.RgbdNormals.create(
        camera.height,
        camera.width,
        cv2.CV_32F,
        camera.matrix.astype(np.float32),
        NORMAL_WINDOW,
        0.0,
        cv2.RgbdNormals_RGBD_NORMALS_METHOD_FALS,
    )


def finish(labels: NDArray[np.integer], above: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Drop small segments and give unlabelled pixels to the nearest large segment.

    Parameters
    ----------
    labels
        (H, W); 0 and below = none.
    above
        Pixels that may belong to objects, (H, W).

    Returns
    -------
    NDArray
        (H, W) int32, 0 = none.
    """
    kept = np.where(above & (labels > 0), labels, 0)
    sizes = np.bincount(kept.ravel())
    renumber = np.zeros(len(sizes), np.int32)
    large = np.flatnonzero(sizes >= MIN_OBJECT_PX)
    large = large[large > 0]
    renumber[large] = np.arange(1, len(large) + 1)
    kept = renumber[kept]
    if not len(large):
        return kept
    return spread(kept, above, RIM_PX)


def spread(labels: NDArray[np.int32], above: NDArray[np.bool_], reach: float) -> NDArray[np.int32]:
    """Label the unlabelled pixels of `above` like their nearest segment within `reach` px.

    Parameters
    ----------
    labels
        (H, W) int32; 0 = none.
    above
        Pixels that may belong to objects, (H, W).
    reach
        Maximum distance, px.

    Returns
    -------
    NDArray
        (H, W) int32.
    """
    seeds = labels > 0
    if not seeds.any():
        return labels
    distance, nearest = cv2.distanceTransformWithLabels(
        (~seeds).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    distance, nearest = np.asarray(distance), np.asarray(nearest, np.int32)
    # OpenCV numbers every seed pixel separately. This maps the numbers back to segments.
    source = np.zeros(int(nearest.max()) + 1, np.int32)
    source[nearest[seeds]] = labels[seeds]
    rim = above & ~seeds & (distance <= reach)
    spread_labels = labels.copy()
    spread_labels[rim] = source[nearest[rim]]
    return spread_labels


def _over_table(
    points: NDArray[np.float32],
    above: NDArray[np.bool_],
    coarse: NDArray[np.float32],
    on_plane: NDArray[np.uint8],
    up: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Return the pixels above the hull of the largest visible part of the plane, (H, W)."""
    over = np.zeros(above.shape, bool)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(on_plane, connectivity=8)
    if len(stats) < 2:
        return over
    table = coarse[np.asarray(parts) == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))]
    along = np.cross(up, [0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0])
    along /= np.linalg.norm(along)
    axes = np.array([along, np.cross(up, along)]).astype(np.float32)
    hull = cv2.convexHull(table @ axes.T)[:, 0]
    edges = np.roll(hull, -1, axis=0) - hull
    outward = np.column_stack([edges[:, 1], -edges[:, 0]])
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
    # The orientation of OpenCV's hulls varies. The centre is inside.
    if np.sum(outward * (hull.mean(axis=0) - hull)) > 0:
        outward = -outward
    feet = points[above] @ axes.T
    outside = np.full(len(feet), -np.inf, np.float32)
    for corner, normal in zip(hull, outward, strict=True):
        np.maximum(outside, (feet - corner) @ normal, out=outside)
    over[above] = outside < OUTSIDE_M
    return over
