"""Compiled tests of candidate poses against surface points."""

from __future__ import annotations

import numpy as np
from numba import njit

FAR = 0.02
"""Clearances above this count as this, m. It is five standard deviations of a clearance."""
BLOCKED = -0.012
"""A candidate whose clearance is smaller is given up, m."""


@njit(cache=True)
def clearances(
    rotation, tip, half, owner, points, blocks, groups, label, finger, fixed, sweep, rank
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
    """
    start, centre, radius = blocks
    group_start, group_centre, group_radius = groups
    n = len(tip)
    out = np.full((n, 2), FAR)
    low = np.empty((2, rank))
    last = rank - 1
    for i in range(n):
        low[:] = FAR
        for group in range(len(label)):
            side = 0 if label[group] == owner[i] else 1
            x, y, z = _local(rotation[i], tip[i], group_centre[group])
            reach = low[side, last] + group_radius[group]
            if _hand_distance(x, y, z, half[i], finger, fixed, sweep, reach) >= reach:
                continue
            for block in range(group_start[group], group_start[group + 1]):
                x, y, z = _local(rotation[i], tip[i], centre[block])
                reach = low[side, last] + radius[block]
                if _hand_distance(x, y, z, half[i], finger, fixed, sweep, reach) >= reach:
                    continue
                for k in range(start[block], start[block + 1]):
                    x, y, z = _local(rotation[i], tip[i], points[k])
                    bound = low[side, last]
                    distance = _hand_distance(x, y, z, half[i], finger, fixed, sweep, bound)
                    if distance < bound:
                        _insert(low[side], distance)
            if low[side, last] < BLOCKED:
                break
        out[i, 0] = low[0, last]
        out[i, 1] = low[1, last]
    return out


@njit(cache=True)
def _insert(low, value):
    """Insert a value into a sorted array, and drop its last one."""
    place = len(low) - 1
    while place > 0 and low[place - 1] > value:
        low[place] = low[place - 1]
        place -= 1
    low[place] = value


@njit(cache=True)
def _local(rotation, tip, point):
    """Return a point in the tool frame."""
    dx, dy, dz = point[0] - tip[0], point[1] - tip[1], point[2] - tip[2]
    return (
        rotation[0, 0] * dx + rotation[1, 0] * dy + rotation[2, 0] * dz,
        rotation[0, 1] * dx + rotation[1, 1] * dy + rotation[2, 1] * dz,
        rotation[0, 2] * dx + rotation[1, 2] * dy + rotation[2, 2] * dz,
    )


@njit(cache=True)
def _hand_distance(x, y, z, half, finger, fixed, sweep, bound):
    """Return the signed distance of a point in the tool frame from the hand, at most `bound`, m."""
    distance = bound
    for b in range(len(finger)):
        distance = min(distance, _box_distance(abs(x) - half, y, z, finger[b], sweep, distance))
    for b in range(len(fixed)):
        distance = min(distance, _box_distance(x, y, z, fixed[b], sweep, distance))
    return distance


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
def travels(rotation, start, half, points, blocks, finger, fixed, length, allowance, rank):
    """Return the travel of boxes until they touch the point of a rank, (n,), m.

    The travel is negative where that point lies inside a box at the start.

    Parameters
    ----------
    rotation, start
        Tool frames at the start, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    points, blocks
        Points (N, 3), and start, centre and radius of the spheres around their blocks.
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
    n = len(start)
    out = np.full(n, length)
    found = np.empty(rank)
    last = rank - 1
    for i in range(n):
        found[:] = length
        r, t = rotation[i], start[i]
        for block in range(len(radius)):
            reach = radius[block]
            x, y, z = _local(r, t, centre[block])
            bound = found[last] + reach
            if _until(x, y, z, half[i], finger, fixed, allowance - reach, bound) >= bound:
                continue
            for k in range(first[block], first[block + 1]):
                x, y, z = _local(r, t, points[k])
                value = _until(x, y, z, half[i], finger, fixed, allowance, found[last])
                if value < found[last]:
                    _insert(found, value)
        out[i] = found[last]
    return out


@njit(cache=True)
def _until(x, y, z, half, finger, fixed, allowance, bound):
    """Return the travel until the hand touches a point, m; `bound` if that is later or never."""
    travel = bound
    for b in range(len(finger)):
        travel = min(travel, _box_until(abs(x) - half, y, z, finger[b], allowance, bound))
    for b in range(len(fixed)):
        travel = min(travel, _box_until(x, y, z, fixed[b], allowance, bound))
    return travel


@njit(cache=True)
def _box_until(x, y, z, box, allowance, bound):
    if x < box[0, 0] + allowance or x > box[1, 0] - allowance:
        return bound
    if y < box[0, 1] + allowance or y > box[1, 1] - allowance:
        return bound
    if z < box[0, 2] + allowance:
        return bound
    return z - box[1, 2]


@njit(cache=True)
def contacts(rotation, tip, points, normals, measured, half_y, height, near, facing, min_seen):
    """Return where the pads meet an object, (n, 9); width -1 where they meet nothing.

    The columns are: offset of the middle along x, width, cosine of the best normal at the pad at +x
    and at -x, whether either side was measured (1 or 0), lowest and highest z of the contact, and
    number of points in it. Lengths in m.

    Parameters
    ----------
    rotation, tip
        Tool frames, (n, 3, 3) and (n, 3), m.
    points, normals
        Surface of the object, (N, 3) each, m.
    measured
        Number of points that were measured; they come first.
    half_y, height
        Half of the pad's width, and its height, m.
    near
        Points within this distance of the outermost one touch the pad, m.
    facing
        Minimum cosine between a measured normal and the closing axis for its side to be seen.
    min_seen
        Minimum number of such points.
    """
    n = len(tip)
    out = np.zeros((n, 9))
    total = len(points)
    x = np.empty(total)
    z = np.empty(total)
    c = np.empty(total)
    for i in range(n):
        count = 0
        seen = 0
        solid = np.array([np.inf, -np.inf])
        first = np.full((2, 3), -np.inf)
        sides = np.zeros(2)
        for k in range(total):
            dx = points[k, 0] - tip[i, 0]
            dy = points[k, 1] - tip[i, 1]
            dz = points[k, 2] - tip[i, 2]
            py = rotation[i, 0, 1] * dx + rotation[i, 1, 1] * dy + rotation[i, 2, 1] * dz
            if abs(py) > half_y:
                continue
            pz = rotation[i, 0, 2] * dx + rotation[i, 1, 2] * dy + rotation[i, 2, 2] * dz
            if pz > 0.0 or pz < -height:
                continue
            px = rotation[i, 0, 0] * dx + rotation[i, 1, 0] * dy + rotation[i, 2, 0] * dz
            pc = (
                rotation[i, 0, 0] * normals[k, 0]
                + rotation[i, 1, 0] * normals[k, 1]
                + rotation[i, 2, 0] * normals[k, 2]
            )
            x[count], z[count], c[count] = px, pz, pc
            count += 1
            if k < measured:
                seen = count
                for s in range(2):
                    sign = 1.0 if s == 0 else -1.0
                    if sign * pc > facing:
                        sides[s] += 1.0
                        v = sign * px
                        if v > first[s, 0]:
                            first[s, 2] = first[s, 1]
                            first[s, 1] = first[s, 0]
                            first[s, 0] = v
                        elif v > first[s, 1]:
                            first[s, 2] = first[s, 1]
                            first[s, 1] = v
                        elif v > first[s, 2]:
                            first[s, 2] = v
            else:
                solid[0] = min(solid[0], px)
                solid[1] = max(solid[1], px)
        if count == 0 or (solid[1] < solid[0] and seen == 0):
            out[i, 1] = -1.0
            continue
        high, low = solid[1], solid[0]
        if sides[0] >= min_seen:
            high = first[0, 1] if np.isinf(high) else 0.5 * (first[0, 1] + high)
        if sides[1] >= min_seen:
            low = -first[1, 1] if np.isinf(low) else 0.5 * (-first[1, 1] + low)
        if np.isinf(high) or np.isinf(low) or high <= low:
            out[i, 1] = -1.0
            continue
        best = np.array([-1.0, -1.0])
        z_low = np.array([np.inf, np.inf])
        z_high = np.array([-np.inf, -np.inf])
        touching = 0
        for k in range(count):
            for s in range(2):
                gap = high - x[k] if s == 0 else x[k] - low
                if gap < near:
                    best[s] = max(best[s], c[k] if s == 0 else -c[k])
                    z_low[s] = min(z_low[s], z[k])
                    z_high[s] = max(z_high[s], z[k])
                    touching += 1
        out[i, 0] = 0.5 * (high + low)
        out[i, 1] = high - low
        out[i, 2] = best[0]
        out[i, 3] = best[1]
        out[i, 4] = 1.0 if sides[0] >= min_seen else 0.0
        out[i, 5] = 1.0 if sides[1] >= min_seen else 0.0
        out[i, 6] = max(z_low[0], z_low[1])
        out[i, 7] = min(z_high[0], z_high[1])
        out[i, 8] = touching
    return out
