"""Merge patches into objects: neighbours that touch at a convex border are one solid."""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .ambiguity import FLAT, UncertainJoin
from .convexity import HOLLOW, pair_convexity, region_convexity
from .free_space import MAX_CROSSING_SHARE, count_free_lines
from .label_pixels import LINES, pixels_by_label
from .local_planes import CREASE_SIGMAS, STEP_SIGMAS
from .regions import MIN_BORDER

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .working_image import WorkingImage

    BorderSums = dict[tuple[int, int], NDArray[np.float64]]
    """Sums over the border of two patches a < b, in the order of the names below."""

PAIRS, CONTACT, WEIGHT, CONCAVITY, TESTED, CROSSED, CONVEXITY = range(7)
"""Columns of the sums over a border: pixel pairs, pairs in contact, weight of their bends, weighted
concave angles in rad, lines tested, lines through free space, convexity along these lines."""

MAX_CONCAVITY = 0.25
"""Maximum mean concave angle of a border inside one object, rad. A lower value splits bent objects,
a higher one joins touching ones."""
BEND_REACH = 4
"""Distance from the border at which the bend is measured, px at the reference width. A longer one
is more reliable, a shorter one works for smaller parts."""
BEND_SIGMAS = 3.0
"""Bend in disparity that counts with full weight, in σ."""
MIN_CONTACT_SHARE = 0.25
"""Minimum share of a border without a depth step for two patches to touch."""
MIN_STEP_CONVEXITY = 0.5
"""Minimum convexity between two parts that are joined across a depth step. A lower value joins
neighbours, a higher one separates faces seen at a grazing angle."""
MAX_STEP_CROSSING_SHARE = 0.1
"""Maximum share of the lines between such parts that cross free space."""
FLAT_ANGLE = 0.06
"""Mean angle of a border below which it cannot be decided if its parts are one object, rad."""
FLAT_SHARE = 0.15
"""Minimum share of an object on either side of such a border."""


class BorderLimits(NamedTuple):
    """Thresholds of :func:`border_votes`."""

    max_step: np.float32
    """Maximum step in disparity between pixels in contact, 1/m."""
    max_crease: np.float32
    """Maximum change of slope at a crease, 1/(m px)."""
    full_bend: np.float32
    """Bend in disparity that counts with full weight, 1/m."""
    reach: int
    """Distance from the border at which the bend is measured, px."""


def merge_patches(
    patches: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes, min_object: int
) -> tuple[NDArray[np.int32], list[UncertainJoin]]:
    """Merge patches (H, W) into objects; parts below `min_object` px are never uncertain.

    Each pair of neighbouring pixels of two patches is a vote on their border. A pair without a
    step in disparity is in contact. The angle between its planes is concave where the disparity
    is below the line through its neighbours across the border, and convex where it is above.
    Perspective keeps convexity: in disparity a convex solid is the lower envelope of its planes.
    The most convex border is removed first, and the votes of the merged patches are added up.
    This ends when all borders are concave or steps (after Stein et al. 2014, on the image grid).

    Returns
    -------
    labels, uncertain
        Objects (H, W) int32 in arbitrary numbers, 0 stays 0; and merges across flat borders.
    """
    count = int(patches.max(initial=0))
    if count < 2:
        return patches, []
    limits = BorderLimits(
        np.float32(STEP_SIGMAS * image.noise),
        np.float32(CREASE_SIGMAS * image.noise),
        np.float32(BEND_SIGMAS * image.noise),
        image.length(BEND_REACH),
    )
    votes = border_votes(patches, image.disparity, planes, image.pinhole, limits)
    borders = _sum_votes(*votes, count)
    pairs = np.array(list(borders), np.int64).reshape(-1, 2)
    hollow = region_convexity(patches, image, planes) < HOLLOW
    crossed = count_free_lines(patches, pairs, hollow, image)
    convexity = pair_convexity(patches, pairs, image, planes)
    for sums, lines, mean in zip(borders.values(), crossed, convexity, strict=True):
        sums[TESTED:] = LINES, lines, mean * LINES
    parent = _agglomerate(borders, count, image.length(MIN_BORDER))
    return parent[patches], _flat_joins(patches, borders, parent, min_object)


def _sum_votes(pairs: NDArray[np.int64], votes: NDArray[np.float32], count: int) -> BorderSums:
    if not len(pairs):
        return {}
    keys = pairs[:, 0] * (count + 1) + pairs[:, 1]
    unique, inverse = np.unique(keys, return_inverse=True)
    sums = np.zeros((len(unique), 7))
    np.add.at(sums[:, :4], inverse, votes)
    return {
        (int(key) // (count + 1), int(key) % (count + 1)): row
        for key, row in zip(unique, sums, strict=True)
    }


def _agglomerate(borders: BorderSums, count: int, min_border: int) -> NDArray[np.int32]:
    """Remove borders by rising cost; return the object of each patch, (count + 1,)."""
    neighbours: dict[int, dict[int, NDArray[np.float64]]] = {k: {} for k in range(count + 1)}
    for (a, b), sums in borders.items():
        neighbours[a][b] = neighbours[b][a] = sums
    parent = np.arange(count + 1, dtype=np.int32)
    alive = np.ones(count + 1, bool)
    heap = [
        (cost, a, b)
        for (a, b), sums in sorted(borders.items())
        if (cost := _join_cost(sums, min_border)) is not None
    ]
    heapq.heapify(heap)
    while heap:
        cost, a, b = heapq.heappop(heap)
        if not (alive[a] and alive[b]) or b not in neighbours[a]:
            continue
        # Entries of borders that have changed since are out of date.
        if _join_cost(neighbours[a][b], min_border) != cost:
            continue
        alive[b] = False
        parent[parent == b] = a
        for c, sums in neighbours.pop(b).items():
            del neighbours[c][b]
            if c == a:
                continue
            total = sums + neighbours[a].get(c, 0.0)
            neighbours[a][c] = neighbours[c][a] = total
            if (updated := _join_cost(total, min_border)) is not None:
                heapq.heappush(heap, (updated, min(a, c), max(a, c)))
    return parent


def _join_cost(sums: NDArray[np.float64], min_border: int) -> float | None:
    """Return the mean concavity of a border, rad, or None where it separates two objects."""
    pairs, contact, weight, concavity, tested, crossed, convexity = sums
    if crossed > MAX_CROSSING_SHARE * tested or pairs < min_border:
        return None
    if contact < min_border or contact < MIN_CONTACT_SHARE * pairs:
        # A face seen at a grazing angle begins with a step. It belongs to the object when the two
        # parts are convex together and leave no free space.
        convex = convexity >= MIN_STEP_CONVEXITY * tested
        filled = crossed <= MAX_STEP_CROSSING_SHARE * tested
        return MAX_CONCAVITY if convex and filled else None
    mean = concavity / max(weight, 1e-9)
    if mean > MAX_CONCAVITY:
        return None
    return float(mean)


def _flat_joins(
    patches: NDArray[np.int32], borders: BorderSums, parent: NDArray[np.int32], min_object: int
) -> list[UncertainJoin]:
    """Return the merges of large parts whose border is flat: flush neighbours look the same."""
    order, starts = pixels_by_label(patches, len(parent) - 1)
    sizes = np.diff(starts)
    whole = np.bincount(parent, weights=sizes)
    uncertain: list[UncertainJoin] = []
    for (a, b), sums in borders.items():
        if parent[a] != parent[b]:
            continue
        small = min(sizes[a], sizes[b])
        mean = abs(sums[CONCAVITY]) / max(sums[WEIGHT], 1e-9)
        if (
            mean <= FLAT_ANGLE
            and small >= max(FLAT_SHARE * whole[parent[a]], min_object)
            and sums[CONTACT] >= np.sqrt(small) / 2
        ):
            uncertain.append(UncertainJoin(int(order[starts[a]]), int(order[starts[b]]), FLAT))
    return uncertain


@njit(cache=True, nogil=True)
def border_votes(patches, q, planes, pinhole, limits):
    """Return (patch a < patch b) and (1, contact, weight, weighted angle) of all border pairs."""
    rows, columns = patches.shape
    capacity = _count_border_pairs(patches)
    pairs = np.empty((capacity, 2), np.int64)
    votes = np.zeros((capacity, 4), np.float32)
    k = 0
    for v in range(rows):
        for u in range(columns):
            a = patches[v, u]
            if a <= 0:
                continue
            for dv, du in ((0, 1), (1, 0)):
                y, x = v + dv, u + du
                if y >= rows or x >= columns:
                    continue
                b = patches[y, x]
                if b <= 0 or b == a:
                    continue
                pairs[k, 0], pairs[k, 1] = min(a, b), max(a, b)
                votes[k, PAIRS] = 1.0
                if _in_contact(q, planes, limits, (v, u), (dv, du)):
                    votes[k, CONTACT] = 1.0
                    weight, second = _bend(patches, q, planes, limits, (v, u), (dv, du))
                    if weight > 0:
                        angle = _angle(planes, pinhole, (v, u), (y, x))
                        votes[k, WEIGHT] = weight
                        votes[k, CONCAVITY] = angle * weight * np.sign(second)
                k += 1
    return pairs, votes


@njit(cache=True, nogil=True)
def _count_border_pairs(patches):
    rows, columns = patches.shape
    count = 0
    for v in range(rows):
        for u in range(columns):
            a = patches[v, u]
            if a > 0:
                if u + 1 < columns and patches[v, u + 1] > 0 and patches[v, u + 1] != a:
                    count += 1
                if v + 1 < rows and patches[v + 1, u] > 0 and patches[v + 1, u] != a:
                    count += 1
    return count


@njit(cache=True, nogil=True)
def _in_contact(q, planes, limits, pixel, step):
    """Return whether two neighbouring pixels have no step in disparity between them.

    At a crease their planes intersect between the pixels. Then the errors of the two planes at
    each other's reading add up to the change of slope. This change is subtracted, but only up to
    a limit: the rim of a round solid is so steep that its plane would bridge any step.
    """
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    (v, u), (dv, du) = pixel, step
    y, x = v + dv, u + du
    if value[v, u] <= 0 or value[y, x] <= 0:
        return False
    rise = q[y, x] - q[v, u]
    near = rise - slope_u[v, u] * du - slope_v[v, u] * dv
    far = rise - slope_u[y, x] * du - slope_v[y, x] * dv
    crease = min(abs(far - near), limits.max_crease)
    return abs(near) + abs(far) - crease < limits.max_step


@njit(cache=True, nogil=True)
def _bend(patches, q, planes, limits, pixel, step):
    """Return the weight of the bend between two pixels in contact, and its second difference.

    The sign of the bend comes from the disparities themselves, because a shifted window may have
    crossed the border. The weight is 0 where the patches are too narrow to measure it.
    """
    slope_u, slope_v, reach = planes.slope_u, planes.slope_v, limits.reach
    rows, columns = patches.shape
    (v, u), (dv, du) = pixel, step
    y, x = v + dv, u + du
    rise_u = slope_u[y, x] - slope_u[v, u]
    rise_v = slope_v[y, x] - slope_v[v, u]
    bend = np.sqrt(rise_u * rise_u + rise_v * rise_v)
    along = rise_u * du + rise_v * dv
    by, bx = v - reach * dv, u - reach * du
    ay, ax = y + reach * dv, x + reach * du
    if (
        bend <= 0
        or by < 0
        or bx < 0
        or ay >= rows
        or ax >= columns
        or patches[by, bx] != patches[v, u]
        or patches[ay, ax] != patches[y, x]
    ):
        return 0.0, 0.0
    second = q[by, bx] + q[ay, ax] - q[v, u] - q[y, x]
    clear = min(abs(second) / limits.full_bend, np.float32(1.0))
    return clear * abs(along) / bend, second


@njit(cache=True, nogil=True)
def _angle(planes, pinhole, a, b):
    """Return the angle between the planes at two pixels, rad."""
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    fx, fy, cx, cy = pinhole
    (v, u), (y, x) = a, b
    ax, ay = slope_u[v, u] * fx, slope_v[v, u] * fy
    az = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
    bx, by = slope_u[y, x] * fx, slope_v[y, x] * fy
    bz = value[y, x] - slope_u[y, x] * (x - cx) - slope_v[y, x] * (y - cy)
    dot = ax * bx + ay * by + az * bz
    lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    return np.arccos(min(max(dot / lengths, -1.0), 1.0))
