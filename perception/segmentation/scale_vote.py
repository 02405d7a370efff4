"""The majority of three segmentations with patches of different sizes, and where they disagree."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .ambiguity import NEARLY, SCALES, UncertainJoin
from .join_patches import contract_edges
from .label_pixels import count_labels, renumber_labels

STEPS = (0, -2, 2)
"""Sides of the windows of the three segmentations, relative to ``window``, px."""
MIN_VOTES = 2
"""Minimum number of segmentations in which two parts are one object."""
MIN_DISPUTED = 0.2
"""Minimum share of an object that another segmentation joins otherwise, for a warning."""


def vote_scales(
    segmentations: Sequence[NDArray[np.int32]], min_part: int
) -> tuple[NDArray[np.int32], list[UncertainJoin]]:
    """Join the common parts of several segmentations as most of these do.

    Parameters
    ----------
    segmentations
        Labels (H, W) of each, 0 = no object. What is no object in the first one stays none.
    min_part
        Minimum size of a part that votes, px. Smaller parts join the one with most votes.

    Returns
    -------
    labels, disputed
        Objects (H, W) int32 in arbitrary numbers; pairs of parts that one segmentation joins and
        another one separates.
    """
    parts, members, pixels = _common_parts(segmentations)
    sizes = count_labels(parts, len(members) - 1)
    same = (members[:, None] == members[None]) & (members[:, None] > 0)
    votes = same.sum(axis=2)
    owner = _join_by_votes(votes, sizes, min_part)
    disputed: list[UncertainJoin] = []
    for of_scale in members.T:
        disputed += _disputed_joins(owner, of_scale, sizes, pixels)
    return renumber_labels(parts, owner), disputed


def _common_parts(
    segmentations: Sequence[NDArray[np.int32]],
) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """Number the parts that are in one object in each segmentation.

    Returns the numbers 1..n (H, W), the object of each part in each segmentation (n + 1, K), and
    the flat index of a pixel of each part (n + 1,).
    """
    parts = segmentations[0]
    for other in segmentations[1:]:
        keys = np.where(parts > 0, parts * (other.max(initial=0) + 1) + other, 0).astype(np.int32)
        used = count_labels(keys, int(keys.max(initial=0))) > 0
        used[0] = False
        parts = renumber_labels(keys, np.where(used, np.cumsum(used), 0).astype(np.int32))
    pixels = np.zeros(int(parts.max(initial=0)) + 1, np.int64)
    pixels[parts.ravel()] = np.arange(parts.size)
    members = np.stack([labels.ravel()[pixels] for labels in segmentations], axis=1)
    members[0] = 0
    return parts, members.astype(np.int64), pixels


def _join_by_votes(
    votes: NDArray[np.int64], sizes: NDArray[np.int64], min_part: int
) -> NDArray[np.int32]:
    """Join parts, the pair with the largest majority first; return their objects (n + 1,)."""
    large = np.flatnonzero(sizes >= min_part)
    large = large[large > 0]
    owner = np.zeros(len(sizes), np.int32)
    first, second = np.triu_indices(len(large), 1)
    pairs = np.column_stack([large[first], large[second]])
    gain = votes[pairs[:, 0], pairs[:, 1]] - (MIN_VOTES - 0.5)
    parent = contract_edges(pairs, gain * sizes[pairs].min(axis=1), len(sizes) - 1)
    owner[large] = parent[large]
    for part in np.flatnonzero((sizes > 0) & (sizes < min_part)):
        if part and len(large):
            best = large[np.lexsort((sizes[large], votes[part, large]))[-1]]
            owner[part] = owner[best] if votes[part, best] >= MIN_VOTES else 0
    return owner


def _disputed_joins(
    owner: NDArray[np.int32],
    other: NDArray[np.int64],
    sizes: NDArray[np.int64],
    pixels: NDArray[np.int64],
) -> list[UncertainJoin]:
    """Return pairs of parts that one of two partitions of the parts (n + 1,) joins only."""
    table = np.zeros((int(owner.max(initial=0)) + 1, int(other.max(initial=0)) + 1), np.int64)
    np.add.at(table, (owner, other), sizes)
    table[0] = table[:, 0] = 0
    first = np.zeros(table.shape, np.int64)
    first[owner, other] = pixels
    whole = table.sum(axis=1)
    disputed: list[UncertainJoin] = []
    for k in np.flatnonzero(whole):
        most, second = np.argsort(-table[k], kind="stable")[:2] if table.shape[1] > 1 else (0, 0)
        if table[k, second] > MIN_DISPUTED * whole[k]:
            disputed.append(UncertainJoin(int(first[k, most]), int(first[k, second]), SCALES))
        beside = table[:, most].copy()
        beside[k] = 0
        neighbour = int(np.argmax(beside))
        if beside[neighbour] > MIN_DISPUTED * max(whole[k], whole[neighbour]):
            disputed.append(UncertainJoin(int(first[k, most]), int(first[neighbour, most]), NEARLY))
    return disputed
