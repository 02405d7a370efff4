"""Compiled tests of candidate poses against surface points.

The loops that transform points and compute their distances have no branches, so that the processor
handles several points at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FAR = 0.02
"""Clearances above this count as this, m. It is five standard deviations of a clearance."""
BLOCKED = -0.012
"""A candidate whose clearance is smaller is given up in any case, m."""


class Limits(NamedTuple):
    """Which clearances are computed."""

    rank: int
    """Number of the distance that counts, from the smallest, >= 1. Single points are noise."""
    least: NDArray[np.float64]
    """Clearance below which a candidate is given up, (n,), m. Then both of its clearances are upper
    bounds."""
    most: NDArray[np.float64]
    """Largest clearances, (n, 2), m. Larger ones are returned as this value: -inf skips a side."""


class Boxes(NamedTuple):
    """The boxes of a hand."""

    boxes: NDArray[np.float64]
    """Boxes of the finger at +x, then those of the palm and the camera, (b, 2, 3), m."""
    fingers: int
    """Number of boxes of the finger. Their x counts from the pad, on both sides."""
    moving: bool
    """Whether values are those of :func:`_travel_values`, else those of `_distance_values`."""


class Memory(NamedTuple):
    """Arrays that are overwritten for each part of the points."""

    local: NDArray[np.float64]
    """Points in the tool frame, (3, N), m."""
    near: NDArray[np.float64]
    """Values of the groups for each box, and the least ones, (b + 1, G), m."""
    gap: NDArray[np.float64]
    """The same of the blocks of a group, (b + 1, B), m."""
    value: NDArray[np.float64]
    """Values of the points of a block, (N,), m."""
    group_order: NDArray[np.int64]
    """Groups, the nearest first, (G,)."""
    order: NDArray[np.int64]
    """Blocks of a group that may count, the nearest first, (B,)."""
    zeros: NDArray[np.float64]
    """The radius of points, (N,), m."""


@njit(cache=True, nogil=True)
def clearances(rotation, tip, half, owner, points, label, finger, fixed, sweep, limits):
    """Return the clearance of each candidate from its own object's points and from others', (n, 2).

    The clearance is the signed distance of a point from the hand's boxes, m: the third smallest one
    if the rank is 3. It is negative inside. The boxes reach back by the approach.

    Parameters
    ----------
    rotation, tip
        Tool frames, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    owner
        Object of each candidate, (n,).
    points, label
        `columns` and `label` of :class:`.PointBlocks`.
    finger
        Boxes of the finger at +x, (f, 2, 3), m.
    fixed
        Boxes of the palm and the camera, (p, 2, 3), m.
    sweep
        Length of the straight approach, m.
    limits
        :class:`Limits`.
    """
    rank, least, most = limits
    hand = Boxes(np.concatenate((finger, fixed)), len(finger), False)
    hand.boxes[:, 0, 2] -= sweep
    memory = _memory(points, hand)
    out = np.empty((len(tip), 2))
    side = np.empty(len(label), np.int64)
    low = np.empty((2, rank))
    for i in range(len(tip)):
        low[0], low[1] = most[i, 0], most[i, 1]
        for group in range(len(label)):
            side[group] = 0 if label[group] == owner[i] else 1
        frame = tool_frame(rotation[i], tip[i])
        _lower(low, side, frame, half[i], hand, points, least[i], memory)
        out[i, 0], out[i, 1] = low[0, rank - 1], low[1, rank - 1]
    return out


@njit(cache=True, nogil=True)
def travels(rotation, start, half, points, finger, fixed, length, allowance, rank):
    """Return the travel of boxes until they touch the point of a rank, (n,), m.

    The travel is negative where that point lies inside a box at the start.

    Parameters
    ----------
    rotation, start
        Tool frames at the start, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    points
        `columns` of :class:`.PointBlocks`.
    finger, fixed
        Boxes of the finger at +x, and of the palm, (k, 2, 3), m.
    length
        Maximum travel, m.
    allowance
        Width by which the boxes are smaller across the approach, m.
    rank
        Number of the point that counts, from the first one.
    """
    hand = Boxes(np.concatenate((finger, fixed)), len(finger), True)
    hand.boxes[:, 0] += allowance
    hand.boxes[:, 1, :2] -= allowance
    memory = _memory(points, hand)
    out = np.empty(len(start))
    side = np.zeros(memory.near.shape[1], np.int64)
    low = np.empty((1, rank))
    for i in range(len(start)):
        low[:] = length
        frame = tool_frame(rotation[i], start[i])
        _lower(low, side, frame, half[i], hand, points, -np.inf, memory)
        out[i] = low[0, rank - 1]
    return out


@njit(cache=True, nogil=True)
def tool_frame(r, tip):
    """Return the axes and the origin of a tool frame: not arrays, which are loaded every time."""
    return (
        (r[0, 0], r[1, 0], r[2, 0]),
        (r[0, 1], r[1, 1], r[2, 1]),
        (r[0, 2], r[1, 2], r[2, 2]),
        (tip[0], tip[1], tip[2]),
    )


@njit(cache=True, nogil=True)
def to_tool(frame, point):
    """Return a point in the tool frame."""
    x, y, z, tip = frame
    d = point[0] - tip[0], point[1] - tip[1], point[2] - tip[2]
    return dot(x, d), dot(y, d), dot(z, d)


@njit(cache=True, nogil=True)
def dot(a, b):
    """Return the scalar product of two vectors of three numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def columns_to_tool(frame, points, first, last, local):
    """Write the points [first, last) of (3, N) in the tool frame to the start of `local` (3, N)."""
    x, y, z, tip = frame
    px, py, pz = points[0, first:last], points[1, first:last], points[2, first:last]
    lx, ly, lz = local[0], local[1], local[2]
    for k in range(len(px)):
        dx, dy, dz = px[k] - tip[0], py[k] - tip[1], pz[k] - tip[2]
        lx[k] = x[0] * dx + x[1] * dy + x[2] * dz
        ly[k] = y[0] * dx + y[1] * dy + y[2] * dz
        lz[k] = z[0] * dx + z[1] * dy + z[2] * dz


@njit(cache=True, nogil=True)
def _memory(points, hand):
    cloud, blocks, groups = points
    n, b = max(cloud.shape[1], 1), len(hand.boxes)
    return Memory(
        np.empty((3, n)),
        np.empty((b + 1, len(groups[2]))),
        np.empty((b + 1, len(blocks[2]))),
        np.empty(n),
        np.empty(len(groups[2]), np.int64),
        np.empty(len(blocks[2]), np.int64),
        np.zeros(n),
    )


@njit(cache=True, nogil=True)
def _lower(low, side, frame, half, hand, points, least, memory):
    """Insert the least values of points into the sorted rows of `low` (sides, rank).

    A value counts for the side (G,) of its group. The search ends when a side's last value is below
    `least`.
    """
    cloud, blocks, groups = points
    last = low.shape[1] - 1
    near, gap = memory.near, memory.gap
    count = _values(frame, half, hand, groups[1:], (0, len(side)), memory.local, near)
    for group in memory.group_order[: _nearest(near[-1, :count], np.inf, memory.group_order)]:
        row = low[side[group]]
        if near[-1, group] >= row[last]:
            continue
        span = groups[0][group], groups[0][group + 1]
        count = _values(frame, half, hand, blocks[1:], span, memory.local, gap)
        for place in memory.order[: _nearest(gap[-1, :count], row[last], memory.order)]:
            if gap[-1, place] >= row[last] or row[last] < least:
                break
            begin, end = blocks[0][span[0] + place], blocks[0][span[0] + place + 1]
            columns_to_tool(frame, cloud, begin, end, memory.local)
            value = memory.value[: end - begin]
            value[:] = np.inf
            for b in range(len(hand.boxes)):
                if gap[b, place] < row[last]:
                    _box_values(memory.local, memory.zeros, half, hand, b, value)
            for k in range(len(value)):
                if value[k] < row[last]:
                    _insert(row, value[k])
        if row[last] < least:
            break


@njit(cache=True, nogil=True)
def _values(frame, half, hand, spheres, span, local, out):
    """Write the least values of points in spheres for each box, and of all, into `out` (b + 1, n).

    `spheres` are centres (3, N) and radii, and `span` is the first one and the end. Returns n.
    """
    centre, radius = spheres
    count = span[1] - span[0]
    columns_to_tool(frame, centre, span[0], span[1], local)
    out[:, :count] = np.inf
    whole = out[-1, :count]
    for b in range(len(hand.boxes)):
        row = out[b, :count]
        _box_values(local, radius[span[0] : span[1]], half, hand, b, row)
        for k in range(count):
            whole[k] = row[k] if row[k] < whole[k] else whole[k]
    return count


@njit(cache=True, nogil=True)
def _nearest(value, bound, order):
    """Write the places of the values below a bound into `order`, sorted; return their number."""
    count = 0
    for k in range(len(value)):
        if value[k] < bound:
            place = count
            while place > 0 and value[order[place - 1]] > value[k]:
                order[place] = order[place - 1]
                place -= 1
            order[place] = k
            count += 1
    return count


@njit(cache=True, nogil=True)
def _insert(low, value):
    """Insert a value into a sorted array, and drop its last one."""
    place = len(low) - 1
    while place > 0 and low[place - 1] > value:
        low[place] = low[place - 1]
        place -= 1
    low[place] = value


@njit(cache=True, nogil=True)
def _box_values(local, radius, half, hand, b, out):
    """Lower the values in `out` to those of a box, less the radius of the spheres."""
    # The finger's box stands for those of both fingers.
    both = b < hand.fingers
    if hand.moving:
        _travel_values(local, radius, half, both, hand.boxes[b], out)
    else:
        _distance_values(local, radius, half, both, hand.boxes[b], out)


@njit(cache=True, nogil=True)
def _distance_values(local, radius, half, both, box, out):
    """Lower values to the signed distances from a box, m."""
    lx, ly, lz = local[0], local[1], local[2]
    x0, y0, z0 = box[0, 0], box[0, 1], box[0, 2]
    x1, y1, z1 = box[1, 0], box[1, 1], box[1, 2]
    for k in range(len(out)):
        x = abs(lx[k]) - half if both else lx[k]
        qx = _larger(x0 - x, x - x1)
        qy = _larger(y0 - ly[k], ly[k] - y1)
        qz = _larger(z0 - lz[k], lz[k] - z1)
        inside = _larger(qx, _larger(qy, qz))
        inside = inside if inside < 0.0 else 0.0
        qx, qy, qz = _larger(qx, 0.0), _larger(qy, 0.0), _larger(qz, 0.0)
        value = inside + np.sqrt(qx * qx + qy * qy + qz * qz) - radius[k]
        out[k] = value if value < out[k] else out[k]


@njit(cache=True, nogil=True)
def _travel_values(local, radius, half, both, box, out):
    """Lower values to the travels until a box touches points, m."""
    lx, ly, lz = local[0], local[1], local[2]
    x0, y0, z0 = box[0, 0], box[0, 1], box[0, 2]
    x1, y1, z1 = box[1, 0], box[1, 1], box[1, 2]
    for k in range(len(out)):
        x = abs(lx[k]) - half if both else lx[k]
        qx = _larger(x0 - x, x - x1)
        qy = _larger(y0 - ly[k], ly[k] - y1)
        beside = _larger(_larger(qx, qy), z0 - lz[k]) - radius[k]
        value = lz[k] - z1 - radius[k] if beside <= 0.0 else np.inf
        out[k] = value if value < out[k] else out[k]


@njit(cache=True, nogil=True)
def _larger(a, b):
    """Return the larger number. `max` handles NaN, and so prevents vector instructions."""
    return a if a > b else b
