"""Common segmentation methods without training, as baselines in the chart.

Each is a short implementation with library calls on the same table detection
(`baseline_tabletop.py`). The chart sweeps one dial of each, so that its best setting is shown. The
other constants were chosen by mean overlap F on development data: every second frame of the mOSD
learn half and twelve synthetic frames with realistic noise (seeds 9000 to 9011: separate, touching
and stacked). Therefore a chart of the learn half favours the baselines a little. Synthetic seeds
from 0 are frames on which nothing was chosen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from eyehand.perception import DepthFrame

from ..open3d_import import import_open3d
from .baseline_tabletop import STEP_SHARE, Tabletop, find_tabletop, finish, normals_of, spread


@dataclass(frozen=True)
class Baseline:
    """A common segmentation method."""

    name: str
    """For the chart."""
    why: str
    """Reason to compare with it, one line."""
    dial: str
    """The swept parameter with its unit."""
    settings: tuple[float, ...]
    """Values of the dial."""
    run: Callable[[DepthFrame, float], NDArray[np.int32]]
    """Label the objects of a frame at a value of the dial, (H, W) int32; 0 = not an object."""


def open3d_dbscan(frame: DepthFrame, voxel: float) -> NDArray[np.int32]:
    """Cluster the points above the table with Open3D's DBSCAN, in voxels of `voxel` m."""
    table = find_tabletop(frame)
    labels = np.zeros(frame.depth.shape, np.int32)
    points = table.points[table.above].astype(np.float64)
    if len(points) < DBSCAN_POINTS:
        return labels
    cells = np.floor((points - points.min(axis=0)) / voxel).astype(np.int64)
    spans = cells.max(axis=0) + 1
    keys = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    _, cell_of_point, counts = np.unique(keys, return_inverse=True, return_counts=True)
    centres = np.column_stack([np.bincount(cell_of_point, points[:, k]) / counts for k in range(3)])
    geometry = import_open3d().geometry.PointCloud()
    geometry.points = import_open3d().utility.Vector3dVector(centres)
    clusters = geometry.cluster_dbscan(eps=DBSCAN_REACH * voxel, min_points=DBSCAN_POINTS)
    # Every pixel gets its voxel's label; -1 is noise.
    labels[table.above] = np.asarray(clusters)[cell_of_point] + 1
    return finish(labels, table.above)


def normal_edges(frame: DepthFrame, angle: float) -> NDArray[np.int32]:
    """Join convex neighbours among patches separated by normal edges of over `angle` rad."""
    table = find_tabletop(frame)
    normals = normals_of(frame)
    cosine = np.cos(angle)
    z = np.asarray(cv2.medianBlur(frame.depth, 5), np.float32)
    step = np.asarray(cv2.morphologyEx(z, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)))
    smooth = table.above & (step < STEP_SHARE * z)
    for axis in (0, 1):
        agree = _cosine(normals, axis) > cosine
        smooth &= agree & np.roll(agree, NORMAL_REACH, axis)
    patches = cv2.connectedComponents(smooth.astype(np.uint8), connectivity=4)[1]
    patches = np.asarray(patches, np.int32)
    return join_convex(patches, table, normals, min_border=SURFACE_BORDER, extended=False)


def slic_lccp(frame: DepthFrame, patch_pixels: float) -> NDArray[np.int32]:
    """Join locally convex patches of scikit-image's SLIC on points and normals."""
    from skimage.segmentation import slic

    table = find_tabletop(frame, LCCP_CLEARANCE_M)
    if not table.above.any():
        return table.above.astype(np.int32)
    normals = normals_of(frame)
    u, v, width, height = cv2.boundingRect(table.above.astype(np.uint8))
    box = slice(v, v + height), slice(u, u + width)
    features = np.dstack([table.points / SLIC_SIZE_M, normals])
    patches = np.zeros(frame.depth.shape, np.int32)
    patches[box] = slic(
        features[box].astype(np.float64),
        n_segments=max(int(table.above[box].size / patch_pixels), 1),
        compactness=SLIC_COMPACTNESS,
        max_num_iter=5,
        start_label=1,
        channel_axis=2,
        enforce_connectivity=True,
    )
    return join_convex(patches, table, normals, min_border=1, extended=True)


DBSCAN_REACH = 2.0
"""Voxels between neighbours."""
DBSCAN_POINTS = 10
"""Minimum number of voxels around a core voxel of a cluster."""
NORMAL_REACH = 3
"""Pixels between the normals that are compared."""
SURFACE_BORDER = 4
"""Minimum number of touching pixel pairs of two surfaces, diagonal pairs included."""
LCCP_CLEARANCE_M = 0.008
"""Larger than for the others: patches at the foot of an object must not contain table."""
SLIC_SIZE_M = 0.03
"""Distance that weighs as much as a change of the unit normal by 1, m."""
SLIC_COMPACTNESS = 0.01

BASELINES: tuple[Baseline, ...] = (
    Baseline(
        "Open3D DBSCAN",
        "the method of most tutorials: remove the plane, cluster the other points",
        "voxel (m)",
        (0.003, 0.004, 0.006, 0.01),
        open3d_dbscan,
    ),
    Baseline(
        "normal edges",
        "real-time segmentation by normal edges, after Ueckermann et al. 2013",
        "angle (rad)",
        (0.3, 0.35, 0.4, 0.5),
        normal_edges,
    ),
    Baseline(
        "SLIC + LCCP",
        "local convexity of patches, after Stein et al. 2014, the best method in PCL",
        "patch (px)",
        (40, 60, 90, 150),
        slic_lccp,
    ),
)
"""In the order of the table."""


def _cosine(normals: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Return the cosine between the normals of pixels NORMAL_REACH apart along an axis."""
    return np.einsum("ijk,ijk->ij", normals, np.roll(normals, -NORMAL_REACH, axis))


CONVEX_ANGLE = 0.17
"""Patches whose normals differ by less are one surface, rad (10°, from Stein et al.)."""
GAP_PX = 4
"""Patches grow by this distance, so that they touch across the edge between them, px."""


def join_convex(
    patches: NDArray[np.int32],
    table: Tabletop,
    normals: NDArray[np.float32],
    *,
    min_border: int,
    extended: bool,
) -> NDArray[np.int32]:
    """Join neighbouring patches that form a convex or flat pair.

    Source: Stein, Schoeler, Papon and Wörgötter, "Object Partitioning Using Local Convexity",
    CVPR 2014. Two patches with centres x and normals n are convex when (x1 - x2) · (n1 - n2) > 0.

    Parameters
    ----------
    patches
        (H, W) int32; 0 = none.
    table
        The table and the pixels above it.
    normals
        Unit normals towards the camera, (H, W, 3).
    min_border
        Minimum number of touching pixel pairs of two neighbours.
    extended
        Join two patches only if a third patch is convex to both (their extended criterion). Use it
        for many small patches.

    Returns
    -------
    NDArray
        Labels of the objects, (H, W) int32; 0 = none.
    """
    seeds = np.where(table.above, patches, 0)
    grown = spread(seeds, table.above, GAP_PX)
    count = int(grown.max()) + 1
    centre = _sums(seeds, table.points, count)
    centre /= np.maximum(np.bincount(seeds.ravel(), minlength=count), 1)[:, None]
    normal = _unit(_sums(seeds, normals, count))
    first, second = _neighbours(grown, table.points[..., 2], min_border)
    direction = _unit(centre[first] - centre[second])
    convexity = np.sum(direction * (normal[first] - normal[second]), axis=1)
    flat = np.sum(normal[first] * normal[second], axis=1) > np.cos(CONVEX_ANGLE)
    join = (convexity > 0) | flat
    if extended and first.size:
        half = _graph(first[join], second[join], count).tocsr()
        convex = half + half.T
        join &= np.asarray((convex @ convex)[first, second]).ravel() > 0
    _, group = connected_components(_graph(first[join], second[join], count), directed=False)
    return finish(np.where(grown > 0, group[grown] + 1, 0), table.above)


def _sums(
    labels: NDArray[np.int32], values: NDArray[np.float32], count: int
) -> NDArray[np.float64]:
    """Sum of (H, W, 3) values over each label, (count, 3)."""
    flat = labels.ravel()
    sums = [np.bincount(flat, values[..., k].ravel(), count) for k in range(3)]
    return np.column_stack(sums).astype(np.float64)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def _graph(first: NDArray[np.int64], second: NDArray[np.int64], count: int) -> coo_array:
    return coo_array((np.ones(len(first)), (first, second)), shape=(count, count))


def _neighbours(
    patches: NDArray[np.int32], z: NDArray[np.float32], min_border: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pairs of patches that touch, also at corners, without a step in depth."""
    count = int(patches.max()) + 1
    pairs = []
    for one, other in (
        ((slice(None), slice(0, -1)), (slice(None), slice(1, None))),
        ((slice(0, -1), slice(None)), (slice(1, None), slice(None))),
        ((slice(0, -1), slice(0, -1)), (slice(1, None), slice(1, None))),
        ((slice(0, -1), slice(1, None)), (slice(1, None), slice(0, -1))),
    ):
        a, b = patches[one], patches[other]
        touch = (a != b) & (a > 0) & (b > 0) & (np.abs(z[one] - z[other]) < STEP_SHARE * z[one])
        low, high = np.minimum(a, b)[touch], np.maximum(a, b)[touch]
        pairs.append(low.astype(np.int64) * count + high)
    keys, lengths = np.unique(np.concatenate(pairs), return_counts=True)
    first, second = np.divmod(keys[lengths >= min_border], count)
    return first, second
