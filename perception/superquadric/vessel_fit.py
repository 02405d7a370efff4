"""Fit a vessel to a cloud that shows an opening."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .effective_samples import effective_sample_size
from .free_space import FreeSpace
from .model_selection import CandidateModel
from .opening import Opening, find_opening
from .options import FitOptions
from .problem import FitProblem, Observation, build_problem
from .result import SuperquadricFit
from .robust import log_square
from .shape import Superquadric
from .vessel import UNKNOWN_WALL, Vessel
from .vessel_outer import fit_outer_solids

RIM_PARAMETERS = 6
"""Parameters of a vessel besides its outer solid: middle (3) and semi-axes (2) of the rim, wall."""
MAX_THROUGH = 0.05
"""Maximum share of the opening of a vessel through which other surfaces are seen. More are seen
through a ring."""
FLOOR_QUANTILE = 0.25
"""Share of the points inside, or seen through the opening, below the height of the floor ..."""
MIN_FLOOR_NOISE, MIN_SEEN_NOISE = 1.0, 2.0
"""... and a lower floor, in expected noise, is the support plane seen through a ring. The second is
that of readings on other surfaces, because a ray has the smallest reading of its neighbours."""
INNER_WEIGHT = 0.1
"""Weight of a point of the inside against one of the outside."""
RAY_FACTOR = 3.0
"""Weight of the rays against that in other fits. On synthetic cups it lowers the median error of
the width from 2.6 to 2.2 mm."""
WALL_BAND = (0.003, 0.02)
"""Depths below the rim between which the inner wall is compared with the outer surface, m."""
MIN_WALL_SCALE = 0.8
"""Points nearer to the axis than this share of the part of the rim that all rays enter belong to
the floor."""
MIN_WALL_POINTS = 20
"""Minimum number of points of the inner wall."""
RAY_STEPS = 6
"""Samples along the ray of an inner point at which a closed solid is tested."""
MIN_WALL = 0.001
"""Thinner walls are not resolved, m."""


class Describe(Protocol):
    """Makes the result of a fit from its models, best first."""

    def __call__(
        self, models: list[CandidateModel], problem: FitProblem, options: FitOptions, /
    ) -> SuperquadricFit:
        """Return the fit with the first model as its solid."""
        ...


class FittedVessel(NamedTuple):
    """A vessel, and the data of its outer solid."""

    fit: SuperquadricFit
    """The fit of the outer solid, with the vessel."""
    observation: Observation
    """The observation with a lid on the opening: points and empty space end there."""


def fit_vessel(
    closed: SuperquadricFit, observation: Observation, options: FitOptions, describe: Describe
) -> FittedVessel | None:
    """Fit a vessel if the cloud shows an opening and a closed solid explains it worse.

    The points inside move along their rays to a lid in the plane of the rim. The outer solid is a
    solid of revolution, or one over an ellipse, about the axis of the rim. Vessel and closed solid
    are compared by the Bayesian information criterion over all points.

    Parameters
    ----------
    closed
        The fit of a solid without opening. Its axes are possible directions of the opening.
    observation
        The data of that fit.
    options
        The options of that fit.
    describe
        Function that makes the result from the models of the outer solid.
    """
    points, origin = observation.cloud.points, observation.view_origin
    if origin is None:
        return None
    opening = find_opening(
        points,
        origin,
        _directions(closed, observation),
        options.noise,
        _other_surfaces(observation.free_space),
    )
    if opening is None:
        return None
    lidded = _with_lid(observation, opening)
    problem = build_problem(lidded, options)
    guided = _with_inner_points(problem, points[opening.inside], opening)
    models, samples = fit_outer_solids(guided, opening, lidded.plane, options)
    problem = replace(problem, samples=samples)
    fit = describe(models, problem, options)
    if fit.superquadric is None:
        return None
    inside = points[opening.inside]
    wall = _wall(fit.superquadric, opening, inside)
    through = _is_through(opening, inside, observation.plane, options.noise)
    vessel = Vessel(fit.superquadric, opening.rim, wall, through)
    residuals = _residuals(vessel, points, opening.inside)
    if closed.superquadric is not None and not _pays(
        residuals, vessel, closed.superquadric, points, opening, options
    ):
        return None
    return FittedVessel(replace(fit, vessel=vessel, residuals=residuals), lidded)


def _directions(closed: SuperquadricFit, observation: Observation) -> list[NDArray[np.float64]]:
    """Return the directions in which the opening may point: up, and axes of the closed solid."""
    directions = [] if observation.plane is None else [observation.plane[:3]]
    if closed.superquadric is not None and observation.view_origin is not None:
        axes = closed.superquadric.rotation.T
        towards = axes @ (observation.view_origin - closed.superquadric.centre)
        order = np.argsort(-np.abs(towards))
        directions += [np.sign(towards[k]) * axes[k] for k in order if towards[k] != 0.0]
    return directions


def _with_lid(observation: Observation, opening: Opening) -> Observation:
    """Return the observation as if a lid closed the opening."""
    points = np.vstack([observation.cloud.points[~opening.inside], opening.lid])
    free_space = observation.free_space
    if free_space is not None:
        free_space = _closed(free_space, opening)
    return observation._replace(
        cloud=observation.cloud._replace(points=points), free_space=free_space
    )


def _closed(free_space: FreeSpace, opening: Opening) -> FreeSpace:
    """Return the free space with rays that end at the lid."""
    distance, scale = _crossings(free_space, opening)
    depth = np.where(scale < 1.0, np.minimum(free_space.depth, distance), free_space.depth)
    return replace(free_space, depth=depth)


def _other_surfaces(free_space: FreeSpace | None) -> NDArray[np.float64]:
    """Return the points (K, 3) at which rays meet other surfaces than the object, m."""
    if free_space is None:
        return np.zeros((0, 3))
    other = (free_space.depth > 0.0) & ~free_space.on_object
    return free_space.origin + free_space.depth[other, None] * free_space.rays[other]


def _is_through(
    opening: Opening,
    inside: NDArray[np.float64],
    plane: NDArray[np.float64] | None,
    noise: float,
) -> bool:
    """Return whether the opening is that of a ring: the support plane is seen in it.

    The floor of a vessel is higher. The segmentation may count it as another surface.
    """
    seen_through = opening.through_share > MAX_THROUGH
    points = opening.seen_through if seen_through else inside
    limit = MIN_SEEN_NOISE if seen_through else MIN_FLOOR_NOISE
    if plane is None or not len(points):
        return seen_through
    floor = float(np.quantile(points @ plane[:3] + plane[3], FLOOR_QUANTILE))
    return floor < limit * noise


def _crossings(
    free_space: FreeSpace, opening: Opening
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distance (K,) of each ray to the plane of the rim, m, and the rim's scale there.

    Both are infinite for rays that do not come from above.
    """
    rim = opening.rim
    rise = float((rim.centre - free_space.origin) @ rim.opening)
    along = free_space.rays @ rim.opening
    falling = (along < 0.0) & (rise < 0.0)
    distance = rise / np.where(falling, along, -1.0)
    scale = rim.scale(free_space.origin + free_space.rays * distance[:, None])
    return np.where(falling, distance, np.inf), np.where(falling, scale, np.inf)


def _with_inner_points(
    problem: FitProblem, inside: NDArray[np.float64], opening: Opening
) -> FitProblem:
    """Return the problem with the points inside, moved outwards by a usual wall.

    Seen from above, the inside is all that shows the shape of the outside. The rays at the outline
    weigh more, because the outline of a vessel is that of its outer solid.
    """
    offset = inside - opening.rim.centre
    outwards = offset / np.linalg.norm(offset, axis=1, keepdims=True)
    moved = (inside + UNKNOWN_WALL * outwards - problem.centre) / problem.unit
    terms = problem.terms
    points = np.vstack([terms.points, moved])
    weights = np.append(np.ones(len(terms.points)), np.full(len(moved), INNER_WEIGHT))
    order = np.random.default_rng(0).permutation(len(points))
    terms = terms._replace(
        points=np.ascontiguousarray(points[order]),
        point_weights=weights[order] / weights.sum(),
        ray_weight=RAY_FACTOR * terms.ray_weight,
    )
    return replace(problem, terms=terms)


def _wall(outer: Superquadric, opening: Opening, inside: NDArray[np.float64]) -> float | None:
    """Return the thickness of the wall just below the rim, m; None if it is not resolved.

    The distance of the inner wall from the outer surface is the thickness, and a wave around the
    axis from the error of the outer solid's middle.
    """
    rim = opening.rim
    below = (rim.centre - inside) @ rim.opening
    points = inside[(below > WALL_BAND[0]) & (below < WALL_BAND[1])]
    points = points[rim.scale(points) > MIN_WALL_SCALE * opening.inner_share]
    if len(points) < MIN_WALL_POINTS:
        return None
    depth = -outer.distance(points)
    x, y = ((points - rim.centre) @ rim.directions.T).T
    angle = np.arctan2(y, x)
    rows = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    wall = float(np.linalg.lstsq(rows, depth, rcond=None)[0][0])
    return wall if wall >= MIN_WALL else None


def _residuals(
    vessel: Vessel, points: NDArray[np.float64], inside: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the signed distances (N,) of points from the outer surface or the cavity, m."""
    return np.where(inside, -vessel.cavity_distance(points), vessel.outer.distance(points))


def _pays(
    residuals: NDArray[np.float64],
    vessel: Vessel,
    closed: Superquadric,
    points: NDArray[np.float64],
    opening: Opening,
    options: FitOptions,
) -> bool:
    """Return whether a vessel explains all points better than a closed solid.

    The points inside may lie on the far side of a closed solid, and those seen through a ring
    behind it. The view refutes that: their residual is the length of their rays in the solid, from
    the plane of the rim.
    """
    closed_residuals = np.abs(closed.distance(points))
    inside = np.flatnonzero(opening.inside)
    lengths = _lengths_inside(closed, opening.lid, points[inside])
    closed_residuals[inside] = np.maximum(closed_residuals[inside], lengths)
    behind = _lengths_inside(closed, opening.seen_lid, opening.seen_through)
    closed_residuals = np.append(closed_residuals, behind)
    residuals = np.append(residuals, np.zeros(len(behind)))
    points = np.vstack([points, opening.seen_through])
    order = np.random.default_rng(options.seed).permutation(len(points))
    count = effective_sample_size(points[order], residuals[order])
    gain = log_square(closed_residuals, options.noise) - log_square(residuals, options.noise)
    more = vessel.outer.parameter_count + RIM_PARAMETERS - closed.parameter_count
    return count * gain > more * float(np.log(count))


def _lengths_inside(
    solid: Superquadric, starts: NDArray[np.float64], ends: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the lengths (K,) of segments between points (K, 3) inside a solid, m."""
    steps = (np.arange(RAY_STEPS) + 0.5) / RAY_STEPS
    samples = starts[:, None] + steps[:, None] * (ends - starts)[:, None]
    return solid.contains(samples).mean(axis=1) * np.linalg.norm(ends - starts, axis=1)
