"""The frame of a hand, found by its name in a MuJoCo model."""

from __future__ import annotations

from typing import Any

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco
from .name_suggestions import suggest_names


def find_frame(model: Any, frame: str) -> tuple[int, int]:
    """Return the body that carries a frame, and its site; -1 if the frame is that of the body.

    Raises
    ------
    InputError
        If there is neither a site nor a body of that name.
    """
    mujoco = import_mujoco()
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, frame)
    if site >= 0:
        return int(model.site_bodyid[site]), int(site)
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, frame)
    if body > 0:
        return int(body), -1
    names = [model.site(k).name for k in range(model.nsite)]
    names += [model.body(k).name for k in range(1, model.nbody)]
    raise InputError(
        f"the robot has no site or body {frame!r} to be the hand's frame; "
        + suggest_names(frame, names)
    )
