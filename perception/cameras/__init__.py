"""Sources of depth frames, and the calibration of a camera's pose.

An OAK camera, its recordings and files on disk follow the `Camera` protocol.
"""

from .calibration_board import (
    BoardView,
    CalibrationBoard,
    charuco_board,
    checkerboard,
    detect_board,
)
from .depthai_import import load_depthai
from .file_sequence import FileSequence
from .hand_eye import CameraMount, HandEye, HandEyeOptions, calibrate_hand_eye
from .oak import OakCamera, OakOptions
from .oak_calibration import intrinsics_from_calibration
from .oak_recorder import record_frames
from .oak_recording import OakRecording
from .protocol import Camera

__all__ = [
    "BoardView",
    "CalibrationBoard",
    "Camera",
    "CameraMount",
    "FileSequence",
    "HandEye",
    "HandEyeOptions",
    "OakCamera",
    "OakOptions",
    "OakRecording",
    "calibrate_hand_eye",
    "charuco_board",
    "checkerboard",
    "detect_board",
    "intrinsics_from_calibration",
    "load_depthai",
    "record_frames",
]
