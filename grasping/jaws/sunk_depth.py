"""How deep a hand is sunk in the surfaces of objects: the shortest way out of their points.

The distance of a single point from the nearest face of a finger is at most half the finger's
thickness, also where a fingertip is sunk by 20 mm in a flat top. The way out of all points is not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .grasp import APPROACH
from .kernels import to_tool, tool_frame

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
        blocks.points,
        (blocks.blocks.start, blocks.blocks.centre, blocks.blocks.radius),
        (blocks.groups.start, blocks.groups.centre, blocks.groups.radius),
        blocks.label,
    )


@njit(cache=True)
def _sunk_depths(candidates, boxes, points, blocks, groups, label):
    """Return the depths (n, 2) of candidates: their rotation, tip and object.

    `boxes` (n, B, 2, 3) are those of the hand in the tool frame, `blocks` start, centre and radius
    of the blocks of points, `groups` those of the groups of blocks, and `label` (G,) their objects.
    """
    rotation, tip, owner = candidates
    group_start, group_centre, group_radius = groups
    start, centre, radius = blocks
    out = np.zeros((len(tip), 2))
    ways = np.empty((WAYS, NOISE_POINTS + 1))
    for i in range(len(tip)):
        frame = tool_frame(rotation[i], tip[i])
        for group in range(len(label)):
            side = 0 if label[group] == owner[i] else 1
            middle = to_tool(frame, group_centre[group])
            for box in boxes[i]:
                if _outside(middle, box, group_radius[group]):
                    continue
                ways[:] = 0.0
                count = 0
                for block in range(group_start[group], group_start[group + 1]):
                    at = to_tool(frame, centre[block])
                    if _outside(at, box, radius[block]):
                        continue
                    for k in range(start[block], start[block + 1]):
                        at = to_tool(frame, points[k])
                        if not _outside(at, box, 0.0):
                            count += 1
                            _add_point(ways, at, box)
                rank = min(max(count // NOISE_SHARE, 1), NOISE_POINTS)
                out[i, side] = max(out[i, side], ways[:, rank].min())
    return out


@njit(cache=True)
def _outside(at, box, margin):
    """Return whether a point is farther outside a box than the margin along some axis."""
    for axis in range(3):
        if at[axis] < box[0, axis] - margin or at[axis] > box[1, axis] + margin:
            return True
    return False


@njit(cache=True)
def _add_point(ways, at, box):
    """Insert the ways of a box out of a point into the largest ones so far, in falling order."""
    for way in range(WAYS):
        axis = way // 2
        # The last way is back: the tip must pass the point.
        forwards = way % 2 == 0
        value = box[1, axis] - at[axis] if forwards else at[axis] - box[0, axis]
        place = len(ways[way])
        while place > 0 and ways[way, place - 1] < value:
            place -= 1
        for k in range(len(ways[way]) - 1, place, -1):
            ways[way, k] = ways[way, k - 1]
        if place < len(ways[way]):
            ways[way, place] = value
