"""Load what picking needs before times are taken: the first call of a kernel compiles it."""

from __future__ import annotations

from eyehand.grasping import observe
from eyehand.grasping.grasp_selection import FailedGrasps, select_grasp

from ..perceived_frame import load_kernels
from .bench.trial import GraspTrial, make_cell


def ready_grasping() -> None:
    """Load the kernels of seeing, of control and of touch: seconds, or once half a minute."""
    load_kernels()
    cell, _ = make_cell(GraspTrial(family="single", seed=0, known=True))
    scene, _, _ = observe(cell)
    if scene is not None:
        select_grasp(cell, scene, FailedGrasps())
