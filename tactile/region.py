"""The contact region: the largest connected region of touched tactels, with hysteresis."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def find_region(pressures, thresholds, links, geometry, previous, hysteresis, members):
    """Find the contact region and return its number of tactels.

    The region with the most tactels is selected. Of equal ones, the one with the largest force is
    selected. If there was a contact in the last cycle, all regions with at least (1 - `hysteresis`)
    times the maximum number of tactels are candidates. The candidate nearest to that contact is
    selected. This avoids jumps between two contacts of similar size.

    Parameters
    ----------
    pressures, thresholds
        (N,) each, Pa. A tactel is touched if its pressure is above its threshold.
    links
        (N + 1 + L,) int32, neighbour lists as in `TactileArray.links`.
    geometry
        (N, 8), as in `TactileArray.geometry`.
    previous
        (3,), m, centre of the contact in the last cycle; NaN if there was none.
    hysteresis
        Relative difference in the number of tactels, 0..1, below which a smaller region may be
        selected.
    members
        (N,) int32; the tactels of the region are written to its start.
    """
    count = len(pressures)
    queue = np.empty(count, np.int32)
    visited = np.zeros(count, np.bool_)
    starts = np.empty(count + 1, np.int32)
    sums = np.empty((count, 4))
    regions, end, max_size = 0, 0, 0
    for seed in range(count):
        if visited[seed] or not pressures[seed] > thresholds[seed]:
            continue
        starts[regions] = end
        force, x, y, z = 0.0, 0.0, 0.0, 0.0
        queue[end] = seed
        visited[seed] = True
        head, end = end, end + 1
        while head < end:
            tactel = queue[head]
            head += 1
            share = pressures[tactel] * geometry[tactel, 6]
            force += share
            x += share * geometry[tactel, 0]
            y += share * geometry[tactel, 1]
            z += share * geometry[tactel, 2]
            for link in range(links[tactel], links[tactel + 1]):
                other = links[link]
                if not visited[other] and pressures[other] > thresholds[other]:
                    visited[other] = True
                    queue[end] = other
                    end += 1
        # If the force underflows to zero, the centre is undefined. An infinite centre is never
        # the nearest one.
        sums[regions, 0] = force
        sums[regions, 1] = x / force if force > 0.0 else np.inf
        sums[regions, 2] = y / force if force > 0.0 else np.inf
        sums[regions, 3] = z / force if force > 0.0 else np.inf
        max_size = max(max_size, end - starts[regions])
        regions += 1
    starts[regions] = end
    if regions == 0:
        return 0
    selected = _select(starts, sums, regions, max_size, previous, hysteresis)
    size = starts[selected + 1] - starts[selected]
    for k in range(size):
        members[k] = queue[starts[selected] + k]
    return size


@njit(cache=True)
def _select(starts, sums, regions, max_size, previous, hysteresis):
    """Select the region nearest to the previous contact, or the largest without one."""
    has_previous = previous[0] == previous[0]
    min_size = (1.0 - hysteresis) * max_size if has_previous else max_size
    best_score, best = -np.inf, 0
    for region in range(regions):
        if starts[region + 1] - starts[region] < min_size:
            continue
        if has_previous:
            score = 0.0
            for axis in range(3):
                score -= (sums[region, 1 + axis] - previous[axis]) ** 2
        else:
            score = sums[region, 0]
        if score > best_score:
            best_score, best = score, region
    return best
