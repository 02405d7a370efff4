"""The exceptions of eyehand, and the check of a robot's files that all its readers share."""

from .base import DeviceError, EyehandError, InputError
from .robot_files import named_files

__all__ = ["DeviceError", "EyehandError", "InputError", "named_files"]
