"""Planes with a known normal, such as the boards of a shelf, from a histogram of heights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .frame_noise import NoiseProfile
from .local_planes import LocalPlanes, fit_centred_windows, row_normals
from .median import median
from .result import SupportPlane
from .working_image import WorkingImage

WIDTH = 160
"""Columns of the reduced image whose readings are counted."""
RADIUS = 2
"""Half side of the windows in that image, px. A board seen at a grazing angle is a few px high."""
MIN_WINDOW_SHARE = 0.5
"""Minimum share of a window's pixels with readings."""
RESIDUAL_SIGMAS = 2.5
"""Maximum residual of a window, in σ. A larger one is a curved surface or an edge."""
MIN_COSINE = 0.94
"""Minimum cosine between the normals of a window and of a plane."""
BIN = 0.003
"""Width of the histogram's bins, m."""
MAX_SPAN = 10.0
"""Maximum range of the heights that are counted, m, from the one nearest to the camera."""
MIN_VISIBLE = 0.002
"""Minimum area of the counted readings of a plane, m². Windows across its border do not count. With
0.004 boards of shelves among objects are missed."""
SEPARATION = 0.02
"""Minimum distance between two planes, m."""
MIN_SLANT = 0.02
"""Minimum cosine between a viewing ray and the normal. At a lower one a reading says nothing."""
MAX_PLANES = 8
"""Maximum number of planes."""
MAX_MEASURED = 600
"""Maximum number of readings that are returned with a plane. More take longer."""
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


class FlatReadings(NamedTuple):
    """Readings of a reduced image on flat surfaces."""

    points: NDArray[np.float64]
    """(N, 3), m, camera frame."""
    normals: NDArray[np.float32]
    """Unit normals of their windows towards the camera, (N, 3)."""
    pixel_area: float
    """Area of a pixel on a plane across the viewing ray at 1 m, m²."""


def flat_readings(image: WorkingImage, noise: NoiseProfile) -> FlatReadings:
    """Return the readings of the reduced image whose windows show a plane within the noise."""
    stride = max(image.intrinsics.width // WIDTH, 1)
    k = image.intrinsics.reduced(stride)
    disparity = np.ascontiguousarray(image.disparity[::stride, ::stride])
    planes = LocalPlanes(*fit_centred_windows(disparity, RADIUS, MIN_WINDOW_SHARE))
    depth = np.ascontiguousarray(image.depth[::stride, ::stride])
    pinhole = (k.fx, k.fy, k.cx, k.cy)
    limits = noise.disparities, RESIDUAL_SIGMAS * noise.sigmas
    if len(limits[0]) == 1:
        limits = np.tile(limits[0], 2), np.tile(limits[1], 2)
    points, normals = select_flat(depth, planes, pinhole, limits)
    return FlatReadings(points, normals, 1.0 / (k.fx * k.fy))


def parallel_planes(
    readings: FlatReadings, normal: NDArray[np.float64]
) -> list[tuple[SupportPlane, NDArray[np.float64]]]:
    """Return the planes with a given unit normal (3,) and their readings, largest area first.

    The readings whose windows have this normal are counted by their height along it. A reading
    counts with the area that its pixel spans. So a board has the same weight from every view, and
    the time does not depend on the number of planes. At most ``MAX_MEASURED`` readings (M, 3) are
    returned with each plane.
    """
    members, offsets, areas = facing_readings(readings, normal)
    found: list[tuple[SupportPlane, NDArray[np.float64]]] = []
    if not offsets.size:
        return found
    low = float(offsets.min())
    counted = offsets < low + MAX_SPAN
    bins = ((offsets[counted] - low) / BIN).astype(np.intp)
    blurred = np.convolve(np.bincount(bins, weights=areas[counted]), np.ones(3), "same")
    reach = round(SEPARATION / BIN)
    while len(found) < MAX_PLANES:
        peak = int(np.argmax(blurred))
        if blurred[peak] < MIN_VISIBLE:
            break
        near = np.flatnonzero(np.abs(offsets - (low + (peak + 0.5) * BIN)) < 3 * BIN)
        near = near[:: max(-(-len(near) // MAX_MEASURED), 1)]
        blurred[max(peak - reach, 0) : peak + reach + 1] = 0.0
        if near.size:
            offset = float(median(offsets[near]))
            scatter = MAD_TO_SIGMA * float(median(np.abs(offsets[near] - offset)))
            plane = SupportPlane(normal, offset, scatter)
            found.append((plane, readings.points[members[near]]))
    return found


@njit(cache=True, nogil=True)
def select_flat(depth, planes, pinhole, limits):
    """Return the points (N, 3) and normals (N, 3) of the pixels with a flat window.

    Parameters
    ----------
    depth
        (H, W) float32, m.
    planes
        Planes of the windows of its disparity, `LocalPlanes`.
    pinhole
        fx, fy, cx, cy.
    limits
        Ascending disparities (K,), 1/m, and the greatest residual of a flat window there, 1/m.
    """
    rows, columns = depth.shape
    fx, fy, cx, cy = pinhole
    points = np.empty((rows * columns, 3))
    normals = np.empty((rows * columns, 3), np.float32)
    disparities, residuals = limits
    largest = residuals.max()
    row = np.empty((3, columns), np.float32)
    from_centre = np.arange(columns) - cx
    count = 0
    for v in range(rows):
        row_normals(planes, v, pinhole, from_centre, row)
        for u in range(columns):
            rms = planes.rms[v, u]
            z = np.float64(depth[v, u])
            if rms < 0 or rms >= largest or z <= 0:
                continue
            q = np.float64(planes.value[v, u])
            # A search costs less than np.interp, which makes arrays of its arguments.
            k = min(max(np.searchsorted(disparities, q), 1), len(disparities) - 1)
            share = (q - disparities[k - 1]) / max(disparities[k] - disparities[k - 1], 1e-9)
            share = min(max(share, 0.0), 1.0)
            if rms >= residuals[k - 1] + share * (residuals[k] - residuals[k - 1]):
                continue
            points[count, 0], points[count, 1], points[count, 2] = (
                (u - cx) / fx * z,
                (v - cy) / fy * z,
                z,
            )
            for axis in range(3):
                normals[count, axis] = row[axis, u]
            count += 1
    return points[:count].copy(), normals[:count].copy()


@njit(cache=True, nogil=True)
def facing_readings(readings, normal):
    """Return the indices (M,) of the readings with a normal (3,), their offsets (M,) and areas."""
    points, normals = readings.points, readings.normals
    members = np.empty(len(points), np.intp)
    offsets, areas = np.empty(len(points)), np.empty(len(points))
    a, b, c = normal[0], normal[1], normal[2]
    count = 0
    for i in range(len(points)):
        if normals[i, 0] * a + normals[i, 1] * b + normals[i, 2] * c <= MIN_COSINE:
            continue
        z = points[i, 2]
        offset = -(points[i, 0] * a + points[i, 1] * b + z * c)
        slant = offset / z
        if slant <= MIN_SLANT:
            continue
        members[count], offsets[count] = i, offset
        areas[count] = readings.pixel_area * z * z / slant
        count += 1
    return members[:count], offsets[:count], areas[:count]
