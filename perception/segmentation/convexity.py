"""Which way regions curve: towards the viewer only the inside of something does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes

SHUFFLE = 1009
"""A prime larger than any number of lines: its multiples pair every part with every other."""
SAMPLES = 64
"""Pixels that stand for a region; the cost grows with their square."""


def region_turns(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    camera: CameraIntrinsics,
) -> NDArray[np.float64]:
    """How every region of (H, W) labels curves, (n + 1,) in [-1, 1].

    1 = bulges everywhere, 0 = flat, -1 = hollow everywhere: over all pairs of points the
    difference of normals along the difference of places, over the product of their lengths,
    weighed by these products.
    """
    order, starts = pixels_by_label(labels, int(labels.max(initial=0)))
    return turns(
        order,
        starts,
        disparity,
        planes.value,
        planes.slope_u,
        planes.slope_v,
        (camera.fx, camera.fy, camera.cx, camera.cy),
        SAMPLES,
    )


@njit(cache=True, nogil=True)
def pixels_by_label(labels, count):
    """Flat pixel indices sorted by label 1..count, and where each label's begin, (count + 2,)."""
    flat = labels.ravel()
    starts = np.zeros(count + 2, np.int64)
    for label in flat:
        if label > 0:
            starts[label + 1] += 1
    for label in range(1, count + 2):
        starts[label] += starts[label - 1]
    order = np.empty(starts[count + 1], np.int32)
    place = starts.copy()
    for k in range(flat.size):
        label = flat[k]
        if label > 0:
            order[place[label]] = k
            place[label] += 1
    return order, starts


@njit(cache=True, nogil=True)
def turns(order, starts, q, value, slope_u, slope_v, camera, samples):
    """Turn of every region; see :func:`region_turns`."""
    fx, fy, cx, cy = camera
    columns = q.shape[1]
    count = len(starts) - 2
    found = np.zeros(count + 1)
    points = np.empty((samples, 3))
    normals = np.empty((samples, 3))
    for label in range(1, count + 1):
        size = starts[label + 1] - starts[label]
        picked = min(samples, size)
        n = 0
        for i in range(picked):
            pixel = order[starts[label] + (2 * i + 1) * size // (2 * picked)]
            v, u = pixel // columns, pixel % columns
            if q[v, u] <= 0 or value[v, u] <= 0:
                continue
            z = 1.0 / q[v, u]
            points[n, 0], points[n, 1], points[n, 2] = (u - cx) / fx * z, (v - cy) / fy * z, z
            x, y = slope_u[v, u] * fx, slope_v[v, u] * fy
            w = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
            length = np.sqrt(x * x + y * y + w * w)
            normals[n, 0], normals[n, 1], normals[n, 2] = -x / length, -y / length, -w / length
            n += 1
        along = lengths = 0.0
        for i in range(n):
            for j in range(i):
                dot = apart = turned = 0.0
                for k in range(3):
                    dp = points[i, k] - points[j, k]
                    dn = normals[i, k] - normals[j, k]
                    dot += dp * dn
                    apart += dp * dp
                    turned += dn * dn
                along += dot
                lengths += np.sqrt(apart * turned)
        found[label] = along / max(lengths, 1e-12)
    return found


@njit(cache=True, nogil=True)
def pair_turns(order, starts, pairs, q, value, slope_u, slope_v, camera, samples):
    """How two regions curve from one to the other, per pair (K, 2), (K,) in [-1, 1].

    As :func:`region_turns`, over lines from a pixel of the first to one of the second.
    """
    fx, fy, cx, cy = camera
    columns = q.shape[1]
    found = np.zeros(len(pairs))
    ends = np.empty((2, 6))
    for k in range(len(pairs)):
        along = lengths = 0.0
        for i in range(samples):
            j = (i * SHUFFLE + 7) % samples
            known = True
            for side in range(2):
                region = pairs[k, side]
                size = starts[region + 1] - starts[region]
                place = (2 * (i if side == 0 else j) + 1) * size // (2 * samples)
                pixel = order[starts[region] + place]
                v, u = pixel // columns, pixel % columns
                if q[v, u] <= 0 or value[v, u] <= 0:
                    known = False
                    break
                z = 1.0 / q[v, u]
                x, y = slope_u[v, u] * fx, slope_v[v, u] * fy
                w = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
                length = np.sqrt(x * x + y * y + w * w)
                ends[side, 0], ends[side, 1], ends[side, 2] = (
                    (u - cx) / fx * z,
                    (v - cy) / fy * z,
                    z,
                )
                ends[side, 3], ends[side, 4], ends[side, 5] = -x / length, -y / length, -w / length
            if not known:
                continue
            dot = apart = turned = 0.0
            for c in range(3):
                dp = ends[0, c] - ends[1, c]
                dn = ends[0, c + 3] - ends[1, c + 3]
                dot += dp * dn
                apart += dp * dp
                turned += dn * dn
            along += dot
            lengths += np.sqrt(apart * turned)
        found[k] = along / max(lengths, 1e-12)
    return found
