"""The compiled path search: two trees that grow towards each other, and shortcuts of a path.

RRT-Connect of Kuffner and LaValle (2000): each iteration extends one tree towards a random
configuration, and then the other tree to the new node as far as it can. The path is then shortened
by straight edges between random points on it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .configuration_space import edge_cost

STEP = 0.35
"""Maximum joint distance of a new node from its parent, rad or m, as a weighted norm."""


@njit(cache=True, nogil=True)
def connect(limits, space, motion, iterations, rng):
    """Return a path (N, n) from the start to one of the goals, both in ``motion.ends``.

    Parameters
    ----------
    limits
        (n, 2): range of each joint in which configurations are drawn.
    space, motion
        See :mod:`configuration_space`.
    iterations
        Maximum number of iterations.
    rng
        A ``numpy.random.Generator``.

    Returns
    -------
    The path, with no rows if none was found, and the number of nodes.
    """
    n = len(limits)
    goals = len(motion.ends) - 1
    size = 64 * iterations + goals + 1
    nodes, parents = np.empty((2, size, n)), np.full((2, size), -1)
    counts = np.array([1, goals])
    nodes[0, 0] = motion.ends[0]
    nodes[1, :goals] = motion.ends[1:]
    target, new = np.empty(n), np.empty(n)
    for iteration in range(iterations):
        grown = iteration % 2
        other = 1 - grown
        for joint in range(n):
            low, high = limits[joint, 0], limits[joint, 1]
            target[joint] = low + (high - low) * rng.random()
        near = _nearest(nodes[grown, : counts[grown]], target, motion.levers)
        _towards(nodes[grown, near], target, motion.levers, new)
        if not edge_cost(nodes[grown, near], new, space, motion) < np.inf:
            continue
        nodes[grown, counts[grown]] = new
        parents[grown, counts[grown]] = near
        counts[grown] += 1
        near = _nearest(nodes[other, : counts[other]], new, motion.levers)
        target[:] = new
        while counts[other] < size:
            arrived = _towards(nodes[other, near], target, motion.levers, new)
            if not edge_cost(nodes[other, near], new, space, motion) < np.inf:
                break
            nodes[other, counts[other]] = new
            parents[other, counts[other]] = near
            near = counts[other]
            counts[other] += 1
            if arrived:
                ends = np.array([counts[0] - 1, counts[1] - 1])
                return _joined(nodes, parents, ends), counts[0] + counts[1]
        if counts.max() >= size - 1:
            break
    return np.empty((0, n)), counts[0] + counts[1]


@njit(cache=True, nogil=True)
def shorten(path, space, motion, attempts, rng):
    """Return a path (M, n) with edges between random points on it, and its time, s.

    An edge replaces the part between its ends if it is faster and clear.
    """
    costs = path_costs(path, space, motion)
    for _ in range(attempts):
        total = costs.sum()
        one, other = total * rng.random(), total * rng.random()
        first, second = min(one, other), max(one, other)
        i, a = _point_at(path, costs, first)
        j, b = _point_at(path, costs, second)
        if i == j:
            continue
        cost = edge_cost(a, b, space, motion)
        if cost > 0.98 * (second - first):
            continue
        shorter = np.empty((i + 1 + 2 + len(path) - 1 - j, path.shape[1]))
        shorter[: i + 1] = path[: i + 1]
        shorter[i + 1], shorter[i + 2] = a, b
        shorter[i + 3 :] = path[j + 1 :]
        renewed = path_costs(shorter, space, motion)
        if renewed.sum() < total:
            path, costs = shorter, renewed
    return path, costs.sum()


@njit(cache=True, nogil=True)
def path_costs(path, space, motion):
    """Return the time of each edge of a path (N, n), (N - 1,), s."""
    costs = np.empty(len(path) - 1)
    for edge in range(len(path) - 1):
        costs[edge] = edge_cost(path[edge], path[edge + 1], space, motion)
    return costs


@njit(cache=True, nogil=True)
def _point_at(path, costs, time):
    """Return the edge at a time on the path, and the configuration (n,) there."""
    edge = 0
    while edge < len(costs) - 1 and time > costs[edge]:
        time -= costs[edge]
        edge += 1
    fraction = min(time / costs[edge], 1.0) if costs[edge] > 0.0 else 0.0
    return edge, path[edge] + fraction * (path[edge + 1] - path[edge])


@njit(cache=True, nogil=True)
def _distance(a, b, levers):
    square = 0.0
    for joint in range(len(a)):
        square += (levers[joint] * (a[joint] - b[joint])) ** 2
    return math.sqrt(square)


@njit(cache=True, nogil=True)
def _nearest(nodes, q, levers):
    best, index = np.inf, 0
    for node in range(len(nodes)):
        distance = _distance(nodes[node], q, levers)
        if distance < best:
            best, index = distance, node
    return index


@njit(cache=True, nogil=True)
def _towards(start, target, levers, new):
    """Fill the configuration at most STEP from the start; return whether it is the target."""
    distance = _distance(start, target, levers)
    fraction = min(1.0, STEP / distance) if distance > 0.0 else 1.0
    for joint in range(len(start)):
        new[joint] = start[joint] + fraction * (target[joint] - start[joint])
    return fraction == 1.0


@njit(cache=True, nogil=True)
def _joined(nodes, parents, ends):
    """Return the path from the root of the first tree to the root of the second."""
    count, n = 0, nodes.shape[2]
    for tree in range(2):
        node = ends[tree]
        while node >= 0:
            count += 1
            node = parents[tree, node]
    path = np.empty((count - 1, n))
    row, node = 0, ends[0]
    while node >= 0:
        path[row] = nodes[0, node]
        row += 1
        node = parents[0, node]
    path[:row] = path[:row][::-1].copy()
    # The last node of both trees is the same configuration.
    node = parents[1, ends[1]]
    while node >= 0:
        path[row] = nodes[1, node]
        row += 1
        node = parents[1, node]
    return path
