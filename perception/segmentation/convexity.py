"""Convexity of regions: normals that spread are convex, normals that converge are hollow."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import LabelPixels, pixels_by_label, sample_pixel
from .local_planes import LocalPlanes
from .working_image import WorkingImage

HOLLOW = -0.35
"""Maximum convexity of the inside of a vessel. A higher value takes the backs of bent sheets for
vessels, a lower one misses shallow bowls."""
SAMPLES = 128
"""Pixels that represent a region. The time grows with their square. 64 miss the inside of a bowl:
its convexity is -0.24 with them, -0.50 with 128, -0.45 with 400."""


def region_convexity(
    labels: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    pixels: LabelPixels | None = None,
) -> NDArray[np.float64]:
    """Compute the convexity of every region of an image (H, W), (n + 1,) in [-1, 1].

    1 = convex everywhere, 0 = flat, -1 = hollow everywhere. For a pair of points it is the dot
    product of their difference and the difference of their normals, divided by the product of the
    lengths. The result is the mean over all pairs, weighted by these lengths.

    `pixels` are the pixels of the regions, if the caller has them.
    """
    pixels = pixels or pixels_by_label(labels, int(labels.max(initial=0)))
    return convexities(pixels, image.disparity, planes, image.pinhole, SAMPLES)


@njit(cache=True, nogil=True)
def convexities(pixels, q, planes, pinhole, samples):
    """Compute :func:`region_convexity` from at most `samples` pixels of each region."""
    count = len(pixels.starts) - 2
    values = np.zeros(count + 1)
    points = np.empty((6, samples))
    for label in range(1, count + 1):
        picked = min(samples, pixels.starts[label + 1] - pixels.starts[label])
        n = 0
        for i in range(picked):
            if _point_and_normal(
                sample_pixel(pixels, label, i, picked), q, planes, pinhole, points[:, n]
            ):
                n += 1
        dots = lengths = 0.0
        for i in range(n):
            dot, length = _sum_spread(points, i)
            dots += dot
            lengths += length
        values[label] = dots / max(lengths, 1e-12)
    return values


@njit(cache=True, nogil=True)
def _point_and_normal(pixel, q, planes, pinhole, out):
    """Write the point and the normal of a pixel to `out` (6,); return whether it has both."""
    fx, fy, cx, cy = pinhole
    columns = q.shape[1]
    v, u = pixel // columns, pixel % columns
    if q[v, u] <= 0 or planes.value[v, u] <= 0:
        return False
    z = 1.0 / q[v, u]
    x, y = planes.slope_u[v, u] * fx, planes.slope_v[v, u] * fy
    w = planes.value[v, u] - planes.slope_u[v, u] * (u - cx) - planes.slope_v[v, u] * (v - cy)
    length = np.sqrt(x * x + y * y + w * w)
    out[0], out[1], out[2] = (u - cx) / fx * z, (v - cy) / fy * z, z
    out[3], out[4], out[5] = -x / length, -y / length, -w / length
    return True


@njit(cache=True, nogil=True, fastmath={"reassoc", "nsz"})
def _sum_spread(points, i):
    """Sum the dot products of the differences of points and normals, and their lengths' products.

    The sums are over the pairs of point `i` with all earlier ones. `points` holds points with
    normals, (6, N). The compiler may change the order of the sums, to handle several pairs at once.
    """
    x, y, z = points[0], points[1], points[2]
    a, b, c = points[3], points[4], points[5]
    dots = lengths = 0.0
    for j in range(i):
        dx, dy, dz = x[i] - x[j], y[i] - y[j], z[i] - z[j]
        da, db, dc = a[i] - a[j], b[i] - b[j], c[i] - c[j]
        dots += dx * da + dy * db + dz * dc
        lengths += np.sqrt((dx * dx + dy * dy + dz * dz) * (da * da + db * db + dc * dc))
    return dots, lengths
