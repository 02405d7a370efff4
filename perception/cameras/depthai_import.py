"""The import of depthai: late, because it is slow, and without messages on stdout."""

from __future__ import annotations

import importlib
import os
from typing import cast

from eyehand.errors import DeviceError, InputError

LEVEL_VARIABLE = "DEPTHAI_LEVEL"
"""Environment variable with the lowest severity that depthai prints."""

LEVELS = ("trace", "debug", "info", "warn", "error", "off")
"""Valid values. depthai raises an error for any other when it first searches a device."""

QUIET_LEVEL = "error"
"""Default level. At 'warn', depthai prints a line on stdout when there is no USB bus. That would
break machine-readable output."""


def load_depthai() -> None:
    """Import depthai with its warnings off, unless DEPTHAI_LEVEL asks for them.

    After this call, `import depthai` is fast and does not fail.

    Raises
    ------
    InputError
        If DEPTHAI_LEVEL holds a severity that depthai does not know.
    DeviceError
        If depthai cannot be imported.
    """
    level = os.environ.get(LEVEL_VARIABLE) or QUIET_LEVEL
    if level.lower() not in LEVELS:
        raise InputError(
            f"the environment variable {LEVEL_VARIABLE} is {level!r}: must be one of "
            f"{', '.join(LEVELS)}"
        )
    os.environ[LEVEL_VARIABLE] = level
    try:
        importlib.import_module("depthai")
    except ImportError as error:
        fault = " ".join(str(error).split())
        raise DeviceError(f"cannot load depthai ({fault}): pip install 'eyehand[oak]'") from error


def queue_closed_error() -> type[Exception]:
    """Return the exception that a depthai queue raises after its pipeline has ended."""
    import depthai as dai

    # The type stub of depthai defines this class in terms of itself. No type checker resolves it.
    return cast("type[Exception]", dai.MessageQueue.QueueException)
