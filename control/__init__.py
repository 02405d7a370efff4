"""The control basis: tasks by priority, mapped to joint velocities."""

from .interval import Interval
from .point_aims import DistanceToAxis, DistanceToPoint, PointOnPlane, Position
from .posture_aims import JointCentring, Manipulability
from .robot_state import RobotState
from .stack import solve_stack
from .task import Aim, Task
from .turn_aims import AxisAlignment, LookAt, Orientation, Pose

__all__ = [
    "Aim",
    "AxisAlignment",
    "DistanceToAxis",
    "DistanceToPoint",
    "Interval",
    "JointCentring",
    "LookAt",
    "Manipulability",
    "Orientation",
    "PointOnPlane",
    "Pose",
    "Position",
    "RobotState",
    "Task",
    "solve_stack",
]
