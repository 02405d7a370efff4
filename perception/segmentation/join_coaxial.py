"""Join the neck or the cap of a bottle to its body: both are round about one upright axis."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .ambiguity import COAXIAL, UncertainJoin
from .label_pixels import pixels_by_label
from .local_planes import LocalPlanes
from .regions import merge_regions
from .result import SupportPlane
from .working_image import WorkingImage

SAMPLES = 400
"""Approximate number of readings of a region that are used."""
MIN_SAMPLES = 8
"""Minimum number of readings of a wall, or of a ring of a shoulder."""
MIN_SLOPE = 0.35
"""Minimum sine of the angle between a normal and the vertical for a reading to show the axis."""
ROUNDS, SCALE = 3, 0.003
"""Fits of the axis, and the distance at which a reading's weight is halved, m."""
MIN_ARC = 0.08
"""Minimum share of the less certain direction in the evidence for an axis. Walls of a box have 0."""
MAX_DISTANCE = 0.005
"""Maximum median distance of the axis from the normals of each region, m. It is 0.2 to 4.5 mm for
parts of a bottle. No other two things on a table or in a real frame are below it."""
MIN_OUTWARDS = 0.9
"""Minimum cosine between the normals and the directions away from the axis, median."""
RADIUS = 0.95
"""Quantile of the distances from the axis that is the radius of a region."""
MAX_RATIO = 0.62
"""Maximum radius of a neck, as a share of that of the body: 0.6 at most for drawn bottles. Stacks
of round things have 0.64 or more."""
MIN_DROP = 0.2
"""Minimum drop of the shoulder from its inner to its outer half, as a share of its width. It is
0.3 or more for bottles, and below 0.2 for a thing on the flat top of another one."""
TOP = 0.8
"""Quantile of the heights of a ring that is its height: its readings on walls are lower."""


class _Region(NamedTuple):
    """Readings of one region."""

    height: NDArray[np.float64]
    """Heights over the support, (N,), m."""
    plan: NDArray[np.float64]
    """Positions in plan, (N, 2), m."""
    normal: NDArray[np.float64]
    """Plan components of the unit normals towards the camera, (N, 2)."""
    wall: NDArray[np.bool_]
    """(N,) whether the normal is inclined enough to show an axis."""


def join_coaxial(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes, support: SupportPlane
) -> tuple[NDArray[np.int32], list[UncertainJoin]]:
    """Join necks to the bodies below them, and report other pairs about one axis.

    Their border is as concave as that between two objects, or a depth step from above. The normals
    of both point away from one upright axis. The shoulder of a bottle slopes down from its neck. A
    thing on a can has a flat ring around it, or is nearly as wide.

    Parameters
    ----------
    labels
        Objects 1..n by size, (H, W).
    image
        Their image.
    planes
        Its local planes.
    support
        The support plane, camera frame.

    Returns
    -------
    labels, uncertain
        New labels by size, and the pairs about one axis that stay two objects.
    """
    count = int(labels.max(initial=0))
    order, starts = pixels_by_label(labels, count)
    firsts = [int(order[starts[label]]) for label in range(1, count + 1)]
    regions = [
        _region(order[starts[label] : starts[label + 1]], image, planes, support)
        for label in range(1, count + 1)
    ]
    parent = np.arange(count + 1, dtype=np.int32)
    uncertain = []
    for a, b in combinations(range(count), 2):
        body, neck = sorted((regions[a], regions[b]), key=lambda one: float(np.median(one.height)))
        if not _overlap_in_plan(body, neck):
            continue
        axis = _common_axis(body, neck)
        if axis is None:
            continue
        if _is_neck(neck, body, axis):
            parent[parent == parent[b + 1]] = parent[a + 1]
        else:
            uncertain.append(UncertainJoin(firsts[a], firsts[b], COAXIAL))
    return merge_regions(labels, parent), uncertain


def _region(
    pixels: NDArray[np.integer], image: WorkingImage, planes: LocalPlanes, support: SupportPlane
) -> _Region:
    """Return the readings of the region with these flat pixels."""
    pixels = pixels[:: len(pixels) // SAMPLES + 1]
    pixels = pixels[(image.disparity.flat[pixels] > 0) & (planes.value.flat[pixels] > 0)]
    rows, columns = np.divmod(pixels, image.disparity.shape[1])
    points = image.points(rows, columns)
    fx, fy, cx, cy = image.pinhole
    slope_u, slope_v = planes.slope_u.flat[pixels], planes.slope_v.flat[pixels]
    depth = planes.value.flat[pixels] - slope_u * (columns - cx) - slope_v * (rows - cy)
    normal = -np.column_stack([slope_u * fx, slope_v * fy, depth]).astype(np.float64)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    axes = perpendicular_pair(support.normal).T
    flat = normal @ axes
    wall = np.hypot(*flat.T) > MIN_SLOPE
    return _Region(support.height(points), points @ axes, flat, wall)


def _overlap_in_plan(a: _Region, b: _Region) -> bool:
    """Return whether both regions have readings, and their rectangles in plan overlap."""
    if min(len(a.plan), len(b.plan)) < MIN_SAMPLES:
        return False
    low = np.maximum(a.plan.min(axis=0), b.plan.min(axis=0))
    return bool((low < np.minimum(a.plan.max(axis=0), b.plan.max(axis=0))).all())


def _common_axis(body: _Region, neck: _Region) -> NDArray[np.float64] | None:
    """Return the place (2,) in plan of the upright axis of both regions, m, or None.

    The lines along the normals of a round wall meet in its axis. The level top of a neck has none.
    """
    walls = [one for one in (body, neck) if np.count_nonzero(one.wall) >= MIN_SAMPLES]
    if not any(one is body for one in walls):
        return None
    across = [one.normal[one.wall][:, ::-1] * (-1.0, 1.0) for one in walls]
    across = [one / np.linalg.norm(one, axis=1, keepdims=True) for one in across]
    offsets = [(t * one.plan[one.wall]).sum(axis=1) for t, one in zip(across, walls, strict=True)]
    weights = [np.full(len(one), 1.0 / len(one)) for one in offsets]
    axis = np.zeros(2)
    for _ in range(ROUNDS):
        t, d, w = np.concatenate(across), np.concatenate(offsets), np.concatenate(weights)
        matrix = (t * w[:, None]).T @ t
        spread = np.linalg.eigvalsh(matrix)
        if spread[0] < MIN_ARC * spread.sum():
            return None
        axis = np.linalg.solve(matrix, (t * w[:, None]).T @ d)
        apart = [(t @ axis - d) / SCALE for t, d in zip(across, offsets, strict=True)]
        weights = [1.0 / (len(one) * (1.0 + one**2)) for one in apart]
    for one, distance in zip(walls, apart, strict=True):
        away = one.plan[one.wall] - axis
        away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
        outwards = (away * one.normal[one.wall]).sum(axis=1) / np.hypot(*one.normal[one.wall].T)
        if SCALE * np.median(np.abs(distance)) > MAX_DISTANCE or np.median(outwards) < MIN_OUTWARDS:
            return None
    centred = np.linalg.norm(np.median(neck.plan, axis=0) - axis)
    return axis if centred < np.quantile(np.linalg.norm(body.plan - axis, axis=1), RADIUS) else None


def _is_neck(neck: _Region, body: _Region, axis: NDArray[np.float64]) -> bool:
    """Return whether a narrow region goes over into the sloping shoulder of the one below it."""
    distances = np.linalg.norm(body.plan - axis, axis=1)
    outer = float(np.quantile(distances, RADIUS))
    inner = float(np.quantile(np.linalg.norm(neck.plan - axis, axis=1), RADIUS))
    if inner > MAX_RATIO * outer:
        return False
    middle = (inner + RADIUS * outer) / 2.0
    near = body.height[(distances > inner) & (distances < middle)]
    far = body.height[(distances >= middle) & (distances < RADIUS * outer)]
    if min(len(near), len(far)) < MIN_SAMPLES:
        return False
    return bool(np.quantile(near, TOP) - np.quantile(far, TOP) > MIN_DROP * (outer - inner))
