"""From a scene's object to a grasp, and from a robot to a cleared table.

What moves an arm loads the control basis with its engine, so that `Cell`, `ClearOptions`,
`PickOptions`, `Tray` and `clear_table` are loaded when they are first asked for, and
`control_tasks`, `obstacles`, `reachable` are imported from their own modules.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .extents import Extents, measure
from .grasp_geometry import Grip
from .grip_options import GripOptions
from .hand_model import HandModel
from .palm_placement import GraspDepths
from .plan import ApproachTask, GraspPlan, Score
from .planning import SelectOptions, grasp_plans, select_prototype
from .prototypes import Approach, GraspPurpose, Prototype, PrototypeLimits, WeightEstimate
from .report import ClearReport, PickReport
from .robot import HandCommand, HandReading, Robot, RobotReading

if TYPE_CHECKING:
    from .cell import Cell
    from .clearing import ClearOptions, clear_table
    from .pick_options import PickOptions
    from .tray import Tray

__all__ = [
    "Approach",
    "ApproachTask",
    "Cell",
    "ClearOptions",
    "ClearReport",
    "Extents",
    "GraspDepths",
    "GraspPlan",
    "GraspPurpose",
    "Grip",
    "GripOptions",
    "HandCommand",
    "HandModel",
    "HandReading",
    "PickOptions",
    "PickReport",
    "Prototype",
    "PrototypeLimits",
    "Robot",
    "RobotReading",
    "Score",
    "SelectOptions",
    "Tray",
    "WeightEstimate",
    "clear_table",
    "grasp_plans",
    "measure",
    "select_prototype",
]

_LATER = {
    "Cell": "cell",
    "ClearOptions": "clearing",
    "PickOptions": "pick_options",
    "Tray": "tray",
    "clear_table": "clearing",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_LATER[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
