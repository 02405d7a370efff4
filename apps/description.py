"""From a frame to a scene with a grasp for every object, the step all commands share."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.grasping import GraspPlan, SelectOptions, select_prototype
from eyehand.perception import (
    DepthFrame,
    PerceiveOptions,
    Scene,
    kernels_are_cached,
    perceive,
    warm_up,
)

from .console import say

if TYPE_CHECKING:
    from numpy.typing import NDArray

CAMERA_UP = (0.0, -1.0, 0.0)
"""Up in the camera's frame when nothing else tells: against y."""


@dataclass(frozen=True)
class Description:
    """A frame, what it shows, and how to grasp it."""

    frame: DepthFrame
    """The depth frame."""
    scene: Scene
    """Support plane and objects."""
    plans: dict[int, GraspPlan]
    """Grasp plan by object label."""
    plan_seconds: float
    """Time the choice of grasps took."""


def describe(
    frame: DepthFrame,
    select: SelectOptions | None = None,
    options: PerceiveOptions | None = None,
) -> Description:
    """Perceive a frame and choose a grasp for each object."""
    scene = perceive(frame, options)
    began = time.perf_counter()
    up: NDArray[np.float64] | None = np.array(CAMERA_UP) if scene.frame == "camera" else None
    plans = {
        item.label: select_prototype(
            item, scene.support, neighbours=scene.objects, up=up, options=select
        )
        for item in scene.objects
    }
    return Description(frame, scene, plans, time.perf_counter() - began)


def ready_kernels() -> None:
    """Compile the numba kernels if this is the first run, saying so; load them otherwise."""
    if not kernels_are_cached():
        say("first run: compiling numerical kernels, once, about half a minute ...")
    warm_up()
