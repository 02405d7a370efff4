"""Split an object that no single solid explains into a few solids."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .effective_samples import MAX_SAMPLES, TRUSTED_SHARE
from .finish import describe_fit, is_finite, model_solid, refine_model
from .free_space import FreeSpace
from .model_selection import CandidateModel
from .options import FitOptions
from .part_assignment import (
    PartAssignment,
    RoughPart,
    assignment_of,
    cut_part,
    principal_box,
    reassign,
    rough_part,
    worst_part,
)
from .part_cloud import PartCloud, prepare_part_cloud
from .part_kinds import fit_kinds
from .problem import FitProblem, Observation
from .result import SuperquadricFit
from .robust import robust_square
from .shape import PARAMETER_COUNT, Superquadric
from .validity import PLANE_PARAMETERS, check_residuals

EXPLAINED_NOISE = 0.95
"""Residuals within this share of the expected noise are explained."""
CLEAR_NOISE = 1.1
"""The same for a solid that covers no empty ray. The correlated noise of a depth camera leaves up
to 1.08 on simple solids, and parts of them never paid."""
MARGIN = 10.0
"""Parts must lower the criterion by more than this: very strong evidence (Kass and Raftery 1995),
because the best of many splits gains something by chance."""
FINAL_ROUNDS = 2
"""Rounds of assignment of each number of parts that may win."""
PART_PARAMETERS = PARAMETER_COUNT["superquadric"] + 1
"""Parameters of a rough part, with one for the share of the points."""

MIN_PARAMETERS = PARAMETER_COUNT["cylinder"]
"""Parameters of the simplest part."""


class _Parts(NamedTuple):
    """Models of all parts, per part best first."""

    models: list[list[CandidateModel]]
    assignment: PartAssignment
    criterion: float


def split_into_parts(
    whole: SuperquadricFit, observation: Observation, options: FitOptions
) -> SuperquadricFit:
    """Split an object that one solid does not explain into at most ``options.max_parts`` solids.

    Rough solids are assigned to the points, one more at a time. They must follow the points and
    miss the empty rays. More parts are kept if they clearly lower the Bayesian information
    criterion.

    Parameters
    ----------
    whole
        The fit of one solid. It has no solid if a plane explains the points.
    observation
        The data of that fit.
    options
        The options of that fit.

    Returns
    -------
    SuperquadricFit
        The fit of the largest part by volume, with all parts and the residuals of their union;
        `whole` if more parts are no better.
    """
    if _is_clearly_explained(whole, observation.free_space, options):
        return whole
    cloud = prepare_part_cloud(observation, options)
    single, parameters = _single(whole, cloud)
    assignments = _assign_parts(single, cloud, options, needed=not whole)
    if not assignments:
        return whole
    # Any parts that pass the checks are better than a solid that fails them.
    limit = part_criterion(single.square, parameters, cloud) - MARGIN if whole else np.inf
    best = min(assignments, key=lambda one: _rough_criterion(one, cloud))
    if part_criterion(best.square, MIN_PARAMETERS * len(best.parts), cloud) < limit:
        parts = _select_kinds(best, cloud, options)
        if parts.criterion < limit:
            fit = _to_result(parts, cloud, options)
            if fit is not None and (whole or fit):
                return fit
    if whole:
        return whole
    counts = " or ".join(str(len(one.parts)) for one in assignments)
    return replace(whole, reason=f"{whole.reason} (no better in {counts} parts)")


def _is_clearly_explained(
    whole: SuperquadricFit, free_space: FreeSpace | None, options: FitOptions
) -> bool:
    """Return whether a solid explains the points and covers no empty ray.

    Most objects end here, without the neighbours and the rays of a :class:`PartCloud`.
    """
    if whole.superquadric is None or whole.covered_share > 0.0:
        return False
    limit = EXPLAINED_NOISE if free_space is None else CLEAR_NOISE
    return robust_square(whole.residuals, options.noise) < (limit * options.noise) ** 2


def _single(whole: SuperquadricFit, cloud: PartCloud) -> tuple[PartAssignment, int]:
    """Return the fit of one solid as an assignment, and its number of parameters."""
    labels = np.zeros(len(cloud.points), dtype=np.int64)
    if whole.superquadric is not None:
        part = rough_part(cloud.scaled(whole.superquadric), cloud)
        return assignment_of([part], labels, cloud), whole.superquadric.parameter_count
    _, _, rows = np.linalg.svd(cloud.points, full_matrices=False)
    plane = RoughPart(principal_box(cloud.points), cloud.points @ rows[2], None)
    return assignment_of([plane], labels, cloud), PLANE_PARAMETERS


def _rough_criterion(assignment: PartAssignment, cloud: PartCloud) -> float:
    return part_criterion(assignment.square, PART_PARAMETERS * len(assignment.parts), cloud)


def _is_explained(assignment: PartAssignment, cloud: PartCloud) -> bool:
    return assignment.square < (EXPLAINED_NOISE**2 + 0.25) * cloud.noise**2


def _assign_parts(
    single: PartAssignment, cloud: PartCloud, options: FitOptions, *, needed: bool
) -> list[PartAssignment]:
    """Assign the points to 2, 3, ... rough solids while points remain unexplained.

    Unless parts are `needed`, because no single solid is valid, the first cut that does not lower
    the error is the last one.
    """
    assignment = single
    assignments: list[PartAssignment] = []
    while len(assignment.parts) < options.max_parts and not _is_explained(assignment, cloud):
        cut = cut_part(assignment, worst_part(assignment, cloud), cloud, options)
        if cut is None:
            break
        assignments.append(cut)
        if not needed and cut.square >= assignment.square:
            break
        assignment = cut
    return assignments


def _select_kinds(assignment: PartAssignment, cloud: PartCloud, options: FitOptions) -> _Parts:
    """Refine the parts together, and select the kind of each."""
    assignment = reassign(assignment, FINAL_ROUNDS, cloud, options)
    models = [
        fit_kinds(part.shape, assignment.labels == index, cloud, options)
        for index, part in enumerate(assignment.parts)
    ]
    rough = [rough_part(one[0].shape, cloud) for one in models]
    final = assignment_of(rough, assignment.labels, cloud)
    parameters = sum(PARAMETER_COUNT[one[0].kind] + 1 for one in models) - 1
    return _Parts(models, final, part_criterion(final.square, parameters, cloud))


def part_criterion(square: float, parameters: int, cloud: PartCloud) -> float:
    """Return the BIC of a mean square of residuals with the expected noise.

    The number of readings depends on the number of points alone. Residuals that agree over
    neighbours show that a solid misfits, so they must not count as fewer readings.
    """
    readings = min(MAX_SAMPLES, TRUSTED_SHARE * len(cloud.points))
    return readings * square / cloud.noise**2 + parameters * float(np.log(readings))


def _to_result(parts: _Parts, cloud: PartCloud, options: FitOptions) -> SuperquadricFit | None:
    """Refine every part on all its points; return None if the parts are no valid result."""
    labels = parts.assignment.labels
    refined: list[tuple[Superquadric, list[CandidateModel], FitProblem]] = []
    for index, (best, *others) in enumerate(parts.models):
        problem = cloud.part_problem(labels == index, options.points)
        model = refine_model(best, problem, options)
        if not is_finite(model.shape):
            return None
        solid = model_solid(model, problem)
        refined.append((solid, [model, *others], problem))
    refined.sort(key=lambda part: -part[0].volume)
    solids = tuple(solid for solid, _, _ in refined)
    unit = cloud.problem.unit
    origin = cloud.problem.terms.view_origin * unit + cloud.problem.centre
    if cloud.image is not None and any(solid.contains(origin) for solid in solids):
        return None
    points = cloud.all_points * unit + cloud.problem.centre
    residuals = np.min([solid.distance(points) for solid in solids], axis=0)
    reason = check_residuals(residuals, unit, options)
    _, models, problem = refined[0]
    models = [models[0], *(model for model in models[1:] if is_finite(model.shape))]
    largest = describe_fit(models, problem, options)
    assert largest.superquadric is not None
    return replace(
        largest,
        residuals=residuals,
        converged=not reason,
        reason=reason,
        parts=(largest.superquadric, *solids[1:]),
    )
