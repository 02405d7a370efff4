"""A minimum of distances that is smooth, and never above the true one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def soft_minimum(
    distances: NDArray[np.float64], sharpness: float
) -> tuple[float, NDArray[np.float64]]:
    """Soft minimum d = -log(Σ exp(-k d_i)) / k and the share of each distance in its gradient.

    It lies below the least distance, by log(B) / k at most; where the nearest of two points L apart
    jumps while a face turns by an angle, its gradient turns within about 1 / (k L) rad instead.

    Parameters
    ----------
    distances
        (B,), m, B >= 1.
    sharpness
        k, 1/m.

    Returns
    -------
    value, weights
        m; (B,) in [0, 1] with sum 1.
    """
    least = float(distances.min())
    powers = np.exp(-sharpness * (distances - least))
    total = float(powers.sum())
    return least - float(np.log(total)) / sharpness, powers / total
