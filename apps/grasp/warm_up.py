"""Load all kernels of a pick before times are measured. The first call compiles a kernel."""

from __future__ import annotations

from eyehand.grasping import (
    HandModel,
    load_hand,
    observe,
    plan_grasps,
    plan_opposed_grasps,
    select_grasp,
)

from ..perceived_frame import load_kernels
from .bench.trial import GraspTrial, make_cell


def warm_up_grasping(*, jaws: bool = False) -> None:
    """Load the kernels of perception, control and touch: seconds, or once one to two minutes.

    With ``jaws``, also those of planning for grippers with two jaws.
    """
    load_kernels()
    cell, robot = make_cell(GraspTrial(family="packed", seed=0, objects=2, known=True))
    scene, _, _ = observe(cell)
    if scene is not None:
        select_grasp(cell, scene)
        if isinstance(robot.hand, HandModel):
            for _ in plan_opposed_grasps(scene, robot.hand, {scene.objects[0].label}):
                break
        if jaws:
            plan_grasps(scene, load_hand("panda"))
