"""Common segmentation methods without training, as baselines in the chart.

Each is a short implementation with library calls on the same table detection
(`baseline_tabletop.py`). The chart sweeps one dial of each, so that its best setting is shown. The
other constants were chosen by mean overlap F on development data: every second frame of the mOSD
learn half and twelve synthetic frames with realistic noise (seeds 9000 to 9011: separate, touching
and stacked). Therefore a chart of the learn half favours the baselines a little. Synthetic seeds
from 0 are frames on which nothing was chosen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import cv2
import numpy as np

from ..open3d_import import import_open3d
from .baseline_tabletop import STEP_SHARE, find_tabletop, finish, normals_of
from .convex_patches import join_convex

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame


class Segmenter(Protocol):
    """A baseline at one setting of its dial."""

    def __call__(self, frame: DepthFrame, dial: float, /) -> NDArray[np.int32]:
        """Label the objects of a frame, (H, W) int32; 0 = not an object."""
        ...


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
    run: Segmenter


def depth_steps(frame: DepthFrame, step: float) -> NDArray[np.int32]:
    """Return connected components with depth steps below `step`, a share of depth."""
    table = find_tabletop(frame)
    z = np.asarray(cv2.medianBlur(frame.depth, 5), np.float32)
    return finish(_components(_flat_pixels(z, table.above, step)), table.above)


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
    smooth = _flat_pixels(z, table.above, STEP_SHARE) > 0
    for axis in (0, 1):
        agree = _cosine(normals, axis) > cosine
        smooth &= agree & np.roll(agree, NORMAL_REACH, axis)
    patches = _components(smooth.astype(np.uint8))
    return join_convex(patches, table, normals, min_border=SURFACE_BORDER, extended=False)


def slic_lccp(frame: DepthFrame, patch_pixels: float) -> NDArray[np.int32]:
    """Join locally convex patches of scikit-image's SLIC on points and normals."""
    from skimage.segmentation import slic

    table = find_tabletop(frame, LCCP_CLEARANCE_M)
    if not table.above.any():
        return table.above.astype(np.int32)
    normals = normals_of(frame)
    box = _box(table.above)
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


def felzenszwalb_normals(frame: DepthFrame, scale: float) -> NDArray[np.int32]:
    """Segment depth and normals with scikit-image's graph cut (Felzenszwalb, Huttenlocher)."""
    from skimage.segmentation import felzenszwalb

    table = find_tabletop(frame)
    if not table.above.any():
        return table.above.astype(np.int32)
    features = np.dstack([frame.depth / FELZENSZWALB_SIZE_M, normals_of(frame)[..., :2]])
    # All pixels not above the table become one flat region far from the others.
    features[~table.above] = -FAR
    box = _box(table.above)
    patches = np.zeros(frame.depth.shape, np.int32)
    patches[box] = 1 + felzenszwalb(
        features[box].astype(np.float64), scale=scale, sigma=0.0, min_size=100, channel_axis=2
    )
    return finish(patches, table.above)


def watershed_edges(frame: DepthFrame, depth: float) -> NDArray[np.int32]:
    """Segment the edge strength with scikit-image's watershed, from minima `depth` deep."""
    from skimage.morphology import h_minima
    from skimage.segmentation import watershed

    table = find_tabletop(frame)
    if not table.above.any():
        return table.above.astype(np.int32)
    normals = normals_of(frame)
    z = np.asarray(cv2.medianBlur(frame.depth, 5), np.float32)
    steps = np.asarray(cv2.morphologyEx(z, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)))
    edges = np.clip(steps / np.maximum(z, 1e-3) / FULL_STEP_SHARE, 0, 1)
    for axis in (0, 1):
        bend = 1 - _cosine(normals, axis)
        edges = np.maximum(edges, np.clip(np.roll(bend, NORMAL_REACH // 2, axis), 0, 1))
    edges = np.where(
        table.above, cv2.GaussianBlur(edges.astype(np.float32), (0, 0), EDGE_BLUR), 1.0
    )
    box = _box(table.above)
    above = table.above[box]
    markers = _components((np.asarray(h_minima(edges[box], depth)) > 0) & above)
    basins = np.zeros(frame.depth.shape, np.int32)
    basins[box] = watershed(edges[box], markers, mask=above)
    return finish(basins, table.above)


FULL_STEP_SHARE = 0.012
"""A step this large is an edge of full strength."""
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
FELZENSZWALB_SIZE_M = 0.02
"""The same for the graph cut, m."""
FAR = 100.0
"""Feature value of pixels that are not above the table."""
EDGE_BLUR = 3.0
"""Standard deviation of the blur of edges, px."""

BASELINES: tuple[Baseline, ...] = (
    Baseline(
        "depth steps",
        "the simplest method: cut where depth jumps",
        "step (share of depth)",
        (0.008, 0.012, 0.02),
        depth_steps,
    ),
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
    Baseline(
        "Felzenszwalb",
        "the classic graph-based segmentation, on geometry instead of colour",
        "scale",
        (4000, 8000, 16000),
        felzenszwalb_normals,
    ),
    Baseline(
        "watershed",
        "the classic image segmentation, on depth and normal edges",
        "depth of minima",
        (0.15, 0.2, 0.25, 0.3),
        watershed_edges,
    ),
)
"""In the order of the table."""


def _flat_pixels(
    z: NDArray[np.float32], above: NDArray[np.bool_], step: float
) -> NDArray[np.uint8]:
    """Return the pixels above the table whose neighbourhood has no step in depth."""
    near = np.asarray(cv2.erode(z, np.ones((3, 3), np.uint8)))
    far = np.asarray(cv2.dilate(z, np.ones((3, 3), np.uint8)))
    return (above & (far - near < step * z)).astype(np.uint8)


def _cosine(normals: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Return the cosine between the normals of pixels NORMAL_REACH apart along an axis."""
    return np.einsum("ijk,ijk->ij", normals, np.roll(normals, -NORMAL_REACH, axis))


def _box(above: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the bounding box (rows, columns) of the pixels above the table."""
    u, v, width, height = cv2.boundingRect(above.astype(np.uint8))
    return slice(v, v + height), slice(u, u + width)


def _components(mask: NDArray) -> NDArray[np.int32]:
    return np.asarray(cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)[1], np.int32)
