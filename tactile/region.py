"""The contact region: the largest connected one of the touched tactels, or the one held so far."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileArray


def pack_links(array: TactileArray) -> NDArray[np.int32]:
    """Put the neighbour lists behind one another, for :func:`find_region`.

    Returns
    -------
    (N + 1 + L,) int32: where each tactel's list starts, where the last ends, then all lists.
    """
    return array.links


@njit(cache=True)
def find_region(pressures, thresholds, links, geometry, previous, hysteresis, members):
    """Fill the tactels of the contact region into the start of `members`, and count them.

    The region with most tactels wins, of equal ones that with more force. Where the centre of the
    contact before is known, all regions with at least (1 - `hysteresis`) times the most tactels
    are in the running, and the one nearest to it wins: two contacts that take turns in being the
    larger one do not make the hand jump between them.

    Parameters
    ----------
    pressures, thresholds
        (N,) each, Pa; a tactel above its threshold is touched.
    links
        As :func:`pack_links` gives them.
    geometry
        (N, >= 7): position x, y, z, m, three columns of no concern, and area, m².
    previous
        (3,), m, centre of the contact before; NaN where there was none.
    hysteresis
        Share of tactels, 0..1.
    members
        (N,) int32, to be filled.
    """
    count = len(pressures)
    queue = np.empty(count, np.int32)
    seen = np.zeros(count, np.bool_)
    starts = np.empty(count + 1, np.int32)
    sums = np.empty((count, 4))
    regions, end, most = 0, 0, 0
    for seed in range(count):
        if seen[seed] or not pressures[seed] > thresholds[seed]:
            continue
        starts[regions] = end
        force, x, y, z = 0.0, 0.0, 0.0, 0.0
        queue[end] = seed
        seen[seed] = True
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
                if not seen[other] and pressures[other] > thresholds[other]:
                    seen[other] = True
                    queue[end] = other
                    end += 1
        # Forces so small that they vanish say nothing of a place; inf loses against any other.
        sums[regions, 0] = force
        sums[regions, 1] = x / force if force > 0.0 else np.inf
        sums[regions, 2] = y / force if force > 0.0 else np.inf
        sums[regions, 3] = z / force if force > 0.0 else np.inf
        most = max(most, end - starts[regions])
        regions += 1
    starts[regions] = end
    if regions == 0:
        return 0
    chosen = _choose(starts, sums, regions, most, previous, hysteresis)
    size = starts[chosen + 1] - starts[chosen]
    for k in range(size):
        members[k] = queue[starts[chosen] + k]
    return size


@njit(cache=True)
def _choose(starts, sums, regions, most, previous, hysteresis):
    """Region that is nearest to the previous centre, or the largest where there was none."""
    held = previous[0] == previous[0]
    least = (1.0 - hysteresis) * most if held else most
    best, chosen = -np.inf, 0
    for region in range(regions):
        if starts[region + 1] - starts[region] < least:
            continue
        if held:
            worth = 0.0
            for axis in range(3):
                worth -= (sums[region, 1 + axis] - previous[axis]) ** 2
        else:
            worth = sums[region, 0]
        if worth > best:
            best, chosen = worth, region
    return chosen
