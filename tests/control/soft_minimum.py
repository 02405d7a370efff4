"""A smooth lower bound of the minimum distance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def soft_minimum(
    distances: NDArray[np.float64], sharpness: float
) -> tuple[float, NDArray[np.float64]]:
    """Compute the soft minimum d = -log(Σ exp(-k d_i)) / k and the weights of its gradient.

    The value lies at most log(B) / k below the minimum. The closest point of a face that turns can
    jump by a length L. The gradient of the soft minimum changes over about 1 / (k L) rad instead.

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
    minimum = float(distances.min())
    powers = np.exp(-sharpness * (distances - minimum))
    total = float(powers.sum())
    return minimum - float(np.log(total)) / sharpness, powers / total
