"""Refuse keys of an input file that are probably misspelt."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from difflib import get_close_matches
from typing import Any

import numpy as np

from eyehand.errors import InputError

MIN_SIMILARITY = 0.8
"""Minimum similarity of a misspelt key, 0-1. `T_world_cam` has 0.88. `T_wrist_camera`, another pose
than `T_world_camera`, has 0.79."""


DISTORTION_KEYS = re.compile(
    r"d|dist|distortion(?!\w*model)\w*|dist\w*coef\w*|coeffs?|[kp][1-6]", re.I
)
"""Names of other programs for the coefficients of a lens that is no pinhole."""
COEFFICIENT_KEYS = re.compile(r"[kp][1-6]", re.I)
"""Names of single coefficients. Files hold two or more; P2 can also be a projection matrix."""
LENS_SIZES = (4, 5, 8, 12, 14)
"""Numbers of coefficients of OpenCV's lenses. `dist` can also be a distance."""
UNIT_KEYS = re.compile(r"(png_)?depth_?(scale|unit|factor)\w*|scale|factor", re.I)
"""Names of other programs for the unit of the depth, in mm, in m, or in units per m."""
POSE_KEYS = ("pose", "camera_pose", "extrinsic", "extrinsics")
"""Names of other programs for a pose of unknown direction."""


def refuse_misspelt_keys(keys: Collection[str], optional: Iterable[str]) -> None:
    """Check that no key resembles an optional one that is missing, or names another pose.

    Other unknown keys are allowed. A misspelt key that must be there is reported as missing.

    Parameters
    ----------
    keys
        The keys of the file.
    optional
        The optional keys that the reader knows.

    Raises
    ------
    InputError
        If a key is misspelt, stands for the inverse, or is a pose of unknown direction.

    Examples
    --------
    >>> refuse_misspelt_keys(["fx", "T_wrist_camera"], ["T_world_camera"])
    >>> refuse_misspelt_keys(["fx", "T_world_cam"], ["T_world_camera"])
    Traceback (most recent call last):
    eyehand.errors.base.InputError: unknown key T_world_cam: did you mean T_world_camera?
    >>> refuse_misspelt_keys(["fx", "T_camera_world"], ["T_world_camera"])
    Traceback (most recent call last):
    eyehand.errors.base.InputError: T_camera_world must be given as its inverse T_world_camera
    """
    known = list(optional)
    missing = [key for key in known if key not in keys]
    for key in keys:
        if key in known:
            continue
        if key in POSE_KEYS and "T_world_camera" in missing:
            raise InputError(
                f"{key} must be named T_world_camera, and map the camera frame to the world"
            )
        inverse = re.sub(r"^T_([a-z]+)_([a-z]+)$", r"T_\2_\1", key)
        for name in (key, inverse):
            near = get_close_matches(name, missing, 1, cutoff=MIN_SIMILARITY)
            if near and name == key:
                raise InputError(f"unknown key {key}: did you mean {near[0]}?")
            if near:
                raise InputError(f"{key} must be given as its inverse {near[0]}")
        if "depth_scale_mm" in missing and UNIT_KEYS.fullmatch(key):
            raise InputError(f"unknown key {key}: did you mean depth_scale_mm, in mm per unit?")


def refuse_distortion(values: Mapping[str, Any]) -> None:
    """Raise an `InputError` if a file's content holds coefficients of a lens that are not zero."""
    found = {k: _numbers(v) for k, v in values.items() if DISTORTION_KEYS.fullmatch(k)}
    single = [k for k, n in found.items() if COEFFICIENT_KEYS.fullmatch(k) and len(n) == 1]
    for key, numbers in found.items():
        if COEFFICIENT_KEYS.fullmatch(key):
            is_lens = key in single and len(single) > 1
        else:
            is_lens = key.lower() != "dist" or len(numbers) in LENS_SIZES
        if is_lens and any(numbers):
            raise InputError(f"{key} must be zero, got {values[key]}: undistort the images first")


def _numbers(value: Any) -> list[Any]:
    """Return the numbers of a JSON value or an array, one after the other."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in _numbers(item)]
    return [] if value is None or isinstance(value, str) else [value]
