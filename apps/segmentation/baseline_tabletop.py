"""First and last step of all baselines: find the table, and clean the labels.

Open3D's RANSAC finds the table on every fourth row and column. The full cloud takes ten times as
long and gave no better plane on the frames that were compared.
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
PLANE_BAND_M = 0.01
"""Points this near the plane are the plane's."""
PLANE_TRIES = 300
CLEARANCE_M = 0.004
"""Best of 4, 8 and 12 mm for most baselines. More cuts off low objects, less keeps table noise."""
OUTSIDE_M = 0.01
"""How far outside the table's hull an object's points may lie."""
MIN_OBJECT_PX = 400
"""Smaller segments are noise: the best of 100, 200, 400 and 800 for most baselines."""
STEP_SHARE = 0.008
"""A step in depth by more than this share of it is an edge."""
NORMAL_WINDOW = 7
"""Largest that OpenCV's least squares take."""
RIM_PX = 6
"""Left-over pixels join the nearest segment within this distance."""


@dataclass(frozen=True)
class Tabletop:
    """What stands on the support plane of a frame."""

    points: NDArray[np.float32]
    """Organised cloud in the camera frame, (H, W, 3), m."""
    above: NDArray[np.bool_]
    """Pixels of what stands on the table, (H, W)."""
    up: NDArray[np.float64]
    """Normal of the table towards the camera, (3,)."""


def find_tabletop(frame: DepthFrame, clearance: float = CLEARANCE_M) -> Tabletop:
    """Find the support plane and what stands on it; nothing does where no plane is found.

    Parameters
    ----------
    frame
        What the camera saw.
    clearance
        How far above the plane an object's points are at 1 m, growing with depth squared, m.
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
    plane, inliers = pcd.segment_plane(PLANE_BAND_M, 3, PLANE_TRIES)
    # The camera, at the origin, sees the table from above.
    plane = np.asarray(plane) * (1.0 if plane[3] > 0 else -1.0)
    up, offset = plane[:3], plane[3]
    height = points @ up.astype(np.float32) + np.float32(offset)
    above = frame.valid & (height > clearance * np.maximum(frame.depth, 1.0) ** 2)
    on_plane = np.zeros(valid.shape, np.uint8)
    on_plane[valid] = np.isin(np.arange(len(cloud)), inliers)
    above &= _over_table(points, above, coarse, on_plane, up)
    return Tabletop(points, above, up)


def normals_of(frame: DepthFrame) -> NDArray[np.float32]:
    """Unit normals towards the camera by OpenCV's least squares (FALS), (H, W, 3); 0 = none."""
    points = np.dstack([frame.points(), np.ones_like(frame.depth)])
    points[~frame.valid] = np.nan
    normals = np.asarray(_normal_estimator(frame.intrinsics).apply(points), np.float32)
    return np.nan_to_num(normals[..., :3])


@lru_cache(maxsize=4)
def _normal_estimator(camera: CameraIntrinsics) -> cv2.RgbdNormals:
    """Keep one per camera: its tables take ten times longer than its normals."""
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
    """Drop small segments, give their pixels and left-over ones to the nearest large one near by.

    Parameters
    ----------
    labels
        (H, W); 0 and below = none.
    above
        Pixels that may become an object's, (H, W).

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
    """Let segments grow over pixels of `above` that have none, each to the nearest within reach px.

    Parameters
    ----------
    labels
        (H, W) int32; 0 = none.
    above
        Pixels that may become an object's, (H, W).
    reach
        Farthest pixel, px.

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
    # OpenCV numbers the pixels at distance 0 one by one; here each gets its segment's number back.
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
    """Whether the pixels above the plane lie over the hull of its largest part in view."""
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
    # The orientation of OpenCV's hulls varies; the centre decides which side is inside.
    if np.sum(outward * (hull.mean(axis=0) - hull)) > 0:
        outward = -outward
    feet = points[above] @ axes.T
    outside = np.full(len(feet), -np.inf, np.float32)
    for corner, normal in zip(hull, outward, strict=True):
        np.maximum(outside, (feet - corner) @ normal, out=outside)
    over[above] = outside < OUTSIDE_M
    return over
