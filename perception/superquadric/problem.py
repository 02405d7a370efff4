"""The fit as an optimisation problem: measurements and priors in a scaled frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .effective_samples import MAX_SAMPLES
from .free_space import FreeSpace
from .kinds import fixed_exponents
from .options import FitOptions
from .outliers import FilteredCloud
from .parameters import CostTerms, Prior
from .shape import MAX_EXPONENT, MAX_TAPER, MIN_EXPONENT, Kind

SILHOUETTE_PIXELS = 0.5
"""Distance of the rays from the outline in pixels, added to ``silhouette_margin``, if the points
come from an image: a pixel at the outline may or may not show the object."""
SILHOUETTE_WEIGHT = 0.3
"""Weight of the rays against the mean squared point residual."""
SILHOUETTE_PULL = 0.1
"""Share of that weight with which the outline also attracts the solid, if the points come from an
image. It costs a third of the time."""
EXPONENT_RANGE = (0.1, 1.9)
"""Minimum and maximum exponent of kinds that fit exponents. Sharper edges need denser points."""
LOG_AXIS_SD = 1.5
"""Prior standard deviation of log semi-axes about the radius of the cloud. It only limits extents
that the view does not show."""
UNSEEN_LOG_AXIS_SD = 0.07
"""Prior standard deviation of log semi-axes beyond the farthest point. A larger value lets hidden
sides lie farther away."""
EXPONENT_SD = 0.7
"""Prior standard deviation of exponents about 1."""
TAPER_SD = 0.3
"""Prior standard deviation of the taper about 0."""
_PRIOR_MEAN = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
_PRIOR_VARIANCES = np.repeat([LOG_AXIS_SD, EXPONENT_SD, TAPER_SD], [3, 2, 2]) ** 2
_CEILING_VARIANCES = np.repeat([UNSEEN_LOG_AXIS_SD**2, np.inf], [3, 4])
OUTLINE_WEIGHT = 0.5
"""Weight of a complete outline, or of the planes around a whole object, against the mean squared
point residual."""
_GRID = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)], dtype=np.float64) - 1.0
DIRECTIONS = _GRID / np.linalg.norm(_GRID, axis=1, keepdims=True)
"""Directions in which extents are compared: along the axes and between them, (26, 3)."""
INITIAL_SAMPLES = 100.0
"""Effective samples in a depth image of a hand-sized object, until residuals give an estimate."""


class Observation(NamedTuple):
    """A cloud with all that is known about it."""

    cloud: FilteredCloud
    view_origin: NDArray[np.float64] | None = None
    """(3,) position of the camera, m."""
    plane: NDArray[np.float64] | None = None
    """(4,) unit normal and offset of the support plane, m."""
    free_space: FreeSpace | None = None
    """The space around the object that the view shows to be empty."""
    whole: bool = False
    """Whether the points show the object from all sides, so that it ends where they end."""


@dataclass(frozen=True)
class FitProblem:
    """Cost and prior of a fit in a frame centred on the cloud, with an RMS radius of 1."""

    terms: CostTerms
    prior: Prior
    centre: NDArray[np.float64]
    """(3,) centre of the scaled frame, m."""
    unit: float
    """Length of the scaled unit, m."""
    samples: float = INITIAL_SAMPLES
    """Effective number of independent samples in the points."""

    @property
    def points(self) -> NDArray[np.float64]:
        """(N, 3) scaled points."""
        return self.terms.points

    def thinned(self, points: int, ray_step: int, *, pull: bool = True) -> FitProblem:
        """Return the problem on the first points (their order is random) and every n-th ray."""
        terms = self.terms
        weights = terms.point_weights[:points]
        return replace(
            self,
            terms=terms._replace(
                points=terms.points[:points],
                point_weights=weights / weights.sum(),
                rays=np.ascontiguousarray(terms.rays[::ray_step]),
                ray_pull=terms.ray_pull if pull else 0.0,
            ),
        )


def build_problem(observation: Observation, options: FitOptions) -> FitProblem:
    """Centre, scale and thin a cloud in m, and set up the rays, the plane and the priors."""
    cloud, view_origin, plane, free_space, whole = observation
    points = cloud.points
    centre = points.mean(axis=0)
    square_radii = np.sum((points - centre) ** 2, axis=1)
    unit = float(np.sqrt(np.mean(square_radii)))
    points = sort_by_radius(points)
    chosen = np.random.default_rng(options.seed).permutation(len(points))[: options.points]
    rays = np.zeros((0, 3))
    origin = np.zeros(3)
    if view_origin is not None and options.silhouette_rays > 0:
        origin = (view_origin - centre) / unit
        scaled = (points - centre) / unit
        margin = (options.silhouette_margin + SILHOUETTE_PIXELS * cloud.pitch) / unit
        beside = silhouette_rays(scaled, origin, options.silhouette_rays, margin)
        # The outline of scattered points already lies outside the object by their noise.
        rays = beside if cloud.on_grid else silhouette_rays(scaled, origin, len(beside), 0.0)
        if free_space is not None and len(rays):
            rays = np.ascontiguousarray(rays[~free_space.hides(beside)])
    scaled_plane = np.array([0.0, 0.0, 1.0, 0.0])
    if plane is not None:
        scaled_plane = np.append(plane[:3], (plane[3] + plane[:3] @ centre) / unit)
    outline = tangent_planes((points - centre) / unit) if whole else np.zeros((0, 4))
    return FitProblem(
        terms=CostTerms(
            points=(points[chosen] - centre) / unit,
            point_weights=np.full(len(chosen), 1.0 / len(chosen)),
            rays=rays,
            view_origin=origin,
            plane=scaled_plane,
            cauchy_scale=2.0 * options.noise / unit,
            ray_weight=SILHOUETTE_WEIGHT if len(rays) else 0.0,
            ray_pull=SILHOUETTE_PULL if cloud.on_grid else 0.0,
            plane_weight=options.plane_weight if plane is not None else 0.0,
            plane_scale=options.plane_scale / unit,
            outline=outline,
            outline_weight=OUTLINE_WEIGHT if whole else 0.0,
        ),
        prior=point_prior(options.noise / unit, float(np.sqrt(square_radii.max())) / unit),
        centre=centre,
        unit=unit,
    )


def tangent_planes(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the planes (26, 4) around points (N, 3), with inward normals and offsets."""
    return np.column_stack([-DIRECTIONS, (points @ DIRECTIONS.T).max(axis=0)])


def parameter_bounds(kind: Kind, problem: FitProblem, options: FitOptions) -> NDArray[np.float64]:
    """Return rows of [low, high] (3, 2): log semi-axes in the scaled unit, exponents, taper.

    EXPONENT_RANGE applies to kinds that fit exponents only.
    """
    low, high = np.log(np.array(options.axis_range) / problem.unit)
    free = fixed_exponents(kind) is None
    exponents = EXPONENT_RANGE if free else (MIN_EXPONENT, MAX_EXPONENT)
    return np.array([[low, high], exponents, [-MAX_TAPER, MAX_TAPER]])


def sort_by_radius(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sort points (N, 3) by distance from their mean, an order that no frame or file changes."""
    square_radii = np.sum((points - points.mean(axis=0)) ** 2, axis=1)
    return points[np.argsort(square_radii, kind="stable")]


def point_prior(noise: float, max_radius: float, similar_sd: float | None = None) -> Prior:
    """Return the priors as weights relative to samples of this noise, both lengths scaled.

    `max_radius` is the distance of the farthest point. Extents beyond it are unseen.
    """
    unit_weight = noise**2 / MAX_SAMPLES
    ceiling = np.full(7, np.inf)
    ceiling[:3] = np.log(max_radius)
    return Prior(
        mean=_PRIOR_MEAN,
        weight=unit_weight / _PRIOR_VARIANCES,
        ceiling=ceiling,
        ceiling_weight=unit_weight / _CEILING_VARIANCES,
        similar_weight=0.0 if similar_sd is None else unit_weight / similar_sd**2,
    )


def silhouette_rays(
    points: NDArray[np.float64], origin: NDArray[np.float64], count: int, margin: float
) -> NDArray[np.float64]:
    """Return unit rays (K, 3) from the camera that pass the outline of the points at a margin.

    The outline is the convex hull of the view directions of the points. There are no rays if the
    camera is nearly inside the cloud.
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
    # The outline starts at its farthest point, which does not depend on the frame.
    hull = np.roll(hull, -int(np.argmax(np.sum(hull**2, axis=1))), axis=0)
    closed = np.vstack([hull, hull[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    positions = np.linspace(0.0, length[-1], count, endpoint=False)
    outline = np.column_stack([np.interp(positions, length, closed[:, k]) for k in range(2)])
    middle = np.mean(outline, axis=0)
    offset = outline - middle
    radius = np.linalg.norm(offset, axis=1, keepdims=True)
    outline = outline + margin / distance * offset / np.maximum(radius, 1e-12)
    rays = outline[:, :1] * side + outline[:, 1:] * up + forward
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
