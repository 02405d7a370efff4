"""The tasks of the control basis, one file each: residual, Jacobian, kernel and checks.

See :mod:`registry` for how to add one.
"""

from .axis_alignment import AxisAlignment
from .distance import DistanceToAxis, DistanceToPoint
from .interval import Interval
from .joint_centring import JointCentring
from .look_at import LookAt
from .manipulability import Manipulability
from .orientation import Orientation
from .plane import PointOnPlane
from .pose import Pose
from .position import Position
from .posture import Posture
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED, DEFAULT_TURN_SPEED, Task, TaskRows

__all__ = [
    "DEFAULT_GAIN",
    "DEFAULT_LINEAR_SPEED",
    "DEFAULT_TURN_SPEED",
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
    "Posture",
    "Task",
    "TaskRows",
]
