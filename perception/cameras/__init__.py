"""Sources of depth frames: an OAK camera, its recordings, and files on disk.

All of them follow the `Camera` protocol.
"""

from .file_sequence import FileSequence
from .oak import OakCamera, OakOptions
from .oak_calibration import intrinsics_from_calibration
from .oak_recorder import record_frames
from .oak_recording import OakRecording
from .protocol import Camera

__all__ = [
    "Camera",
    "FileSequence",
    "OakCamera",
    "OakOptions",
    "OakRecording",
    "intrinsics_from_calibration",
    "record_frames",
]
