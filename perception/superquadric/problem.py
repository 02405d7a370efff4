"""The fit as an optimisation problem: points, silhouette rays and support plane, scaled to one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

from ..perpendicular import perpendicular_pair

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .options import FitOptions
    from .outliers import Neighbourly


class Guess(NamedTuple):
    """A point in parameter space, in the problem's scaled frame."""

    axes: NDArray[np.float64]
    """Logarithms of the semi-axes, (3,)."""
    eps: NDArray[np.float64]
    """Exponents, (2,)."""
    R: NDArray[np.float64]
    """Local axes as columns, (3, 3)."""
    c: NDArray[np.float64]
    """Centre, (3,)."""
    taper: NDArray[np.float64] = np.zeros(2)
    """Taper along x and y, (2,)."""


@dataclass(frozen=True)
class FitProblem:
    """Everything the residual kernels need, in a frame centred on the cloud with radius 1."""

    points: NDArray[np.float64]
    """(N, 3) scaled points."""
    weights: NDArray[np.float64]
    """(N,) weights that sum to 1."""
    rays: NDArray[np.float64]
    """(K, 3) unit directions of rays that must miss the solid."""
    origin: NDArray[np.float64]
    """(3,) scaled origin of the rays."""
    plane: NDArray[np.float64]
    """(4,) scaled support plane: normal and offset."""
    centre: NDArray[np.float64]
    """(3,) centre of the scaled frame, m."""
    unit: float
    """Length of the scaled unit, m."""
    prior: NDArray[np.float64]
    """(4, 7) homes and weights of log semi-axes, exponents and taper, ceilings and the weights
    above them."""
    cauchy: float
    """Cauchy scale of point residuals, scaled."""
    ray_weight: float
    ray_pull: float
    """Share of the weight with which rays pull a solid that they miss."""
    plane_weight: float
    plane_scale: float
    readings: float = 100.0
    """Independent readings that the points count for; until residuals tell, what a depth image of
    a hand-sized object holds."""

    def data(self) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Arguments before the guess in :func:`residual_kernels.normal_equations`."""
        return self.points, self.weights, self.rays, self.plane, self.origin

    def weighting(self) -> tuple[float, float, float, float, float]:
        """Arguments after the guess in :func:`residual_kernels.normal_equations`."""
        return self.cauchy, self.ray_weight, self.ray_pull, self.plane_weight, self.plane_scale

    def thinned(self, points: int, every_ray: int, *, pull: bool = True) -> FitProblem:
        """Give the same problem on the first points (their order is random) and every n-th ray."""
        weights = self.weights[:points] / self.weights[:points].sum()
        rays = np.ascontiguousarray(self.rays[::every_ray])
        ray_pull = self.ray_pull if pull else 0.0
        return replace(
            self, points=self.points[:points], weights=weights, rays=rays, ray_pull=ray_pull
        )


def pose_problem(
    near: Neighbourly,
    view_origin: NDArray[np.float64] | None,
    plane: NDArray[np.float64] | None,
    hidden: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None,
    options: FitOptions,
) -> FitProblem:
    """Centre and scale a cloud in m, thin it, and set up its side conditions."""
    points = near.cloud
    centre = points.mean(axis=0)
    reach = np.sum((points - centre) ** 2, axis=1)
    unit = float(np.sqrt(np.mean(reach)))
    points = in_own_order(points)
    chosen = np.random.default_rng(options.seed).permutation(len(points))[: options.points]
    fitted = (points[chosen] - centre) / unit
    rays = np.zeros((0, 3))
    origin = np.zeros(3)
    if view_origin is not None and options.silhouette_rays > 0:
        origin = (view_origin - centre) / unit
        scaled = (points - centre) / unit
        margin = (options.silhouette_margin + options.silhouette_pitch * near.pitch) / unit
        beside = silhouette_rays(scaled, origin, options.silhouette_rays, margin)
        # The outline of scattered points lies outside the object's already, by their noise.
        rays = beside if near.on_grid else silhouette_rays(scaled, origin, len(beside), 0.0)
        if hidden is not None and len(rays):
            rays = np.ascontiguousarray(rays[~hidden(beside)])
    scaled_plane = np.array([0.0, 0.0, 1.0, 0.0])
    if plane is not None:
        scaled_plane = np.append(plane[:3], (plane[3] + plane[:3] @ centre) / unit)
    return FitProblem(
        points=fitted,
        weights=np.full(len(fitted), 1.0 / len(fitted)),
        rays=rays,
        origin=origin,
        plane=scaled_plane,
        centre=centre,
        unit=unit,
        prior=_prior(options.noise / unit, float(np.sqrt(reach.max())) / unit, options),
        cauchy=2.0 * options.noise / unit,
        ray_weight=options.silhouette_weight if len(rays) else 0.0,
        ray_pull=options.silhouette_pull if near.on_grid else 0.0,
        plane_weight=options.plane_weight if plane is not None else 0.0,
        plane_scale=options.plane_scale / unit,
    )


def in_own_order(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sort points (N, 3) by distance from their mean: neither listing nor frame matters."""
    reach = np.sum((points - points.mean(axis=0)) ** 2, axis=1)
    return points[np.argsort(reach, kind="stable")]


def _prior(noise: float, reach: float, options: FitOptions) -> NDArray[np.float64]:
    """Homes, weights, ceilings, weights above (4, 7), as Gaussians beside readings of this noise.

    `reach` is the distance of the farthest point: an extent beyond it was not seen.
    """
    home = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    spread = np.repeat([options.axis_prior, options.exponent_prior, options.taper_prior], [3, 2, 2])
    certain = noise**2 / options.effective_points
    ceiling = np.repeat([np.log(reach), np.inf], [3, 4])
    above = np.repeat([certain / options.unseen_growth**2, 0.0], [3, 4])
    return np.stack([home, certain / spread**2, ceiling, above])


def silhouette_rays(
    points: NDArray[np.float64], origin: NDArray[np.float64], count: int, margin: float
) -> NDArray[np.float64]:
    """Unit rays (K, 3) from the view's origin that pass the points' outline at a margin.

    The outline is the convex hull of the points' directions: a view says where a convex solid
    is not. Empty when the origin lies inside the cloud's bounding ball.
    """
    distance = float(np.linalg.norm(origin))
    offset = points - origin
    forward = -origin / max(distance, 1e-12)
    depth = offset @ forward
    if distance < 1e-9 or depth.min() <= 0.05 * distance:
        return np.zeros((0, 3))
    side, up = perpendicular_pair(forward)
    image = np.column_stack([offset @ side, offset @ up]) / depth[:, None]
    hull = cv2.convexHull(image.astype(np.float32)).reshape(-1, 2).astype(np.float64)
    if len(hull) < 3:
        return np.zeros((0, 3))
    # The outline starts where it is farthest out: a place that turns with the cloud.
    hull = np.roll(hull, -int(np.argmax(np.sum(hull**2, axis=1))), axis=0)
    closed = np.vstack([hull, hull[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    marks = np.linspace(0.0, length[-1], count, endpoint=False)
    outline = np.column_stack([np.interp(marks, length, closed[:, k]) for k in range(2)])
    middle = np.mean(outline, axis=0)
    away = outline - middle
    radius = np.linalg.norm(away, axis=1, keepdims=True)
    outline = outline + margin / distance * away / np.maximum(radius, 1e-12)
    rays = outline[:, :1] * side + outline[:, 1:] * up + forward
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
