"""Depth frames of synthetic scenes, as a camera takes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception import DepthFrame

from ..scenes.furnished_scene import FurnishedScene
from ..scenes.tabletop_scene import TabletopScene
from .depth_noise import DepthNoise, add_depth_noise
from .depth_renderer import render_scene
from .depth_sensor import DepthSensor, sense_depth
from .rendered_view import DepthRenderer, RenderedView


def render_frame(
    scene: TabletopScene | FurnishedScene,
    noise: DepthNoise | DepthSensor | None = None,
    seed: int = 0,
    *,
    renderer: DepthRenderer | None = None,
    colour: bool = True,
) -> tuple[DepthFrame, NDArray[np.int32]]:
    """Render a depth frame of a scene, with the ground-truth label of each pixel.

    Parameters
    ----------
    scene
        The scene.
    noise
        The camera's noise, or a kind of sensor; no noise if not given.
    seed
        Source of the noise, >= 0; the same seed gives the same image.
    renderer
        Renderer; `open_renderer` chooses one if not given.
    colour
        Whether to draw colours too.

    Returns
    -------
    frame, labels
        The frame with `T_world_camera`, and (H, W) int32 labels of the noise-free view: 0
        background, k object k-1 of the scene.

    Raises
    ------
    InputError
        If the seed is negative, or the noise leaves no reading.
    DeviceError
        If no renderer works on this machine.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    view = render_scene(scene, renderer=renderer, colour=colour)
    return capture(scene, view, noise, np.random.default_rng(seed)), view.labels


def capture(
    scene: TabletopScene | FurnishedScene,
    view: RenderedView,
    noise: DepthNoise | DepthSensor | None,
    rng: np.random.Generator,
) -> DepthFrame:
    """Return the depth frame that a camera with noise, or a sensor, takes of a rendered view.

    Raises
    ------
    InputError
        If no reading is left.
    """
    if isinstance(noise, DepthSensor):
        depth = sense_depth(view, scene.intrinsics, rng, noise)
    else:
        depth = add_depth_noise(view.depth, scene.intrinsics, rng, noise or DepthNoise.none())
    return DepthFrame(depth, scene.intrinsics, scene.T_world_camera, view.colour)
