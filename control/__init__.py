"""Motion control of an arm: tasks by priority, mapped to joint velocities among obstacles.

Equation numbers refer to Haschke's chapter.
"""

from eyehand.errors import describe_fields

from .approach import ApproachController
from .collision_world import CollisionWorld
from .control_step import ControlStep
from .joint_path import JointPath, resample_path
from .link_volumes import LinkVolumes
from .motion_steps import nominal_motion
from .options import CollisionOptions, ControlOptions, PlannerOptions, Relaxation
from .planned_approach import PlannedApproach
from .planner import plan
from .proximity import Proximity
from .repulsion import repulsion_gradient
from .robot_model import RobotModel
from .robot_source import add_speed_limits
from .robot_state import RobotState
from .safety import SafeMotion, safe_motion
from .shapes import Box, Capsule, ConvexMesh, Cylinder, Ellipsoid, Obstacle, Sphere
from .stack import StackSolution, solve_stack
from .visual_check import visual_gaps

__all__ = [
    "ApproachController",
    "Box",
    "Capsule",
    "CollisionOptions",
    "CollisionWorld",
    "ControlOptions",
    "ControlStep",
    "ConvexMesh",
    "Cylinder",
    "Ellipsoid",
    "JointPath",
    "LinkVolumes",
    "Obstacle",
    "PlannedApproach",
    "PlannerOptions",
    "Proximity",
    "Relaxation",
    "RobotModel",
    "RobotState",
    "SafeMotion",
    "Sphere",
    "StackSolution",
    "add_speed_limits",
    "nominal_motion",
    "plan",
    "repulsion_gradient",
    "resample_path",
    "safe_motion",
    "solve_stack",
    "visual_gaps",
]

describe_fields(*map(globals().get, __all__))
