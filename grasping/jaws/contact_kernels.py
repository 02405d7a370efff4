"""Compiled contacts of the pads with the points of an object."""

from __future__ import annotations

import numpy as np
from numba import njit

from .kernels import dot, to_tool, tool_frame

FACE_DEPTH = 0.01
"""Maximum depth of a measured face behind the outermost reading, m. A deeper one is the inner side
of the opposite wall of a vessel."""


@njit(cache=True, nogil=True)
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
    slab = np.empty((3, len(surface[0]) + 1))
    for i in range(len(tip)):
        size = (reach[i], pad[0], pad[1])
        frame = tool_frame(rotation[i], tip[i])
        count, seen = _slab(frame, size, surface, blocks, measured, slab)
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


@njit(cache=True, nogil=True)
def _slab(frame, size, surface, blocks, measured, slab):
    """Write x, z and cosine of the points between the pads into `slab`.

    Returns their number, and that of the measured ones among them, which come first.
    """
    points, normals = surface
    start, centre, radius = blocks
    count = 0
    seen = 0
    for block in range(len(radius)):
        if not _between(to_tool(frame, centre[block]), size, radius[block]):
            continue
        for k in range(start[block], start[block + 1]):
            at = to_tool(frame, points[k])
            # The next point overwrites one that does not count. A branch costs more.
            slab[0, count], slab[1, count] = at[0], at[2]
            slab[2, count] = dot(frame[0], (normals[k, 0], normals[k, 1], normals[k, 2]))
            count += _between(at, size, 0.0)
        if start[block] < measured:
            seen = count
    return count, seen


@njit(cache=True, nogil=True)
def _between(at, size, radius):
    """Return whether a sphere in the tool frame reaches into the space between the pads.

    `size` is the reach along x, half of the pads' width, and their height, m.
    """
    x, y, z = at
    return (
        (abs(y) <= size[1] + radius)
        & (z <= radius)
        & (z >= -size[2] - radius)
        & (abs(x) <= size[0] + radius)
    )


@njit(cache=True, nogil=True)
def _faces(seen, solid, facing):
    """Return the least and greatest x of an object, and whether each side was measured.

    A side is that of the solid, or the second outermost point of a measured one if that lies
    farther out. The edge of what is seen lies inside the object: it proves a least width.
    """
    right, right_points = _measured_face(seen, 1.0, facing[0])
    left, left_points = _measured_face(seen, -1.0, facing[0])
    high = low = -np.inf
    for k in range(len(solid)):
        high = max(high, solid[k])
        low = max(low, -solid[k])
    on_right, on_left = right_points >= facing[1], left_points >= facing[1]
    if on_right:
        high = max(right, high)
    if on_left:
        low = max(left, low)
    return -low, high, 1.0 * on_right, 1.0 * on_left


@njit(cache=True, nogil=True)
def _measured_face(seen, sign, facing):
    """Return the second largest sign · x of the points that face a pad, and their number.

    The number is 0 if they lie deeper than `FACE_DEPTH` behind the second outermost point.
    """
    first = second = first_of_all = second_of_all = -np.inf
    count = 0
    for k in range(seen.shape[1]):
        value = sign * seen[0, k]
        second_of_all = max(second_of_all, min(first_of_all, value))
        first_of_all = max(first_of_all, value)
        if sign * seen[2, k] > facing:
            count += 1
            second = max(second, min(first, value))
            first = max(first, value)
    if second < second_of_all - FACE_DEPTH:
        count = 0
    return second, count


@njit(cache=True, nogil=True)
def _touching(slab, low, high, near, out):
    """Write cosines, z range and number of the points that touch the pads into a row."""
    right = _patch(slab, 1.0, high - near)
    left = _patch(slab, -1.0, -low - near)
    out[2], out[3] = right[0], left[0]
    out[6], out[7] = max(right[1], left[1]), min(right[2], left[2])
    out[8] = right[3] + left[3]


@njit(cache=True, nogil=True)
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
