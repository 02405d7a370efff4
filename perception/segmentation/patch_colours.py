"""Evidence of colours that two patches are one object."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

BIN_WIDTHS = (64, 16, 16)
"""Distance of the bins of a histogram in lightness, a and b, of 256. Narrow ones in lightness take
light and shade for colours, wide ones in a and b take beige for white."""
BINS = (5, 17, 17)
"""Bins in lightness, a and b. Each pixel is shared by the 8 nearest ones."""
OWN_SHARE = 0.7
"""Probability that a pixel has a colour of its own patch, and not any colour of the scene. A higher
one splits printed boxes."""
MISALIGNED = 2
"""Distance from the border of a patch below which a pixel may show its neighbour, px."""
BORDER_WEIGHT = np.float32(0.1)
"""Weight of these pixels. They decide only where a patch has no others."""
MAX_SAMPLES = 500
"""Pixels of a patch that are counted. More take longer."""
TABLE_SHIFT = 3
"""Bits of red, green and blue that the table of colours ignores."""


def colour_evidence(
    patches: NDArray[np.int32], colour: NDArray[np.uint8], pairs: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the evidence of colours that pairs of patches are one object, (K,).

    It is a log-likelihood ratio per pixel, from about -1.2 to 3, and 0 where colours say nothing:
    how much better the colours of one patch predict those of the other than the colours of all
    patches do, mean of both directions. Two patches with a colour that is rare in the scene are
    strong evidence, two grey ones in a grey scene are none. Whole patches are compared instead of
    the two sides of a border: prints have many colours, and colour images are often misaligned.

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
    histograms = colour_histograms(patches, colour, lab_table(), count).reshape(count + 1, -1)
    histograms /= np.maximum(histograms.sum(axis=1, keepdims=True), 1e-6)
    sizes = np.bincount(patches.ravel(), minlength=count + 1)[1:].astype(np.float32)
    scene = sizes @ histograms[1:] / max(sizes.sum(), 1.0)
    used = scene > 0
    histograms, scene = histograms[:, used], scene[used]
    ratios = np.log(OWN_SHARE * histograms / scene + (1 - OWN_SHARE))
    a, b = pairs.T
    both = np.einsum("kb,kb->k", histograms[a], ratios[b])
    both += np.einsum("kb,kb->k", histograms[b], ratios[a])
    return both.astype(np.float64) / 2


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
    """Return the histogram of each patch, (count + 1, 5, 17, 17) float32; the first is empty.

    At most about ``MAX_SAMPLES`` pixels of a patch count, those at its border with
    ``BORDER_WEIGHT``.
    """
    rows, columns = patches.shape
    lights, reds, yellows = BINS
    histograms = np.zeros((count + 1, lights, reds, yellows), np.float32)
    step = _sizes(patches, count) // MAX_SAMPLES + 1
    passed = np.zeros(count + 1, np.int32)
    for v in range(rows):
        for u in range(columns):
            label = patches[v, u]
            if label <= 0:
                continue
            passed[label] += 1
            if passed[label] % step[label] > 0:
                continue
            weight = np.float32(1.0)
            for dv, du in ((0, -MISALIGNED), (0, MISALIGNED), (-MISALIGNED, 0), (MISALIGNED, 0)):
                y, x = v + dv, u + du
                if y < 0 or x < 0 or y >= rows or x >= columns or patches[y, x] != label:
                    weight = BORDER_WEIGHT
            at = table[
                colour[v, u, 0] >> TABLE_SHIFT,
                colour[v, u, 1] >> TABLE_SHIFT,
                colour[v, u, 2] >> TABLE_SHIFT,
            ]
            light, red, yellow = int(at[0]), int(at[1]), int(at[2])
            for i in range(2):
                for j in range(2):
                    share = weight * abs(1 - i - at[0] + light) * abs(1 - j - at[1] + red)
                    upper = share * (at[2] - yellow)
                    histograms[label, light + i, red + j, yellow] += share - upper
                    histograms[label, light + i, red + j, yellow + 1] += upper
    return histograms


@njit(cache=True, nogil=True)
def _sizes(patches, count):
    """Return the number of pixels of each patch, (count + 1,)."""
    sizes = np.zeros(count + 1, np.int32)
    for label in patches.ravel():
        sizes[label] += 1
    return sizes
