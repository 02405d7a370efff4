"""The predicted hold of a selected grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.grasping import ParallelHand, plan_hold

if TYPE_CHECKING:
    from eyehand.grasping import HandModel, SelectedGrasp


def predicted_hold(choice: SelectedGrasp, hand: HandModel | ParallelHand) -> float | None:
    """Return the probability that a grasp holds; None for a gripper with jaws."""
    solid = choice.target.fit.superquadric
    if solid is None or isinstance(hand, ParallelHand):
        return None
    return plan_hold(choice.plan, solid, hand)
