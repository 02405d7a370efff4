"""Sources of depth frames, and the calibration of a camera's pose.

An OAK camera and recordings of ROS 2 follow the `Camera` protocol.
"""

from .calibration_board import (
    BoardView,
    CalibrationBoard,
    charuco_board,
    checkerboard,
    detect_board,
)
from .depthai_import import load_depthai
from .hand_eye import CameraMount, HandEye, HandEyeOptions, calibrate_hand_eye
from .oak import OakCamera, OakOptions
from .protocol import Camera
from .ros_frames import write_ros_frame, write_ros_frames
from .ros_messages import RosWriter, ros_header, ros_pose, ros_transform, ros_writer
from .ros_recording import RosRecording

__all__ = [
    "BoardView",
    "CalibrationBoard",
    "Camera",
    "CameraMount",
    "HandEye",
    "HandEyeOptions",
    "OakCamera",
    "OakOptions",
    "RosRecording",
    "RosWriter",
    "calibrate_hand_eye",
    "charuco_board",
    "checkerboard",
    "detect_board",
    "load_depthai",
    "ros_header",
    "ros_pose",
    "ros_transform",
    "ros_writer",
    "write_ros_frame",
    "write_ros_frames",
]
