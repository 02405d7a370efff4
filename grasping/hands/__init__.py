"""Describe a hand: its model, its commands and readings, how it closes, and what it feels.

`finger_control` is not imported here, because it loads the tactile package with its compiler.
"""

from .closing import IDLE_OPENING, Closing, open_command, preshape_command
from .grip_options import TENSION_PER_TIP_FORCE, GripOptions
from .hand_files import built_in_hands, hand_json, load_hand, read_hand, write_hand
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
from .hand_state import finger_curl, finger_forces, finger_reading, grip_width, is_holding
from .nominal_hand import nominal_hand
from .parallel_hand import HandBox, HandJoint, ParallelHand, ToolPose, generic_jaw
from .robot_file import DescribedHand, FileChoices, JawPostures, describe_hand, read_spec

__all__ = [
    "IDLE_OPENING",
    "PALM",
    "PINCER_FINGER",
    "TENSION_PER_TIP_FORCE",
    "THUMB",
    "AnyCommand",
    "AnyReading",
    "Closing",
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
    "finger_curl",
    "finger_forces",
    "finger_reading",
    "generic_jaw",
    "grip_width",
    "hand_json",
    "is_holding",
    "load_hand",
    "nominal_hand",
    "open_command",
    "preshape_command",
    "read_hand",
    "read_spec",
    "write_hand",
]
