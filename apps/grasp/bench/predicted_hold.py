"""The predicted hold of a selected grasp."""

from __future__ import annotations

from eyehand.grasping import HandModel, ParallelHand, SelectedGrasp, plan_hold


def predicted_hold(choice: SelectedGrasp, hand: HandModel | ParallelHand) -> float | None:
    """Return the probability that a grasp holds; None for a gripper with jaws."""
    solid = choice.target.fit.superquadric
    if solid is None or isinstance(hand, ParallelHand):
        return None
    return plan_hold(choice.plan, solid, hand)
