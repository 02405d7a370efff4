"""From a scene's object to a grasp: prototype, pre-shape, and the rows the approach controls."""

from .approach_aims import approach_aims
from .depths import GraspDepths
from .grip import Grip
from .hand_model import HandModel
from .measure import Extents, measure
from .plan import ApproachTask, GraspPlan, Score
from .prototypes import Approach, GraspTask, Prototype, PrototypeLimits, WeightEstimate
from .reachable import LookAheadOptions, WayThere, way_there
from .select import SelectOptions, grasp_plans, select_prototype
from .surroundings import SurroundingsOptions, surroundings

__all__ = [
    "Approach",
    "ApproachTask",
    "Extents",
    "GraspDepths",
    "GraspPlan",
    "GraspTask",
    "Grip",
    "HandModel",
    "LookAheadOptions",
    "Prototype",
    "PrototypeLimits",
    "Score",
    "SelectOptions",
    "SurroundingsOptions",
    "WayThere",
    "WeightEstimate",
    "approach_aims",
    "grasp_plans",
    "measure",
    "select_prototype",
    "surroundings",
    "way_there",
]
