"""A cloud to be shared out among parts: neighbours, noise, and what a view shows of each part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from .problem import in_own_order

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .options import FitOptions
    from .outliers import Neighbourly

    Hidden = Callable[[NDArray[np.float64]], NDArray[np.bool_]]

NEIGHBOURS = 8
"""Neighbours of a point that tell the surface's direction and vote on its part."""
CONTACT = 2.0
"""Parts that end higher over the support than so many times the scale at which contact lets go
do not stand on it."""
BESIDE = 2.0
"""Points this many spacings beside a ray, and ..."""
BEHIND = 3.0
"""... not so many behind the part's own, hide where the part ends."""


class Seen(NamedTuple):
    """A cloud with all that is known about it: what one solid is fitted to."""

    near: Neighbourly
    """Points (N, 3), m, without outliers."""
    origin: NDArray[np.float64] | None
    """(3,) place of the camera."""
    plane: NDArray[np.float64] | None
    """(4,) support plane."""
    hidden: Hidden | None
    """Tells of unit directions (K, 3) from the camera which say nothing, (K,)."""


@dataclass(frozen=True)
class PartCloud:
    """A cloud about its own middle, in an order of its own."""

    seen: Seen
    """Points (N, 3) in random order, m, and what is known about them."""
    centre: NDArray[np.float64]
    """Where the middle lies, (3,), m."""
    unit: float
    """Root mean square distance from it, m."""
    neighbours: NDArray[np.int64]
    """(N, NEIGHBOURS) indices of each point's neighbours."""
    spacing: float
    """Median distance to them, m."""
    waviness: NDArray[np.float64]
    """(N,) distances from the plane through the neighbours, m: what no solid explains."""
    directions: KDTree | None
    """Unit directions from the camera to the points."""
    depths: NDArray[np.float64]
    """(N,) distances from the camera, m; empty without one."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(N, 3), m."""
        return self.seen.near.cloud

    def part(self, labels: NDArray[np.int64], index: int, options: FitOptions) -> Seen:
        """Give the part of the cloud with a label, (N,) labels."""
        points = self.points[labels == index]
        plane = self.seen.plane
        if plane is not None:
            lowest = float((points @ plane[:3] + plane[3]).min())
            if lowest > CONTACT * options.plane_scale:
                plane = None

        def hidden(rays: NDArray[np.float64]) -> NDArray[np.bool_]:
            return self._hidden(rays, labels == index)

        near = self.seen.near._replace(cloud=points)
        return Seen(near, self.seen.origin, plane, hidden)

    def _hidden(self, rays: NDArray[np.float64], own: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether rays (K, 3) pass where another part continues this one, or stands before it."""
        asked = self.seen.hidden
        # Directions are the same in the cloud's frame and about its middle.
        hidden = np.zeros(len(rays), dtype=bool) if asked is None else asked(rays).copy()
        assert self.directions is not None
        reach = BESIDE * self.spacing / float(np.median(self.depths))
        for ray, found in enumerate(self.directions.query_ball_point(rays, reach)):
            beside = np.asarray(found, dtype=np.int64)
            mine = own[beside]
            if mine.all():
                continue
            depths = self.depths[beside]
            limit = depths[mine].max() + BEHIND * self.spacing if mine.any() else np.inf
            hidden[ray] |= bool(depths[~mine].min() < limit)
        return hidden


def part_cloud(seen: Seen, options: FitOptions) -> PartCloud:
    """Centre a cloud, put it in random order, and look at every point's surroundings."""
    cloud = seen.near.cloud
    centre = cloud.mean(axis=0)
    order = np.random.default_rng(options.seed).permutation(len(cloud))
    points = in_own_order(cloud)[order] - centre
    gaps, indices = KDTree(points).query(points, k=NEIGHBOURS + 1)
    neighbours = np.asarray(indices)[:, 1:]
    origin, plane, directions, depths = None, None, None, np.zeros(0)
    if seen.origin is not None:
        origin = seen.origin - centre
        depths = np.linalg.norm(points - origin, axis=1)
        directions = KDTree((points - origin) / depths[:, None])
    if seen.plane is not None:
        plane = np.append(seen.plane[:3], seen.plane[3] + seen.plane[:3] @ centre)
    return PartCloud(
        seen=Seen(seen.near._replace(cloud=points), origin, plane, seen.hidden),
        centre=centre,
        unit=float(np.sqrt(np.mean(np.sum(points**2, axis=1)))),
        neighbours=neighbours,
        spacing=float(np.median(np.asarray(gaps)[:, 1:])),
        waviness=_off_plane(points, neighbours),
        directions=directions,
        depths=depths,
    )


def _off_plane(points: NDArray[np.float64], neighbours: NDArray[np.int64]) -> NDArray[np.float64]:
    """Distances (N,) of points from the planes through their neighbours."""
    patches = points[neighbours]
    middles = patches.mean(axis=1)
    spread = patches - middles[:, None]
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))
    return np.einsum("ni,ni->n", points - middles, axes[:, :, 0])
