"""Score a segmentation against the truth by overlap, boundary and kind of mistake.

The protocol of the object segmentation literature: Dave, Tokmakov and Ramanan, "Towards
Segmenting Anything That Moves", ICCV workshops 2019; Xie, Xiang, Mousavian and Fox, "The Best of
Both Modes", CoRL 2020, and "Unseen Object Instance Segmentation for Robotic Environments", T-RO
2021.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

from eyehand.errors import InputError

FOUND_F = 0.75
"""F of an object above which it counts as found (%75 in the literature)."""
BOUNDARY_TOLERANCE = 0.003
"""Distance at which boundaries still agree, as a share of the image diagonal, rounded up to whole
px: the value of Xie et al. from the DAVIS video benchmark."""
_TIE = 1e-6
"""Weight of the boundary F in the matching. It breaks ties, so that the order of labels has no
effect."""
_LOOKUP_LABELS = 1 << 20
"""If all labels are below this, they are renumbered with a lookup table. It is ten times faster
than sorting."""


@dataclass(frozen=True)
class Match:
    """A true object and its matched predicted segment."""

    truth: int
    """Label of the true object."""
    predicted: int
    """Label of the segment."""
    f: float
    """F of their overlap, in (0, 1]."""


@dataclass(frozen=True)
class SegmentationScore:
    """The scores of one frame; shares are in [0, 1]."""

    precision: float
    """Share of predicted pixels that lie on the matched object."""
    recall: float
    """Share of true pixels that the matched segment covers."""
    f: float
    """Harmonic mean of both."""
    boundary_precision: float
    """Share of predicted boundary pixels within the tolerance of the matched object's boundary."""
    boundary_recall: float
    """Share of true boundary pixels within the tolerance of the matched segment's boundary."""
    boundary_f: float
    """Harmonic mean of both."""
    found: float
    """Share of true objects whose own F exceeds 0.75."""
    truth_count: int
    """Number of true objects."""
    predicted_count: int
    """Number of predicted objects."""
    over: int
    """Over-segmentation: extra segments on the same object. Summed over true objects: the number of
    segments with more than half of their pixels on that object, minus one (at least 0)."""
    under: int
    """Under-segmentation: extra objects in the same segment. Summed over segments: the number of
    true objects with more than half of their pixels in that segment, minus one (at least 0)."""
    missed: int
    """Number of true objects of which all segments together cover at most half."""
    false: int
    """Number of segments of which at most half lies on any objects."""
    matches: tuple[Match, ...] = field(default=(), compare=False)
    """Matched pairs with common pixels, by rising label of the object. Not part of equality,
    because label numbers are arbitrary."""


def score_segmentation(
    predicted: NDArray[np.integer],
    truth: NDArray[np.integer],
    ignore: NDArray[np.bool_] | None = None,
) -> SegmentationScore:
    """Match predicted to true objects by the sum of their F, and score overlap and boundaries.

    The Hungarian assignment maximises the sum of F over pairs. The common pixels of matched pairs,
    divided by all predicted pixels, are the precision; divided by all true pixels, the recall. The
    boundary scores are the same for pixels of outer contours (no holes). A contour pixel counts
    when it lies within ceil(0.003 diagonal) px of the partner's contour. Pairs without a common
    pixel are not matched. A frame without true objects scores 1 without predictions, else 0.

    Parameters
    ----------
    predicted
        Labels, (H, W), integers >= 0; 0 is no object.
    truth
        True labels, likewise.
    ignore
        (H, W) bool: pixels left out of both, such as those without a depth reading.

    Returns
    -------
    SegmentationScore
        Swapping `predicted` and `truth` swaps precision and recall, over and under, missed and
        false. Renumbering labels changes nothing.

    Raises
    ------
    InputError
        If the images differ in size, or a label is negative or no integer.
    """
    true = _Objects.read(truth, ignore, "true labels")
    guess = _Objects.read(predicted, ignore, "predicted labels")
    if true.ranks.shape != guess.ranks.shape:
        raise InputError(
            f"labels differ in size: predicted {guess.ranks.shape} against true {true.ranks.shape}"
        )
    table = _common_pixels(true, guess)
    reach = int(np.ceil(BOUNDARY_TOLERANCE * np.hypot(*true.ranks.shape)))
    true_edges, guess_edges = _Contours.trace(true), _Contours.trace(guess)
    guess_hits = true_edges.near(guess_edges, reach)
    true_hits = guess_edges.near(true_edges, reach).T
    pairs = 2.0 * table / np.maximum(true.sizes[:, None] + guess.sizes, 1)
    edge_pairs = (guess_hits + true_hits) / np.maximum(
        true_edges.sizes[:, None] + guess_edges.sizes, 1
    )
    rows, columns = linear_sum_assignment(-(pairs + _TIE * edge_pairs * (table > 0)))
    overlapping = table[rows, columns] > 0
    rows, columns = rows[overlapping], columns[overlapping]
    empty = float(len(true.sizes) == len(guess.sizes) == 0)
    hits = int(table[rows, columns].sum())
    precision, recall, f = _rates(hits, guess.sizes, hits, true.sizes, empty)
    edge_precision, edge_recall, edge_f = _rates(
        int(guess_hits[rows, columns].sum()),
        guess_edges.sizes,
        int(true_hits[rows, columns].sum()),
        true_edges.sizes,
        empty,
    )
    found = np.count_nonzero(pairs[rows, columns] > FOUND_F)
    return SegmentationScore(
        precision=precision,
        recall=recall,
        f=f,
        boundary_precision=edge_precision,
        boundary_recall=edge_recall,
        boundary_f=edge_f,
        found=found / len(true.sizes) if len(true.sizes) else empty,
        truth_count=len(true.sizes),
        predicted_count=len(guess.sizes),
        over=_shared_majority(table.T, guess.sizes),
        under=_shared_majority(table, true.sizes),
        missed=int(np.count_nonzero(2 * table.sum(axis=1) <= true.sizes)),
        false=int(np.count_nonzero(2 * table.sum(axis=0) <= guess.sizes)),
        matches=tuple(
            Match(int(true.labels[t]), int(guess.labels[p]), float(pairs[t, p]))
            for t, p in zip(rows, columns, strict=True)
        ),
    )


@dataclass(frozen=True)
class _Objects:
    """A label image whose objects are numbered 1..n."""

    ranks: NDArray[np.int32]
    """(H, W): 0 = no object."""
    labels: NDArray[np.integer]
    """(n,): original label of each object, rising."""
    sizes: NDArray[np.intp]
    """(n,): number of pixels of each object."""

    @classmethod
    def read(
        cls, image: NDArray[np.integer], ignore: NDArray[np.bool_] | None, name: str
    ) -> _Objects:
        image = np.asarray(image)
        if image.ndim != 2 or image.dtype.kind not in "iub":
            raise InputError(f"{name} are {image.shape} {image.dtype}, expected (H, W) integers")
        if ignore is not None:
            if ignore.shape != image.shape:
                raise InputError(
                    f"{name} differ in size from the pixels to ignore: "
                    f"{image.shape} against {ignore.shape}"
                )
            image = np.where(ignore, 0, image)
        if image.size and image.min() < 0:
            raise InputError(f"{name} reach down to {image.min()}, expected 0 or more")
        if image.size and image.max() < _LOOKUP_LABELS:
            counts = np.bincount(image.ravel())
            labels = np.flatnonzero(counts[1:]) + 1
            rank = np.zeros(len(counts), np.int32)
            rank[labels] = np.arange(1, len(labels) + 1)
            return cls(rank[image], labels, counts[labels])
        labels, ranks, counts = np.unique(image, return_inverse=True, return_counts=True)
        background = int(labels.size > 0 and labels[0] == 0)
        ranks = ranks.reshape(image.shape).astype(np.int32) + (1 - background)
        return cls(ranks, labels[background:], counts[background:])


@dataclass(frozen=True)
class _Contours:
    """The outer contours of all objects of an image. A contour pixel belongs to its object."""

    ranks: NDArray[np.int32]
    """(H, W): object 1..n whose contour runs through the pixel, 0 = none."""
    sizes: NDArray[np.intp]
    """(n,): number of contour pixels of each object."""
    boxes: list[tuple[slice, slice]]
    """Bounding box (rows, columns) of each object."""

    @classmethod
    def trace(cls, objects: _Objects) -> _Contours:
        edges = np.zeros_like(objects.ranks)
        boxes = ndimage.find_objects(objects.ranks)
        for rank, box in enumerate(boxes, start=1):
            mask = (objects.ranks[box] == rank).astype(np.uint8)
            outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            points = np.concatenate(outlines).reshape(-1, 2)
            edges[box][points[:, 1], points[:, 0]] = rank
        sizes = np.bincount(edges.ravel(), minlength=len(boxes) + 1)[1:]
        return cls(edges, sizes, boxes)

    def near(self, others: _Contours, reach: int) -> NDArray[np.intp]:
        """Count the pixels of each other contour within `reach` px of each contour, (n, others)."""
        offsets = np.arange(-reach, reach + 1)
        disk = (offsets[:, None] ** 2 + offsets**2 <= reach**2).astype(np.uint8)
        counts = np.zeros((len(self.boxes), len(others.boxes)), np.intp)
        for row, box in enumerate(self.boxes):
            wide = tuple(slice(max(side.start - reach, 0), side.stop + reach) for side in box)
            band = cv2.dilate((self.ranks[wide] == row + 1).astype(np.uint8), disk)
            inside = others.ranks[wide][band > 0]
            counts[row] = np.bincount(inside, minlength=len(others.boxes) + 1)[1:]
        return counts


def _common_pixels(true: _Objects, guess: _Objects) -> NDArray[np.intp]:
    """Count the common pixels of each pair of true object and segment, (objects, segments)."""
    rows, columns = len(true.sizes) + 1, len(guess.sizes) + 1
    both = true.ranks * np.intp(columns) + guess.ranks
    return np.bincount(both.ravel(), minlength=rows * columns).reshape(rows, columns)[1:, 1:]


def _rates(
    guess_hits: int,
    guess_sizes: NDArray[np.intp],
    true_hits: int,
    true_sizes: NDArray[np.intp],
    empty: float,
) -> tuple[float, float, float]:
    """Return precision, recall and their harmonic mean; all `empty` if a side has no object."""
    if not len(guess_sizes) or not len(true_sizes):
        return empty, empty, empty
    precision = guess_hits / int(guess_sizes.sum())
    recall = true_hits / int(true_sizes.sum())
    f = 2 * precision * recall / (precision + recall) if precision + recall > 0 else 0.0
    return precision, recall, f


def _shared_majority(common: NDArray[np.intp], sizes: NDArray[np.intp]) -> int:
    """Count the rows whose majority column is also that of an earlier row."""
    rows, columns = np.nonzero(2 * common > sizes[:, None])
    return len(rows) - len(np.unique(columns))
