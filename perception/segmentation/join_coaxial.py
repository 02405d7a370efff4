"""Join the neck or the cap of a bottle to its body: both are round about one upright axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .ambiguity import COAXIAL, UncertainJoin
from .label_pixels import pixels_by_label
from .local_planes import LocalPlanes
from .median import median, quantile
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
"""Minimum share of the less certain direction in the evidence for an axis. A plane wall has 0."""
MAX_DISTANCE = 0.005
"""Maximum median distance of the axis from the normals of each region, m. It is 0.2 to 4.5 mm for
parts of a bottle. Of other things, stacks and one pair in 62 real frames are below it."""
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
    wall: NDArray[np.float64]
    """Positions in plan of the readings with an inclined normal, (M, 2), m."""
    outwards: NDArray[np.float64]
    """Directions in plan of their normals, (M, 2)."""

    @property
    def across(self) -> NDArray[np.float64]:
        """Directions in plan across the normals, (M, 2)."""
        return self.outwards[:, ::-1] * (-1.0, 1.0)


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
    axes = np.vstack([support.normal, perpendicular_pair(support.normal)])
    regions = []
    for label in range(1, count + 1):
        pixels = order[starts[label] : starts[label + 1]]
        readings = region_readings(
            pixels[:: len(pixels) // SAMPLES + 1].copy(),
            image.disparity,
            planes,
            image.pinhole,
            axes,
            support.offset,
        )
        regions.append(_Region(*readings))
    parent = np.arange(count + 1, dtype=np.int32)
    uncertain = []
    for a, b in _standing_pairs(regions):
        body, neck = regions[a], regions[b]
        axis = _common_axis(body, neck)
        if axis is None:
            continue
        if _is_neck(neck, body, axis):
            parent[parent == parent[b + 1]] = parent[a + 1]
        else:
            uncertain.append(UncertainJoin(firsts[a], firsts[b], COAXIAL))
    return merge_regions(labels, parent), uncertain


def _standing_pairs(regions: list[_Region]) -> list[list[int]]:
    """Return the pairs of regions, the lower one first, of which the upper one stands over it.

    Its middle lies in plan in the rectangle around the lower one.
    """
    usable = np.array([k for k, one in enumerate(regions) if len(one.height) >= MIN_SAMPLES], int)
    if not len(usable):
        return []
    height = np.array([median(regions[k].height) for k in usable])
    middle = np.array([[median(values) for values in regions[k].plan.T] for k in usable])
    low = np.array([regions[k].plan.min(axis=0) for k in usable])[:, None]
    high = np.array([regions[k].plan.max(axis=0) for k in usable])[:, None]
    over = ((low < middle) & (middle < high)).all(axis=2) & (height[:, None] < height)
    return usable[np.argwhere(over)].tolist()


def _common_axis(body: _Region, neck: _Region) -> NDArray[np.float64] | None:
    """Return the place (2,) in plan of the upright axis of both regions, m, or None.

    The lines along the normals of a round wall meet in its axis. The level top of a neck has none.
    """
    if len(body.wall) < MIN_SAMPLES:
        return None
    walls = [body, neck] if len(neck.wall) >= MIN_SAMPLES else [body]
    across = np.concatenate([one.across for one in walls])
    offsets = (across * np.concatenate([one.wall for one in walls])).sum(axis=1)
    equal = np.concatenate([np.full(len(one.wall), 1.0 / len(one.wall)) for one in walls])
    axis, weights = np.zeros(2), equal
    for _ in range(ROUNDS):
        weighted = across.T * weights
        matrix = weighted @ across
        spread = np.linalg.eigvalsh(matrix)
        if spread[0] < MIN_ARC * spread.sum():
            return None
        axis = np.linalg.solve(matrix, weighted @ offsets)
        weights = equal / (1.0 + ((across @ axis - offsets) / SCALE) ** 2)
    for one in walls:
        away = one.wall - axis
        distance = np.abs((one.across * away).sum(axis=1))
        along = (one.outwards * away).sum(axis=1) / np.linalg.norm(away, axis=1)
        if median(distance) > MAX_DISTANCE or not median(along) >= MIN_OUTWARDS:
            return None
    return axis


def _is_neck(neck: _Region, body: _Region, axis: NDArray[np.float64]) -> bool:
    """Return whether a narrow region goes over into the sloping shoulder of the one below it."""
    distances = np.linalg.norm(body.plan - axis, axis=1)
    outer = quantile(distances, RADIUS)
    inner = quantile(np.linalg.norm(neck.plan - axis, axis=1), RADIUS)
    if inner > MAX_RATIO * outer:
        return False
    middle = (inner + RADIUS * outer) / 2.0
    near = body.height[(distances > inner) & (distances < middle)]
    far = body.height[(distances >= middle) & (distances < RADIUS * outer)]
    if min(len(near), len(far)) < MIN_SAMPLES:
        return False
    return bool(quantile(near, TOP) - quantile(far, TOP) > MIN_DROP * (outer - inner))


@njit(cache=True, nogil=True)
def region_readings(pixels, q, planes, pinhole, axes, offset):
    """Return the fields of `_Region` from some pixels of a region.

    Parameters
    ----------
    pixels
        Flat pixels (N,).
    q
        Disparity (H, W), 1/m.
    planes
        Its `LocalPlanes`.
    pinhole
        fx, fy, cx, cy.
    axes
        Rows (3, 3): the normal of the support, and the two axes of the plan.
    offset
        Offset of the support, m.
    """
    fx, fy, cx, cy = pinhole
    columns = q.shape[1]
    height, plan = np.empty(len(pixels)), np.empty((len(pixels), 2))
    wall, outwards = np.empty((len(pixels), 2)), np.empty((len(pixels), 2))
    count = inclined = 0
    for pixel in pixels:
        v, u = pixel // columns, pixel % columns
        value = np.float64(planes.value[v, u])
        if q[v, u] <= 0 or value <= 0:
            continue
        z = 1.0 / np.float64(q[v, u])
        x, y = (u - cx) / fx * z, (v - cy) / fy * z
        slope_u, slope_v = np.float64(planes.slope_u[v, u]), np.float64(planes.slope_v[v, u])
        a, b, c = -slope_u * fx, -slope_v * fy, slope_u * (u - cx) + slope_v * (v - cy) - value
        length = np.sqrt(a * a + b * b + c * c)
        height[count] = x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2] + offset
        for k in range(2):
            along = axes[k + 1]
            plan[count, k] = x * along[0] + y * along[1] + z * along[2]
            outwards[inclined, k] = (a * along[0] + b * along[1] + c * along[2]) / length
        slope = np.hypot(outwards[inclined, 0], outwards[inclined, 1])
        if slope > MIN_SLOPE:
            for k in range(2):
                wall[inclined, k] = plan[count, k]
                outwards[inclined, k] /= slope
            inclined += 1
        count += 1
    return (
        height[:count].copy(),
        plan[:count].copy(),
        wall[:inclined].copy(),
        outwards[:inclined].copy(),
    )
