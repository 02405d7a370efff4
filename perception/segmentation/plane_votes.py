"""Compiled functions of the plane search: inliers of candidate planes, and fits to readings."""

from __future__ import annotations

import numpy as np
from numba import njit

REFITS = 12
"""Reweighted least-squares fits of a proposed plane, to the samples and then to all readings. Fewer
leave it near its first hypothesis, and another hypothesis gives another plane."""
MIN_SPREAD = 1e-9
"""Minimum determinant of the samples' covariance in the image, relative to that of an upright
ellipse. Samples on a line determine no plane."""
MIN_COSINE = 0.95
"""Minimum cosine between the normals of a sample and of its plane."""


@njit(cache=True, nogil=True, error_model="numpy")
def fit_tukey_plane(start, rays, q, width):
    """Fit a plane n·X = 1 in ``REFITS`` steps of reweighted least squares; return n, (3,).

    Parameters
    ----------
    start
        The plane of the first weights, (3,).
    rays
        Directions with z = 1, (N, 3).
    q
        Disparities (N,), 1/m.
    width
        Residuals (N,) at which the weight of a reading reaches 0, 1/m.

    If the readings do not determine a plane, the result is 0.
    """
    n = np.array([start[0], start[1], start[2]])
    # The compiler handles several weights at once if their loop is apart from that of the sums.
    us, vs, weights = rays[:, 0].copy(), rays[:, 1].copy(), np.empty(len(q))
    for _ in range(REFITS):
        n0, n1, n2 = n
        for i in range(len(q)):
            residual = (n0 * us[i] + n1 * vs[i] + n2 - q[i]) / width[i]
            weight = max(1.0 - residual * residual, 0.0)
            weights[i] = weight * weight
        xx = xy = yy = x = y = total = xq = yq = sq = 0.0
        for i in range(len(q)):
            u, v, weight = us[i], vs[i], weights[i]
            wu, wv, wq = weight * u, weight * v, weight * q[i]
            xx += wu * u
            xy += wu * v
            yy += wv * v
            x += wu
            y += wv
            total += weight
            xq += wu * q[i]
            yq += wv * q[i]
            sq += wq
        if total <= 0:
            return np.zeros(3)
        # The plane through the mean is better conditioned than the one through the camera.
        mu, mv, mq = x / total, y / total, sq / total
        xx, xy, yy = xx / total - mu * mu, xy / total - mu * mv, yy / total - mv * mv
        xq, yq = xq / total - mu * mq, yq / total - mv * mq
        determinant = xx * yy - xy * xy
        if not determinant > MIN_SPREAD * xx * yy:
            return np.zeros(3)
        n[0] = (xq * yy - yq * xy) / determinant
        n[1] = (yq * xx - xq * xy) / determinant
        n[2] = mq - n[0] * mu - n[1] * mv
    return n


@njit(cache=True, nogil=True)
def plane_distances(n, plane, rays, z, tolerance):
    """Return the mask (N,) of the inliers of a plane, and their distances (M,) from it, m.

    Parameters
    ----------
    n
        The plane n·X = 1, (3,).
    plane
        The same plane: unit normal (3,) and offset, m.
    rays, z
        Directions with z = 1, (N, 3), and depths (N,), m.
    tolerance
        Maximum residuals (N,) of the disparity, 1/m.
    """
    normal, offset = plane
    inliers, distances = np.empty(len(z), np.bool_), np.empty(len(z))
    count = 0
    for i in range(len(z)):
        u, v, depth = rays[i, 0], rays[i, 1], z[i]
        inliers[i] = abs(n[0] * u + n[1] * v + n[2] - 1.0 / depth) < tolerance[i]
        distances[count] = abs(depth * (normal[0] * u + normal[1] * v + normal[2]) + offset)
        count += inliers[i]
    return inliers, distances[:count]


@njit(cache=True, nogil=True)
def plane_inliers(candidates, offsets, samples, tolerance):
    """Return a mask (C, N) of the samples on each plane (C, 3) that have its normal."""
    q, rays, normals = samples.disparity, samples.rays, samples.normals
    inliers = np.empty((len(candidates), len(q)), np.bool_)
    # The compiler handles several samples at once if they are contiguous and without branches.
    u, v, w = rays[:, 0].copy(), rays[:, 1].copy(), rays[:, 2].copy()
    nu, nv, nw = normals[:, 0].copy(), normals[:, 1].copy(), normals[:, 2].copy()
    for k in range(len(candidates)):
        a, b, c = candidates[k, 0], candidates[k, 1], candidates[k, 2]
        scale = 1.0 / offsets[k]
        row = inliers[k]
        for i in range(len(q)):
            # A height h over the plane n·X + d = 0 is a disparity residual of h / (z |d|).
            along = a * u[i] + b * v[i] + c * w[i]
            near = abs(along * scale + q[i]) < tolerance[i]
            cosine = a * nu[i] + b * nv[i] + c * nw[i]
            row[i] = near & (cosine > MIN_COSINE)
    return inliers


@njit(cache=True, nogil=True, fastmath={"reassoc"})
def score_planes(inliers, weights):
    """Return the sum of the weights (N,) of the inliers of each plane, (C,): inliers (C, N)."""
    scores = np.empty(len(inliers))
    for k in range(len(inliers)):
        total = 0.0
        for i in range(len(weights)):
            total += weights[i] if inliers[k, i] else 0.0
        scores[k] = total
    return scores


@njit(cache=True, nogil=True)
def facing_rays(readings, normal):
    """Return the rays (M, 3) with z = 1 and the depths (M,) of the readings with a normal (3,)."""
    points, normals = readings.points, readings.normals
    rays, depths = np.ones((len(points), 3)), np.empty(len(points))
    a, b, c = normal[0], normal[1], normal[2]
    count = 0
    for i in range(len(points)):
        # A normal that is NaN faces no direction.
        if not normals[i, 0] * a + normals[i, 1] * b + normals[i, 2] * c > MIN_COSINE:
            continue
        z = points[i, 2]
        rays[count, 0], rays[count, 1], depths[count] = points[i, 0] / z, points[i, 1] / z, z
        count += 1
    return rays[:count], depths[:count]
