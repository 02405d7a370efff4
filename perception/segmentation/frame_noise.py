"""How noisy a frame is, measured on the frame itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import SegmentationOptions

ACROSS = 54
"""Windows across the image that are measured: some 2000 in all are plenty for a quantile."""
MIN_SHARE = 0.5
"""Least share of a window's pixels with readings."""


def frame_noise(disparity: NDArray[np.float32], options: SegmentationOptions) -> float:
    """Noise σ of a disparity image (H, W), 1/m: a low quantile of planes' residuals on a grid."""
    radius = options.window // 2
    step = max(disparity.shape[1] // ACROSS, 1)
    residuals = window_residuals(disparity, radius, step, MIN_SHARE)
    residuals = residuals[residuals >= 0]
    if residuals.size == 0:
        return options.min_noise
    return max(float(np.quantile(residuals, options.noise_quantile)), options.min_noise)


@njit(cache=True, nogil=True)
def window_residuals(q, radius, step, min_share):
    """Rms residual of a plane per window on a grid, 1/m; -1 = too few readings."""
    rows, columns = q.shape
    down, across = (rows + step - 1) // step, (columns + step - 1) // step
    residuals = np.full((down, across), -1.0)
    least = max(min_share * (2 * radius + 1) ** 2, 4.0)
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
            if n < least:
                continue
            mx, my, mq = sx / n, sy / n, sq / n
            cxx, cyy, cxy = sxx / n - mx * mx, syy / n - my * my, sxy / n - mx * my
            cxq, cyq = sxq / n - mx * mq, syq / n - my * mq
            determinant = cxx * cyy - cxy * cxy
            if determinant < 1e-3 * cxx * cyy or cxx < 0.1 or cyy < 0.1:
                continue
            b = (cxq * cyy - cyq * cxy) / determinant
            c = (cyq * cxx - cxq * cxy) / determinant
            residuals[k, m] = np.sqrt(max(sqq / n - mq * mq - b * cxq - c * cyq, 0.0))
    return residuals
