"""Perceive a frame and plan a grasp for every object: the step that all commands share."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping import GraspOptions, GraspPlan, select_prototype
from eyehand.perception import (
    DepthFrame,
    PerceiveOptions,
    Scene,
    SceneWarning,
    kernels_are_cached,
    perceive,
    warm_up,
)

from .console import say

CAMERA_UP = (0.0, -1.0, 0.0)
"""Up direction in the camera frame when neither gravity nor a camera pose is known."""


@dataclass(frozen=True)
class PerceivedFrame:
    """A depth frame, the scene in it, and a grasp plan per object."""

    frame: DepthFrame
    """The depth frame."""
    scene: Scene
    """Support plane and objects."""
    plans: dict[int, GraspPlan]
    """Grasp plan by object label."""
    plan_seconds: float
    """Duration of grasp planning, s."""


def perceive_and_plan(
    frame: DepthFrame,
    select: GraspOptions | None = None,
    options: PerceiveOptions | None = None,
) -> PerceivedFrame:
    """Perceive a frame and select a grasp for each object."""
    scene = perceive(frame, options)
    began = time.perf_counter()
    plans = plan_scene(scene, select)
    return PerceivedFrame(frame, scene, plans, time.perf_counter() - began)


def plan_scene(scene: Scene, select: GraspOptions | None = None) -> dict[int, GraspPlan]:
    """Return the grasp plan of each object by its label."""
    up: NDArray[np.float64] | None = (
        np.array(CAMERA_UP) if scene.reference_frame == "camera" else None
    )
    return {
        item.label: select_prototype(
            item,
            scene.support,
            neighbours=scene.objects,
            background=scene.background,
            up=up,
            options=select,
        )
        for item in scene.objects
    }


def support_line(scene: Scene) -> str:
    """Describe where the support is in the world or from the camera; empty without a support."""
    if scene.support is None:
        return ""
    if scene.reference_frame == "camera":
        return f"the camera is {round(1e3 * scene.support.offset)} mm from the plane of the support"
    normal, points = scene.support.normal, [item.points for item in scene.objects]
    x, y = np.median(np.concatenate(points), axis=0)[:2] if points else scene.view_origin[:2]
    z = -(normal[0] * x + normal[1] * y + scene.support.offset) / normal[2]
    tilt = np.degrees(np.arccos(min(normal[2], 1.0)))
    return f"the support is at z = {round(1e3 * z)} mm in the world, tilted by {tilt:.1f}°"


def load_kernels() -> Scene:
    """Load the numba kernels, and return the small scene that :func:`warm_up` perceives.

    The first run compiles the kernels and prints that it does.
    """
    if not kernels_are_cached():
        say("first run: compiling numerical kernels (once, one to two minutes) ...")
    return warm_up()


UNUSABLE = ("camera", "noise", "constant")
"""Kinds of warnings after which no result is of use. A live camera or a recording goes on after
them, because its next frame can be better. A file has no next frame."""


def check_usable(warnings: Iterable[SceneWarning], source: str = "") -> None:
    """Check that a frame with some warnings can be used.

    Parameters
    ----------
    warnings
        Those of its segmentation, or its faults before that.
    source
        The file, for the message.

    Raises
    ------
    InputError
        If the frame shows noise or nothing, or the camera is implausible.
    """
    for warning in warnings:
        if warning.kind in UNUSABLE:
            raise InputError(f"{source}: {warning.message}" if source else warning.message)
