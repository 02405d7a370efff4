"""Relaxed motion: how far avoidance may bend a task's straight line (eq. 8-10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import ControlOptions, Relaxation
    from .task import TaskRows

LARGEST_BETA = 1.0
"""A dynamic β stops here: avoidance at full strength, even far from the goal."""


def relaxed_rate(
    task: TaskRows, gradient: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], float]:
    """Rate (m,) of a task bent by avoidance, and the β that bends it.

    rate - β J ∇H (eq. 8-9): against the cost's gradient (n,), so it leads away from obstacles.
    """
    avoidance = task.jacobian @ gradient
    beta = relaxation_weight(task.rate, avoidance, options.beta, options.epsilon)
    return task.rate - beta * avoidance, beta


def relaxation_weight(
    rate: NDArray[np.float64],
    avoidance: NDArray[np.float64],
    beta: Relaxation,
    epsilon: float,
) -> float:
    """Weight β: fixed, or the largest up to 1 with |rate| - ε >= β |avoidance| (eq. 10).

    Near the goal, where the rate falls below ε, a dynamic β is 0 and nothing holds the task off.
    """
    if not isinstance(beta, str):
        return float(beta)
    push = float(np.linalg.norm(avoidance))
    room = float(np.linalg.norm(rate)) - epsilon
    if room <= 0.0:
        return 0.0
    return LARGEST_BETA if push * LARGEST_BETA <= room else room / push
