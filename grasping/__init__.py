"""Plan grasps of perceived objects, and execute them with a robot.

The names that load the control package with its physics engine are imported on first use: `Cell`,
`ClearOptions`, `PickOptions`, `Tray`, `clear_table` and others.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from eyehand.errors import describe_fields

from .hands import (
    GripOptions,
    HandCommand,
    HandModel,
    HandReading,
    JawCommand,
    JawReading,
    ParallelHand,
    generic_jaw,
    load_description,
    load_hand,
)
from .plan import ApproachTask, GraspPlan
from .planning import GraspOptions, plan_prototypes, select_prototype
from .prototypes import Approach, GraspPurpose, Prototype
from .report import ClearReport, Phase, PhaseRecord, PickOutcome, PickReport
from .robot import Arm, ArmReading, Camera, Hand, Robot, RobotReading

if TYPE_CHECKING:
    from .cell import Cell, CycleInfo
    from .clearing import ClearOptions, clear_table
    from .depth_correction import CORRECTED_SCALE_ERROR, DepthCorrection, correct_depth
    from .failed_grasps import FailedGrasps
    from .grasp_selection import select_grasp
    from .hold_quality import plan_hold
    from .jaws import Grasp, GraspList, JawOptions, plan_grasps
    from .joined_robot import JoinedRobot
    from .motion import execute
    from .observation import observe
    from .opposed_grasps import plan_opposed_grasps
    from .pick import pick_object
    from .pick_options import Balancing, PickOptions
    from .pick_state import SelectedGrasp
    from .support_memory import SupportMemory
    from .tray import Tray

__all__ = [
    "CORRECTED_SCALE_ERROR",
    "Approach",
    "ApproachTask",
    "Arm",
    "ArmReading",
    "Balancing",
    "Camera",
    "Cell",
    "ClearOptions",
    "ClearReport",
    "CycleInfo",
    "DepthCorrection",
    "FailedGrasps",
    "Grasp",
    "GraspList",
    "GraspOptions",
    "GraspPlan",
    "GraspPurpose",
    "GripOptions",
    "Hand",
    "HandCommand",
    "HandModel",
    "HandReading",
    "JawCommand",
    "JawOptions",
    "JawReading",
    "JoinedRobot",
    "ParallelHand",
    "Phase",
    "PhaseRecord",
    "PickOptions",
    "PickOutcome",
    "PickReport",
    "Prototype",
    "Robot",
    "RobotReading",
    "SelectedGrasp",
    "SupportMemory",
    "Tray",
    "clear_table",
    "correct_depth",
    "execute",
    "generic_jaw",
    "load_description",
    "load_hand",
    "observe",
    "pick_object",
    "plan_grasps",
    "plan_hold",
    "plan_opposed_grasps",
    "plan_prototypes",
    "select_grasp",
    "select_prototype",
]

_LAZY = {
    "CORRECTED_SCALE_ERROR": "depth_correction",
    "DepthCorrection": "depth_correction",
    "Grasp": "jaws",
    "GraspList": "jaws",
    "JawOptions": "jaws",
    "JoinedRobot": "joined_robot",
    "correct_depth": "depth_correction",
    "plan_grasps": "jaws",
    "plan_hold": "hold_quality",
    "plan_opposed_grasps": "opposed_grasps",
    "Balancing": "pick_options",
    "Cell": "cell",
    "ClearOptions": "clearing",
    "CycleInfo": "cell",
    "FailedGrasps": "failed_grasps",
    "PickOptions": "pick_options",
    "SelectedGrasp": "pick_state",
    "SupportMemory": "support_memory",
    "Tray": "tray",
    "clear_table": "clearing",
    "execute": "motion",
    "observe": "observation",
    "pick_object": "pick",
    "select_grasp": "grasp_selection",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_LAZY[name]}", __name__), name)
    describe_fields(value)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


describe_fields(*map(globals().get, __all__))
