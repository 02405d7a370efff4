"""Compiled depths by which rays enter a solid within the empty space along them."""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .levenberg_marquardt import apply_step
from .parameters import N_PARAMETERS
from .ray_kernels import TIME, compute_ray_rows, evaluate_on_rays, write_depths
from .whitened_kernels import add_whitened
from .work_rows import FAST_MATH, LANES, lane_count, new_workspace


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def ray_depths(rays, depth, view_origin, shape, tapered, values, rows):
    """Compute the depths by which rays enter a solid before `depth`, and their derivatives.

    A depth is r (1 - min G) over the part of the ray up to `depth` (K,). It is negative where the
    ray misses the solid there.

    Parameters
    ----------
    rays, view_origin
        (K, 3) unit directions from the camera, (3,).
    shape, tapered
        As in :func:`~.cost_kernels.normal_equations`.
    values, rows
        Receive the depths (K,) and their derivatives (K, 13) by a full step.
    """
    work = new_workspace()
    for first in range(0, rays.shape[0], LANES):
        n = min(rays.shape[0] - first, LANES)
        lanes = lane_count(n)
        local = compute_ray_rows(rays, view_origin, first, n, shape, tapered, True, work)
        for i in range(lanes):
            limit = depth[first + min(i, n - 1)]
            work.flat[TIME + i] = min(work.flat[TIME + i], limit)
        evaluate_on_rays(local, shape, tapered, work, lanes)
        write_depths(shape.log_axes, shape.taper, True, work.flat, work.grid, lanes)
        for i in range(n):
            values[first + i] = work.flat[at.RESIDUAL + i]
            for j in range(N_PARAMETERS):
                rows[first + i, j] = work.flat[j * LANES + i]


@njit(cache=True, nogil=True, error_model="numpy")
def whitened_ray_depths(y, unwhiten, rays, depth, view_origin, start, tapered, bounds):
    """Return the depths (K,) of :func:`ray_depths` and their derivatives (K, k) by y.

    See :func:`~.whitened_kernels.whitened_cost` for y (k,), `unwhiten`, `start` and `bounds`.
    """
    step = np.zeros(N_PARAMETERS)
    for a in range(N_PARAMETERS):
        for j in range(y.size):
            step[a] += unwhiten[a, j] * y[j]
    shape = apply_step(start, step, bounds)
    count = rays.shape[0]
    values, rows = np.empty(count), np.zeros((count, N_PARAMETERS))
    ray_depths(rays, depth, view_origin, shape, tapered, values, rows)
    gradients = np.zeros((count, y.size))
    for i in range(count):
        add_whitened(rows[i], shape, start, step, unwhiten, gradients[i])
    return values, gradients
