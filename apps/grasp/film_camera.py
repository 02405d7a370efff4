"""The camera of the film: it renders the simulated cell from the side."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.render import GlRenderer
from eyehand.data_synth.scenes import look_at
from eyehand.perception import CameraIntrinsics

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.cell import SimRobot

EYE, TARGET = (0.66, 0.92, 0.82), (0.165, -0.12, 0.13)
"""Camera position and the point it looks at, world, m. The tray is in view."""
FOCAL_WIDTHS = 1.2
"""Focal length over image width. The field of view is 45° wide."""
SLICES = 28
"""Number of facets around round geoms. MuJoCo's default takes five times as long."""
SHADOW_PX = 2048
"""Side of the shadow map, px. A smaller map leaves specks on the arm."""
SAMPLES = 4
"""Samples per pixel for smooth edges."""
HEADLIGHT = 0.29
"""Diffuse light from the camera. The lamp alone leaves the near side of the hand dark."""


class FilmCamera:
    """A renderer of the simulated cell for the film.

    Parameters
    ----------
    robot
        The simulated robot.
    size
        Width and height of the images, px.

    Raises
    ------
    DeviceError
        If no OpenGL context can be opened.
    """

    def __init__(self, robot: SimRobot, size: tuple[int, int]) -> None:
        self._data = robot.data
        # Copy the model: its render quality must not change for the depth images.
        self._model = model = copy.copy(robot.model)
        quality = model.vis.quality
        quality.numslices, quality.numstacks = SLICES, SLICES // 2
        quality.shadowsize, quality.offsamples = SHADOW_PX, SAMPLES
        model.vis.headlight.diffuse = [HEADLIGHT] * 3
        wide, high = size
        focal = FOCAL_WIDTHS * wide
        self._intrinsics = CameraIntrinsics(
            focal, focal, (wide - 1) / 2, (high - 1) / 2, wide, high
        )
        self._T_world_camera = look_at(np.array(EYE), np.array(TARGET))
        self._renderer = GlRenderer()

    def picture(self) -> NDArray[np.uint8]:
        """Render the current state of the cell, (H, W, 3) uint8 RGB."""
        return self._renderer.photograph(
            self._model, self._data, self._intrinsics, self._T_world_camera
        )

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()
