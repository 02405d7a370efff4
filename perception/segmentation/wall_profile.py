"""Compiled loops over the readings around a container: their plan, and the profiles of walls."""

from __future__ import annotations

import numpy as np
from numba import njit

MIN_SLANT = 0.1
"""Minimum cosine between the viewing ray and the normal that is used for areas."""


@njit(cache=True, nogil=True)
def read_window(depth, rays, axes, offset, pixel_area):
    """Return the plan coordinates, heights, areas and flat pixels of the readings of an image.

    Parameters
    ----------
    depth
        (H, W) float32, m; 0 = no reading.
    rays
        Horizontal (W,) and vertical (H,) components of the viewing rays with z = 1.
    axes
        Rows (3, 3): the normal of a plane, and the two axes of the plan.
    offset
        Offset of the plane, m.
    pixel_area
        Area of a pixel on a plane across the viewing ray at 1 m, m².

    Returns
    -------
    tuple
        (N, 2) m, (N,) m, (N,) m², (N,).
    """
    rows, columns = depth.shape
    rays_u, rays_v = rays
    plan, heights = np.empty((rows * columns, 2)), np.empty(rows * columns)
    areas, pixels = np.empty(rows * columns), np.empty(rows * columns, np.intp)
    count = 0
    for v in range(rows):
        for u in range(columns):
            z = np.float64(depth[v, u])
            if z <= 0:
                continue
            slope = axes[0, 0] * rays_u[u] + axes[0, 1] * rays_v[v] + axes[0, 2]
            x, y = rays_u[u] * z, rays_v[v] * z
            for k in range(2):
                plan[count, k] = x * axes[k + 1, 0] + y * axes[k + 1, 1] + z * axes[k + 1, 2]
            heights[count] = x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2] + offset
            areas[count] = pixel_area * z * z / max(-slope, MIN_SLANT)
            pixels[count] = v * columns + u
            count += 1
    return plan[:count], heights[:count], areas[:count], pixels[:count]


@njit(cache=True, nogil=True)
def inside_polygon(plan, corners, margin):
    """Return which points (N, 2) lie farther than `margin` inside a convex polygon (K, 2).

    The corners are in counterclockwise order.
    """
    count = len(corners)
    normals, offsets = np.empty((count, 2)), np.empty(count)
    for k in range(count):
        x, y = corners[(k + 1) % count] - corners[k]
        length = max(np.sqrt(x * x + y * y), 1e-9)
        normals[k, 0], normals[k, 1] = -y / length, x / length
        offsets[k] = normals[k, 0] * corners[k, 0] + normals[k, 1] * corners[k, 1] + margin
    inside = np.ones(len(plan), np.bool_)
    for i in range(len(plan)):
        for k in range(count):
            if plan[i, 0] * normals[k, 0] + plan[i, 1] * normals[k, 1] <= offsets[k]:
                inside[i] = False
                break
    return inside


@njit(cache=True, nogil=True)
def read_strip(plan, heights, side, levels, strip):
    """Return the readings beside one side of a polygon, and their greatest heights.

    Parameters
    ----------
    plan, heights
        Readings (N, 2) and (N,), m.
    side
        Its start (2,), m, its unit direction (2,), and its length, m.
    levels
        The readings are higher than the first one, and at most as high as the second one, m.
    strip
        Length left out at both ends; reach on both sides; length of a place; and of a cell, m.

    Returns
    -------
    tuple
        (M, 3): the distances along the side and outwards from it, and the heights, m. (M,): the
        places. (places, cells): the greatest heights, m; -inf = no reading.
    """
    start, along, length = side
    corner, reach, place_length, cell_length = strip
    count = int((length - 2 * corner) / place_length)
    cells = int(2 * reach / cell_length) + 1
    profile = np.full((count, cells), -np.inf)
    readings, places = np.empty((len(plan), 3)), np.empty(len(plan), np.intp)
    found = 0
    for i in range(len(plan)):
        x, y = plan[i, 0] - start[0], plan[i, 1] - start[1]
        d = x * along[1] - y * along[0]
        if not (abs(d) < reach and levels[0] < heights[i] <= levels[1]):
            continue
        s = x * along[0] + y * along[1]
        if not (corner < s < length - corner):
            continue
        place = min(int((s - corner) / place_length), count - 1)
        cell = int((d + reach) / cell_length)
        profile[place, cell] = max(profile[place, cell], heights[i])
        readings[found, 0], readings[found, 1], readings[found, 2] = s, d, heights[i]
        places[found] = place
        found += 1
    return readings[:found], places[:found], profile


@njit(cache=True, nogil=True)
def outermost_run(profile, level):
    """Return the first and last + 1 cells (K,) of the outermost runs of high cells (K, M).

    A single low cell does not interrupt a run. What is high farther inside belongs to the contents.
    In a place without high cells the run is the whole profile.
    """
    count, cells = profile.shape
    inner, outer = np.empty(count, np.intp), np.empty(count, np.intp)
    for k in range(count):
        last = cells
        while last > 0 and profile[k, last - 1] < level:
            last -= 1
        outer[k] = inner[k] = last if last > 0 else cells
        for cell in range(last - 1, -1, -1):
            if inner[k] - cell > 2:
                break
            if profile[k, cell] >= level:
                inner[k] = cell
    return inner, outer


@njit(cache=True, nogil=True)
def face_distances(readings, places, edge, limits, shape):
    """Return the outermost distances of an inner face per band of height, (bands, places), m.

    Parameters
    ----------
    readings, places
        From :func:`read_strip`.
    edge
        Slope and distance, m, of the edge of the rim in these coordinates.
    limits
        The distance from the edge, and the height, below which readings belong to the face, m.
    shape
        Number of bands and places; lower and upper end of the bands, m.

    Returns
    -------
    NDArray
        The greatest distances outwards from the edge; -inf = no reading.
    """
    bands, count, floor, top = shape
    outermost = np.full((bands, count), -np.inf)
    for i in range(len(readings)):
        s, d, height = readings[i]
        across = d - edge[1] - edge[0] * s
        if across < limits[0] and height < limits[1]:
            band = min(max(int((height - floor) / max(top - floor, 1e-6) * bands), 0), bands - 1)
            outermost[band, places[i]] = max(outermost[band, places[i]], across)
    return outermost
