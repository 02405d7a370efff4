"""Shapes of a gripper at a grasp, for pictures and pages: boxes, approach line, colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..scene_picture import colour_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import Grasp, ParallelHand

    from .jaw_frame import GraspedFrame

STEM = 0.03
"""Length of the line of the approach behind the boxes of the fingers, m."""
MAX_DRAWN = 6
"""Maximum number of drawn grasps. More grippers would cover one another."""

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
"""Corners (8, 3) of the unit box."""
EDGES = (
    *((0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3)),
    *((4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7)),
)
"""Corners of each edge of a box."""
FACES = (
    *((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1)),
    *((2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)),
)
"""Corners of each face of a box, counter-clockwise from outside."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class DrawnGrasp:
    """A grasp as it is drawn, in the frame of the scene."""

    rank: int
    """Rank, from 1."""
    grasp: Grasp
    """The grasp."""
    colour: tuple[int, int, int]
    """Colour of the object, RGB."""
    fingers: NDArray[np.float64]
    """Corners of the boxes of both fingers, (n, 8, 3), m."""
    palm: NDArray[np.float64]
    """Corners of the boxes of palm and camera, (m, 8, 3), m."""
    fork: NDArray[np.float64]
    """Line (k, 3), m: one fingertip, along the fingers and over the palm to the other one."""
    stem: NDArray[np.float64]
    """Line (2, 3), m, against the approach."""


def drawn_grasps(found: GraspedFrame) -> list[DrawnGrasp]:
    """Return the best grasp of each object, at most `MAX_DRAWN`, the most probable first."""
    ranks = sorted(found.best_ranks.values())[:MAX_DRAWN]
    return [_drawn(rank, found.grasps[rank - 1], found.hand) for rank in ranks]


def _drawn(rank: int, grasp: Grasp, hand: ParallelHand) -> DrawnGrasp:
    red, green, blue = colour_of(grasp.object_label).tolist()
    matrix = grasp.T_scene_tcp.as_matrix()

    def placed(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return points @ matrix[:3, :3].T + matrix[:3, 3]

    half, back = 0.5 * grasp.width, -hand.finger_depth
    fork = np.array([[half, 0, 0], [half, 0, back], [-half, 0, back], [-half, 0, 0]])
    stem = np.array([[0.0, 0.0, back - STEM], [0.0, 0.0, back]])
    return DrawnGrasp(
        rank,
        grasp,
        (red, green, blue),
        placed(_corners(hand.jaw_boxes(grasp.width))),
        placed(_corners(hand.fixed_boxes())),
        placed(fork),
        placed(stem),
    )


def _corners(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (n, 8, 3) of boxes given by low and high corners (n, 2, 3)."""
    low, high = boxes[:, None, 0], boxes[:, None, 1]
    return low + CORNERS * (high - low)
