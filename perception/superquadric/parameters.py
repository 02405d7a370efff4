"""Parameters of a superquadric and terms of the fit's cost, as the compiled kernels take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

N_PARAMETERS = 13
"""Length of a full parameter step: log a1, log a2, log a3, ε1, ε2, rotation vector (3),
translation (3), taper k1, k2. Rotation and translation are in the axes of the solid:
R ← R exp(δ), c ← c + R τ."""
N_STRAIGHT = 11
"""Parameters of a solid without taper."""


class ShapeParameters(NamedTuple):
    """Parameters of one superquadric in the scaled frame of a :class:`~.problem.FitProblem`."""

    log_axes: NDArray[np.float64]
    """Logarithms of the semi-axes, (3,)."""
    exponents: NDArray[np.float64]
    """ε1 and ε2, (2,)."""
    R: NDArray[np.float64]
    """Local axes as columns, (3, 3)."""
    centre: NDArray[np.float64]
    """Centre, (3,)."""
    taper: NDArray[np.float64] = np.zeros(2)
    """Taper along x and y, (2,)."""


class CostTerms(NamedTuple):
    """Measurements and weights of the cost, in the scaled frame."""

    points: NDArray[np.float64]
    """(N, 3) points."""
    point_weights: NDArray[np.float64]
    """(N,) weights that sum to 1."""
    rays: NDArray[np.float64]
    """(K, 3) unit directions of rays from `view_origin` that must miss the solid; K may be 0."""
    view_origin: NDArray[np.float64]
    """(3,) origin of the rays."""
    plane: NDArray[np.float64]
    """(4,) unit normal and offset of the support plane; used if `plane_weight` > 0."""
    cauchy_scale: float
    """Scale of the Cauchy loss of the point residuals."""
    ray_weight: float
    """Weight of the rays against the mean squared point residual."""
    ray_pull: float
    """Share of `ray_weight` with which rays attract a solid that they miss."""
    plane_weight: float
    """Weight of the contact with the plane against the mean squared point residual."""
    plane_scale: float
    """Scale of the Cauchy loss of the gap between solid and plane."""
    outline: NDArray[np.float64] = np.zeros((0, 4))
    """(J, 4) inward unit normals and offsets of planes that the solid must touch from inside: each
    contains `view_origin` and touches the outline, or touches a whole cloud. J may be 0."""
    outline_weight: float = 0.0
    """Weight of these planes against the mean squared point residual."""


class Prior(NamedTuple):
    """Gaussian priors of log semi-axes (3), exponents (2) and taper (2), each array (7,)."""

    mean: NDArray[np.float64]
    weight: NDArray[np.float64]
    ceiling: NDArray[np.float64]
    """Values above which `ceiling_weight` adds a second, one-sided prior."""
    ceiling_weight: NDArray[np.float64]
    similar_weight: float = 0.0
    """Weight of the difference of the two smaller log semi-axes: unseen depth is about the width
    seen."""
