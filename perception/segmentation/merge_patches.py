"""Patches become objects: neighbours that touch and bend outwards are one solid."""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .ambiguity import FLAT, Doubt
from .convexity import pair_turns, pixels_by_label, region_turns
from .free_space import crossings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes
    from .options import SegmentationOptions


def merge_patches(
    patches: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> tuple[NDArray[np.int32], list[Doubt]]:
    """Join patches into objects, (H, W) int32 with arbitrary numbers, 0 stays 0.

    A pair of neighbouring pixels votes on the border of its two patches. Without a step in
    disparity it speaks for contact; the angle between the patches' planes counts as concave
    where the disparity lies below the line through its neighbours across the border, and as
    convex where it lies above (perspective keeps convexity: in disparity a convex solid is the
    lower envelope of its planes). Borders are then joined, most convex first, their votes adding
    up, until only concave or stepped borders are left (after Stein et al. 2014, on the image
    grid).
    """
    count = int(patches.max(initial=0))
    if count < 2:
        return patches, []
    pairs, votes = border_votes(
        patches,
        disparity,
        planes.value,
        planes.slope_u,
        planes.slope_v,
        (camera.fx, camera.fy, camera.cx, camera.cy),
        np.float32(options.grow_sigmas * planes.noise),
        np.float32(options.crease_sigmas * planes.noise),
        np.float32(options.bend_sigmas * planes.noise),
        options.bend_reach,
    )
    borders = _collect(pairs, votes, count)
    found = np.array(list(borders), np.int64).reshape(-1, 2)
    hollow = region_turns(patches, disparity, planes, camera) < -options.hollow_turn
    crossed = crossings(patches, found, hollow, disparity, planes.noise, camera, options)
    order, starts = pixels_by_label(patches, count)
    turns = pair_turns(
        order,
        starts,
        found,
        disparity,
        planes.value,
        planes.slope_u,
        planes.slope_v,
        (camera.fx, camera.fy, camera.cx, camera.cy),
        options.line_samples,
    )
    for row, lines, turn in zip(borders.values(), crossed, turns, strict=True):
        row[4:] = options.line_samples, lines, turn * options.line_samples
    parent = _agglomerate(borders, count, options)
    return parent[patches], _flat_joins(patches, borders, parent, options)


def _collect(
    pairs: NDArray[np.int64], votes: NDArray[np.float32], count: int
) -> dict[tuple[int, int], NDArray[np.float64]]:
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


def _agglomerate(
    borders: dict[tuple[int, int], NDArray[np.float64]], count: int, options: SegmentationOptions
) -> NDArray[np.int32]:
    neighbours: dict[int, dict[int, NDArray[np.float64]]] = {k: {} for k in range(count + 1)}
    for (a, b), row in borders.items():
        neighbours[a][b] = neighbours[b][a] = row
    parent = np.arange(count + 1, dtype=np.int32)
    alive = np.ones(count + 1, bool)
    heap = [
        (cost, a, b)
        for (a, b), row in sorted(borders.items())
        if (cost := _join_cost(row, options)) is not None
    ]
    heapq.heapify(heap)
    while heap:
        cost, a, b = heapq.heappop(heap)
        if not (alive[a] and alive[b]) or b not in neighbours[a]:
            continue
        if _join_cost(neighbours[a][b], options) != cost:
            continue
        alive[b] = False
        parent[parent == b] = a
        for c, row in neighbours.pop(b).items():
            del neighbours[c][b]
            if c == a:
                continue
            total = row + neighbours[a].get(c, 0.0)
            neighbours[a][c] = neighbours[c][a] = total
            if (updated := _join_cost(total, options)) is not None:
                heapq.heappush(heap, (updated, min(a, c), max(a, c)))
    return parent


def _flat_joins(
    patches: NDArray[np.int32],
    borders: dict[tuple[int, int], NDArray[np.float64]],
    parent: NDArray[np.int32],
    options: SegmentationOptions,
) -> list[Doubt]:
    """Large parts of one object whose border bends neither way: flush neighbours look alike."""
    order, starts = pixels_by_label(patches, len(parent) - 1)
    sizes = np.diff(starts)
    whole = np.bincount(parent, weights=sizes)
    doubts: list[Doubt] = []
    for (a, b), row in borders.items():
        if parent[a] != parent[b]:
            continue
        small = min(sizes[a], sizes[b])
        mean = abs(row[3]) / max(row[2], 1e-9)
        if (
            mean <= options.flat_angle
            and small >= max(options.flat_share * whole[parent[a]], options.min_object)
            and row[1] >= np.sqrt(small) / 2
        ):
            doubts.append((int(order[starts[a]]), int(order[starts[b]]), FLAT))
    return doubts


def _join_cost(row: NDArray[np.float64], options: SegmentationOptions) -> float | None:
    """Order of joining, lowest first; None where the border separates."""
    pairs, contact, weight, concavity, lines, crossed, turn = row
    if crossed > options.crossing_share * lines or pairs < options.min_border:
        return None
    if contact < options.min_border or contact < options.contact_share * pairs:
        # A face seen at a grazing angle begins with a step, but bulges and leaves no space free.
        bulges = turn >= options.bulge_turn * lines
        clear = crossed <= options.bulge_crossing_share * lines
        return options.concave_angle if bulges and clear else None
    mean = concavity / max(weight, 1e-9)
    if mean > options.concave_angle:
        return None
    return float(mean)


@njit(cache=True, nogil=True)
def border_votes(
    patches, q, value, slope_u, slope_v, camera, max_step, max_crease, clear_bend, reach
):
    """One row per border pixel pair: (patch a < patch b) and (1, contact, weight, concavity)."""
    rows, columns = patches.shape
    capacity = 0
    for v in range(rows):
        for u in range(columns):
            a = patches[v, u]
            if a > 0:
                if u + 1 < columns and patches[v, u + 1] > 0 and patches[v, u + 1] != a:
                    capacity += 1
                if v + 1 < rows and patches[v + 1, u] > 0 and patches[v + 1, u] != a:
                    capacity += 1
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
                votes[k, 0] = 1.0
                if value[v, u] > 0 and value[y, x] > 0:
                    rise_u = slope_u[y, x] - slope_u[v, u]
                    rise_v = slope_v[y, x] - slope_v[v, u]
                    # On a crease the planes cross between the pixels: their misses at each
                    # other's reading add up to the change of slope, and no more. The change
                    # that is granted is bounded: the rim of a round solid falls off so steeply
                    # that its plane would bridge any step.
                    rise = q[y, x] - q[v, u]
                    near = rise - slope_u[v, u] * du - slope_v[v, u] * dv
                    far = rise - slope_u[y, x] * du - slope_v[y, x] * dv
                    granted = min(abs(far - near), max_crease)
                    step = abs(near) + abs(far) - granted
                    if step < max_step:
                        bend = np.sqrt(rise_u * rise_u + rise_v * rise_v)
                        along = rise_u * du + rise_v * dv
                        angle = _angle(value, slope_u, slope_v, camera, v, u, y, x)
                        votes[k, 1] = 1.0
                        by, bx = v - reach * dv, u - reach * du
                        ay, ax = y + reach * dv, x + reach * du
                        if (
                            bend > 0
                            and by >= 0
                            and bx >= 0
                            and ay < rows
                            and ax < columns
                            and patches[by, bx] == a
                            and patches[ay, ax] == b
                        ):
                            # Which way the surface bends is read off the disparities
                            # themselves: shifted windows may have crossed over.
                            second = q[by, bx] + q[ay, ax] - q[v, u] - q[y, x]
                            clear = min(abs(second) / clear_bend, np.float32(1.0))
                            weight = clear * abs(along) / bend
                            votes[k, 2] = weight
                            votes[k, 3] = angle * weight * np.sign(second)
                k += 1
    return pairs, votes


@njit(cache=True, nogil=True)
def _angle(value, slope_u, slope_v, camera, v, u, y, x):
    """Angle between the planes at two pixels, rad."""
    fx, fy, cx, cy = camera
    ax, ay = slope_u[v, u] * fx, slope_v[v, u] * fy
    az = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
    bx, by = slope_u[y, x] * fx, slope_v[y, x] * fy
    bz = value[y, x] - slope_u[y, x] * (x - cx) - slope_v[y, x] * (y - cy)
    dot = ax * bx + ay * by + az * bz
    lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    return np.arccos(min(max(dot / lengths, -1.0), 1.0))
