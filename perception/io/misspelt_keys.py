"""Refuse keys of an input file that are probably misspelt."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from difflib import get_close_matches

from eyehand.errors import InputError

MIN_SIMILARITY = 0.8
"""Minimum similarity of a misspelt key, 0-1. `T_world_cam` has 0.88. `T_wrist_camera`, another pose
than `T_world_camera`, has 0.79."""


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
