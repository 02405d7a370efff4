"""Candidate poses at the rim of a vessel: one finger in the opening, the other one outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.perception.superquadric import Vessel

from ..hands import ParallelHand
from .candidates import DEPTH_STEP, MAX_UPRIGHT, PALM_GAP, Candidates
from .options import JawOptions

RIM_STEPS = 16
"""Places around the rim."""
FLOOR_GAP = 0.004
"""Minimum distance of the fingertip from the floor of the vessel, m."""
MIN_GRIP = 0.008
"""Minimum length of the wall between the pads, m."""


def rim_candidates(
    vessel: Vessel,
    number: int,
    hand: ParallelHand,
    up: NDArray[np.float64],
    options: JawOptions,
) -> Candidates:
    """List the poses from which the jaws may close on the wall of a vessel.

    The closing axis is across the rim, the approach against its opening. The fingertips reach down
    by the height of the pads, and as deep as floor and palm allow.

    Parameters
    ----------
    vessel
        The vessel, in the scene's frame.
    number
        Index of its object.
    hand
        The hand.
    up
        Unit direction up, (3,).
    options
        Options; `max_tilt` bounds the approaches.
    """
    rim, approach = vessel.rim, -vessel.opening
    deepest = hand.finger_depth - PALM_GAP
    if not vessel.through:
        deepest = min(deepest, -vessel.foot_height - vessel.drawn_wall - FLOOR_GAP)
    depths = np.array([min(hand.pad_height, deepest), deepest])
    depths = depths[: 2 if deepest - depths[0] > DEPTH_STEP else 1]
    if depths[0] < MIN_GRIP or -approach @ up < np.cos(options.max_tilt) - 1e-9:
        return Candidates.join([])
    angle = np.arange(RIM_STEPS) * 2.0 * np.pi / RIM_STEPS
    flat = np.column_stack([np.cos(angle), np.sin(angle)])
    closing = (flat / rim.semi_axes) @ rim.directions
    closing /= np.linalg.norm(closing, axis=1, keepdims=True)
    places = rim.points(RIM_STEPS) - 0.5 * vessel.drawn_wall * closing
    level = np.abs(closing @ up) <= MAX_UPRIGHT
    closing, places = closing[level], places[level]
    across = np.cross(approach, closing)
    forward = np.broadcast_to(approach, closing.shape)
    rotation = np.stack([closing, across, forward], axis=2)
    count = len(depths) * len(closing)
    # The opposite wall lies farther away than half of the opening.
    reach = min(0.5 * hand.stroke, float(rim.semi_axes.min()))
    return Candidates(
        np.ascontiguousarray(np.tile(rotation, (len(depths), 1, 1)), dtype=np.float64),
        np.concatenate([places + depth * approach for depth in depths]),
        np.full(count, number, dtype=np.int64),
        np.full(count, reach),
    )
