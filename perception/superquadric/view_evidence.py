"""What one view proves about the reach of an object: points seen, and space seen to be empty."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .free_space import FreeSpace

SEEN_QUANTILE = 0.995
"""Share of the points below the farthest point seen. Noise moves single points farther."""
MIN_HIDDEN = 0.015
"""A ray that ends less than this above the support plane meets the plane, m. Noise and rays that
graze the plane differ by less."""
BESIDE_PITCHES = 1.6
"""A ray without a reading may meet the object if one of its neighbours does: this is the angle to
its neighbours, in pitches."""
RAY_MARGIN = 2.0
"""Distance of the outline from the outermost points, in multiples of the noise, if no free space is
known."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class ViewEvidence:
    """Points and rays of one view of an object."""

    points: NDArray[np.float64]
    """(N, 3) points on the object, m."""
    noise: float
    """Expected noise of the points, m."""
    view_origin: NDArray[np.float64] | None = None
    """(3,) position of the camera, m; None if unknown."""
    plane: NDArray[np.float64] | None = None
    """(4,) unit normal and offset of the support plane, m; None if unknown."""
    free_space: FreeSpace | None = None
    """The empty space along the rays of the view; None if unknown."""

    def seen_reach(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far the points reach along unit directions (K, 3), (K,), m."""
        along = directions @ self.points.T
        last = min(int(SEEN_QUANTILE * along.shape[1]), along.shape[1] - 1)
        return np.partition(along, last, axis=1)[:, last]

    def free_reach(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the farthest reach along unit directions (K, 3) that the view allows, (K,), m.

        It is the support function of the visual hull over the support plane: all points behind
        the surfaces that the rays meet. It is infinite where nothing limits the object.
        """
        if self.view_origin is None:
            return np.full(len(directions), np.inf)
        corners, open_rays, margin = self._hidden_space
        reach = (directions @ corners.T).max(axis=1) + margin
        if len(open_rays):
            reach[(directions @ open_rays.T).max(axis=1) > 0.0] = np.inf
        return reach

    @cached_property
    def diameter(self) -> float:
        """Diagonal of the bounds of the points, m."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @cached_property
    def _hidden_space(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """Return the ends (M, 3) of the hidden sections of rays, the rays without end, a margin."""
        origin = np.asarray(self.view_origin)
        offsets = self.points - origin
        distances = np.linalg.norm(offsets, axis=1)
        if self.free_space is None:
            rays, depth = offsets / distances[:, None], distances
            margin = RAY_MARGIN * self.noise
        else:
            rays, depth = self._hidden_rays(self.free_space, distances)
            margin = 0.5 * self.free_space.pitch * float(distances.max())
        end = self._plane_distance(rays, origin)
        corners = [origin + depth[:, None] * rays, self.points]
        bounded = np.isfinite(end)
        far = np.maximum(end, depth)[bounded]
        corners.append(origin + far[:, None] * rays[bounded])
        return np.concatenate(corners), rays[~bounded], margin

    def _hidden_rays(
        self, free_space: FreeSpace, distances: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the rays (M, 3) behind whose surface the object may continue, and its depth (M,).

        They meet the object, or something nearer than the object's farthest point, or nothing
        beside the object.
        """
        rays, depth, on_object = free_space.rays, free_space.depth, free_space.on_object
        near, far = float(distances.min()), float(distances.max())
        end = self._plane_distance(rays, free_space.origin)
        covered = (depth > 0.0) & (depth < far) & (end - depth > MIN_HIDDEN)
        unread = np.flatnonzero((depth <= 0.0) & ~on_object)
        if len(unread) and on_object.any():
            cosines = (rays[unread] @ rays[on_object].T).max(axis=1)
            beside = unread[cosines > np.cos(BESIDE_PITCHES * free_space.pitch)]
            covered[beside] = True
        hidden = on_object | covered
        start = np.where(depth > 0.0, depth, near)
        return rays[hidden], start[hidden]

    def _plane_distance(
        self, rays: NDArray[np.float64], origin: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the distance (K,) along each ray to the support plane, m; inf without one."""
        if self.plane is None:
            return np.full(len(rays), np.inf)
        height = float(origin @ self.plane[:3] + self.plane[3])
        fall = -(rays @ self.plane[:3])
        return np.where(fall > 1e-6, height / np.maximum(fall, 1e-6), np.inf)
