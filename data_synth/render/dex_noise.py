"""The depth noise of the public clutter-removal protocol."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SHAPE, SCALE = 1000.0, 0.001
"""Parameters of the gamma distribution of the factor of the whole image: mean 1, σ 3.2 %."""
BLOTCH_SIGMA = 0.005
"""Standard deviation of the blotches, m."""
BLOTCH_PX = 4
"""Distance between two independent values of the blotches, px."""
BLOTCH_SHARE = 0.5
"""Share of the frames with blotches."""


def add_dex_noise(depth: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Multiply a depth image by one random factor and, in half the frames, add smooth blotches.

    The noise of Dex-Net 2.0 (Mahler et al. 2017) with the parameters of GIGA's code.

    Parameters
    ----------
    depth
        Depth (H, W), m; 0 = no reading.
    rng
        Source of randomness.

    Returns
    -------
    NDArray
        Depth (H, W) float32, m. Pixels without a reading stay 0.
    """
    rows, columns = depth.shape
    noisy = depth * np.float32(rng.gamma(SHAPE, SCALE))
    if rng.random() < BLOTCH_SHARE:
        coarse = rng.standard_normal((rows // BLOTCH_PX, columns // BLOTCH_PX)) * BLOTCH_SIGMA
        noisy = noisy + cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_LINEAR)
    return np.where(depth > 0, np.maximum(noisy, 1e-3), 0.0).astype(np.float32)
