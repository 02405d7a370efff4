"""Uncertainty of the parameters of a fitted solid, and the sides that the view does not show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .cost_kernels import normal_equations
from .kinds import basis
from .levenberg_marquardt import add_prior
from .options import FitOptions
from .parameters import N_PARAMETERS, N_STRAIGHT, ShapeParameters
from .problem import FitProblem
from .shape import Kind, Superquadric

PARAMETERS = (
    "a1",
    "a2",
    "a3",
    "eps1",
    "eps2",
    "rx",
    "ry",
    "rz",
    "cx",
    "cy",
    "cz",
    "k1",
    "k2",
)
"""Order of the covariance: semi-axes, m; exponents; rotation about the local axes, rad; centre in
the frame of the cloud, m; taper."""
SIDES = ("+x", "-x", "+y", "-y", "+z", "-z")
UNOBSERVED_SHARE = 0.1
"""A side is unobserved if its standard deviation exceeds this share of the semi-axis ..."""
UNOBSERVED_NOISE = 2.0
"""... and also so many times the expected noise."""

_RIDGE = 1e-12


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Uncertainty:
    """First-order uncertainty of a fitted solid (inverse of the Gauss-Newton Hessian)."""

    covariance: NDArray[np.float64]
    """(13, 13) in the order of PARAMETERS. Rows of numbers that the kind fixes are 0."""
    unobserved: tuple[str, ...]
    """Sides of the solid, of +x -x +y -y +z -z, whose position the view does not determine."""

    @property
    def standard_deviations(self) -> NDArray[np.float64]:
        """Square roots of the covariance's diagonal, (13,)."""
        return np.sqrt(np.diag(self.covariance))


def estimate_uncertainty(
    shape: ShapeParameters,
    kind: Kind,
    solid: Superquadric,
    problem: FitProblem,
    options: FitOptions,
) -> Uncertainty:
    """Estimate the covariance at an optimum, in the axes of its canonical form `solid`.

    The residuals count as the effective number of samples of the problem. Their variance is what
    they show, at least half the expected noise.
    """
    columns = basis(kind)
    tapered = bool(columns[N_STRAIGHT:].any())
    cost, gradient, hessian = normal_equations(problem.terms, shape, tapered)
    # The prior on unseen extents is no observation of them.
    prior = problem.prior._replace(ceiling_weight=np.zeros(7))
    add_prior(prior, shape, gradient, hessian)
    reduced = columns.T @ hessian @ columns
    reduced += _RIDGE * np.trace(reduced) * np.eye(len(reduced))
    square = max(2.0 * float(cost), (0.5 * options.noise / problem.unit) ** 2)
    scaled = columns @ np.linalg.inv(reduced) @ columns.T * square / problem.samples
    to_metres = np.ones(N_PARAMETERS)
    to_metres[:3] = np.exp(shape.log_axes) * problem.unit
    to_metres[8:11] = problem.unit
    local = _in_canonical_axes(to_metres[:, None] * scaled * to_metres, shape.R, solid)
    sides = _side_deviations(local)
    limit = np.maximum(
        UNOBSERVED_SHARE * np.repeat(solid.semi_axes, 2), UNOBSERVED_NOISE * options.noise
    )
    unobserved = tuple(
        side for side, sd, max_sd in zip(SIDES, sides, limit, strict=True) if sd > max_sd
    )
    turn = np.eye(N_PARAMETERS)
    turn[8:11, 8:11] = solid.rotation
    covariance = turn @ local @ turn.T
    return Uncertainty(0.5 * (covariance + covariance.T), unobserved)


def _in_canonical_axes(
    covariance: NDArray[np.float64], R: NDArray[np.float64], solid: Superquadric
) -> NDArray[np.float64]:
    """Return the covariance in canonical axes, which permute and flip those of the optimiser.

    The canonical axes of a round solid are no permutation. Its semi-axes are equal there, and
    rotation and centre are rotated.
    """
    between = solid.rotation.T @ R
    order = np.argmax(np.abs(between), axis=1)
    turn = np.eye(N_PARAMETERS)
    if len(set(order.tolist())) == 3:
        turn[:3, :3] = np.eye(3)[order]
    turn[5:8, 5:8] = between
    turn[8:11, 8:11] = between
    # z stays z, so that both exponents keep their meaning. x and y may change places.
    if order[0] == 1:
        turn[11:, 11:] = np.array([[0.0, 1.0], [1.0, 0.0]])
    if between[2, 2] < 0:
        turn[11:, 11:] *= -1.0
    return turn @ covariance @ turn.T


def _side_deviations(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return standard deviations (6,) of the positions of the sides in the order of SIDES, m."""
    deviations = []
    for axis in range(3):
        extent, centre = covariance[axis, axis], covariance[8 + axis, 8 + axis]
        both = covariance[axis, 8 + axis]
        deviations += [extent + centre + 2 * both, extent + centre - 2 * both]
    return np.sqrt(np.maximum(deviations, 0.0))
