"""Add the handle of a vessel as a second part."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from .effective_samples import effective_sample_size
from .part_assignment import log_square
from .part_cloud import prepare_part_cloud
from .part_proposals import largest_cluster
from .validity import MIN_POINTS

if TYPE_CHECKING:
    from .options import FitOptions
    from .parts import FitOne
    from .problem import Observation
    from .result import SuperquadricFit

HANDLE_GAP = 0.005
"""Minimum distance of the points of a handle from the outer solid, m. Lips and feet lie nearer."""


def add_handle(
    fit: SuperquadricFit, observation: Observation, options: FitOptions, fit_one: FitOne
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
    fit_one
        Function that fits the handle.
    """
    if fit.superquadric is None:
        return fit
    cloud = prepare_part_cloud(observation, options)
    gaps = fit.superquadric.distance(cloud.points + cloud.centre)
    projects = largest_cluster(gaps > HANDLE_GAP, cloud.neighbours)
    if np.count_nonzero(projects) < MIN_POINTS:
        return fit
    handle = fit_one(cloud.part(projects.astype(np.int64), 1, options), options).superquadric
    if handle is None:
        return fit
    handle = replace(handle, pose=RigidTransform.from_translation(cloud.centre) * handle.pose)
    union = np.minimum(gaps, handle.distance(cloud.points + cloud.centre))
    samples = effective_sample_size(cloud.points, union)
    gain = log_square(gaps, options) - log_square(union, options)
    if samples * gain <= handle.parameter_count * float(np.log(samples)):
        return fit
    return replace(fit, parts=(*fit.parts, handle))
