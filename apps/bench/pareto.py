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


def simplest_front(
    costs: Sequence[float], gains: Sequence[float], same_cost: float, same_gain: float = 0.0
) -> list[int]:
    """Find the front when costs and gains are only roughly known, and points come simplest first.

    A point is passed over when a simpler one gains at most `same_gain` less and costs at most
    `same_cost` times as much; of the front of the others, steps that gain less than `same_gain`
    are left out. What only chance made better gives way.

    Parameters
    ----------
    costs, gains
        One of each per point, the simplest point first; costs > 0.
    same_cost
        Factor by which equal costs differ when measured twice, >= 1.
    same_gain
        Difference of gains that says nothing, >= 0, unit of the gains. With 1 and 0 the front is
        the exact one.

    Returns
    -------
    list of int
        Indices by rising cost, and with it strictly rising gain.

    Raises
    ------
    InputError
        If the lengths differ, a value is not finite, a cost is not positive, the factor is below
        1 or the difference below 0.
    """
    if len(costs) != len(gains):
        raise InputError(f"costs and gains must pair up, got {len(costs)} and {len(gains)}")
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


def thin_front(gains: Sequence[float], front: Sequence[int], least: float) -> list[int]:
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
