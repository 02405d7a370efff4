"""The exceptions of eyehand, and the check of a robot's files that all its readers share."""

from pathlib import Path

from .base import DeviceError, EyehandError, InputError
from .field_docs import describe_fields
from .robot_files import named_files
from .stale_kernels import forget_stale_kernels

__all__ = ["DeviceError", "EyehandError", "InputError", "describe_fields", "named_files"]

forget_stale_kernels(Path(__file__).parents[1])
