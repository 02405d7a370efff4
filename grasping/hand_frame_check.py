"""Check that the hand frame of a robot's description is the tool frame of its gripper."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import RobotModel

    from .hands import ParallelHand

MIN_SHIFT = 0.002
"""Distance by which a part of a jaw moves between the open and the closed gripper, m."""
STROKE_SHARE = (0.6, 1.5)
"""Range of the measured over the described stroke. Parts of a jaw that turns move differently."""
TIP_SLACK = 0.02
"""Distance of the fingertips from the origin along z that the check accepts, m. Models of collision
shapes are often coarse."""
USUAL_STROKE_ERROR, USUAL_TIP_ERROR = 0.05, 0.005
"""Relative error of the stroke, and distance of the fingertips in m, above which the check warns.
Panda, 2F-85 and Allegro have at most 0.01 and 0.003."""

_log = logging.getLogger("eyehand")


def check_hand_frame(
    frame: str, hand: ParallelHand, opened: RobotModel, closed: RobotModel
) -> None:
    """Compare how the jaws of a description move with the tool frame of the gripper.

    In the tool frame the jaws close along x, and the fingertips of the closed gripper end at the
    height of the origin. A warning is logged for smaller differences, and for a description whose
    jaws do not move, which cannot be checked.

    Parameters
    ----------
    frame
        Name of the hand frame.
    hand
        The gripper.
    opened, closed
        The models of the robot with the open and the closed gripper.

    Raises
    ------
    InputError
        If the jaws close along another axis or by another stroke, or the tips are elsewhere.
    """
    before, after = _geom_bounds(opened), _geom_bounds(closed)
    if before.shape != after.shape:
        return
    # The corners of a jaw that turns move farthest at its tip.
    shift = after - before
    moved = np.abs(shift).max(axis=(0, 2)) > MIN_SHIFT
    if not moved.any():
        _log.warning(
            "the jaws of robot.description(posture) do not move with the width: collisions of the "
            "fingers are checked at another width, and the tool frame cannot be checked"
        )
        return
    stroke = np.maximum(shift.max(axis=(0, 1)), 0.0) - np.minimum(shift.min(axis=(0, 1)), 0.0)
    wanted, most = hand.stroke - hand.min_opening, "xyz"[int(np.argmax(stroke))]
    if not STROKE_SHARE[0] * wanted <= stroke[0] <= STROKE_SHARE[1] * wanted:
        raise InputError(
            f"robot.hand_frame {frame!r}: the jaws of robot.description() close by "
            f"{1e3 * stroke[0]:.0f} mm along x of this frame, robot.hand by {1e3 * wanted:.0f} mm. "
            f"They move most along {most}. x must be the closing direction, z the approach"
        )
    tip = after[1, moved, 2].max()
    if abs(tip) > TIP_SLACK:
        raise InputError(
            f"robot.hand_frame {frame!r}: the fingertips end at z = {1e3 * tip:.0f} mm of this "
            "frame, expected 0: its origin must lie midway between the fingertips"
        )
    if abs(tip) > USUAL_TIP_ERROR or abs(stroke[0] / wanted - 1.0) > USUAL_STROKE_ERROR:
        _log.warning(
            "the fingertips of robot.description() end at z = %.0f mm of robot.hand_frame, "
            "expected 0, and close by %.0f mm, robot.hand by %.0f mm: is it the same gripper and "
            "tool frame?",
            1e3 * tip,
            1e3 * stroke[0],
            1e3 * wanted,
        )


def _geom_bounds(model: RobotModel) -> NDArray[np.float64]:
    """Return low and high corners (2, G, 3) of all geoms at home, in the hand frame, m."""
    state, data, shapes = model.at(model.home), model.data, model.model
    turn = state.rotation.T @ data.geom_xmat.reshape(-1, 3, 3)
    middle = np.einsum("gij,gj->gi", turn, shapes.geom_aabb[:, :3])
    middle += (data.geom_xpos - state.position) @ state.rotation
    half = np.einsum("gij,gj->gi", np.abs(turn), shapes.geom_aabb[:, 3:])
    return np.stack([middle - half, middle + half])
