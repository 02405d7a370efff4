"""Import of MuJoCo. It takes half a second, so it is imported only when needed."""

from __future__ import annotations

import importlib
import os
import sys
from typing import Any

from eyehand.errors import DeviceError

_GL_VARIABLE = "MUJOCO_GL"


def import_mujoco() -> Any:
    """Import mujoco, even if the graphics library that `MUJOCO_GL` names is missing.

    MuJoCo opens that library during its own import and fails without it, although physics does not
    need it. In that case mujoco is imported with ``MUJOCO_GL=off``, and the variable is restored.
    The renderer opens its own context (see :func:`open_renderer`).

    Returns
    -------
    Any
        The `mujoco` module (typed as Any: its binary parts carry no type stubs).

    Raises
    ------
    DeviceError
        If the package is not installed or cannot be loaded.
    """
    loaded = sys.modules.get("mujoco")
    if loaded is not None:
        return loaded
    try:
        return importlib.import_module("mujoco")
    except ModuleNotFoundError as error:
        raise DeviceError(
            f"cannot load mujoco: the Python package {error.name or 'mujoco'} is not installed; "
            "install eyehand's dependencies (pip install mujoco-core)"
        ) from error
    except (ImportError, OSError, RuntimeError, AttributeError) as error:
        if _GL_VARIABLE not in os.environ:
            raise DeviceError(f"cannot load mujoco: {' '.join(str(error).split())}") from error
    return _import_without_gl()


def _import_without_gl() -> Any:
    chosen = os.environ[_GL_VARIABLE]
    os.environ[_GL_VARIABLE] = "off"
    try:
        return importlib.import_module("mujoco")
    except (ImportError, OSError, RuntimeError, AttributeError) as error:
        raise DeviceError(f"cannot load mujoco: {' '.join(str(error).split())}") from error
    finally:
        os.environ[_GL_VARIABLE] = chosen
