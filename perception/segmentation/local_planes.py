"""A plane in disparity around every pixel, with windows that stay on their own side of an edge.

In disparity q = 1/z a plane in space is linear in pixel coordinates, and the noise of stereo and
structured light does not depend on distance, so one threshold serves the whole image.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .row_bands import in_bands

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import SegmentationOptions

SETTLED = 2.0
"""Squared error of a centred window, in σ², below which no other window is looked for."""
MIN_WINDOW_SHARE = 0.3
"""Least share of a window's pixels with readings for a plane to be trusted."""


class LocalPlanes(NamedTuple):
    """Per-pixel planes ``q(u', v') = value + slope_u (u'-u) + slope_v (v'-v)``; NaN-free."""

    value: NDArray[np.float32]
    """Plane's disparity at the pixel, (H, W), 1/m; 0 = no plane."""
    slope_u: NDArray[np.float32]
    """Slope along columns, (H, W), 1/(m px)."""
    slope_v: NDArray[np.float32]
    """Slope along rows, (H, W), 1/(m px)."""
    rms: NDArray[np.float32]
    """Residual of the window centred on the pixel, (H, W), 1/m; -1 = none."""
    noise: float = 0.0
    """Noise σ of disparity, 1/m."""


def fit_local_planes(
    disparity: NDArray[np.float32], noise: float, options: SegmentationOptions
) -> LocalPlanes:
    """Fit a plane around every pixel of a disparity image (H, W), 1/m, 0 = no reading.

    Least squares from running sums over a square window; where a window shifted to one of eight
    sides explains the pixel clearly better (Kuwahara et al. 1976), that plane is taken. `noise`
    is σ of disparity, 1/m.
    """
    radius = options.window // 2
    value, slope_u, slope_v, rms = in_bands(
        lambda q: plane_sums(q, radius, MIN_WINDOW_SHARE), (disparity,), radius, options.threads
    )
    if options.shift_windows:
        value, slope_u, slope_v = in_bands(
            lambda q, value, slope_u, slope_v, rms: pick_windows(
                q, value, slope_u, slope_v, rms, radius, noise, options.shift_gain
            ),
            (disparity, value, slope_u, slope_v, rms),
            radius,
            options.threads,
        )
    return LocalPlanes(value, slope_u, slope_v, rms, noise)


@njit(cache=True, nogil=True)
def plane_sums(q, radius, min_share):
    """Fit a plane per centred window: value and slopes at its centre, rms residual, -1 = none."""
    rows, columns = q.shape
    value = np.zeros((rows, columns), np.float32)
    slope_u = np.zeros((rows, columns), np.float32)
    slope_v = np.zeros((rows, columns), np.float32)
    rms = np.full((rows, columns), np.float32(-1.0))
    least = max(min_share * (2 * radius + 1) ** 2, 4.0)
    # Sums over a column of the window, with v relative to the current row.
    n, sv, svv = np.zeros(columns), np.zeros(columns), np.zeros(columns)
    sq, svq, sqq = np.zeros(columns), np.zeros(columns), np.zeros(columns)
    for v in range(-radius, rows):
        entering, leaving = v + radius, v - radius - 1
        for u in range(columns):
            # Shift the origin down by one row before adding and dropping rows.
            svv[u] += n[u] - 2.0 * sv[u]
            sv[u] -= n[u]
            svq[u] -= sq[u]
            if entering < rows and q[entering, u] > 0:
                x = np.float64(q[entering, u])
                n[u] += 1.0
                sv[u] += radius
                svv[u] += radius * radius
                sq[u] += x
                svq[u] += radius * x
                sqq[u] += x * x
            if leaving >= 0 and q[leaving, u] > 0:
                x = np.float64(q[leaving, u])
                offset = -radius - 1.0
                n[u] -= 1.0
                sv[u] -= offset
                svv[u] -= offset * offset
                sq[u] -= x
                svq[u] -= offset * x
                sqq[u] -= x * x
        if v < 0:
            continue
        tn = tv = tvv = tq = tvq = tqq = tu = tuu = tuv = tuq = 0.0
        for u in range(-radius, columns):
            tuu += tn - 2.0 * tu
            tuv -= tv
            tuq -= tq
            tu -= tn
            right, left = u + radius, u - radius - 1
            if right < columns:
                tn += n[right]
                tv += sv[right]
                tvv += svv[right]
                tq += sq[right]
                tvq += svq[right]
                tqq += sqq[right]
                tu += radius * n[right]
                tuu += radius * radius * n[right]
                tuv += radius * sv[right]
                tuq += radius * sq[right]
            if left >= 0:
                offset = -radius - 1.0
                tn -= n[left]
                tv -= sv[left]
                tvv -= svv[left]
                tq -= sq[left]
                tvq -= svq[left]
                tqq -= sqq[left]
                tu -= offset * n[left]
                tuu -= offset * offset * n[left]
                tuv -= offset * sv[left]
                tuq -= offset * sq[left]
            if u < 0 or tn < least or q[v, u] <= 0:
                continue
            mu, mv, mq = tu / tn, tv / tn, tq / tn
            cuu, cvv, cuv = tuu / tn - mu * mu, tvv / tn - mv * mv, tuv / tn - mu * mv
            cuq, cvq = tuq / tn - mu * mq, tvq / tn - mv * mq
            determinant = cuu * cvv - cuv * cuv
            if determinant < 1e-3 * cuu * cvv or cuu < 0.1 or cvv < 0.1:
                continue
            b = (cuq * cvv - cvq * cuv) / determinant
            c = (cvq * cuu - cuq * cuv) / determinant
            residual = tqq / tn - mq * mq - b * cuq - c * cvq
            value[v, u] = mq - b * mu - c * mv
            slope_u[v, u] = b
            slope_v[v, u] = c
            rms[v, u] = np.sqrt(max(residual, 0.0))
    return value, slope_u, slope_v, rms


@njit(cache=True, nogil=True)
def pick_windows(q, value, slope_u, slope_v, rms, radius, noise, gain):
    """Replace planes by those of the best of eight shifted windows where that is clearly better."""
    rows, columns = q.shape
    new_value, new_u, new_v = value.copy(), slope_u.copy(), slope_v.copy()
    for v in range(rows):
        for u in range(columns):
            here = q[v, u]
            if here <= 0:
                continue
            best = np.float32(1e9)
            if rms[v, u] >= 0:
                miss = value[v, u] - here
                best = rms[v, u] * rms[v, u] + miss * miss
                if best < SETTLED * noise * noise:
                    continue
                best *= gain * gain
            for dv in (-radius, 0, radius):
                for du in (-radius, 0, radius):
                    y, x = v + dv, u + du
                    if y < 0 or x < 0 or y >= rows or x >= columns or rms[y, x] < 0:
                        continue
                    at = value[y, x] - slope_u[y, x] * du - slope_v[y, x] * dv
                    miss = at - here
                    cost = rms[y, x] * rms[y, x] + miss * miss
                    if cost < best:
                        best = cost
                        new_value[v, u] = at
                        new_u[v, u] = slope_u[y, x]
                        new_v[v, u] = slope_v[y, x]
    return new_value, new_u, new_v
