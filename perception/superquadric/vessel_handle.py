"""Add the handle of a vessel as a second part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .finish import FinishFit
from .options import FitOptions
from .part_assignment import MIN_PART_POINTS, coarse_fit, rough_part
from .part_cloud import prepare_part_cloud
from .part_cuts import largest_cluster
from .part_kinds import fit_kinds
from .parts import part_criterion
from .problem import Observation
from .result import SuperquadricFit

HANDLE_GAP = 0.005
"""Minimum distance of the points of a handle from the outer solid, m. Lips and feet lie nearer."""


def add_handle(
    fit: SuperquadricFit, observation: Observation, options: FitOptions, finish: FinishFit
) -> SuperquadricFit:
    """Fit a second solid to what projects from a vessel; return `fit` if it does not pay.

    Parameters
    ----------
    fit
        The fit of the vessel.
    observation
        The observation with a lid on the opening.
    options
        The options of that fit.
    finish
        Function that refines the selected model of the handle.
    """
    if fit.superquadric is None:
        return fit
    cloud = prepare_part_cloud(observation, options)
    body = rough_part(cloud.scaled(fit.superquadric), cloud)
    projects = largest_cluster(body.gaps * cloud.problem.unit > HANDLE_GAP, cloud.neighbours)
    if np.count_nonzero(projects) < MIN_PART_POINTS:
        return fit
    models = fit_kinds(coarse_fit(projects, cloud, options).shape, projects, cloud, options)
    handle = finish(models, cloud.part_problem(projects, options.points), options).superquadric
    if handle is None:
        return fit
    gaps = np.minimum(body.gaps, rough_part(cloud.scaled(handle), cloud).gaps)
    before = part_criterion(cloud.square_error(body.gaps, None), 0, cloud)
    after = part_criterion(cloud.square_error(gaps, None), handle.parameter_count, cloud)
    return fit if after >= before else replace(fit, parts=(*fit.parts, handle))
