"""Compiled test of the rays that enter a solid within the empty space along them."""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .ray_kernels import TIME, compute_ray_rows, evaluate_on_rays
from .work_rows import FAST_MATH, LANES, lane_count, new_workspace


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def covers_free_space(rays, depth, view_origin, shape):
    """Return the state (K,) of each ray: 0 misses, 1 meets the solid, 2 meets it in empty space.

    A ray meets the solid in empty space if G falls below 1 before `depth` (K,). G along a ray has
    one minimum, so it is enough to evaluate it at the minimum or at `depth`, whichever is nearer.

    Parameters
    ----------
    rays, view_origin
        (K, 3) unit directions from the camera, (3,).
    depth
        (K,) distances up to which the rays are empty. Rays with depth <= 0 are never covered.
    shape
        :class:`~.parameters.ShapeParameters` in the frame and unit of the rays.
    """
    states = np.zeros(rays.shape[0], dtype=np.int8)
    near = rays_through_box(rays, view_origin, shape)
    if near.size == 0:
        return states
    near_rays = rays[near]
    work = new_workspace()
    tapered = shape.taper[0] != 0.0 or shape.taper[1] != 0.0
    for first in range(0, near.size, LANES):
        n = min(near.size - first, LANES)
        local = compute_ray_rows(near_rays, view_origin, first, n, shape, tapered, False, work)
        for i in range(n):
            if work.flat[at.RESIDUAL + i] > 0.0:
                states[near[first + i]] = 1
        for i in range(lane_count(n)):
            limit = depth[near[first + min(i, n - 1)]]
            work.flat[TIME + i] = min(work.flat[TIME + i], limit)
        evaluate_on_rays(local, shape, tapered, work, lane_count(n))
        for i in range(n):
            k = near[first + i]
            if states[k] == 1 and work.flat[at.INV_G + i] > 1.0 and depth[k] > 0.0:
                states[k] = 2
    return states


@njit(cache=True, nogil=True, error_model="numpy")
def rays_through_box(rays, view_origin, shape):
    """Return the indices (M,) of the rays that meet the box around a solid, along its axes.

    All other rays miss the solid. Few of the rays of an image meet the box of a thin solid.
    """
    R, c = shape.R, shape.centre
    origin, half = np.zeros(3), np.empty(3)
    for k in range(3):
        half[k] = np.exp(shape.log_axes[k])
        if k < 2:
            half[k] *= 1.0 + abs(shape.taper[k])
        for j in range(3):
            origin[k] += R[j, k] * (view_origin[j] - c[j])
    near = np.empty(rays.shape[0], dtype=np.int64)
    count = 0
    for i in range(rays.shape[0]):
        enter, leave = 0.0, np.inf
        for k in range(3):
            slope = R[0, k] * rays[i, 0] + R[1, k] * rays[i, 1] + R[2, k] * rays[i, 2]
            if slope == 0.0:
                slope = 1e-300
            one, other = (-half[k] - origin[k]) / slope, (half[k] - origin[k]) / slope
            enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
        if enter <= leave:
            near[count] = i
            count += 1
    return near[:count]
