"""A cloud prepared for its division into parts: neighbours, noise, and occlusion between parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

from .problem import Observation, sort_by_radius

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions

NEIGHBOURS = 8
"""Neighbours of a point that define its local plane and vote on its part."""
MAX_CONTACT_GAP = 2.0
"""Maximum height of the lowest point of a part that stands on the support, in multiples of
``plane_scale``."""
BESIDE_SPACINGS = 2.0
"""Maximum distance beside a ray at which points of another part make the outline of this part
unknown, in point spacings."""
BEHIND_SPACINGS = 3.0
"""Maximum distance of these points behind this part, in point spacings."""


@dataclass(frozen=True)
class PartCloud:
    """A cloud about its centre, in random order."""

    observation: Observation
    """Points (N, 3), m, camera and plane, all relative to `centre`."""
    centre: NDArray[np.float64]
    """Position of the centre in the frame of the cloud, (3,), m."""
    radius: float
    """Root mean square distance of the points from the centre, m."""
    neighbours: NDArray[np.int64]
    """(N, NEIGHBOURS) indices of the neighbours of each point."""
    spacing: float
    """Median distance of neighbours, m."""
    roughness: NDArray[np.float64]
    """(N,) distances from the plane through the neighbours, m: noise that no solid explains."""
    directions: KDTree | None
    """Unit directions from the camera to the points."""
    depths: NDArray[np.float64]
    """(N,) distances from the camera, m; empty without one."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(N, 3), m."""
        return self.observation.cloud.points

    def part(self, labels: NDArray[np.int64], index: int, options: FitOptions) -> Observation:
        """Return the observation of the points whose label, of labels (N,), is `index`."""
        cloud, view_origin, plane, free_space, _ = self.observation
        in_part = labels == index
        points = self.points[in_part]
        if plane is not None:
            lowest = float((points @ plane[:3] + plane[3]).min())
            if lowest > MAX_CONTACT_GAP * options.plane_scale:
                plane = None

        def hides(rays: NDArray[np.float64]) -> NDArray[np.bool_]:
            return self._hides(rays, in_part)

        return Observation(cloud._replace(points=points), view_origin, plane, free_space, hides)

    def _hides(self, rays: NDArray[np.float64], in_part: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return whether another part continues or occludes this one along rays (K, 3)."""
        free_space = self.observation.free_space
        hidden = np.zeros(len(rays), dtype=bool) if free_space is None else free_space.hides(rays)
        assert self.directions is not None
        radius = BESIDE_SPACINGS * self.spacing / float(np.median(self.depths))
        for ray, indices in enumerate(self.directions.query_ball_point(rays, radius)):
            beside = np.asarray(indices, dtype=np.int64)
            beside_in_part = in_part[beside]
            if beside_in_part.all():
                continue
            depths = self.depths[beside]
            limit = (
                depths[beside_in_part].max() + BEHIND_SPACINGS * self.spacing
                if beside_in_part.any()
                else np.inf
            )
            hidden[ray] |= bool(depths[~beside_in_part].min() < limit)
        return hidden


def prepare_part_cloud(observation: Observation, options: FitOptions) -> PartCloud:
    """Centre a cloud, put it in random order, and find the neighbours of each point."""
    cloud = observation.cloud.points
    centre = cloud.mean(axis=0)
    order = np.random.default_rng(options.seed).permutation(len(cloud))
    points = sort_by_radius(cloud)[order] - centre
    gaps, indices = KDTree(points).query(points, k=NEIGHBOURS + 1)
    neighbours = np.asarray(indices)[:, 1:]
    origin, plane, directions, depths = None, None, None, np.zeros(0)
    free_space = observation.free_space and observation.free_space.shifted(-centre)
    if observation.view_origin is not None:
        origin = observation.view_origin - centre
        depths = np.linalg.norm(points - origin, axis=1)
        directions = KDTree((points - origin) / depths[:, None])
    if observation.plane is not None:
        normal, offset = observation.plane[:3], observation.plane[3]
        plane = np.append(normal, offset + normal @ centre)
    filtered = observation.cloud._replace(points=points)
    return PartCloud(
        observation=Observation(filtered, origin, plane, free_space),
        centre=centre,
        radius=float(np.sqrt(np.mean(np.sum(points**2, axis=1)))),
        neighbours=neighbours,
        spacing=float(np.median(np.asarray(gaps)[:, 1:])),
        roughness=_plane_distances(points, neighbours),
        directions=directions,
        depths=depths,
    )


def _plane_distances(
    points: NDArray[np.float64], neighbours: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return distances (N,) of points from the planes through their neighbours."""
    patches = points[neighbours]
    middles = patches.mean(axis=1)
    offsets = patches - middles[:, None]
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    return np.einsum("ni,ni->n", points - middles, axes[:, :, 0])
