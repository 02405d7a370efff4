"""Votes of edges for the orientation and the sides of a rectangle."""

from __future__ import annotations

import numpy as np
from numba import njit

from .container_walls import MIN_SIDE

LAYER = 0.01
"""Height of a layer, m: the scatter of one rim. Layers overlap by half."""
BIN = 0.008
"""Width of the bins in which edges vote for a side, m."""
PLACE = 0.015
"""Length of the places along a side, m. Edges cover a place or not."""
PEAKS = 5
"""Number of possible sides along each direction, those with the most votes first."""
MIN_COVER = 0.4
"""Share of covered places from which a side speaks for a rectangle."""
MIN_VISIBLE = 4
"""Minimum number of visible places of a side that contents hide in part."""
MAX_NEARER = 0.02
"""Distance before a place of a side from which a reading hides it, m."""
MIN_LENGTH = 0.12
"""Minimum length of the edges in a layer, m."""


@njit(cache=True, nogil=True)
def vote_turns(plan, heights, sizes, layers, turns):
    """Return the votes (layers, T) for rectangles of T orientations in overlapping layers.

    A vote is the sum of the squared lengths of the edges in each bin across both directions.
    """
    votes = np.zeros((layers, len(turns)))
    length = np.zeros(layers)
    radius = 0.0
    for i in range(len(plan)):
        radius = max(radius, np.hypot(plan[i, 0], plan[i, 1]))
        first = int(heights[i] / (LAYER / 2))
        for layer in range(max(first - 1, 0), min(first + 1, layers)):
            length[layer] += sizes[i]
    # Only the layers with long edges get votes. A table of all layers would not fit the cache.
    active = np.flatnonzero(length >= MIN_LENGTH)
    # The last entry, which is also that before the first one, is no layer.
    rows = np.full(layers + 1, -1, np.intp)
    for row in range(len(active)):
        rows[active[row]] = row
    # Each edge lies in two layers. Those without an active layer are left out.
    lower, upper = np.empty(len(plan), np.intp), np.empty(len(plan), np.intp)
    used = np.empty(len(plan), np.intp)
    count = 0
    for i in range(len(plan)):
        first = int(heights[i] / (LAYER / 2))
        if not 0 <= first <= layers:
            continue
        lower[count], upper[count] = rows[first - 1], rows[first]
        if lower[count] >= 0 or upper[count] >= 0:
            used[count] = i
            count += 1
    x, y, length = plan[used[:count], 0], plan[used[:count], 1], sizes[used[:count]]
    lengths = np.empty((len(active), int(2 * radius / BIN) + 3))
    for t in range(len(turns)):
        cos, sin = np.cos(turns[t]), np.sin(turns[t])
        for axis in range(2):
            along, across = (cos, sin) if axis == 0 else (-sin, cos)
            lengths[:] = 0.0
            for i in range(count):
                cell = int((along * x[i] + across * y[i] + radius) / BIN) + 1
                if lower[i] >= 0:
                    lengths[lower[i], cell] += length[i]
                if upper[i] >= 0:
                    lengths[upper[i], cell] += length[i]
            for row in range(len(active)):
                bins, vote = lengths[row], votes[active[row], t]
                for cell in range(1, len(bins)):
                    vote += (bins[cell - 1] + bins[cell]) ** 2
                votes[active[row], t] = vote
    return votes


@njit(cache=True, nogil=True)
def cover_places(across, along, sides):
    """Count the covered places before each place along each side, (K, places + 1)."""
    places = int(along.max() / PLACE) + 1
    counts = np.zeros((len(sides), places + 1), np.int32)
    for k in range(len(sides)):
        for i in range(len(across)):
            if abs(across[i] - sides[k]) < 1.5 * BIN:
                counts[k, int(along[i] / PLACE) + 1] = 1
        for place in range(places):
            counts[k, place + 1] += counts[k, place]
    return counts


@njit(cache=True, nogil=True)
def side_peaks(values, sizes):
    """Return the coordinates (K,) at which the most edges lie, m, in rising order."""
    low = values.min() - BIN
    lengths = np.zeros(int((values.max() - low) / BIN) + 2)
    for i in range(len(values)):
        lengths[int((values[i] - low) / BIN)] += sizes[i]
    for cell in range(len(lengths) - 1, 0, -1):
        lengths[cell] += lengths[cell - 1]
    found = np.empty(PEAKS)
    count = 0
    for _ in range(PEAKS):
        peak = int(lengths.argmax())
        if lengths[peak] <= 0:
            break
        total = weight = 0.0
        for i in range(len(values)):
            if 0 <= peak - int((values[i] - low) / BIN) <= 1:
                total += sizes[i] * values[i]
                weight += sizes[i]
        if weight > 0:
            found[count] = total / weight
            count += 1
        lengths[max(peak - 2, 0) : peak + 3] = 0.0
    return np.sort(found[:count])


@njit(cache=True, nogil=True)
def search_rectangle(xs, ys, covered, seen, lows):
    """Return the best bounds (x0, x1, y0, y1), its evidence, m, and its covers.

    `covered` and `seen` hold the counts across x and across y; those of `seen` are of the places
    within the image, and of the visible ones among them, (K, places + 1, 2). Places outside the
    image do not count. The first cover is that of all places or that of the places in the quarters
    at the corners, whichever is less. The second one is the least of the four sides, of the
    visible places alone; it is 0 if a side has fewer than ``MIN_VISIBLE``.
    """
    bounds, evidence, cover, visible = (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    for i in range(len(xs)):
        for j in range(i + 1, len(xs)):
            if xs[j] - xs[i] < MIN_SIDE:
                continue
            a, b = int((xs[i] - lows[0]) / PLACE), int((xs[j] - lows[0]) / PLACE) + 1
            for m in range(len(ys)):
                for n in range(m + 1, len(ys)):
                    if ys[n] - ys[m] < MIN_SIDE:
                        continue
                    c, d = int((ys[m] - lows[1]) / PLACE), int((ys[n] - lows[1]) / PLACE) + 1
                    whole = corner = all_whole = all_corner = 0
                    least = 1.0
                    for axis, side, low, high in (
                        (0, i, c, d),
                        (0, j, c, d),
                        (1, m, a, b),
                        (1, n, a, b),
                    ):
                        quarter = (high - low) // 4
                        row, every = covered[axis][side], seen[axis][side]
                        whole += row[high] - row[low]
                        all_whole += every[high, 0] - every[low, 0]
                        shown = every[high, 1] - every[low, 1]
                        share = (row[high] - row[low]) / max(shown, 1)
                        least = min(least, share if shown >= MIN_VISIBLE else 0.0)
                        for start in (low, high - quarter):
                            corner += row[start + quarter] - row[start]
                            all_corner += every[start + quarter, 0] - every[start, 0]
                    value = PLACE * (whole - MIN_COVER * all_whole)
                    if value > evidence:
                        bounds, evidence = (xs[i], xs[j], ys[m], ys[n]), value
                        cover = min(whole / max(all_whole, 1), corner / max(all_corner, 1))
                        visible = least
    return bounds, evidence, cover, visible


@njit(cache=True, nogil=True)
def count_visible(base, along, direction, pinhole, depth):
    """Count the points within the image, and the visible ones, before each point of some lines.

    A point is visible if no reading (H, W), m, is ``MAX_NEARER`` before it. Contents that lie over
    a rim hide it. Point i of line k is ``base[k] + along[i] direction``, camera frame, m. `base` is
    (K, 3), `along` (N,). The result is (K, N + 1, 2) int32.
    """
    fx, fy, cx, cy = pinhole
    rows, columns = depth.shape
    counts = np.zeros((len(base), len(along) + 1, 2), np.int32)
    for k in range(len(base)):
        for i in range(len(along)):
            x = base[k, 0] + along[i] * direction[0]
            y = base[k, 1] + along[i] * direction[1]
            z = base[k, 2] + along[i] * direction[2]
            inside = visible = False
            if z > 0:
                u, v = fx * x / z + cx, fy * y / z + cy
                inside = 0 < u < columns and 0 < v < rows
                if inside:
                    reading = depth[int(v), int(u)]
                    visible = reading <= 0 or reading > z - MAX_NEARER
            counts[k, i + 1, 0] = counts[k, i, 0] + inside
            counts[k, i + 1, 1] = counts[k, i, 1] + visible
    return counts
