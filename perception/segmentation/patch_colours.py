"""How alike the colours of two patches are: evidence that they are one object."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

BIN_WIDTHS = (64, 16, 16)
"""Distance of the bins of a histogram in lightness, a and b, of 256. Narrow ones in lightness take
light and shade for colours, wide ones in a and b take beige for white."""
BINS = (5, 17, 17)
"""Bins in lightness, a and b. Each pixel is shared by the 8 nearest ones."""
TABLE_SHIFT = 3
"""Bits of red, green and blue that the table of colours ignores."""


def colour_overlaps(
    patches: NDArray[np.int32], colour: NDArray[np.uint8], pairs: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the overlap of the colours of pairs of patches, 0 = all differ, 1 = the same, (K,).

    It is the Bhattacharyya coefficient of their histograms in CIE Lab. Whole patches are compared
    instead of the two sides of a border: prints have many colours, and colour images are often
    misaligned by a few pixels.

    Parameters
    ----------
    patches
        Labels 1..n (H, W), 0 = no patch.
    colour
        RGB of the same pixels, (H, W, 3).
    pairs
        Labels of the patches to compare, (K, 2).
    """
    count = int(patches.max(initial=0))
    histograms = colour_histograms(patches, colour, lab_table(), count)
    amplitudes = np.sqrt(histograms.reshape(count + 1, -1))
    amplitudes /= np.maximum(np.linalg.norm(amplitudes, axis=1, keepdims=True), 1.0)
    first, second = amplitudes[pairs[:, 0]], amplitudes[pairs[:, 1]]
    return np.einsum("kb,kb->k", first, second, dtype=np.float64)


@cache
def lab_table() -> NDArray[np.float32]:
    """Return the places in a histogram of the leading bits of RGB, (32, 32, 32, 3), in bins."""
    levels = np.arange(0, 256, 1 << TABLE_SHIFT, dtype=np.uint8) + (1 << (TABLE_SHIFT - 1))
    red, green, blue = np.meshgrid(levels, levels, levels, indexing="ij")
    rgb = np.stack([red, green, blue], axis=-1).reshape(1, -1, 3)
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).reshape(*red.shape, 3)
    return lab / np.array(BIN_WIDTHS, np.float32)


@njit(cache=True, nogil=True)
def colour_histograms(patches, colour, table, count):
    """Return the histogram of each patch, (count + 1, 5, 17, 17) float32; the first is empty."""
    rows, columns = patches.shape
    lights, reds, yellows = BINS
    histograms = np.zeros((count + 1, lights, reds, yellows), np.float32)
    for v in range(rows):
        for u in range(columns):
            label = patches[v, u]
            if label <= 0:
                continue
            at = table[
                colour[v, u, 0] >> TABLE_SHIFT,
                colour[v, u, 1] >> TABLE_SHIFT,
                colour[v, u, 2] >> TABLE_SHIFT,
            ]
            light, red, yellow = int(at[0]), int(at[1]), int(at[2])
            for i in range(2):
                for j in range(2):
                    share = abs(1 - i - at[0] + light) * abs(1 - j - at[1] + red)
                    upper = share * (at[2] - yellow)
                    histograms[label, light + i, red + j, yellow] += share - upper
                    histograms[label, light + i, red + j, yellow + 1] += upper
    return histograms
