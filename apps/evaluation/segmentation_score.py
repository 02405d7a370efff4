"""Score a segmentation against the truth by overlap, objects matched one to one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

GOOD = 0.75
"""F of an object from which it counts as found."""


@dataclass(frozen=True)
class SegmentationScore:
    """Overlap figures of one frame, all in [0, 1]."""

    precision: float
    """Share of predicted pixels that lie on the matched object."""
    recall: float
    """Share of true pixels that the matched segment covers."""
    f: float
    """Harmonic mean of both."""
    found: float
    """Share of true objects whose own F exceeds 0.75."""
    truth_count: int
    """True objects."""
    predicted_count: int
    """Predicted objects."""


def score_overlap(predicted: NDArray[np.integer], truth: NDArray[np.integer]) -> SegmentationScore:
    """Match predicted to true objects by the sum of their F and score the overlap.

    Protocol of the object segmentation literature (Dave, Tokmakov and Ramanan 2019; used by Xie
    et al. 2020): F of every pair, Hungarian assignment, then pixels summed over the frame.
    Label 0 is no object. A frame without true objects scores 1 without predictions, else 0.

    Raises
    ------
    InputError
        If the two label images differ in size.
    """
    if predicted.shape != truth.shape:
        raise InputError(f"labels differ in size: {predicted.shape} against {truth.shape}")
    _, true = np.unique(truth, return_inverse=True)
    _, guess = np.unique(predicted, return_inverse=True)
    # Unique numbers start at 0 only where label 0 occurs; adding one empty row keeps it apart.
    true = true.ravel() + int(truth.min() > 0)
    guess = guess.ravel() + int(predicted.min() > 0)
    columns = int(guess.max()) + 1
    table = np.bincount(true * columns + guess, minlength=(int(true.max()) + 1) * columns)
    table = table.reshape(-1, columns)
    true_sizes, guess_sizes = table.sum(axis=1)[1:], table.sum(axis=0)[1:]
    common = table[1:, 1:]
    if not len(true_sizes) or not len(guess_sizes):
        perfect = float(len(true_sizes) == len(guess_sizes))
        return SegmentationScore(
            perfect, perfect, perfect, perfect, len(true_sizes), len(guess_sizes)
        )
    f = 2.0 * common / (true_sizes[:, None] + guess_sizes[None])
    rows, matched = linear_sum_assignment(-f)
    hits = float(common[rows, matched].sum())
    precision, recall = hits / guess_sizes.sum(), hits / true_sizes.sum()
    return SegmentationScore(
        precision=float(precision),
        recall=float(recall),
        f=float(2 * precision * recall / max(precision + recall, 1e-12)),
        found=float(np.count_nonzero(f[rows, matched] > GOOD) / len(true_sizes)),
        truth_count=len(true_sizes),
        predicted_count=len(guess_sizes),
    )
