"""Compute the Pareto front of a cost against a gain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from eyehand.errors import InputError


def pareto_front(costs: Sequence[float], gains: Sequence[float]) -> list[int]:
    """Return the points that no other point dominates.

    A point is dominated when another one costs no more, gains no less, and is better in one of the
    two. Of equal points the first is kept.

    Parameters
    ----------
    costs, gains
        Cost and gain of each point, finite, any unit.

    Returns
    -------
    list of int
        Indices of the front by rising cost; the gain rises strictly. Empty only without points.

    Raises
    ------
    InputError
        If the lengths differ or a value is not finite.
    """
    cost, gain = np.asarray(costs, dtype=np.float64), np.asarray(gains, dtype=np.float64)
    if cost.shape != gain.shape or cost.ndim != 1:
        raise InputError(
            f"costs and gains must have the same length, got {len(costs)} and {len(gains)}"
        )
    if not (np.isfinite(cost).all() and np.isfinite(gain).all()):
        raise InputError("costs and gains must be finite")
    front: list[int] = []
    best = -np.inf
    # The sort is stable, so the first of equal points stays first. The best gain of a cost leads.
    for index in np.lexsort((-gain, cost)):
        if gain[index] > best:
            best = gain[index]
            front.append(int(index))
    return front


def simplest_front(
    costs: Sequence[float], gains: Sequence[float], same_cost: float, same_gain: float = 0.0
) -> list[int]:
    """Return the front of noisy measurements, with a preference for simple points.

    A point is dropped when a simpler one gains at most `same_gain` less and costs at most
    `same_cost` times as much. From the front of the remaining points, steps that gain less than
    `same_gain` are dropped. Such differences may be noise.

    Parameters
    ----------
    costs, gains
        Cost and gain of each point, the simplest point first; costs > 0.
    same_cost
        Largest ratio of two measurements of the same cost, >= 1.
    same_gain
        Largest difference of gains that is noise, >= 0, unit of the gains. With same_cost=1 and
        same_gain=0 the front is exact.

    Returns
    -------
    list of int
        Indices by rising cost; the gain rises strictly.

    Raises
    ------
    InputError
        If the lengths differ, a value is not finite, a cost is not positive, the factor is below
        1 or the difference below 0.
    """
    if len(costs) != len(gains):
        raise InputError(
            f"costs and gains must have the same length, got {len(costs)} and {len(gains)}"
        )
    if not 1 <= same_cost < np.inf:
        raise InputError(f"same_cost must be a finite factor >= 1, got {same_cost}")
    if not 0 <= same_gain < np.inf:
        raise InputError(f"same_gain must be a finite difference >= 0, got {same_gain}")
    kept: list[int] = []
    for point, (cost, gain) in enumerate(zip(costs, gains, strict=True)):
        if not cost > 0:
            raise InputError(f"costs must be > 0, got {cost}")
        if not any(
            gains[other] >= gain - same_gain and costs[other] <= same_cost * cost for other in kept
        ):
            kept.append(point)
    front = pareto_front([costs[point] for point in kept], [gains[point] for point in kept])
    return thin_front(gains, [kept[index] for index in front], same_gain)


def thin_front(gains: Sequence[float], front: Sequence[int], min_step: float) -> list[int]:
    """Keep the points of a front that gain at least `min_step` over the point kept before.

    The cheapest point stays. A smaller step may be measurement noise and does not justify a higher
    cost.

    Parameters
    ----------
    gains
        Gain of every point.
    front
        Indices from :func:`pareto_front`.
    min_step
        Smallest gain that justifies a higher cost, >= 0, unit of the gains.
    """
    kept: list[int] = []
    for index in front:
        if not kept or gains[index] - gains[kept[-1]] >= min_step:
            kept.append(index)
    return kept
