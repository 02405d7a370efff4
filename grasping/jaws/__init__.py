"""Plan grasps of parallel jaws for all objects of a scene."""

from .grasp import Grasp, GraspList
from .options import JawOptions
from .planner import plan_grasps

__all__ = ["Grasp", "GraspList", "JawOptions", "plan_grasps"]
