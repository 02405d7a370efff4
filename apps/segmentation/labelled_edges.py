"""Edges between patches with known answers, and log-odds that are fitted to them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from eyehand.perception import SegmentationOptions, segment

from .tuned_constants import JOIN, Constant, log_odds, replaced, stage_module

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .kinds import JudgedFrame

MIN_PURITY = 0.8
"""Minimum share of a patch's known pixels on one object. Other patches have no right answer."""
RIDGE = 0.002
"""Weight of the squared log-odds in the fit. It keeps those of rare evidence finite."""


class LabelledEdges(NamedTuple):
    """Edges between patches that lie on known objects."""

    evidence: NDArray[np.float64]
    """(K, W): factor of each constant of `log_odds` in the weight of each edge."""
    same: NDArray[np.bool_]
    """(K,) whether both patches are one object."""


def labelled_edges(judged: JudgedFrame) -> LabelledEdges:
    """Segment a frame and return the edges of its patches whose answers are known."""
    calls: list[tuple[Any, ...]] = []
    join = stage_module(JOIN)
    measure = join.patch_edges

    def record(patches: Any, image: Any, *rest: Any, **options: Any) -> Any:
        edges = measure(patches, image, *rest, **options)
        calls.append((patches, image, edges))
        return edges

    join.patch_edges = record
    try:
        segment(judged.frame, SegmentationOptions())
    finally:
        join.patch_edges = measure
    weights = log_odds()
    if not calls:
        return LabelledEdges(np.zeros((0, len(weights))), np.zeros(0, bool))
    patches, image, edges = calls[0]
    top = round(judged.frame.intrinsics.cy - image.intrinsics.cy)
    left = round(judged.frame.intrinsics.cx - image.intrinsics.cx)
    rows, columns = patches.shape
    owner = _owners(patches, judged.truth[top : top + rows, left : left + columns])
    first, second = owner[edges.pairs[:, 0]], owner[edges.pairs[:, 1]]
    known = (first > 0) & (second > 0)
    return LabelledEdges(_evidence(edges, weights)[known], (first == second)[known])


def fit_log_odds(sources: Sequence[Sequence[LabelledEdges]]) -> dict[Constant, float]:
    """Fit the log-odds by logistic regression. All sources and both answers weigh the same."""
    evidence, same, weight = [], [], []
    for source in sources:
        answers = np.concatenate([edges.same for edges in source])
        for answer in (False, True):
            if not np.any(answers == answer):
                continue
            rows = np.concatenate([edges.evidence[edges.same == answer] for edges in source])
            evidence.append(rows)
            same.append(np.full(len(rows), answer))
            weight.append(np.full(len(rows), 1.0 / len(rows)))
    x, share = np.concatenate(evidence), np.concatenate(weight)
    sign = np.where(np.concatenate(same), 1.0, -1.0)
    share /= share.sum()

    def loss(odds: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        margin = sign * (x @ odds)
        ridge = np.concatenate([[0.0], odds[1:]])
        gradient = -(share * sign / (1.0 + np.exp(np.minimum(margin, 500.0)))) @ x
        cost = share @ np.logaddexp(0.0, -margin) + 0.5 * RIDGE * ridge @ ridge
        return float(cost), gradient + RIDGE * ridge

    found = minimize(loss, np.zeros(x.shape[1]), jac=True)
    return dict(zip(log_odds(), found.x.tolist(), strict=True))


def edges_right(edges: Sequence[LabelledEdges], odds: dict[Constant, float]) -> float:
    """Return the share of edges that log-odds decide right, mean of both answers, 0-1."""
    same = np.concatenate([one.same for one in edges])
    joined = np.concatenate([one.evidence for one in edges]) @ list(odds.values()) > 0
    shares = [np.mean(joined[same == answer] == answer) for answer in np.unique(same)]
    return float(np.mean(shares)) if shares else 1.0


def _evidence(edges: Any, weights: Sequence[Constant]) -> NDArray[np.float64]:
    """Return the factors (K, W) of the log-odds: the weights of edges are linear in them."""
    columns = []
    for one in weights:
        with replaced({other: float(other == one) for other in weights}):
            columns.append(stage_module(JOIN).edge_weights(edges))
    return np.column_stack(columns)


def _owners(patches: NDArray[np.int32], truth: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the object of each patch (n + 1,); 0 where it is unknown, mixed or none."""
    known = truth != 0
    pairs = patches[known].astype(np.int64), truth[known].astype(np.int64) + 1
    counts = np.zeros((int(patches.max(initial=0)) + 1, int(truth.max(initial=0)) + 2), np.int64)
    np.add.at(counts, pairs, 1)
    best = counts.argmax(axis=1)
    pure = counts.max(axis=1) >= np.maximum(MIN_PURITY * counts.sum(axis=1), 1)
    return np.where(pure, best - 1, 0)
