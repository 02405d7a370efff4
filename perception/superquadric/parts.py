"""Split an object that no single solid explains into a few solids."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .canonical import canonical
from .cost_kernels import distances
from .effective_samples import MAX_SAMPLES, effective_sample_size
from .model_selection import PRUNE_MARGIN
from .parameters import ShapeParameters
from .part_assignment import (
    MIN_PART_POINTS,
    PartAssignment,
    buried_points,
    fit_box_behind_face,
    log_square,
    merge_parts,
    nearest_parts,
    robust_cost,
    split_part,
)
from .part_cloud import PartCloud, prepare_part_cloud
from .shape import PARAMETER_COUNT, Superquadric
from .validity import PLANE_PARAMETERS, check_residuals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import Observation
    from .result import CandidateSolid, SuperquadricFit

EXPLAINED_NOISE = 0.8
"""Points within this share of the expected noise are explained, because surfaces are not smooth."""
MARGIN = 10.0
"""Parts must lower the criterion by more than this: very strong evidence (Kass and Raftery 1995),
because the best of many splits gains something by chance."""
BURIED_SHARE = 0.02
"""Share of points inside parts from which on the parts are fitted again."""
REQUIRED_PARAMETERS = PARAMETER_COUNT["box"]
"""Parameters that a further part must be worth before it is searched."""
MIN_PART_PARAMETERS = PARAMETER_COUNT["sphere"]
"""Parameters of the simplest part: rough parts that gain nothing even with so few are dropped."""
ROUGH_PARAMETERS = PARAMETER_COUNT["superquadric"]
"""Parameters of each rough part while numbers of parts are compared."""
MIN_THICKNESS = 0.1
"""Minimum extent of the first shape of a flat cloud, as a share of its largest."""


class FitOne(Protocol):
    """Fits one solid to a cloud."""

    def __call__(self, observation: Observation, options: FitOptions, /) -> SuperquadricFit:
        """Fit one solid, whatever `max_parts` is."""
        ...


class _Model(NamedTuple):
    """Solids that explain a cloud, about its centre."""

    solids: tuple[Superquadric, ...]
    """Largest first; none if a plane explains the points."""
    fit: SuperquadricFit
    """The fit of the largest one."""
    residuals: NDArray[np.float64]
    """(N,) signed distances of the points from the union, m."""
    parameters: int
    """Number of parameters, including one share of the points per part."""


def split_into_parts(
    whole: SuperquadricFit, observation: Observation, options: FitOptions, fit_one: FitOne
) -> SuperquadricFit:
    """Split an object that one solid does not explain into at most ``options.max_parts`` solids.

    Rough solids are assigned to the points, one more at a time. Then the numbers of parts are
    compared by solids that are fitted to their points with all steps. More parts are kept if they
    clearly lower the Bayesian information criterion.

    Parameters
    ----------
    whole
        The fit of one solid. It has no solid if a plane explains the points.
    observation
        The data of that fit.
    options
        The options of that fit.
    fit_one
        Function that fits each part. It uses the rays that no other part blocks or continues.

    Returns
    -------
    SuperquadricFit
        The fit of the largest part by volume, with all parts and the residuals of their union;
        `whole` if more parts are no better.
    """
    cloud = prepare_part_cloud(observation, options)
    single = _single_model(whole, cloud)
    assignments, counts = _assign_parts(single, cloud, options)
    best = single
    for assignment in assignments:
        model = _fit_parts(assignment, cloud, options, fit_one)
        if model is not None and _is_better(model, best, cloud, options):
            best = model
    if best is not single:
        return _to_result(best, cloud)
    if whole or not counts:
        return whole
    return replace(whole, reason=f"{whole.reason} (no better in {counts} parts)")


def _single_model(whole: SuperquadricFit, cloud: PartCloud) -> _Model:
    if whole.superquadric is None:
        _, _, rows = np.linalg.svd(cloud.points, full_matrices=False)
        return _Model((), whole, cloud.points @ rows[2], PLANE_PARAMETERS)
    solid = _shifted(whole.superquadric, -cloud.centre)
    return _Model((solid,), whole, solid.distance(cloud.points), solid.parameter_count)


def _assign_parts(
    single: _Model, cloud: PartCloud, options: FitOptions
) -> tuple[list[PartAssignment], str]:
    """Assign the points to 2, 3, ... rough solids; return what may win, and the counts tried.

    Parts are added while points remain unexplained. A split that gains nothing yet can lead to
    one that does.
    """
    shape = _shape(single.solids[0]) if single.solids else _flat_shape(cloud)
    labels = np.zeros(len(cloud.points), dtype=np.int64)
    score = log_square(single.residuals, options)
    assignment = PartAssignment((shape,), labels, single.residuals, score)
    assignments: list[PartAssignment] = []
    while len(assignment.shapes) < options.max_parts:
        splits = [
            split_part(assignment, index, cloud, options)
            for index in range(len(assignment.shapes))
            if _is_worth_splitting(assignment, index, cloud, options)
        ]
        valid_splits = [split for split in splits if split is not None]
        if not valid_splits:
            break
        assignment = min(valid_splits, key=lambda split: split.score)
        assignments.append(assignment)
    if not assignments:
        return [], ""
    # A later split can correct a first split in the wrong place. Then one part is too many.
    for index in range(len(assignments) - 1, 0, -1):
        fewer = merge_parts(assignments[index], cloud, options)
        if fewer.score < assignments[index - 1].score:
            assignments[index - 1] = fewer
    counts = " or ".join(str(len(one.shapes)) for one in assignments)
    return _promising(assignments, single, cloud, options), counts


def _promising(
    assignments: list[PartAssignment], single: _Model, cloud: PartCloud, options: FitOptions
) -> list[PartAssignment]:
    """Return the assignments that can beat one solid and are near the best in the criterion."""
    samples = effective_sample_size(cloud.points, assignments[-1].residuals)

    def rough(assignment: PartAssignment, part_parameters: int) -> float:
        parameters = (part_parameters + 1) * len(assignment.shapes)
        return _criterion(assignment.residuals, parameters, samples, options)

    limit = _criterion(single.residuals, single.parameters, samples, options)
    hopeful = [one for one in assignments if rough(one, MIN_PART_PARAMETERS) < limit]
    best = min((rough(one, ROUGH_PARAMETERS) for one in hopeful), default=0.0)
    return [one for one in hopeful if rough(one, ROUGH_PARAMETERS) <= best + PRUNE_MARGIN]


def _is_worth_splitting(
    assignment: PartAssignment, index: int, cloud: PartCloud, options: FitOptions
) -> bool:
    """Return whether a further solid in one part could pay for its parameters.

    It cannot if the points are explained, or if they would still be as far from any surface as
    they are from the planes through their neighbours.
    """
    residuals = assignment.residuals
    if 2.0 * robust_cost(residuals, options) < (EXPLAINED_NOISE * options.noise) ** 2:
        return False
    ideal = np.where(assignment.labels == index, cloud.roughness, residuals)
    gain = MAX_SAMPLES * (log_square(residuals, options) - log_square(ideal, options))
    return gain > REQUIRED_PARAMETERS * np.log(MAX_SAMPLES) + MARGIN


def _fit_parts(
    assignment: PartAssignment, cloud: PartCloud, options: FitOptions, fit_one: FitOne
) -> _Model | None:
    """Fit every part with all steps; return None if one of them has no solid."""
    gaps = [distances(cloud.points, shape) for shape in assignment.shapes]
    model = _fit_labels(nearest_parts(gaps, cloud), len(gaps), cloud, options, fit_one)
    if model is None:
        return None
    # A part that contains points of another part must end at these points: assign them to it.
    gaps = [solid.distance(cloud.points) for solid in model.solids]
    buried = buried_points(gaps, options)
    if np.mean(buried) < BURIED_SHARE:
        return model
    labels = np.where(buried, np.argmin(gaps, axis=0), nearest_parts(gaps, cloud))
    again = _fit_labels(labels, len(gaps), cloud, options, fit_one)
    if again is None:
        return model
    return min(model, again, key=lambda one: log_square(one.residuals, options))


def _fit_labels(
    labels: NDArray[np.int64], parts: int, cloud: PartCloud, options: FitOptions, fit_one: FitOne
) -> _Model | None:
    if np.bincount(labels, minlength=parts).min() < MIN_PART_POINTS:
        return None
    solid_fits: list[tuple[Superquadric, SuperquadricFit | None]] = []
    for index in range(parts):
        part = cloud.part(labels, index, options)
        fit = fit_one(part, options)
        if fit.superquadric is not None and fit:
            solid_fits.append((fit.superquadric, fit))
            continue
        box = fit_box_behind_face(part, options) if fit.superquadric is None else None
        if box is None:
            return None
        solid_fits.append((_box(box), None))
    solid_fits.sort(key=lambda pair: -pair[0].volume)
    solids = tuple(solid for solid, _ in solid_fits)
    largest = solid_fits[0][1]
    # The depth behind a single face is assumed, so such a box must not represent the object.
    if largest is None:
        return None
    residuals = np.min([solid.distance(cloud.points) for solid in solids], axis=0)
    parameters = sum(solid.parameter_count + 1 for solid in solids) - 1
    return _Model(solids, largest, residuals, parameters)


def _is_better(model: _Model, than: _Model, cloud: PartCloud, options: FitOptions) -> bool:
    if check_residuals(model.residuals, cloud.radius, options):
        return False
    origin = cloud.observation.view_origin
    if origin is not None and any(solid.contains(origin) for solid in model.solids):
        return False
    n = effective_sample_size(cloud.points, model.residuals)
    after = _criterion(model.residuals, model.parameters, n, options)
    return after + MARGIN < _criterion(than.residuals, than.parameters, n, options)


def _criterion(
    residuals: NDArray[np.float64], parameters: int, samples: float, options: FitOptions
) -> float:
    """Return the BIC as :func:`model_selection.criterion`, in m and of the points alone."""
    return samples * log_square(residuals, options) + parameters * float(np.log(samples))


def _to_result(model: _Model, cloud: PartCloud) -> SuperquadricFit:
    parts = tuple(_shifted(solid, cloud.centre) for solid in model.solids)

    def back(candidate: CandidateSolid) -> CandidateSolid:
        return replace(candidate, superquadric=_shifted(candidate.superquadric, cloud.centre))

    return replace(
        model.fit,
        superquadric=parts[0],
        residuals=model.residuals,
        candidates=tuple(back(candidate) for candidate in model.fit.candidates),
        alternatives=tuple(back(candidate) for candidate in model.fit.alternatives),
        parts=parts,
    )


def _shape(solid: Superquadric) -> ShapeParameters:
    return ShapeParameters(
        np.log(solid.semi_axes),
        np.array(solid.exponents),
        np.ascontiguousarray(solid.rotation),
        solid.centre.copy(),
        np.array(solid.taper),
    )


def _flat_shape(cloud: PartCloud) -> ShapeParameters:
    """Return an ellipsoid over the spread of the cloud."""
    _, sizes, rows = np.linalg.svd(cloud.points, full_matrices=False)
    rows[2] *= np.linalg.det(rows)
    log_axes = np.log(np.maximum(sizes, MIN_THICKNESS * sizes[0]) / np.sqrt(len(cloud.points)))
    return ShapeParameters(log_axes, np.ones(2), np.ascontiguousarray(rows.T), np.zeros(3))


def _box(shape: ShapeParameters) -> Superquadric:
    pose = RigidTransform.from_components(shape.centre, Rotation.from_matrix(shape.R))
    exponents = (float(shape.exponents[0]), float(shape.exponents[1]))
    return canonical(Superquadric(np.exp(shape.log_axes), exponents, pose, "box"))


def _shifted(solid: Superquadric, by: NDArray[np.float64]) -> Superquadric:
    return replace(solid, pose=RigidTransform.from_translation(by) * solid.pose)
