"""Where springs leave a hand's joints when its tendons are pulled in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import nnls

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LEAST_STIFFNESS = 1e-3
"""Stands for the spring of a joint that has none, Nm/rad: its posture would be undetermined."""
_FEASIBLE = 1e-9
"""Least distance of the bounds from the origin that tells them from bounds that cannot be kept."""


def tendon_posture(
    moments: NDArray[np.float64],
    excursions: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    rest: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Give the joint angles of least spring energy that the tendons allow.

    A tendon keeps its joints at least as far closed as it is pulled in; others may close them
    farther and leave it slack. What is pulled in farther than the joints go stays at their limits.

    Parameters
    ----------
    moments
        By how much each joint shortens each tendon, (D, J), m/rad.
    excursions
        How far each is pulled in from the posture without tension, (D,), m.
    stiffness
        Of the joints' springs, (J,), Nm/rad.
    rest
        Angles at which these are relaxed, (J,), rad.
    limits
        Lowest and highest angles, (J, 2), rad.

    Returns
    -------
    NDArray
        (J,), rad, within the limits.

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
    rates, bounds = np.vstack([moments, eye, -eye]), np.concatenate([pulled, low, -high])
    # In y = sqrt(k) (q - rest) the energy is |y|²/2, and the bounds are G y >= h.
    scale = 1.0 / np.sqrt(np.maximum(stiffness, _LEAST_STIFFNESS))
    problem = np.vstack([(rates * scale).T, bounds - rates @ rest])
    target = np.append(np.zeros(len(rest)), 1.0)
    residual = problem @ nnls(problem, target)[0] - target
    if abs(residual[-1]) < _FEASIBLE:
        return open_posture
    return np.clip(rest - scale * residual[:-1] / residual[-1], low, high)
