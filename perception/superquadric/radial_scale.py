"""Radial scale G of points about a superquadric, in local axes and logarithms, and its taper."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

TAPER_REACH = 1.05
"""The width of the sections changes up to this multiple of a3. Beyond it, outside the solid, it
stays constant."""

_TINY = 1e-12


def log_radial_scale(
    local: NDArray[np.float64], semi_axes: NDArray[np.float64], exponents: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return log G (…,) and its gradient (…, 3) at straight shape coordinates (…, 3).

    With weights u = softmax over x, y and w = softmax over (x, y), z, the gradient of log G is
    (w u / x, w (1-u) / y, (1-w) / z).
    """
    e1, e2 = exponents
    # Coordinates away from zero have finite logarithms. The gradient there tends to 0 anyway.
    magnitude = np.maximum(np.abs(local), _TINY * semi_axes)
    signed = np.where(local < 0, -magnitude, magnitude)
    log_x, log_y, log_z = np.moveaxis(np.log(magnitude / semi_axes), -1, 0)
    log_a = np.logaddexp(2 / e2 * log_x, 2 / e2 * log_y)
    log_f = np.logaddexp(e2 / e1 * log_a, 2 / e1 * log_z)
    u = np.exp(2 / e2 * log_x - log_a)
    w = np.exp(e2 / e1 * log_a - log_f)
    share = np.stack([w * u, w * (1 - u), 1 - w], axis=-1)
    return e1 / 2 * log_f, share / signed


def taper_factors(
    z: NDArray[np.float64], a3: float, taper: tuple[float, float]
) -> NDArray[np.float64]:
    """Return the widths of the sections at z (…,) along x and y over those at z = 0, (…, 2)."""
    height = np.clip(z / a3, -TAPER_REACH, TAPER_REACH)
    return 1.0 + height[..., None] * np.asarray(taper)


def straighten(
    local: NDArray[np.float64], a3: float, taper: tuple[float, float]
) -> tuple[NDArray[np.float64], Callable[[NDArray[np.float64]], NDArray[np.float64]]]:
    """Undo a taper; return straight coordinates (…, 3) and the map of gradients back to `local`."""
    if not any(taper):
        return local, lambda gradient: gradient
    factors = taper_factors(local[..., 2], a3, taper)
    straight = np.concatenate([local[..., :2] / factors, local[..., 2:]], axis=-1)
    slope = np.where(np.abs(local[..., 2:]) < TAPER_REACH * a3, np.asarray(taper) / a3, 0.0)

    def pull_back(gradient: NDArray[np.float64]) -> NDArray[np.float64]:
        across = gradient[..., :2] / factors
        along = gradient[..., 2] - np.sum(across * straight[..., :2] * slope, axis=-1)
        return np.concatenate([across, along[..., None]], axis=-1)

    return straight, pull_back
