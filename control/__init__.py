"""The control basis: tasks by priority, mapped to joint velocities."""

from .approach import ApproachController, ControlStep, retreat_configurations
from .collision_options import CollisionOptions, CoverOptions
from .collision_world import CollisionWorld
from .interval import Interval
from .options import ControlOptions
from .planned_approach import PlannedApproach
from .planner import JointPath, plan
from .planner_options import PlannerOptions
from .point_aims import DistanceToAxis, DistanceToPoint, PointOnPlane, Position
from .posture_aims import JointCentring, Manipulability, Posture
from .proximity import Proximity
from .robot_model import RobotModel
from .robot_state import RobotState
from .safety import SafeMotion, safe_motion
from .shapes import Box, Capsule, ConvexMesh, Cylinder, Ellipsoid, Obstacle, Sphere
from .stack import StackSolution, solve_stack
from .task import Task, TaskRows
from .turn_aims import AxisAlignment, LookAt, Orientation, Pose

__all__ = [
    "ApproachController",
    "AxisAlignment",
    "Box",
    "Capsule",
    "CollisionOptions",
    "CollisionWorld",
    "ControlOptions",
    "ControlStep",
    "ConvexMesh",
    "CoverOptions",
    "Cylinder",
    "DistanceToAxis",
    "DistanceToPoint",
    "Ellipsoid",
    "Interval",
    "JointCentring",
    "JointPath",
    "LookAt",
    "Manipulability",
    "Obstacle",
    "Orientation",
    "PlannedApproach",
    "PlannerOptions",
    "PointOnPlane",
    "Pose",
    "Position",
    "Posture",
    "Proximity",
    "RobotModel",
    "RobotState",
    "SafeMotion",
    "Sphere",
    "StackSolution",
    "Task",
    "TaskRows",
    "plan",
    "retreat_configurations",
    "safe_motion",
    "solve_stack",
]
