"""Measure the noise of a frame on the frame itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .local_planes import plane_of_moments

if TYPE_CHECKING:
    from numpy.typing import NDArray

MIN_NOISE = 1e-3
"""Minimum noise σ of disparity, 1/m. Without it any rounding would separate the pixels of a
noise-free frame."""
NOISE_QUANTILE = 0.4
"""Quantile of the windows' residuals that is the noise. It lies below the median because the
residual of a window across an edge is not noise."""
WINDOWS_ACROSS = 54
"""Windows across the image that are measured. Some 2000 windows in all give a stable quantile."""
MIN_SHARE = 0.5
"""Minimum share of a window's pixels with readings."""


def frame_noise(disparity: NDArray[np.float32], window: int) -> float:
    """Return the noise σ of a disparity image (H, W), 1/m.

    It is a quantile of the residuals of planes, fitted to windows of side `window` px on a grid.
    """
    step = max(disparity.shape[1] // WINDOWS_ACROSS, 1)
    residuals = window_residuals(disparity, window // 2, step, MIN_SHARE)
    residuals = residuals[residuals >= 0]
    if residuals.size == 0:
        return MIN_NOISE
    return max(float(np.quantile(residuals, NOISE_QUANTILE)), MIN_NOISE)


@njit(cache=True, nogil=True)
def window_residuals(q, radius, step, min_share):
    """Return the rms residual of a plane per window on a grid, 1/m; -1 = too few readings."""
    rows, columns = q.shape
    down, across = (rows + step - 1) // step, (columns + step - 1) // step
    residuals = np.full((down, across), -1.0)
    min_count = max(min_share * (2 * radius + 1) ** 2, 4.0)
    for k in range(down):
        for m in range(across):
            v, u = k * step, m * step
            n = sx = sy = sxx = sxy = syy = sq = sxq = syq = sqq = 0.0
            for y in range(max(v - radius, 0), min(v + radius + 1, rows)):
                for x in range(max(u - radius, 0), min(u + radius + 1, columns)):
                    here = np.float64(q[y, x])
                    if here <= 0:
                        continue
                    dx, dy = np.float64(x - u), np.float64(y - v)
                    n += 1.0
                    sx += dx
                    sy += dy
                    sxx += dx * dx
                    sxy += dx * dy
                    syy += dy * dy
                    sq += here
                    sxq += dx * here
                    syq += dy * here
                    sqq += here * here
            if n < min_count:
                continue
            moments = sx, sy, sxx, syy, sxy, sq, sxq, syq, sqq
            fitted, _, _, _, residual = plane_of_moments(n, moments)
            if fitted:
                residuals[k, m] = residual
    return residuals
