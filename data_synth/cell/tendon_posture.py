"""Joint angles of a spring-loaded hand at given tendon excursions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import nnls

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MIN_STIFFNESS = 1e-3
"""Spring of a joint without one, Nm/rad: otherwise its angle would be undetermined."""
_MIN_RESIDUAL = 1e-9
"""Residual of the least-squares problem below which no angles satisfy all bounds."""


def tendon_posture(
    moments: NDArray[np.float64],
    excursions: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    rest: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Compute the joint angles of least spring energy that the tendons allow.

    A tendon closes its joints at least as far as its excursion. Other tendons may close them
    farther, and then it is slack. Excursions beyond the joints' range leave the joints at their
    limits.

    Parameters
    ----------
    moments
        Shortening of each tendon per joint angle, (D, J), m/rad.
    excursions
        Excursion of each tendon from the posture without tension, (D,), m.
    stiffness
        Stiffness of the joints' springs, (J,), Nm/rad.
    rest
        Joint angles at which the springs are relaxed, (J,), rad.
    limits
        Smallest and largest joint angles, (J, 2), rad.

    Returns
    -------
    NDArray
        Joint angles (J,), rad, within the limits.

    Notes
    -----
    Least distance programming by non-negative least squares: Lawson and Hanson, Solving Least
    Squares Problems, 1974, chapter 23.
    """
    low, high = limits.T
    open_posture = np.clip(rest, low, high)
    reach = np.maximum(moments * low, moments * high).sum(axis=1)
    pulled = np.minimum(np.maximum(excursions, 0.0) + moments @ open_posture, reach)
    eye = np.eye(len(rest))
    gradients, bounds = np.vstack([moments, eye, -eye]), np.concatenate([pulled, low, -high])
    # In y = sqrt(k) (q - rest) the energy is |y|²/2, and the bounds are G y >= h.
    scale = 1.0 / np.sqrt(np.maximum(stiffness, _MIN_STIFFNESS))
    problem = np.vstack([(gradients * scale).T, bounds - gradients @ rest])
    target = np.append(np.zeros(len(rest)), 1.0)
    residual = problem @ nnls(problem, target)[0] - target
    if abs(residual[-1]) < _MIN_RESIDUAL:
        return open_posture
    return np.clip(rest - scale * residual[:-1] / residual[-1], low, high)
