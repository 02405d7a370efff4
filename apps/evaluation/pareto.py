"""Which settings are worth their price: the Pareto front of a cost against a gain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence


def pareto_front(costs: Sequence[float], gains: Sequence[float]) -> list[int]:
    """Find the points that no other point beats.

    A point is beaten when another one costs no more and gains no less, and is better in one of
    the two; of equal points the first counts.

    Parameters
    ----------
    costs, gains
        One of each per point, finite, any unit.

    Returns
    -------
    list of int
        Indices of the front, by rising cost and with it strictly rising gain. Empty only when
        there are no points.

    Raises
    ------
    InputError
        If the lengths differ or a value is not finite.
    """
    cost, gain = np.asarray(costs, dtype=np.float64), np.asarray(gains, dtype=np.float64)
    if cost.shape != gain.shape or cost.ndim != 1:
        raise InputError(f"costs and gains must pair up, got {len(costs)} and {len(gains)}")
    if not (np.isfinite(cost).all() and np.isfinite(gain).all()):
        raise InputError("costs and gains must be finite")
    front: list[int] = []
    best = -np.inf
    # Stable: of equal points the first one comes first. Of equal costs the best gain does.
    for index in np.lexsort((-gain, cost)):
        if gain[index] > best:
            best = gain[index]
            front.append(int(index))
    return front


def simplest_front(costs: Sequence[float], gains: Sequence[float], same_cost: float) -> list[int]:
    """Find the front when costs are only known to a factor, and points are listed simplest first.

    In place of each point of the exact front stands the first of all points that gains no less
    and costs at most `same_cost` times as much: what only chance made cheaper gives way.

    Parameters
    ----------
    costs, gains
        One of each per point, the simplest point first; costs > 0.
    same_cost
        Factor by which equal costs differ when measured twice, >= 1; 1 gives the exact front.

    Returns
    -------
    list of int
        Indices by rising cost, and with it strictly rising gain.

    Raises
    ------
    InputError
        If the lengths differ, a value is not finite, a cost is not positive, or the factor is
        below 1.
    """
    if not 1 <= same_cost < np.inf:
        raise InputError(f"same_cost must be a finite factor >= 1, got {same_cost}")
    exact = pareto_front(costs, gains)
    if any(costs[index] <= 0 for index in exact):
        raise InputError(f"costs must be > 0, got {min(costs)}")
    stand_ins = [
        next(
            index
            for index in range(len(costs))
            if gains[index] >= gains[point] and costs[index] <= same_cost * costs[point]
        )
        for point in exact
    ]
    # A stand-in may be dearer than the next point's.
    kept = pareto_front([costs[k] for k in stand_ins], [gains[k] for k in stand_ins])
    return [stand_ins[index] for index in kept]


def worthwhile(gains: Sequence[float], front: Sequence[int], least: float) -> list[int]:
    """Thin a front to the points that gain at least `least` over the cheaper point kept before.

    Differences below what a repetition would give (the noise of a measurement) are no reason to
    pay more, and no reason for a name in a chart. The cheapest point stays.

    Parameters
    ----------
    gains
        Gain of every point.
    front
        Indices as :func:`pareto_front` gives them.
    least
        Smallest gain worth a step, >= 0, unit of the gains.
    """
    kept: list[int] = []
    for index in front:
        if not kept or gains[index] - gains[kept[-1]] >= least:
            kept.append(index)
    return kept
