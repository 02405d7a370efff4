"""Radial scale G of points about a superquadric, in local axes and logarithms, and its taper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

TAPER_REACH = 1.05
"""The width of the sections changes up to this multiple of a3. Beyond it, outside the solid, it
stays constant."""

_TINY = 1e-12
_SECTIONS = 65
"""Heights of a search grid for the support of a tapered solid."""
_REFINEMENTS = 6
"""Number of grids, each over two steps of the grid before: to 1e-9 of the height."""


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


def tapered_support(
    directions: NDArray[np.float64],
    semi_axes: NDArray[np.float64],
    exponents: tuple[float, float],
    taper: tuple[float, float],
) -> NDArray[np.float64]:
    """Return the largest d·x over a tapered solid, for local directions d (…, 3), (…,).

    A section at height z is a superellipse of known size. Its support is the dual norm. The
    largest support over z is searched on grids that become finer.
    """
    flat = directions.reshape(-1, 3)
    best = np.zeros(len(flat))
    step = 1.0 / (_SECTIONS - 1)
    grid = np.linspace(-1.0, 1.0, _SECTIONS)
    heights = np.broadcast_to(grid, (len(flat), _SECTIONS))
    for _ in range(_REFINEMENTS):
        reach = _section_support(flat, heights, semi_axes, exponents, taper)
        highest = np.argmax(reach, axis=1)
        best = np.take_along_axis(reach, highest[:, None], axis=1)[:, 0]
        middle = np.take_along_axis(heights, highest[:, None], axis=1)
        heights = np.clip(middle + 2.0 * step * grid, -1.0, 1.0)
        step *= 2.0 / (_SECTIONS - 1)
    return best.reshape(directions.shape[:-1])


def _section_support(
    directions: NDArray[np.float64],
    heights: NDArray[np.float64],
    semi_axes: NDArray[np.float64],
    exponents: tuple[float, float],
    taper: tuple[float, float],
) -> NDArray[np.float64]:
    """Return the support (N, S) of sections at heights (N, S), as shares of a3, along (N, 3)."""
    e1, e2 = exponents
    size = (1.0 - np.abs(heights) ** (2.0 / e1)) ** (e1 / 2.0)
    factors = 1.0 + heights[..., None] * np.asarray(taper)
    pull = np.maximum(np.abs(directions[:, None, :2]) * semi_axes[:2] * factors, _TINY)
    power = 2.0 / (2.0 - e2)
    across = np.exp(np.logaddexp(*(power * np.moveaxis(np.log(pull), -1, 0))) / power)
    return size * across + heights * semi_axes[2] * directions[:, None, 2]
