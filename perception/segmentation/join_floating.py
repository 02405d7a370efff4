"""Nothing floats: a piece that stands on nothing belongs to what it hangs on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .convexity import pixels_by_label
from .regions import ABOVE, BELOW, LEFT, RIGHT, Borders, region_borders

LOW, HIGH = 0.02, 0.98
"""Quantiles between which a piece's heights lie: outliers are no edge."""

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes
    from .options import SegmentationOptions
    from .result import SupportPlane


def join_floating(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    camera: CameraIntrinsics,
    support: SupportPlane,
    options: SegmentationOptions,
) -> NDArray[np.int32]:
    """Join pieces (H, W) that nothing carries to the region they touch most: handles, lids' rims.

    A piece is carried where it goes over into the support or another region along its lower
    edge, and may be where something nearer hides that edge or nothing was measured. Where most
    of its lower edge steps off to what lies far behind, it hangs, unless it begins so low for
    its height that its foot may be hidden by its own belly, as a ball's is.
    """
    borders = region_borders(labels, disparity, planes, options)
    order, starts = pixels_by_label(labels, borders.contact.shape[0] - 1)
    sizes = np.diff(starts)
    count = borders.contact.shape[0] - 1
    parent = np.arange(count + 1, dtype=np.int32)
    down = downwards(support)
    # Small pieces first: a handle hangs on a pot, never the other way round.
    for label in range(count, 0, -1):
        if _free_share(label, down, borders) < options.free_share:
            continue
        touching = borders.contact[label].sum(axis=1)
        touching[0] = 0
        partner = int(np.argmax(touching))
        if sizes[label] > options.hanging_share * sizes[partner]:
            continue
        pixels = order[starts[label] : starts[label + 1]]
        area, low, high = _measure(pixels, disparity, camera, support)
        if area > options.max_hanging or low < options.hanging_height * (high - low):
            continue
        if touching[partner] >= options.min_border:
            parent[label] = partner
    for label in range(1, count + 1):
        parent[label] = _root(parent, label)
    return parent[labels]


def downwards(support: SupportPlane) -> int:
    """Image direction (`RIGHT`, `LEFT`, `BELOW`, `ABOVE`) nearest to that of gravity."""
    x, y = -support.normal[0], -support.normal[1]
    if abs(x) > abs(y):
        return RIGHT if x > 0 else LEFT
    return BELOW if y >= 0 else ABOVE


def _free_share(label: int, down: int, borders: Borders) -> float:
    contact = borders.contact[label, :, down].sum()
    free = borders.before[label, :, down].sum()
    up = (LEFT, RIGHT, ABOVE, BELOW)[down]
    hidden = borders.before[:, label, up].sum() + borders.blind[label, down]
    return float(free / max(contact + free + hidden, 1))


def _measure(
    pixels: NDArray[np.integer],
    disparity: NDArray[np.float32],
    camera: CameraIntrinsics,
    support: SupportPlane,
) -> tuple[float, float, float]:
    """Area of a region as if it faced the camera, m², its least and greatest height, m."""
    pixels = pixels[disparity.flat[pixels] > 0]
    if pixels.size == 0:
        return 0.0, 0.0, 0.0
    rows, columns = np.divmod(pixels, disparity.shape[1])
    z = 1.0 / disparity[rows, columns].astype(np.float64)
    points = np.column_stack(
        [(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z]
    )
    low, high = np.quantile(support.height(points), (LOW, HIGH))
    return float((z**2).sum()) / (camera.fx * camera.fy), float(low), float(high)


def _root(parent: NDArray[np.int32], label: int) -> int:
    seen = {label}
    while parent[label] != label:
        label = int(parent[label])
        if label in seen:
            return min(seen)
        seen.add(label)
    return label
