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
    work = new_workspace()
    tapered = shape.taper[0] != 0.0 or shape.taper[1] != 0.0
    for first in range(0, rays.shape[0], LANES):
        n = min(rays.shape[0] - first, LANES)
        local = compute_ray_rows(rays, view_origin, first, n, shape, tapered, False, work)
        for i in range(n):
            if work.flat[at.RESIDUAL + i] > 0.0:
                states[first + i] = 1
        for i in range(lane_count(n)):
            limit = depth[first + min(i, n - 1)]
            work.flat[TIME + i] = min(work.flat[TIME + i], limit)
        evaluate_on_rays(local, shape, tapered, work, lane_count(n))
        for i in range(n):
            entered = states[first + i] == 1 and work.flat[at.INV_G + i] > 1.0
            if entered and depth[first + i] > 0.0:
                states[first + i] = 2
    return states
