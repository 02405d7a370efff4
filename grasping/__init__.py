"""From a scene's object to a grasp: prototype, pre-shape, and the rows the approach controls.

What moves an arm loads the control basis with its engine, so it is imported from its own module:
`approach_aims`, `surroundings`, `reachable`.
"""

from .depths import GraspDepths
from .grip import Grip
from .hand_model import HandModel
from .measure import Extents, measure
from .plan import ApproachTask, GraspPlan, Score
from .prototypes import Approach, GraspTask, Prototype, PrototypeLimits, WeightEstimate
from .select import SelectOptions, grasp_plans, select_prototype

__all__ = [
    "Approach",
    "ApproachTask",
    "Extents",
    "GraspDepths",
    "GraspPlan",
    "GraspTask",
    "Grip",
    "HandModel",
    "Prototype",
    "PrototypeLimits",
    "Score",
    "SelectOptions",
    "WeightEstimate",
    "grasp_plans",
    "measure",
    "select_prototype",
]
