"""Measure the noise of a frame on the frame itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .local_planes import plane_of_moments
from .median import quantile

MIN_NOISE = 1e-3
"""Minimum noise σ of disparity, 1/m. Without it any rounding would separate the pixels of a
noise-free frame."""
NOISE_QUANTILE = 0.4
"""Quantile of the windows' residuals that is the noise. It lies below the median because the
residual of a window across an edge is not noise."""
WINDOWS_ACROSS = 54
"""Windows across the image that are measured. Some 2000 windows in all give a stable quantile."""
GROUP = 100
"""Minimum number of windows that show the noise at a disparity."""
GROUP_QUANTILE = 0.2
"""Quantile of the residuals of a group that is its noise. Without edges it is 3 % below the one of
the frame."""
MIN_RISE = 1.5
"""Minimum ratio of a group's noise to that of the frame. Curved surfaces raise it by up to 1.3, the
short range of a structured-light camera by 3 to 5."""
MIN_SHARE = 0.5
"""Minimum share of a window's pixels with readings."""


class NoiseProfile(NamedTuple):
    """Noise of a frame over disparity. Near surfaces of some cameras are noisier in disparity."""

    disparities: NDArray[np.float64]
    """(K,) ascending, 1/m."""
    sigmas: NDArray[np.float64]
    """(K,) σ of disparity there, 1/m."""

    def at(self, disparity: NDArray[np.floating] | float) -> NDArray[np.float64]:
        """Return the noise σ at some disparities, 1/m."""
        return np.asarray(np.interp(disparity, self.disparities, self.sigmas))


def frame_noise(disparity: NDArray[np.float32], window: int) -> float:
    """Return the noise σ of a disparity image (H, W), 1/m.

    It is a quantile of the residuals of planes, fitted to windows of side `window` px on a grid.
    """
    return noise_profile(disparity, window)[0]


def noise_profile(disparity: NDArray[np.float32], window: int) -> tuple[float, NoiseProfile]:
    """Return the noise of :func:`frame_noise`, and its clearly higher values by disparity."""
    step = max(disparity.shape[1] // WINDOWS_ACROSS, 1)
    residuals = window_residuals(disparity, window // 2, step, MIN_SHARE)
    measured = residuals >= 0
    if not measured.any():
        return MIN_NOISE, NoiseProfile(np.ones(1), np.full(1, MIN_NOISE))
    values, centres = residuals[measured], disparity[::step, ::step][measured]
    noise = max(quantile(values, NOISE_QUANTILE), MIN_NOISE)
    # Groups of equal size can be sorted at once. The remainder, the nearest windows, is left out.
    count = max(len(values) // GROUP, 1)
    size = len(values) // count
    order = np.argsort(centres, kind="stable")[: count * size].reshape(count, size)
    middles = centres[order[:, size // 2]].astype(np.float64)
    sigmas = np.sort(values[order], axis=1)[:, round(GROUP_QUANTILE * (size - 1))]
    return noise, NoiseProfile(middles, np.where(sigmas > MIN_RISE * noise, sigmas, noise))


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
