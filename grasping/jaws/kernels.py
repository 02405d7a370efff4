"""Compiled tests of candidate poses against surface points."""

from __future__ import annotations

import numpy as np
from numba import njit

FAR = 0.02
"""Clearances above this count as this, m. It is five standard deviations of a clearance."""
BLOCKED = -0.012
"""A candidate whose clearance is smaller is given up in any case, m."""


@njit(cache=True)
def clearances(
    rotation, tip, half, owner, points, blocks, groups, label, finger, fixed, sweep, rank, least
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
    least
        Clearance below which a candidate is given up, (n,), m. A value below it is an upper bound.
    """
    start, centre, radius = blocks
    group_start, group_centre, group_radius = groups
    n = len(tip)
    out = np.full((n, 2), FAR)
    low = np.empty((2, rank))
    last = rank - 1
    hulls = _hull(finger), _hull(fixed)
    near = np.empty(len(label))
    for i in range(n):
        low[:] = FAR
        for group in range(len(label)):
            at = _local(rotation[i], tip[i], group_centre[group])
            reach = FAR + group_radius[group]
            near[group] = _nearest(at, half[i], finger, fixed, hulls, False, sweep, reach)
            near[group] -= group_radius[group]
        for group in np.argsort(near):
            side = 0 if label[group] == owner[i] else 1
            if near[group] >= low[side, last]:
                continue
            for block in range(group_start[group], group_start[group + 1]):
                if low[side, last] < least[i]:
                    break
                at = _local(rotation[i], tip[i], centre[block])
                reach = low[side, last] + radius[block]
                if _nearest(at, half[i], finger, fixed, hulls, False, sweep, reach) >= reach:
                    continue
                for k in range(start[block], start[block + 1]):
                    at = _local(rotation[i], tip[i], points[k])
                    bound = low[side, last]
                    distance = _nearest(at, half[i], finger, fixed, hulls, False, sweep, bound)
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
def _local(rotation, tip, point):
    """Return a point in the tool frame."""
    dx, dy, dz = point[0] - tip[0], point[1] - tip[1], point[2] - tip[2]
    return (
        rotation[0, 0] * dx + rotation[1, 0] * dy + rotation[2, 0] * dz,
        rotation[0, 1] * dx + rotation[1, 1] * dy + rotation[2, 1] * dz,
        rotation[0, 2] * dx + rotation[1, 2] * dy + rotation[2, 2] * dz,
    )


@njit(cache=True)
def _nearest(at, half, finger, fixed, hulls, moving, length, bound):
    """Return the least value of the hand's boxes at a point in the tool frame, at most `bound`, m.

    The value is that of :func:`_box_travel` if the hand is `moving`, else of `_box_distance`.
    `hulls` are the boxes around those of the finger and those of the palm.
    """
    x, y, z = at
    side = abs(x) - half
    if _box_value(side, y, z, hulls[0], moving, length, bound) < bound:
        for b in range(len(finger)):
            bound = min(bound, _box_value(side, y, z, finger[b], moving, length, bound))
    if _box_value(x, y, z, hulls[1], moving, length, bound) < bound:
        for b in range(len(fixed)):
            bound = min(bound, _box_value(x, y, z, fixed[b], moving, length, bound))
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
    hulls = _hull(finger), _hull(fixed)
    for i in range(n):
        found[:] = length
        r, t = rotation[i], start[i]
        for block in range(len(radius)):
            reach = radius[block]
            at = _local(r, t, centre[block])
            bound = found[last] + reach
            narrow = allowance - reach
            if _nearest(at, half[i], finger, fixed, hulls, True, narrow, bound) >= bound:
                continue
            for k in range(first[block], first[block + 1]):
                at = _local(r, t, points[k])
                bound = found[last]
                value = _nearest(at, half[i], finger, fixed, hulls, True, allowance, bound)
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


@njit(cache=True)
def contacts(rotation, tip, reach, surface, blocks, measured, pad, facing):
    """Return where the pads meet an object, (n, 9); width -1 where they meet nothing.

    The columns are: offset of the middle along x, width, cosine of the best normal at the pad at +x
    and at -x, whether either side was measured (1 or 0), lowest and highest z of the contact, and
    number of points in it. Lengths in m.

    Parameters
    ----------
    rotation, tip
        Tool frames, (n, 3, 3) and (n, 3), m.
    reach
        Points farther from the tool frame along x do not count, (n,), m.
    surface, blocks
        Points and normals of the object, (N, 3) each, m, and start, centre and radius of the
        spheres around their blocks.
    measured
        Number of points that were measured; they come first.
    pad
        Half of the pad's width, its height, and the depth behind the outermost point to which
        points touch the pad, m.
    facing
        Minimum cosine between a measured normal and the closing axis for its side to be seen, and
        minimum number of such points.
    """
    out = np.zeros((len(tip), 9))
    slab = np.empty((3, len(surface[0])))
    for i in range(len(tip)):
        size = (reach[i], pad[0], pad[1])
        count, seen = _slab(rotation[i], tip[i], size, surface, blocks, measured, slab)
        low, high, right, left = np.inf, np.inf, 0.0, 0.0
        if count:
            low, high, right, left = _faces(slab[:, :seen], slab[0, seen:count], facing)
        if np.isinf(low) or np.isinf(high) or high <= low:
            out[i, 1] = -1.0
            continue
        out[i, 0] = 0.5 * (high + low)
        out[i, 1] = high - low
        out[i, 4] = right
        out[i, 5] = left
        _touching(slab[:, :count], low, high, pad[2], out[i])
    return out


@njit(cache=True)
def _slab(r, tip, size, surface, blocks, measured, slab):
    """Write x, z and cosine of the points between the pads into `slab`.

    Returns their number, and that of the measured ones among them, which come first.
    """
    points, normals = surface
    start, centre, radius = blocks
    count = 0
    seen = 0
    for block in range(len(radius)):
        if not _between(_local(r, tip, centre[block]), size, radius[block]):
            continue
        for k in range(start[block], start[block + 1]):
            at = _local(r, tip, points[k])
            if not _between(at, size, 0.0):
                continue
            n = normals[k]
            slab[0, count], slab[1, count] = at[0], at[2]
            slab[2, count] = r[0, 0] * n[0] + r[1, 0] * n[1] + r[2, 0] * n[2]
            count += 1
            if k < measured:
                seen = count
    return count, seen


@njit(cache=True)
def _between(at, size, radius):
    """Return whether a sphere in the tool frame reaches into the space between the pads.

    `size` is the reach along x, half of the pads' width, and their height, m.
    """
    x, y, z = at
    return (
        abs(y) <= size[1] + radius
        and z <= radius
        and z >= -size[2] - radius
        and abs(x) <= size[0] + radius
    )


@njit(cache=True)
def _faces(seen, solid, facing):
    """Return the least and greatest x of an object, and whether each side was measured.

    A measured side is its second outermost point, or midway between that and the solid's.
    """
    right, right_points = _measured_face(seen, 1.0, facing[0])
    left, left_points = _measured_face(seen, -1.0, facing[0])
    high = low = -np.inf
    for k in range(len(solid)):
        high = max(high, solid[k])
        low = max(low, -solid[k])
    on_right, on_left = right_points >= facing[1], left_points >= facing[1]
    if on_right:
        high = right if np.isinf(high) else 0.5 * (right + high)
    if on_left:
        low = left if np.isinf(low) else 0.5 * (left + low)
    return -low, high, 1.0 * on_right, 1.0 * on_left


@njit(cache=True)
def _measured_face(seen, sign, facing):
    """Return the second largest sign · x of the points that face a pad, and their number."""
    first = second = -np.inf
    count = 0
    for k in range(seen.shape[1]):
        if sign * seen[2, k] > facing:
            count += 1
            value = sign * seen[0, k]
            second = max(second, min(first, value))
            first = max(first, value)
    return second, count


@njit(cache=True)
def _touching(slab, low, high, near, out):
    """Write cosines, z range and number of the points that touch the pads into a row."""
    right = _patch(slab, 1.0, high - near)
    left = _patch(slab, -1.0, -low - near)
    out[2], out[3] = right[0], left[0]
    out[6], out[7] = max(right[1], left[1]), min(right[2], left[2])
    out[8] = right[3] + left[3]


@njit(cache=True)
def _patch(slab, sign, least):
    """Return the largest cosine, the z range and the number of the points above a sign · x."""
    best, z_low, z_high, count = -1.0, np.inf, -np.inf, 0.0
    for k in range(slab.shape[1]):
        if sign * slab[0, k] > least:
            best = max(best, sign * slab[2, k])
            z_low = min(z_low, slab[1, k])
            z_high = max(z_high, slab[1, k])
            count += 1.0
    return best, z_low, z_high, count
