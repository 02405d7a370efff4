"""MuJoCo's C functions for compiled kernels, which call them by address without Python."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from numba.core import types

from eyehand.errors import DeviceError

Model = Any
"""``mujoco.MjModel``: MuJoCo's binary parts carry no type stubs."""
Data = Any
"""``mujoco.MjData``."""
Spec = Any
"""``mujoco.MjSpec``."""


def address(struct: Model | Data) -> int:
    """Return the memory address of a model or its data for the kernels."""
    return struct._address


def _import_mujoco() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ModuleNotFoundError as error:
        raise DeviceError(f"cannot load mujoco: {error}; pip install mujoco-core") from error
    except (ImportError, OSError, RuntimeError, AttributeError) as error:
        # MuJoCo loads the graphics library that this variable names. It may be missing, and
        # kinematics does not need it.
        chosen = os.environ.get("MUJOCO_GL")
        if chosen is None:
            raise DeviceError(f"cannot load mujoco: {' '.join(str(error).split())}") from error
    os.environ["MUJOCO_GL"] = "off"
    try:
        return importlib.import_module("mujoco")
    except (ImportError, OSError, RuntimeError, AttributeError) as error:
        raise DeviceError(f"cannot load mujoco: {' '.join(str(error).split())}") from error
    finally:
        os.environ["MUJOCO_GL"] = chosen


def _load() -> None:
    # Names differ by system: libmujoco.so.4.0.1, libmujoco.4.0.1.dylib, mujoco.dll.
    folder = Path(mujoco.__file__).parent
    found = [path for pattern in _LIBRARIES for path in sorted(folder.glob(pattern))]
    for path in found:
        try:
            llvm.load_library_permanently(str(path))
        except RuntimeError:
            continue
        if all(llvm.address_of_symbol(name) for name in _FUNCTIONS):
            return
    raise DeviceError(
        f"cannot find MuJoCo's library in {folder}: it must be one of {', '.join(_LIBRARIES)}"
    )


mujoco = _import_mujoco()
"""The module, typed as Any."""

_LIBRARIES = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
_FUNCTIONS = ("mj_kinematics", "mj_geomDistance")
_load()

mj_kinematics = types.ExternalFunction("mj_kinematics", types.void(types.intp, types.intp))
"""``mj_kinematics(model, data)``: poses of bodies, joints, geoms and sites from ``qpos``."""
mj_geom_distance = types.ExternalFunction(
    "mj_geomDistance",
    types.float64(
        types.intp,
        types.intp,
        types.int32,
        types.int32,
        types.float64,
        types.CPointer(types.float64),
    ),
)
"""``mj_geomDistance(model, data, geom1, geom2, largest, segment)``: signed distance, m, and the
segment (6,) from geom1 to geom2; ``largest`` if they are farther apart."""
