"""Learn the height of a fixed support from depth images whose scale is uncertain."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from eyehand.errors import InputError
from eyehand.perception import DepthFrame, find_support

from .depth_correction import CORRECTED_SCALE_ERROR, correct_depth


@dataclass
class SupportMemory:
    """The height of a horizontal support, from all images of it since the clearing began.

    Each image shows the support at another height, because each has its own scale. Their mean has a
    smaller error than one of them. Each image is scaled so that its support lies at the mean. A
    scale that is wrong by the same factor in all images stays wrong.
    """

    depth_error: float
    """Standard deviation of the scale of one image, as a share of the distance."""
    _heights: list[float] = field(default_factory=list)
    """Height of the support in each image, m."""
    _sigmas: list[float] = field(default_factory=list)
    """Standard deviation of each height, m."""

    def corrected(self, frame: DepthFrame) -> tuple[DepthFrame, float]:
        """Add an image, and scale it to the mean height.

        Parameters
        ----------
        frame
            The depth frame; `T_world_camera` must be known.

        Returns
        -------
        frame, depth_error
            The corrected frame, and the standard deviation of its scale, which is also its
            `scale_error`. Without a support, or if the correction is refused, the frame and the
            deviation of one image.

        Raises
        ------
        InputError
            If the pose of the camera is unknown.
        """
        if frame.T_world_camera is None:
            raise InputError("the memory of the support needs T_world_camera")
        support = find_support(frame)
        if support is None:
            return frame, self.depth_error
        distance = support.offset
        self._heights.append(float(frame.T_world_camera.translation[2]) - distance)
        self._sigmas.append(max(self.depth_error * distance, 1e-6))
        weights = 1.0 / np.square(self._sigmas)
        height = float(weights @ self._heights / weights.sum())
        frame, correction = correct_depth(frame, height, support)
        if not correction:
            return frame, self.depth_error
        share = float(weights.sum() ** -0.5) / distance
        error = float(np.hypot(share, CORRECTED_SCALE_ERROR))
        return replace(frame, scale_error=error), error
