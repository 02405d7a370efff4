"""Select the contact region: the largest connected region of touched tactels.

After a contact, the region nearest to it is selected among those of similar size.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def find_region(pressures, thresholds, links, geometry, previous, hysteresis, members):
    """Find the contact region and return its number of tactels.

    Without a contact in the last cycle, the region with the most tactels is selected. If several
    have this number, the one with the largest force is selected. With a contact in the last cycle,
    all regions with at least (1 - `hysteresis`) times the maximum number of tactels are candidates.
    The candidate nearest to that contact is selected. This avoids jumps between two contacts of
    similar size.

    Parameters
    ----------
    pressures, thresholds
        (N,) each, Pa. A tactel is touched if its pressure is above its threshold.
    links
        (N + 1 + L,) int32, neighbour lists as in `TactileArray.links`; L is their total length.
    geometry
        (N, 8), as in `TactileArray.geometry`.
    previous
        (3,), m, centre of the contact in the last cycle; NaN if there was none.
    hysteresis
        A region may be selected if it has at least (1 - hysteresis) times the tactels of the
        largest one, 0..1.
    members
        Output, (N,) int32: its first entries become the indices of the region's tactels.
    """
    count = len(pressures)
    # Tactels of all regions, one region after another. `starts` holds the first index of each.
    queue = np.empty(count, np.int32)
    visited = np.zeros(count, np.bool_)
    starts = np.empty(count + 1, np.int32)
    # Of each region: force, N, and centre of pressure, m.
    forces_and_centres = np.empty((count, 4))
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
            tactel_force = pressures[tactel] * geometry[tactel, 6]
            force += tactel_force
            x += tactel_force * geometry[tactel, 0]
            y += tactel_force * geometry[tactel, 1]
            z += tactel_force * geometry[tactel, 2]
            for link in range(links[tactel], links[tactel + 1]):
                other = links[link]
                if not visited[other] and pressures[other] > thresholds[other]:
                    visited[other] = True
                    queue[end] = other
                    end += 1
        # If the force underflows to zero, the centre is undefined. An infinite centre is never
        # the nearest one.
        forces_and_centres[regions, 0] = force
        forces_and_centres[regions, 1] = x / force if force > 0.0 else np.inf
        forces_and_centres[regions, 2] = y / force if force > 0.0 else np.inf
        forces_and_centres[regions, 3] = z / force if force > 0.0 else np.inf
        max_size = max(max_size, end - starts[regions])
        regions += 1
    starts[regions] = end
    if regions == 0:
        return 0
    selected = _select(starts, forces_and_centres, regions, max_size, previous, hysteresis)
    size = starts[selected + 1] - starts[selected]
    for k in range(size):
        members[k] = queue[starts[selected] + k]
    return size


@njit(cache=True)
def _select(starts, forces_and_centres, regions, max_size, previous, hysteresis):
    """Return the index of the region nearest to the previous contact; without one, the largest."""
    has_previous = not np.isnan(previous[0])
    min_size = (1.0 - hysteresis) * max_size if has_previous else max_size
    best_score, best = -np.inf, 0
    for region in range(regions):
        if starts[region + 1] - starts[region] < min_size:
            continue
        if has_previous:
            score = 0.0
            for axis in range(3):
                score -= (forces_and_centres[region, 1 + axis] - previous[axis]) ** 2
        else:
            score = forces_and_centres[region, 0]
        if score > best_score:
            best_score, best = score, region
    return best
