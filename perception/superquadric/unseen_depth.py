"""Solids of other depth that explain a face seen from the front equally well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from ..perpendicular import perpendicular_pair
from .canonical import canonical
from .free_space import covered_share
from .options import FitOptions
from .problem import Observation
from .result import SHAPE_TOLERANCE, CandidateSolid, SuperquadricFit
from .shape import Kind, Superquadric

ANCHOR_SINE = 0.45
"""Sine of the camera's elevation above the support plane from which on the plane and the upper side
of the object determine its depth."""
MAX_FRONTAL_RATIO = 0.5
"""The view is frontal if the points are less deep than this share of their least width ..."""
ROUND_SEEN_SHARE = 0.35
"""... and either less deep than this share of the solid ..."""
ROUND_UNSEEN_SHARE = 0.8
"""... or the solid ends behind them within this share of their depth. The front of a round solid
spans half its depth, so that its curvature determines the other half."""
SEEN_QUANTILES = (0.02, 0.98)
"""Quantiles of the points between which depth and width are measured."""
MIN_UNSEEN_NOISE = 1.0
"""A solid that ends less than this times the noise behind its points is no deeper than seen."""
MAX_DEPTH_RATIO = 2.0
"""Depth of the deepest alternative over the largest width, where nothing else bounds it."""
MAX_COVERED = 0.02
"""Share of pixels that a deeper solid may cover of the space seen to be empty."""
HALVINGS = 5
"""Halvings of the depth of the deepest alternative: to 3 % of its range."""


def depth_alternatives(
    fit: SuperquadricFit, observation: Observation, options: FitOptions
) -> tuple[CandidateSolid, ...]:
    """Return the thinnest and the deepest solid with the same front, if the depth is unknown.

    That is so in a view on one face, and where a solid is no deeper than its visible points. The
    thinnest solid ends behind the points, the deepest where the view shows empty space. Both
    explain the points as well as the fit does.

    Parameters
    ----------
    fit
        The fit of the object.
    observation
        The data of that fit.
    options
        The options of that fit.

    Returns
    -------
    tuple
        At most two solids that differ from that of the fit; none if the view determines the depth.
    """
    solid, origin = fit.superquadric, observation.view_origin
    if solid is None or origin is None or fit.vessel is not None or not fit.candidates:
        return ()
    points = observation.cloud.points
    towards = origin - points.mean(axis=0)
    towards = towards / np.linalg.norm(towards)
    plane = observation.plane
    if plane is not None and plane[:3] @ towards > ANCHOR_SINE:
        return ()
    along = points @ towards
    seen = float(np.ptp(np.quantile(along, SEEN_QUANTILES)))
    widths = _widths(points, towards)
    behind = max(float(part.support(-towards)) for part in fit.parts) + float(along.min())
    depth = behind + float(np.ptp(along))
    is_round = seen > ROUND_SEEN_SHARE * depth and behind > ROUND_UNSEEN_SHARE * seen
    is_frontal = seen < MAX_FRONTAL_RATIO * min(widths) and not is_round
    if not is_frontal and behind > MIN_UNSEEN_NOISE * options.noise:
        return ()
    axis = int(np.argmax(np.abs(solid.rotation.T @ towards)))
    front = float(solid.support(towards))
    thin = max(front - float(along.min()), 2.0 * options.axis_range[0])
    deep = max(MAX_DEPTH_RATIO * max(widths), 2.0 * float(solid.semi_axes[axis]))
    if observation.free_space is not None:
        low, high = thin, deep
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            candidate = with_depth(solid, axis, towards, middle)
            free = covered_share([candidate], observation.free_space, 3.0 * options.noise)
            low, high = (middle, high) if free <= MAX_COVERED else (low, middle)
        deep = low
    selected = fit.candidates[0]
    fitted = 2.0 * float(solid.semi_axes[axis])
    return tuple(
        replace(selected, superquadric=with_depth(solid, axis, towards, depth))
        for depth in (thin, deep)
        if abs(depth - fitted) > SHAPE_TOLERANCE * options.noise
    )


def _widths(points: NDArray[np.float64], towards: NDArray[np.float64]) -> tuple[float, float]:
    """Return the extents of points (N, 3) across a direction, along their principal axes, m."""
    flat = points @ perpendicular_pair(towards).T
    _, axes = np.linalg.eigh(np.cov(flat.T))
    low, high = np.quantile(flat @ axes, SEEN_QUANTILES, axis=0)
    return float(high[0] - low[0]), float(high[1] - low[1])


def with_depth(
    solid: Superquadric, axis: int, towards: NDArray[np.float64], depth: float
) -> Superquadric:
    """Return the solid with another extent along a local axis and the same side towards (3,)."""
    half = 0.5 * depth
    side = float(np.sign(solid.rotation[:, axis] @ towards)) * solid.rotation[:, axis]
    semi_axes = solid.semi_axes.copy()
    semi_axes[axis] = half
    shift = (float(solid.semi_axes[axis]) - half) * side
    kind: Kind = solid.kind
    if kind == "sphere":
        kind = "ellipsoid"
    elif kind == "cylinder" and axis < 2:
        kind = "superquadric"
    pose = RigidTransform.from_translation(shift) * solid.pose
    return canonical(replace(solid, semi_axes=semi_axes, pose=pose, kind=kind))
