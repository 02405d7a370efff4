"""Compiled tests of candidate poses against surface points."""

from __future__ import annotations

import numpy as np
from numba import njit

FAR = 0.02
"""Clearances above this count as this, m. It is five standard deviations of a clearance."""
BLOCKED = -0.012
"""A candidate whose third deepest point lies deeper is given up, m."""


@njit(cache=True)
def clearances(rotation, tip, half, owner, points, labels, finger, fixed, sweep):
    """Return the clearance of each candidate from its own object's points and from others', (n, 2).

    The clearance is the third smallest signed distance of a point from the hand's boxes, m. It is
    negative inside. Single points are noise. The boxes reach back by the approach.

    Parameters
    ----------
    rotation, tip
        Tool frames, (n, 3, 3) and (n, 3), m.
    half
        Half of the opening, (n,), m.
    owner
        Object of each candidate, (n,).
    points, labels
        Points (N, 3), m, and the object of each, (N,).
    finger
        Boxes of the finger at +x, (f, 2, 3), m.
    fixed
        Boxes of the palm and the camera, (p, 2, 3), m.
    sweep
        Length of the straight approach, m.
    """
    n = len(tip)
    out = np.full((n, 2), FAR)
    for i in range(n):
        # The three smallest distances for the own object and for others.
        low = np.full((2, 3), FAR)
        for k in range(len(points)):
            dx = points[k, 0] - tip[i, 0]
            dy = points[k, 1] - tip[i, 1]
            dz = points[k, 2] - tip[i, 2]
            z = rotation[i, 0, 2] * dx + rotation[i, 1, 2] * dy + rotation[i, 2, 2] * dz
            if z > FAR:
                continue
            y = rotation[i, 0, 1] * dx + rotation[i, 1, 1] * dy + rotation[i, 2, 1] * dz
            x = rotation[i, 0, 0] * dx + rotation[i, 1, 0] * dy + rotation[i, 2, 0] * dz
            side = 0 if labels[k] == owner[i] else 1
            bound = low[side, 2]
            distance = FAR
            for b in range(len(finger)):
                d = _box_distance(abs(x) - half[i], y, z, finger[b], sweep, bound)
                if d < distance:
                    distance = d
            for b in range(len(fixed)):
                d = _box_distance(x, y, z, fixed[b], sweep, bound)
                if d < distance:
                    distance = d
            if distance < bound:
                if distance < low[side, 0]:
                    low[side, 2] = low[side, 1]
                    low[side, 1] = low[side, 0]
                    low[side, 0] = distance
                elif distance < low[side, 1]:
                    low[side, 2] = low[side, 1]
                    low[side, 1] = distance
                else:
                    low[side, 2] = distance
                if low[side, 2] < BLOCKED:
                    break
        out[i, 0] = low[0, 2]
        out[i, 1] = low[1, 2]
    return out


@njit(cache=True)
def _box_distance(x, y, z, box, sweep, bound):
    """Return the signed distance of a point from a box that reaches back by `sweep`, m.

    Distances above `bound` are returned as ``FAR``.
    """
    qx = max(box[0, 0] - x, x - box[1, 0])
    if qx > bound:
        return FAR
    qy = max(box[0, 1] - y, y - box[1, 1])
    if qy > bound:
        return FAR
    qz = max(box[0, 2] - sweep - z, z - box[1, 2])
    if qz > bound:
        return FAR
    largest = max(qx, max(qy, qz))
    if largest <= 0.0:
        return largest
    return np.sqrt(max(qx, 0.0) ** 2 + max(qy, 0.0) ** 2 + max(qz, 0.0) ** 2)


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
