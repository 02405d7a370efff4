"""Where depth frames come from: an OAK camera, its recordings, files on disk."""

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
