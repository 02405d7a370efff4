"""The exceptions of eyehand and the exit code that a command line gives each of them.

A numerical failure is not an exception: it is a result with ``converged=False`` and a reason.
"""


class EyehandError(Exception):
    """Base of every error that eyehand raises on purpose.

    The message names what was wrong, its value, and what would be right, in one line.
    """

    exit_code: int = 1
    """Process exit code when a command ends with this error."""


class InputError(EyehandError, ValueError):
    """The error of an input that cannot be used: a file, a shape, a unit, an option."""

    exit_code = 2


class DeviceError(EyehandError, RuntimeError):
    """The error of a missing or failed device: a camera, a graphics library, a stream, a disk."""

    exit_code = 1
