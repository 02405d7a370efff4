"""A camera beside the cell that photographs the robot at work, as fast as a film needs it."""

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

EYE, LOOKED_AT = (0.66, 0.92, 0.82), (0.165, -0.12, 0.13)
"""Where it stands and looks, m: before the table, above the hand, the tray in view."""
FOCAL_WIDTHS = 1.2
"""Focal length in widths of the picture: 45° across, of the tray to the table's far side."""
SLICES = 28
"""Facets of round things; with more of them a picture takes five times as long."""
SHADOW_PX = 2048
"""Side of the shadow map: less shows as specks on the arm."""
SAMPLES = 4
"""Per pixel: edges are smooth."""
HEADLIGHT = 0.29
"""Light from the camera: the lamp alone leaves the hand's near side dark."""


class StageCamera:
    """Photographs a simulated robot's cell.

    Parameters
    ----------
    robot
        The robot.
    size
        Width and height of the pictures, px.

    Raises
    ------
    DeviceError
        If no OpenGL context can be opened here.
    """

    def __init__(self, robot: SimRobot, size: tuple[int, int]) -> None:
        self._data = robot.data
        # The pictures' quality is the model's: that of depth images is not to change.
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
        self._place = look_at(np.array(EYE), np.array(LOOKED_AT))
        self._renderer = GlRenderer()

    def picture(self) -> NDArray[np.uint8]:
        """Photograph the cell as it is now, (H, W, 3) uint8 RGB."""
        return self._renderer.photograph(self._model, self._data, self._intrinsics, self._place)

    def close(self) -> None:
        """Free what draws."""
        self._renderer.close()
