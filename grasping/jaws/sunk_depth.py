"""How deep a hand is sunk in the surfaces of objects: the shortest way out of their points.

The distance of a single point from the nearest face of a finger is at most half the finger's
thickness, also where a fingertip is sunk by 20 mm in a flat top. The way out of all points is not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .grasp import APPROACH
from .kernels import columns_to_tool, tool_frame

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .point_blocks import PointBlocks

NOISE_POINTS = 4
"""Maximum number of points inside a box that count as noise."""
NOISE_SHARE = 3
"""One of so many points inside a box counts as noise, at least one."""
WAYS = 5
"""Ways out of a box: along its closing direction and the row of fingers, both ways, and back."""


def sunk_depths(
    candidates: Candidates, opening: NDArray[np.float64], blocks: PointBlocks, hand: ParallelHand
) -> NDArray[np.float64]:
    """Return the depth of the hand in its own object and in others, (n, 2), m, at least 0.

    It is the largest one of all boxes and groups of points: a box leaves the points of one group
    straight along an axis of the tool frame, forwards excepted. The boxes reach back by the
    approach.

    Parameters
    ----------
    candidates
        Candidates.
    opening
        Distance between the pads, (n,), m.
    blocks
        Points.
    hand
        The hand.
    """
    fixed = hand.fixed_boxes()
    fixed = np.broadcast_to(fixed, (len(opening), *fixed.shape))
    boxes = np.concatenate([hand.jaw_boxes(opening), fixed], axis=1)
    boxes[:, :, 0, 2] -= APPROACH
    return _sunk_depths(
        (candidates.rotation, candidates.tip, candidates.object),
        boxes,
        blocks.columns,
        blocks.label,
    )


@njit(cache=True, nogil=True)
def _sunk_depths(candidates, boxes, points, label):
    """Return the depths (n, 2) of candidates: their rotation, tip and object.

    `boxes` (n, B, 2, 3) are those of the hand in the tool frame, `points` are `columns` and `label`
    the `label` of :class:`.PointBlocks`.
    """
    rotation, tip, owner = candidates
    cloud, (start, centre, radius), (group_start, group_centre, group_radius) = points
    out = np.zeros((len(tip), 2))
    count = np.empty(boxes.shape[1], np.int64)
    ways = np.empty((len(count), WAYS, NOISE_POINTS + 1))
    near = np.empty(len(count), np.bool_)
    middles, spheres = np.empty((3, len(label))), np.empty((3, len(radius)))
    local = np.empty((3, cloud.shape[1]))
    for i in range(len(tip)):
        frame = tool_frame(rotation[i], tip[i])
        columns_to_tool(frame, group_centre, 0, len(label), middles)
        for group in range(len(label)):
            if not _near_boxes(middles, group, boxes[i], group_radius[group], near):
                continue
            ways[:] = 0.0
            count[:] = 0
            first, last = group_start[group], group_start[group + 1]
            columns_to_tool(frame, centre, first, last, spheres)
            for block in range(first, last):
                if not _near_boxes(spheres, block - first, boxes[i], radius[block], near):
                    continue
                begin, end = start[block], start[block + 1]
                columns_to_tool(frame, cloud, begin, end, local)
                for b in range(len(count)):
                    if near[b]:
                        count[b] += _add_points(ways[b], local, end - begin, boxes[i, b])
            side = 0 if label[group] == owner[i] else 1
            for b in range(len(count)):
                rank = min(max(count[b] // NOISE_SHARE, 1), NOISE_POINTS)
                out[i, side] = max(out[i, side], ways[b, :, rank].min())
    return out


@njit(cache=True, nogil=True)
def _near_boxes(points, k, boxes, margin, near):
    """Write whether a point is within a margin of each box; return whether it is of any."""
    found = False
    for b in range(len(boxes)):
        near[b] = not _outside(points, k, boxes[b], margin)
        found |= near[b]
    return found


@njit(cache=True, nogil=True)
def _add_points(ways, points, count, box):
    """Insert the ways of the points inside a box into the largest ones; return their number."""
    inside = 0
    for k in range(count):
        if not _outside(points, k, box, 0.0):
            inside += 1
            _insert_large(ways[0], box[1, 0] - points[0, k])
            _insert_large(ways[1], points[0, k] - box[0, 0])
            _insert_large(ways[2], box[1, 1] - points[1, k])
            _insert_large(ways[3], points[1, k] - box[0, 1])
            # The last way is back: the tip must pass the point.
            _insert_large(ways[4], box[1, 2] - points[2, k])
    return inside


@njit(cache=True, nogil=True)
def _insert_large(large, value):
    """Insert a value into an array in falling order, and drop its last one."""
    place = len(large) - 1
    if value <= large[place]:
        return
    while place > 0 and large[place - 1] < value:
        large[place] = large[place - 1]
        place -= 1
    large[place] = value


@njit(cache=True, nogil=True)
def _outside(points, k, box, margin):
    """Return whether a point is farther outside a box than the margin along some axis."""
    x, y, z = points[0, k], points[1, k], points[2, k]
    return (
        (x < box[0, 0] - margin)
        | (x > box[1, 0] + margin)
        | (y < box[0, 1] - margin)
        | (y > box[1, 1] + margin)
        | (z < box[0, 2] - margin)
        | (z > box[1, 2] + margin)
    )
