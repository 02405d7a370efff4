"""How sure each number of a fitted solid is, and which of its sides nobody saw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .cost_kernels import normal_equations
from .kinds import basis
from .levenberg_marquardt import add_prior
from .radial_batch_kernels import STRAIGHT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess
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
"""Order of the covariance: semi-axes, m; exponents; rotation about the solid's own axes, rad;
centre in the cloud's frame, m; taper."""
SIDES = ("+x", "-x", "+y", "-y", "+z", "-z")
OPEN_SHARE = 0.1
"""A side is open when its standard deviation is above this share of the semi-axis ..."""
OPEN_NOISE = 2.0
"""... and above so many times the expected noise."""

_RIDGE = 1e-12


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Uncertainty:
    """First-order uncertainty of a fitted solid (inverse of the Gauss-Newton Hessian)."""

    covariance: NDArray[np.float64]
    """(13, 13) in the order of PARAMETERS; rows of numbers that the kind holds are 0."""
    unobserved: tuple[str, ...]
    """Sides of the solid, of +x -x +y -y +z -z, whose place the view leaves open."""

    @property
    def standard_deviations(self) -> NDArray[np.float64]:
        """Square roots of the covariance's diagonal, (13,)."""
        return np.sqrt(np.diag(self.covariance))


def uncertainty(
    guess: Guess, kind: Kind, solid: Superquadric, problem: FitProblem, options: FitOptions
) -> Uncertainty:
    """Take the covariance at an optimum, in the axes of its canonical form.

    Residuals count as the problem's independent readings of the spread that they show, at least
    half the expected noise.
    """
    columns = basis(kind)
    tapered = bool(columns[STRAIGHT:].any())
    cost, gradient, hessian = normal_equations(
        *problem.data(), *guess, tapered, *problem.weighting()
    )
    # What keeps unseen sides near is a belief, not a sight of them.
    seen = problem.prior.copy()
    seen[3] = 0.0
    add_prior(seen, guess.axes, guess.eps, guess.taper, gradient, hessian)
    reduced = columns.T @ hessian @ columns
    reduced += _RIDGE * np.trace(reduced) * np.eye(len(reduced))
    square = max(2.0 * float(cost), (0.5 * options.noise / problem.unit) ** 2)
    scaled = columns @ np.linalg.inv(reduced) @ columns.T * square / problem.readings
    to_metres = np.ones(13)
    to_metres[:3] = np.exp(guess.axes) * problem.unit
    to_metres[8:11] = problem.unit
    in_own_axes = to_metres[:, None] * scaled * to_metres
    turned = _in_canonical_axes(in_own_axes, guess.R, solid)
    sides = _side_deviations(turned)
    limit = np.maximum(OPEN_SHARE * np.repeat(solid.semi_axes, 2), OPEN_NOISE * options.noise)
    unobserved = tuple(
        side for side, sd, most in zip(SIDES, sides, limit, strict=True) if sd > most
    )
    turn = np.eye(13)
    turn[8:11, 8:11] = solid.rotation
    covariance = turn @ turned @ turn.T
    return Uncertainty(0.5 * (covariance + covariance.T), unobserved)


def _in_canonical_axes(
    covariance: NDArray[np.float64], R: NDArray[np.float64], solid: Superquadric
) -> NDArray[np.float64]:
    """Covariance by the canonical form's axes, which permute and flip the optimiser's.

    A round solid's canonical axes are no permutation: its semi-axes are equal there, and
    rotation and centre turn.
    """
    between = solid.rotation.T @ R
    order = np.argmax(np.abs(between), axis=1)
    turn = np.eye(13)
    if len(set(order.tolist())) == 3:
        turn[:3, :3] = np.eye(3)[order]
    turn[5:8, 5:8] = between
    turn[8:11, 8:11] = between
    # The first two exponents and tapers belong to z and to x and y, which keep their meaning;
    # x and y may change places.
    if order[0] == 1:
        turn[11:, 11:] = np.array([[0.0, 1.0], [1.0, 0.0]])
    if between[2, 2] < 0:
        turn[11:, 11:] *= -1.0
    return turn @ covariance @ turn.T


def _side_deviations(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviations (6,) of the places of the sides in the order of SIDES, m."""
    deviations = []
    for axis in range(3):
        own, place = covariance[axis, axis], covariance[8 + axis, 8 + axis]
        both = covariance[axis, 8 + axis]
        deviations += [own + place + 2 * both, own + place - 2 * both]
    return np.sqrt(np.maximum(deviations, 0.0))
