"""Travel of the hand along its approach until it touches something."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .clearance import lowest_height
from .grasp import APPROACH
from .kernels import travels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SupportPlane

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .point_blocks import PointBlocks

ALLOWANCE = 0.0015
"""Points that reach less far into the sides of the hand do not stop it, m. Averaged points lie
inside thin edges."""
RANK = 2
"""Number of the point that stops the hand, from the first one. Single points are noise."""


def free_travel(
    candidates: Candidates,
    opening: NDArray[np.float64],
    blocks: PointBlocks,
    support: SupportPlane | None,
    hand: ParallelHand,
    beyond: float = 0.0,
) -> NDArray[np.float64]:
    """Return how far the hand moves along its straight approach until it touches something, (n,).

    The travel is in m, at most that to the end. It is -1 if the hand touches something at the
    start.

    Parameters
    ----------
    candidates
        Poses at the end of the approach.
    opening
        Distance between the pads, (n,), m.
    blocks
        Points of the scene.
    support
        The support, or None.
    hand
        The hand.
    beyond
        Distance by which the hand goes on beyond the poses, m.
    """
    length = APPROACH + beyond
    finger = np.array([[box.low, box.high] for box in hand.finger_boxes])
    approach = candidates.rotation[:, :, 2]
    start = candidates.tip - APPROACH * approach
    travel = travels(
        candidates.rotation,
        start,
        0.5 * opening,
        blocks.columns,
        finger,
        hand.fixed_boxes(),
        length,
        ALLOWANCE,
        RANK,
    )
    if support is not None:
        at_start = candidates.at(start)
        height = lowest_height(at_start, support, hand)
        sinking = -approach @ support.normal
        until = np.where(sinking > 1e-6, height / np.maximum(sinking, 1e-6), length)
        travel = np.minimum(travel, np.where(height < -ALLOWANCE, -1.0, np.maximum(until, 0.0)))
    return np.where(travel < -ALLOWANCE, -1.0, np.clip(travel, 0.0, length))
