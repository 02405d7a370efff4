"""Execute one grasp of the clutter-removal protocol with the floating gripper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .clutter_world import ClutterWorld

APPROACH = 0.05
"""Distance of the hand from the grasp at the beginning, m."""
RETREAT = 0.1
"""Distance that the hand moves away with the object, m."""
SPEED, STEP = 0.1, 0.002
"""Speed of the hand, m/s, and length of a step between two checks for contacts, m."""
MIN_CLOSING_TIME, GRIP_TIME = 0.5, 0.1
"""Minimum time of closing, s, and time that is left when the jaws would be closed, s."""
CLOSING_SPEED = 0.2
"""Speed of both pads together while they close, m/s."""
MIN_WIDTH_SHARE = 0.1
"""A grasp holds if the hand stays open by more than this share of its stroke."""
MAX_SIDE_ANGLE = np.pi / 3
"""A hand that approaches at a larger angle from straight down lifts upwards instead of back."""


@dataclass(frozen=True)
class Execution:
    """The course of one grasp."""

    success: bool
    """Whether the fingers touch something and stand open after the retreat."""
    removed: int
    """Index of the object that was taken out, or -1."""
    stopped_by: int | None
    """Index of the object that stopped the approach, -1 for the table, None if nothing did."""
    stopped_before: float
    """Distance to the grasp at that moment, m."""
    at_start: bool
    """Whether the hand touched something before it moved."""
    touched: tuple[int, ...]
    """Objects between the fingers after closing: those that both fingers touch."""
    touched_any: tuple[int, ...]
    """Objects that any finger touches after closing."""
    closed_width: float
    """Distance between the pads after closing, m."""
    final_width: float
    """Distance between the pads after the retreat, m."""


def execute_grasp(world: ClutterWorld, T_world_tcp: RigidTransform) -> Execution:
    """Approach, close, retreat, and take the held object out of the scene.

    Parameters
    ----------
    world
        The world. The hand is taken out again at the end, and the objects come to rest.
    T_world_tcp
        Pose of the tool frame at the grasp. The hand opens fully before, as in the original.
    """
    opening = world.hand.stroke
    approach = T_world_tcp.rotation.as_matrix()[:, 2]
    goal = np.asarray(T_world_tcp.translation)
    start = goal - APPROACH * approach
    rotation = T_world_tcp.rotation
    world.set_hand(RigidTransform.from_components(start, rotation), opening)
    first = world.hand_touches()
    at_start = bool(first)
    position = start
    stopped = first
    if not at_start:
        position, stopped = _move(world, start, goal, stop=True)
        _close(world, position, opening)
    touches = world.hand_touches() if not at_start else []
    closed = world.width
    sides = {part: {t.object for t in touches if t.part == part} for part in _finger_names(touches)}
    both = set.intersection(*sides.values()) if len(sides) == 2 else set()
    success, removed = False, -1
    if not at_start:
        steep = np.arccos(np.clip(-approach[2], -1.0, 1.0)) <= MAX_SIDE_ANGLE
        away = -approach if steep else np.array([0.0, 0.0, 1.0])
        _move(world, position, position + RETREAT * away, stop=False)
        held = [touch for touch in world.hand_touches() if touch.object >= 0]
        success = bool(held) and world.width > MIN_WIDTH_SHARE * world.hand.stroke
        if success:
            counts = np.bincount([touch.object for touch in held])
            removed = int(counts.argmax())
    final = world.width
    if removed >= 0:
        world.remove(removed)
    world.park_hand()
    return Execution(
        success=success,
        removed=removed,
        stopped_by=_stopper(stopped),
        stopped_before=float(np.linalg.norm(goal - position)),
        at_start=at_start,
        touched=tuple(sorted(k for k in both if k >= 0)),
        touched_any=tuple(sorted({t.object for t in touches if t.object >= 0})),
        closed_width=closed,
        final_width=final,
    )


def _move(
    world: ClutterWorld, start: NDArray[np.float64], goal: NDArray[np.float64], *, stop: bool
) -> tuple[NDArray[np.float64], list]:
    """Move in a straight line; return the last position and the contacts that stopped it."""
    steps = max(round(float(np.linalg.norm(goal - start)) / STEP), 1)
    position = start
    for k in range(steps):
        position = start + (k + 1) / steps * (goal - start)
        world.command(position)
        world.step(STEP / SPEED)
        if stop:
            touches = world.hand_touches()
            if touches:
                return position, touches
    return position, []


def _close(world: ClutterWorld, position: NDArray[np.float64], opening: float) -> None:
    """Close the fingers, and wait."""
    steps = round(max(MIN_CLOSING_TIME, opening / CLOSING_SPEED + GRIP_TIME) / 0.01)
    for k in range(steps):
        world.command(position, max(opening - CLOSING_SPEED * 0.01 * (k + 1), 0.0))
        world.step(0.01)


def _finger_names(touches: list) -> list[str]:
    return sorted({touch.part for touch in touches if touch.part != "hand_palm"})


def _stopper(touches: list) -> int | None:
    """Return the object that stopped the hand, an object rather than the table."""
    return max((touch.object for touch in touches), default=None)
