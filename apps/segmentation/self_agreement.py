"""Stability of a segmentation: how much of it survives a small change of the readings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame

NOISE_M, NOISE_SHARE, NOISE_SEED = 0.001, 0.005, 0
"""The disturbance of the test of stability: this many metres on this share of the pixels."""


def disturbed_frame(
    frame: DepthFrame, share: float = NOISE_SHARE, seed: int = NOISE_SEED
) -> DepthFrame:
    """Return a frame with ±1 mm on a share of its readings."""
    rng = np.random.default_rng(seed)
    depth = frame.depth.copy()
    hit = (depth > 0) & (rng.random(depth.shape) < share)
    depth[hit] += rng.choice([-NOISE_M, NOISE_M], np.count_nonzero(hit)).astype(np.float32)
    return replace(frame, depth=depth)


def self_agreement(first: NDArray[np.int32], second: NDArray[np.int32]) -> float:
    """Return the share of labelled pixels whose segments match one to one, 0-1.

    Every segment of the first labels is matched with the segment of the second with which it
    shares most pixels, if this segment shares most with it too.
    """
    labelled = (first > 0) | (second > 0)
    total = int(np.count_nonzero(labelled))
    if total == 0:
        return 1.0
    table = np.zeros((int(first.max()) + 1, int(second.max()) + 1), np.int64)
    np.add.at(table, (first[labelled], second[labelled]), 1)
    table[0] = 0
    table[:, 0] = 0
    best = table.argmax(axis=1)
    mutual = table.argmax(axis=0)[best] == np.arange(len(best))
    return float(table[np.arange(len(best)), best][mutual].sum() / total)
