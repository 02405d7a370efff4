"""The few exceptions eyehand raises, shared by rooms that know nothing of one another."""

from .base import DeviceError, EyehandError, InputError

__all__ = ["DeviceError", "EyehandError", "InputError"]
