"""Perceive a frame and plan a grasp for every object: the step that all commands share."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.grasping import GraspOptions, GraspPlan, select_prototype
from eyehand.perception import (
    DepthFrame,
    PerceiveOptions,
    Scene,
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
    up: NDArray[np.float64] | None = (
        np.array(CAMERA_UP) if scene.reference_frame == "camera" else None
    )
    plans = {
        item.label: select_prototype(
            item, scene.support, neighbours=scene.objects, up=up, options=select
        )
        for item in scene.objects
    }
    return PerceivedFrame(frame, scene, plans, time.perf_counter() - began)


def load_kernels() -> None:
    """Load the numba kernels. The first run compiles them and prints that it does."""
    if not kernels_are_cached():
        say("first run: compiling numerical kernels (once, about half a minute) ...")
    warm_up()
