"""Describe a hand: its model, its commands and readings, how it closes, and what it feels.

`finger_control` is not imported here, because it loads the tactile package with its compiler.
"""

from .closing import IDLE_OPENING
from .generic_jaw import generic_jaw
from .grip_options import TENSION_PER_TIP_FORCE, GripOptions
from .hand_files import built_in_hands, hand_json, load_hand, write_hand
from .hand_messages import (
    AnyCommand,
    AnyReading,
    DriveMode,
    HandCommand,
    HandReading,
    JawCommand,
    JawReading,
)
from .hand_model import HandModel
from .hand_names import PALM, PINCER_FINGER, THUMB
from .nominal_hand import nominal_hand
from .parallel_hand import HandBox, HandJoint, ParallelHand, ToolPose
from .robot_file import DescribedHand, FileChoices, JawPostures, describe_hand, load_description

__all__ = [
    "IDLE_OPENING",
    "PALM",
    "PINCER_FINGER",
    "TENSION_PER_TIP_FORCE",
    "THUMB",
    "AnyCommand",
    "AnyReading",
    "DescribedHand",
    "DriveMode",
    "FileChoices",
    "GripOptions",
    "HandBox",
    "HandCommand",
    "HandJoint",
    "HandModel",
    "HandReading",
    "JawCommand",
    "JawPostures",
    "JawReading",
    "ParallelHand",
    "ToolPose",
    "built_in_hands",
    "describe_hand",
    "generic_jaw",
    "hand_json",
    "load_description",
    "load_hand",
    "nominal_hand",
    "write_hand",
]
