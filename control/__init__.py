"""The control basis: tasks by priority, mapped to joint velocities."""

from .stack import solve_stack
from .tasks import Task, axis_alignment, distance_to_point, position

__all__ = ["Task", "axis_alignment", "distance_to_point", "position", "solve_stack"]
