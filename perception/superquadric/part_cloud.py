"""A cloud prepared for its division into parts: neighbours, image, and the empty rays around."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .effective_samples import MAX_SAMPLES
from .free_space import OCCLUDER_GAP, solid_parameters
from .free_space_kernels import covers_free_space
from .neighbour_kernels import nearest_neighbours
from .options import FitOptions
from .parameters import ShapeParameters
from .part_kernels import hides_places
from .part_outline import DIRECTIONS, outline_planes
from .problem import (
    OUTLINE_WEIGHT,
    SILHOUETTE_PIXELS,
    FitProblem,
    Observation,
    build_problem,
    point_prior,
    sort_by_radius,
    tangent_planes,
)
from .robust import robust_square, robust_squares
from .shape import Superquadric

SEARCH_POINTS = 800
"""Points on which parts are searched. All points enter the last fit of each part."""
NEIGHBOURS = 8
"""Neighbours of a point that define its local plane and vote on its part."""
MAX_CONTACT_GAP = 2.0
"""Maximum height of the lowest point of a part that stands on the support, in multiples of
``plane_scale``."""
COVERED_NOISE = 3.0
"""A ray may enter a solid this much too early, in multiples of the noise."""
REACH_SD = 0.003
"""Prior standard deviation of the height of a part over the plane, m, if all below it is hidden."""
REACH = 3.0
"""Height at which this prior loses its influence, in multiples of REACH_SD."""
HIDDEN_SHARES = np.linspace(0.15, 0.95, 6)
"""Places between the middle of a part and the plane that must be hidden, as shares of the way."""
SIMILAR_SD = 0.2
"""Prior standard deviation of the log ratio of the two smaller semi-axes of a part."""
SCATTERED_WEIGHT, LAST_SCATTERED_WEIGHT = 0.2, 0.02
"""Weight in place of OUTLINE_WEIGHT for scattered points in the search and in the last fit. Their
noise has a part across the rays: a full weight makes spheres 0.6 mm too large and boxes with a
margin 0.5 mm too small."""
SCATTERED_MARGIN = -0.3
"""Margin of the outline of scattered points, in multiples of the noise: the outermost points lie
outside the object."""
CLEARANCE = 1.5
"""Factor on the median distance of the farthest of the NEIGHBOURS in the image."""


class EmptyRays(NamedTuple):
    """Rays of the view beside the object that no solid may cross."""

    rays: NDArray[np.float64]
    """(M, 3) unit directions from the camera."""
    depth: NDArray[np.float64]
    """(M,) distances up to which they are empty."""
    gaps: NDArray[np.float64]
    """(M,) distances from the outline of the object, at its depth."""
    object_rays: int
    """Number of rays on the object, which have the same pitch."""


@dataclass(frozen=True)
class PartCloud:
    """A cloud in a scaled frame about its centre, in random order."""

    problem: FitProblem
    """The problem of one solid for all points. It defines the frame and the unit."""
    points: NDArray[np.float64]
    """(N, 3) points of the search, scaled."""
    all_points: NDArray[np.float64]
    """(M, 3) all points, scaled. The first ones are those of the search."""
    neighbours: NDArray[np.int64]
    """(N, NEIGHBOURS) indices of the neighbours of each point."""
    owner: NDArray[np.int64]
    """(M,) index of the point of the search nearest to each point."""
    image: NDArray[np.float64] | None
    """(M, 2) positions of all points in the image plane at unit depth; None without a camera."""
    frame: NDArray[np.float64] | None
    """(3, 3) rows: the axes of the image plane and the viewing direction; None without a camera."""
    empty: EmptyRays | None
    """The empty rays around; None without a free space."""
    unknown: NDArray[np.float64]
    """(U, 2) positions of rays beside the object that are not known to be empty."""
    margin: float
    """Distance of the outline from the outermost points in the image."""
    on_grid: bool
    """Whether the points are pixels of one image, whose noise moves no outline."""
    clearance: float
    """Distance in the image beyond which points are no neighbours."""
    noise: float
    """Expected noise, scaled."""
    whole: bool
    """Whether the points show the object from all sides."""

    def part_problem(self, mask: NDArray[np.bool_], count: int) -> FitProblem:
        """Return the problem of a part.

        Parameters
        ----------
        mask
            (N,) the points of the part. All points near these belong to it.
        count
            Maximum number of points. More than the points of the search take all points.
        """
        terms = self.problem.terms
        few = self.points[mask]
        # The order is random, so that the first points are a sample.
        cloud = (few if count <= len(self.points) else self.all_points[mask[self.owner]])[:count]
        outline = self._outline(mask)
        offsets = cloud - np.ones(len(cloud)) @ cloud / len(cloud)
        radius = float(np.sqrt(np.einsum("ij,ij->i", offsets, offsets).max()))
        complete = len(outline) if self.whole else DIRECTIONS
        outline_weight = OUTLINE_WEIGHT
        if not self.on_grid and not self.whole:
            searching = count <= len(self.points)
            outline_weight = SCATTERED_WEIGHT if searching else LAST_SCATTERED_WEIGHT
        plane_weight, plane_scale = self._contact(mask)
        return replace(
            self.problem,
            terms=terms._replace(
                points=cloud,
                point_weights=np.full(len(cloud), 1.0 / len(cloud)),
                rays=np.zeros((0, 3)),
                ray_weight=0.0,
                plane_weight=plane_weight,
                plane_scale=plane_scale,
                outline=outline,
                outline_weight=outline_weight * len(outline) / complete,
            ),
            prior=point_prior(self.noise, radius, SIMILAR_SD),
        )

    def _contact(self, mask: NDArray[np.bool_]) -> tuple[float, float]:
        """Return weight and scale of the contact of a part with the support plane."""
        terms = self.problem.terms
        lowest = float((self.points[mask] @ terms.plane[:3]).min() + terms.plane[3])
        if lowest < MAX_CONTACT_GAP * terms.plane_scale:
            return terms.plane_weight, terms.plane_scale
        if terms.plane_weight == 0.0 or not self._may_reach_plane(mask):
            return 0.0, terms.plane_scale
        deviation = REACH_SD / self.problem.unit
        return self.noise**2 / MAX_SAMPLES / deviation**2, REACH * deviation

    def _may_reach_plane(self, mask: NDArray[np.bool_]) -> bool:
        """Return whether the part with points in a mask (N,) hides all that lies under it."""
        if self.image is None or self.frame is None:
            return False
        plane, origin = self.problem.terms.plane, self.problem.terms.view_origin
        few = self.points[mask]
        middle = np.ones(len(few)) @ few / len(few)
        below = middle - np.outer(HIDDEN_SHARES * (middle @ plane[:3] + plane[3]), plane[:3])
        return bool(
            hides_places(below, self.points, self.image, mask, self.frame, origin, self.clearance)
        )

    def _outline(self, mask: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Return the planes (J, 4) that touch the outline of the part with points in a mask."""
        if self.whole:
            return tangent_planes(self.points[mask])
        if self.image is None or self.frame is None:
            return np.zeros((0, 4))
        return outline_planes(
            self.image,
            mask,
            self.owner,
            self.unknown,
            self.frame,
            self.problem.terms.view_origin,
            self.margin,
            self.clearance,
        )

    def square_error(self, gaps: NDArray[np.float64], covered: NDArray[np.bool_] | None) -> float:
        """Return the robust mean square of the residuals (M,) of points and empty rays.

        An empty ray that a solid covers counts as a point at the distance of the ray from the
        outline, because the outline of the solid lies at least as far away.
        """
        square = robust_square(gaps, self.noise)
        if self.empty is not None and covered is not None and covered.any():
            squares = robust_squares(self.empty.gaps[covered], self.noise)
            square += float(squares.sum()) / max(self.empty.object_rays, 1)
        return square + (0.5 * self.noise) ** 2

    def covered(self, shape: ShapeParameters) -> NDArray[np.bool_] | None:
        """Return a mask (M,) of the empty rays that a solid covers."""
        if self.empty is None:
            return None
        limit = self.empty.depth - COVERED_NOISE * self.noise
        origin = self.problem.terms.view_origin
        return covers_free_space(self.empty.rays, limit, origin, shape) > 1

    def scaled(self, solid: Superquadric) -> ShapeParameters:
        """Return the parameters of a solid in the scaled frame."""
        return solid_parameters(solid, self.problem.unit, self.problem.centre)


def prepare_part_cloud(observation: Observation, options: FitOptions) -> PartCloud:
    """Scale a cloud, put it in random order, and find the neighbours of each point."""
    problem = build_problem(observation, options)
    order = np.random.default_rng(options.seed).permutation(len(observation.cloud.points))
    points = (sort_by_radius(observation.cloud.points)[order] - problem.centre) / problem.unit
    few = points[:SEARCH_POINTS]
    neighbours = nearest_neighbours(few, few, min(NEIGHBOURS + 1, len(few)))[1][:, 1:]
    nearest = nearest_neighbours(few, points[len(few) :], 1)[1][:, 0]
    owner = np.concatenate([np.arange(len(few)), nearest])
    image, frame, empty = None, None, None
    unknown, margin, clearance = np.zeros((0, 2)), 0.0, 0.0
    if observation.view_origin is not None:
        origin = (observation.view_origin - problem.centre) / problem.unit
        distance = float(np.linalg.norm(origin))
        forward = -origin / distance
        frame = np.vstack([perpendicular_pair(forward), forward])
        image = _project(points - origin, frame)
        gaps = np.linalg.norm(image[neighbours[:, -1]] - image[: len(few)], axis=1)
        clearance = CLEARANCE * float(np.median(gaps))
        margin = SCATTERED_MARGIN * options.noise
        if observation.cloud.on_grid:
            margin = options.silhouette_margin + SILHOUETTE_PIXELS * observation.cloud.pitch
        margin /= problem.unit * distance
        if observation.free_space is not None:
            empty, unknown = _empty_rays(observation, problem, frame, few, image[: len(few)])
    return PartCloud(
        problem=problem,
        points=few,
        all_points=points,
        neighbours=neighbours,
        owner=owner,
        image=image,
        frame=frame,
        empty=empty,
        unknown=unknown,
        margin=margin,
        on_grid=observation.cloud.on_grid,
        clearance=clearance,
        noise=options.noise / problem.unit,
        whole=observation.whole,
    )


def _empty_rays(
    observation: Observation,
    problem: FitProblem,
    frame: NDArray[np.float64],
    points: NDArray[np.float64],
    image: NDArray[np.float64],
) -> tuple[EmptyRays | None, NDArray[np.float64]]:
    space = observation.free_space
    assert space is not None
    origin = (space.origin - problem.centre) / problem.unit
    beside = ~space.on_object & (space.rays @ frame[2] > 0.1)
    rays = space.rays[beside]
    image_of_rays = _project(rays, frame)
    gaps, nearest = nearest_neighbours(_in_plane(image), _in_plane(image_of_rays), 1)
    edge = np.linalg.norm(points[nearest[:, 0]] - origin, axis=1)
    depth = np.minimum(space.depth[beside] / problem.unit, 1e3)
    whole = depth > edge - OCCLUDER_GAP / problem.unit
    if observation.plane is not None:
        plane = problem.terms.plane
        heights = (origin + depth[:, None] * rays) @ plane[:3] + plane[3]
        whole |= np.abs(heights) < OCCLUDER_GAP / problem.unit
    unknown = image_of_rays[~whole]
    empty = depth > 0
    if not empty.any():
        return None, unknown
    empty_rays = EmptyRays(
        rays=np.ascontiguousarray(rays[empty]),
        depth=depth[empty],
        gaps=gaps[empty, 0] * edge[empty],
        object_rays=int(np.count_nonzero(space.on_object)),
    )
    return empty_rays, unknown


def _project(directions: NDArray[np.float64], frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions (N, 2) of directions (N, 3) in the image plane at unit depth."""
    local = directions @ frame.T
    return local[:, :2] / local[:, 2:]


def _in_plane(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return positions (N, 2) in the image as points (N, 3) of its plane."""
    return np.column_stack([positions, np.zeros(len(positions))])
