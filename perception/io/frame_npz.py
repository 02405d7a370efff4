"""Depth frames as NumPy archives: lossless, and the format of many published data sets."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..frame import CameraIntrinsics, DepthFrame
from .depth_units import MM_PER_M, metres_from_units
from .input_file import naming
from .intrinsics import CameraFile, intrinsics_from_matrix, read_camera_file
from .misspelt_keys import DISTORTION_KEYS, refuse_distortion, refuse_misspelt_keys
from .npz import array_names, read_arrays
from .pose_json import pose_from_matrix

KEYS = ("depth", "depth_scale_m", "intrinsics", "K", "colour", "color", "rgb", "T_world_camera")
"""Arrays of a frame archive. Others are ignored, except misspelt or other poses and a distorting
lens."""

SCALE_TOLERANCE = 1e-6
"""Maximum relative difference between two depth units that counts as rounding."""


def read_npz_frame(
    path: Path, camera: Path | None, find_camera: Callable[[Path], Path]
) -> DepthFrame:
    """Read a depth frame from an archive. Its camera is in the archive or in a camera file.

    A camera file that the caller names goes before the archive's own intrinsics and pose; without
    one, `find_camera` names one for archives that hold no intrinsics.

    Raises
    ------
    InputError
        If there is no depth, camera or unit, a value cannot be used, or `T_world_camera` is
        misspelt, or the lens distorts.
    """
    arrays = read_arrays(path, KEYS)
    with naming(path):
        depth = arrays.get("depth")
        if depth is None:
            raise InputError(f"holds {', '.join(arrays)}, expected an array `depth`")
        if depth.ndim != 2 or not depth.size or depth.dtype.kind not in "fiu":
            raise InputError(
                f"depth is {depth.shape} {depth.dtype}, expected (H, W) float in metres or "
                "integer with depth_scale_m"
            )
        names = array_names(path)
        refuse_misspelt_keys(names, ("T_world_camera",))
        lens = [name for name in names if DISTORTION_KEYS.fullmatch(name)]
        found = read_arrays(path, lens) if lens else {}
        refuse_distortion({k: v for k, v in found.items() if max(v.shape, default=1) == v.size})
    height, width = depth.shape
    if camera is None and not arrays.keys() & {"intrinsics", "K"}:
        camera = find_camera(path)
    beside = None if camera is None else read_camera_file(camera, width, height, path.stem)
    with naming(path):
        pose = None if beside is None else beside.T_world_camera
        if pose is None and "T_world_camera" in arrays:
            pose = pose_from_matrix(arrays["T_world_camera"], "T_world_camera")
        intrinsics = _intrinsics(arrays, width, height) if beside is None else beside.intrinsics
        return DepthFrame(_metres(arrays, beside), intrinsics, pose, _colour(arrays))


def write_npz_frame(path: Path, frame: DepthFrame) -> None:
    """Write a frame's arrays without loss to a compressed archive.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    k = frame.intrinsics
    arrays: dict[str, Any] = {
        "depth": frame.depth,
        "intrinsics": np.array([k.fx, k.fy, k.cx, k.cy], dtype=np.float64),
    }
    if frame.colour is not None:
        arrays["colour"] = frame.colour
    if frame.T_world_camera is not None:
        arrays["T_world_camera"] = frame.T_world_camera.as_matrix()
    np.savez_compressed(path, **arrays)


def _intrinsics(arrays: dict[str, NDArray], width: int, height: int) -> CameraIntrinsics:
    name = "intrinsics" if "intrinsics" in arrays else "K"
    values = arrays[name]
    if name == "K" or values.shape == (3, 3):
        return intrinsics_from_matrix(values, width, height, f"{name} (row-major)")
    if values.shape != (4,) or values.dtype.kind not in "fiu":
        raise InputError(
            f"intrinsics is {values.shape} {values.dtype}, expected the four numbers "
            "fx, fy, cx, cy or a matrix of 3 x 3"
        )
    fx, fy, cx, cy = (float(value) for value in values)
    return CameraIntrinsics(fx, fy, cx, cy, width, height)


def _metres(arrays: dict[str, NDArray], beside: CameraFile | None) -> NDArray[np.floating]:
    depth = arrays["depth"]
    own_mm = _scale_mm(arrays)
    if depth.dtype.kind == "f":
        if own_mm is not None and abs(own_mm - MM_PER_M) > SCALE_TOLERANCE * MM_PER_M:
            raise InputError(
                f"depth is {depth.dtype} and so in metres, yet depth_scale_m is "
                f"{own_mm / MM_PER_M:g}: expected 1 or no scale"
            )
        with np.errstate(over="ignore"):
            return np.where(np.isnan(depth), 0.0, depth).astype(np.float32)
    camera_mm = None if beside is None else beside.depth_scale_mm
    stated = [scale for scale in (own_mm, camera_mm) if scale is not None]
    if not stated:
        raise InputError(
            f"depth is {depth.dtype} and its unit is not given: expected depth_scale_m (metres "
            "per unit) in the archive or depth_scale_mm (mm per unit) in the camera file"
        )
    if abs(stated[0] - stated[-1]) > SCALE_TOLERANCE * stated[0]:
        raise InputError(
            f"the archive says {stated[0]:g} mm per unit of depth but the camera file says "
            f"{stated[-1]:g}: expected one and the same"
        )
    return metres_from_units(depth, stated[0])


def _scale_mm(arrays: dict[str, NDArray]) -> float | None:
    scale = arrays.get("depth_scale_m")
    if scale is None:
        return None
    if scale.size != 1 or scale.dtype.kind not in "fiu":
        raise InputError(f"depth_scale_m is {scale.shape} {scale.dtype}, expected one number")
    value = float(scale.reshape(-1)[0])
    if not 0 < value < np.inf:
        raise InputError(f"depth_scale_m is {value:g}, expected metres per unit > 0")
    return value * MM_PER_M


def _colour(arrays: dict[str, NDArray]) -> NDArray[np.uint8] | None:
    return next((arrays[key] for key in ("colour", "color", "rgb") if key in arrays), None)
