"""Compare the depth images before and after a pick: which surfaces left, and which are new."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, Scene

NOISE_SIGMAS = 6.0
"""Difference of two readings beyond which the surface changed, in noise σ of one image. Readings of
surfaces at rest differ by less in 97 % of the pixels. The steps of the disparity are the reason for
the wide tails."""
MIN_POINTS = 40
"""Minimum number of readings that decide about a surface."""


@dataclass(frozen=True)
class DepthChange:
    """The depth images before and after a pick, each with its scene."""

    before: DepthFrame
    """Image before the pick, with its pose."""
    scene_before: Scene
    """Its scene, in the world frame."""
    after: DepthFrame
    """Image after the pick, with its pose."""
    scene_after: Scene
    """Its scene, in the world frame."""

    def remaining(self, points: NDArray[np.float64]) -> float | None:
        """Return the share of the surface points (N, 3) before the pick that are still there.

        Points near the support are left out: without the object the image hardly differs there.
        What hides a point leaves it out, too. None if the image shows too few of the others.
        """
        change, limit, gap = self._change(points, self.after)
        shown = (change > -limit) & (gap > 2.0 * limit)
        return _share(change[shown] < limit[shown])

    def appeared(self, points: NDArray[np.float64]) -> float | None:
        """Return the share of the surface points (N, 3) after the pick at formerly free places.

        Before the pick the image must show a surface behind such a point. None if it shows too few.
        """
        change, limit, _ = self._change(points, self.before)
        return _share(change > limit)

    def _change(
        self, points: NDArray[np.float64], frame: DepthFrame
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Compare points (N, 3), world, m, with a depth image.

        Returns
        -------
        tuple
            For each point with a reading in its line of sight: how much farther the reading is, the
            noise of this difference, and how much farther the support is, (K,) each, m.
        """
        T_world_camera, support = frame.T_world_camera, self.scene_before.support
        if T_world_camera is None or support is None:
            return np.zeros(0), np.zeros(0), np.zeros(0)
        local = T_world_camera.inv().apply(points)
        local, points = local[local[:, 2] > 0], points[local[:, 2] > 0]
        u, v = np.rint(frame.intrinsics.project(local)).astype(np.intp).T
        rows, columns = frame.depth.shape
        inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
        reading = np.zeros(len(local))
        reading[inside] = frame.depth[v[inside], u[inside]]
        read = reading > 0
        depth, height = local[read, 2], support.height(points[read])
        noise = max(one.segmentation.noise for one in (self.scene_before, self.scene_after))
        below = np.maximum(support.height(T_world_camera.translation) - height, 1e-9)
        return reading[read] - depth, NOISE_SIGMAS * noise * depth**2, depth * height / below


def _share(mask: NDArray[np.bool_]) -> float | None:
    return float(mask.mean()) if len(mask) >= MIN_POINTS else None
