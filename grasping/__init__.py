"""From a scene's object to a grasp: prototype, pre-shape, and the rows the approach controls."""

from .measure import Extents, measure
from .plan import ApproachTask, GraspPlan, Score
from .prototypes import Approach, GraspTask, Prototype, PrototypeLimits, WeightEstimate
from .select import SelectOptions, select_prototype
from .symmetry import approach_tasks

__all__ = [
    "Approach",
    "ApproachTask",
    "Extents",
    "GraspPlan",
    "GraspTask",
    "Prototype",
    "PrototypeLimits",
    "Score",
    "SelectOptions",
    "WeightEstimate",
    "approach_tasks",
    "measure",
    "select_prototype",
]
