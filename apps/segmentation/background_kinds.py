"""Which kinds of background became objects: tables, floors, walls of containers, robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.scenes import BACKGROUND_LEGEND, BackgroundKind


def false_kinds(
    predicted: NDArray[np.integer],
    truth: NDArray[np.integer],
    background: NDArray[np.uint8],
    ignore: NDArray[np.bool_] | None = None,
) -> dict[BackgroundKind, int]:
    """Count the false segments by the kind of background that covers most of each.

    Parameters
    ----------
    predicted, truth
        Labels, (H, W), integers >= 0; 0 is no object.
    background
        (H, W): numbers in `BACKGROUND_LEGEND`, 0 where the pixel shows an object.
    ignore
        (H, W) bool: pixels left out.

    Returns
    -------
    dict
        Number of segments of which at most half lies on objects, as in `SegmentationScore.false`,
        for every kind.
    """
    counted = np.ones(predicted.shape, bool) if ignore is None else ~ignore
    labels = np.where(counted, predicted, 0).ravel()
    kinds = len(BACKGROUND_LEGEND) + 1
    shown = np.where(truth > 0, 0, background).ravel()
    table = np.bincount(labels * kinds + shown, minlength=(int(labels.max()) + 1) * kinds)
    table = table.reshape(-1, kinds)[1:]
    on_objects = np.bincount(labels, weights=truth.ravel() > 0, minlength=len(table) + 1)[1:]
    sizes = table.sum(axis=1)
    false = (sizes > 0) & (2 * on_objects <= sizes)
    counts = np.bincount(table[false, 1:].argmax(axis=1), minlength=kinds - 1)
    return {kind: int(counts[number - 1]) for number, kind in BACKGROUND_LEGEND.items()}
