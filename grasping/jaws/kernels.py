"""Compiled tests of candidate poses against surface points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FAR = 0.02
"""Clearances above this count as this, m. It is five standard deviations of a clearance."""
BLOCKED = -0.012
"""A candidate whose clearance is smaller is given up in any case, m."""


class Boxes(NamedTuple):
    """The boxes of a hand."""

    boxes: NDArray[np.float64]
    """Boxes of the finger at +x, then those of the palm and the camera, (b, 2, 3), m."""
    fingers: int
    """Number of boxes of the finger. Their x counts from the pad, on both sides."""
    finger_hull: NDArray[np.float64]
    """Box around those of the finger, (2, 3), m."""
    fixed_hull: NDArray[np.float64]
    """Box around the others, (2, 3), m."""


@njit(cache=True)
def clearances(
    rotation, tip, half, owner, points, blocks, groups, label, finger, fixed, sweep, rank, limits
):
    """Return the clearance of each candidate from its own object's points and from others', (n, 2).

    The clearance is the signed distance of a point from the hand's boxes, m: the third smallest one
    if `rank` is 3. It is negative inside. Single points are noise. The boxes reach back by the
    approach.

    Parameters
    ----------
    rotation, tip
        Tool frames, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    owner
        Object of each candidate, (n,).
    points, blocks, groups, label
        Fields of :class:`.PointBlocks`; start, centre and radius of both sets of spheres.
    finger
        Boxes of the finger at +x, (f, 2, 3), m.
    fixed
        Boxes of the palm and the camera, (p, 2, 3), m.
    sweep
        Length of the straight approach, m.
    rank
        Number of the distance that counts, from the smallest, at least 1.
    limits
        Clearance below which a candidate is given up, (n,), m, and largest clearances, (n, 2), m.
        A value below the first one is an upper bound. Points beyond the second ones do not count.
    """
    least, most = limits
    start, centre, radius = blocks
    group_start, group_centre, group_radius = groups
    n = len(tip)
    out = np.empty((n, 2))
    low = np.empty((2, rank))
    last = rank - 1
    hand = Boxes(np.concatenate((finger, fixed)), len(finger), _hull(finger), _hull(fixed))
    chosen = np.empty(len(hand.boxes), np.int64)
    near = np.empty(len(label))
    for i in range(n):
        low[0], low[1] = most[i, 0], most[i, 1]
        frame = tool_frame(rotation[i], tip[i])
        for group in range(len(label)):
            at = to_tool(frame, group_centre[group])
            reach = FAR + group_radius[group]
            few = _near_boxes(at, half[i], hand, False, sweep, reach, chosen)
            near[group] = _nearest(few, chosen, at, half[i], hand, False, sweep, reach)
            near[group] -= group_radius[group]
        for group in np.argsort(near):
            side = 0 if label[group] == owner[i] else 1
            if near[group] >= low[side, last]:
                continue
            for block in range(group_start[group], group_start[group + 1]):
                if low[side, last] < least[i]:
                    break
                at = to_tool(frame, centre[block])
                reach = low[side, last] + radius[block]
                few = _near_boxes(at, half[i], hand, False, sweep, reach, chosen)
                if few == 0:
                    continue
                for k in range(start[block], start[block + 1]):
                    at = to_tool(frame, points[k])
                    bound = low[side, last]
                    distance = _nearest(few, chosen, at, half[i], hand, False, sweep, bound)
                    if distance < bound:
                        _insert(low[side], distance)
            if low[side, last] < least[i]:
                break
        out[i, 0] = low[0, last]
        out[i, 1] = low[1, last]
    return out


@njit(cache=True)
def _hull(boxes):
    """Return the box around boxes, (2, 3), m."""
    hull = np.empty((2, 3))
    hull[0], hull[1] = np.inf, -np.inf
    for box in boxes:
        for k in range(3):
            hull[0, k] = min(hull[0, k], box[0, k])
            hull[1, k] = max(hull[1, k], box[1, k])
    return hull


@njit(cache=True)
def _insert(low, value):
    """Insert a value into a sorted array, and drop its last one."""
    place = len(low) - 1
    while place > 0 and low[place - 1] > value:
        low[place] = low[place - 1]
        place -= 1
    low[place] = value


@njit(cache=True)
def tool_frame(r, tip):
    """Return the axes and the origin of a tool frame: not arrays, which are loaded every time."""
    return (
        (r[0, 0], r[1, 0], r[2, 0]),
        (r[0, 1], r[1, 1], r[2, 1]),
        (r[0, 2], r[1, 2], r[2, 2]),
        (tip[0], tip[1], tip[2]),
    )


@njit(cache=True)
def to_tool(frame, point):
    """Return a point in the tool frame."""
    x, y, z, tip = frame
    d = point[0] - tip[0], point[1] - tip[1], point[2] - tip[2]
    return dot(x, d), dot(y, d), dot(z, d)


@njit(cache=True)
def dot(a, b):
    """Return the scalar product of two vectors of three numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _near_boxes(at, half, hand, moving, length, bound, chosen):
    """Return the number of boxes with a value below `bound` at a point in the tool frame.

    The value is that of :func:`_box_travel` if the hand is `moving`, else of `_box_distance`. The
    indices of the boxes are written into `chosen`.
    """
    x, y, z = at
    side = abs(x) - half
    count = 0
    if _box_value(side, y, z, hand.finger_hull, moving, length, bound) < bound:
        for b in range(hand.fingers):
            if _box_value(side, y, z, hand.boxes[b], moving, length, bound) < bound:
                chosen[count] = b
                count += 1
    if _box_value(x, y, z, hand.fixed_hull, moving, length, bound) < bound:
        for b in range(hand.fingers, len(hand.boxes)):
            if _box_value(x, y, z, hand.boxes[b], moving, length, bound) < bound:
                chosen[count] = b
                count += 1
    return count


@njit(cache=True)
def _nearest(few, chosen, at, half, hand, moving, length, bound):
    """Return the least value of the first `few` chosen boxes at a point, at most `bound`, m."""
    x, y, z = at
    side = abs(x) - half
    for k in range(few):
        b = chosen[k]
        across = side if b < hand.fingers else x
        bound = min(bound, _box_value(across, y, z, hand.boxes[b], moving, length, bound))
    return bound


@njit(cache=True)
def _box_value(x, y, z, box, moving, length, bound):
    if moving:
        return _box_travel(x, y, z, box, length, bound)
    return _box_distance(x, y, z, box, length, bound)


@njit(cache=True)
def _box_distance(x, y, z, box, sweep, bound):
    """Return the signed distance of a point from a box that reaches back by `sweep`, m.

    Distances above `bound` are returned as infinity.
    """
    qx = max(box[0, 0] - x, x - box[1, 0])
    if qx > bound:
        return np.inf
    qy = max(box[0, 1] - y, y - box[1, 1])
    if qy > bound:
        return np.inf
    qz = max(box[0, 2] - sweep - z, z - box[1, 2])
    if qz > bound:
        return np.inf
    largest = max(qx, max(qy, qz))
    if largest <= 0.0:
        return largest
    return np.sqrt(max(qx, 0.0) ** 2 + max(qy, 0.0) ** 2 + max(qz, 0.0) ** 2)


@njit(cache=True)
def travels(rotation, start, half, points, blocks, groups, finger, fixed, length, allowance, rank):
    """Return the travel of boxes until they touch the point of a rank, (n,), m.

    The travel is negative where that point lies inside a box at the start.

    Parameters
    ----------
    rotation, start
        Tool frames at the start, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    points, blocks, groups
        Points (N, 3), and start, centre and radius of the spheres around blocks and groups.
    finger, fixed
        Boxes of the finger at +x, and of the palm, (k, 2, 3), m.
    length
        Maximum travel, m.
    allowance
        Width by which the boxes are smaller across the approach, m.
    rank
        Number of the point that counts, from the first one.
    """
    first, centre, radius = blocks
    group_first, group_centre, group_radius = groups
    n = len(start)
    out = np.full(n, length)
    found = np.empty(rank)
    last = rank - 1
    hand = Boxes(np.concatenate((finger, fixed)), len(finger), _hull(finger), _hull(fixed))
    chosen = np.empty(len(hand.boxes), np.int64)
    near = np.empty(len(group_radius))
    for i in range(n):
        found[:] = length
        frame = tool_frame(rotation[i], start[i])
        for group in range(len(near)):
            reach = group_radius[group]
            at = to_tool(frame, group_centre[group])
            bound, narrow = length + reach, allowance - reach
            few = _near_boxes(at, half[i], hand, True, narrow, bound, chosen)
            near[group] = _nearest(few, chosen, at, half[i], hand, True, narrow, bound) - reach
        for group in np.argsort(near):
            if near[group] >= found[last]:
                break
            for block in range(group_first[group], group_first[group + 1]):
                reach = radius[block]
                at = to_tool(frame, centre[block])
                bound, narrow = found[last] + reach, allowance - reach
                few = _near_boxes(at, half[i], hand, True, narrow, bound, chosen)
                if few == 0:
                    continue
                for k in range(first[block], first[block + 1]):
                    at = to_tool(frame, points[k])
                    bound = found[last]
                    value = _nearest(few, chosen, at, half[i], hand, True, allowance, bound)
                    if value < bound:
                        _insert(found, value)
        out[i] = found[last]
    return out


@njit(cache=True)
def _box_travel(x, y, z, box, allowance, bound):
    """Return the travel until a box touches a point, m; `bound` if that is never."""
    if x < box[0, 0] + allowance or x > box[1, 0] - allowance:
        return bound
    if y < box[0, 1] + allowance or y > box[1, 1] - allowance:
        return bound
    if z < box[0, 2] + allowance:
        return bound
    return z - box[1, 2]
