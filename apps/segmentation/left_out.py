"""`evaluate segmentation --report left-out`: settings chosen without a source, scored on it.

For each source there are two choices without it. The first fits the log-odds of the join to the
labelled edges of the other sources. The second searches along each constant, log-odds and others:
each is scaled down and up, and the value with the best mean score of the other sources is taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.errors import InputError
from eyehand.perception import SegmentationOptions, segment

from ..bench import machine_line, write_csv
from ..bench.experiment import markdown_table, result_table
from ..output_files import write_text
from ..perceived_frame import load_kernels
from ..run_folder import claim_folder
from .kinds import JudgedFrame, KindFrame, KindOptions, open_kinds, score_by_kind
from .tuned_constants import JOIN, OTHERS, Constant, log_odds, replaced, stage_module

FACTORS = (0.75, 1.33)
"""Factors of each constant in the search."""
MIN_GAIN = 0.002
"""Minimum gain of the mean score for which a constant is changed, 0-1. Less is noise."""
TABLE_FILE, DOCUMENT_FILE = "left_out.csv", "left_out.md"
COLUMNS = (
    ("kind", "{name}"),
    ("left-out source", "{source}"),
    ("frames", "{frames}"),
    ("default %", "{default_pct:.1f}"),
    ("fitted without it %", "{fitted_pct:.1f}"),
    ("edges right %", "{edges_right_pct:.1f}"),
    ("searched without it %", "{searched_pct:.1f}"),
)
"""Heading and cell of each column of the table."""
CAPTION = (
    "default: settings chosen on all sources; fitted: log-odds fitted to the edges of the other "
    "sources; searched: constants chosen for the mean score of the other sources"
)

Setting = dict[Constant, float]

MIN_PURITY = 0.8
"""Minimum share of a patch's known pixels on one object. Other patches have no right answer."""
RIDGE = 0.002
"""Weight of the squared log-odds in the fit. It keeps those of rare evidence finite."""


@dataclass(frozen=True)
class _Data:
    """All frames, loaded once, and their edges."""

    frames: Sequence[KindFrame]
    judged: Sequence[JudgedFrame]
    edges: Sequence[LabelledEdges]

    @property
    def sources(self) -> list[str]:
        return list(dict.fromkeys(frame.source for frame in self.frames))

    def scores(
        self, setting: Mapping[Constant, float], only: str | None = None
    ) -> dict[str, float]:
        """Score all kinds, or those of one source, with a setting."""
        kept = [k for k, frame in enumerate(self.frames) if only in (None, frame.source)]
        with replaced(setting):
            found = [self.judged[k].judge(segment(self.judged[k].frame).labels) for k in kept]
        return score_by_kind([self.frames[k] for k in kept], found)

    def mean_without(self, shares: Mapping[str, float], source: str) -> float:
        """Return the mean over the other sources of the mean score of their kinds."""
        by_source: dict[str, list[float]] = {}
        for kind, own in {frame.kind: frame.source for frame in self.frames}.items():
            if own != source:
                by_source.setdefault(own, []).append(shares[kind])
        return float(np.mean([np.mean(values) for values in by_source.values()]))

    def fitted(self, source: str) -> tuple[Setting, float]:
        """Fit the log-odds without a source; return them and the share of its edges right."""
        by_source = {s: self._edges_of(s) for s in self.sources}
        odds = fit_log_odds([edges for s, edges in by_source.items() if s != source])
        return odds, edges_right(by_source[source], odds)

    def _edges_of(self, source: str) -> list[LabelledEdges]:
        pairs = zip(self.edges, self.frames, strict=True)
        return [edges for edges, frame in pairs if frame.source == source]


def evaluate_left_out(options: KindOptions, out: Path, *, json: bool) -> int:
    """Choose settings without each source, score it with them, and print one row per kind."""
    frames = open_kinds(options)
    sources = {frame.source for frame in frames}
    if len(sources) < 2:
        raise InputError(f"--report left-out needs at least two sources, got {', '.join(sources)}")
    claim_folder(out)
    load_kernels()
    judged = [frame.load() for frame in tracked(frames, "loading", len(frames))]
    data = _Data(frames, judged, [labelled_edges(one) for one in judged])
    default = data.scores({})
    tried = _search(data)
    rows: list[dict[str, Any]] = []
    for source in data.sources:
        odds, right = data.fitted(source)
        chosen = _choose(data, default, tried, source)
        say(f"without {source}: {_named(chosen) or 'default'}; fitted {_named(odds)}")
        fitted, searched = data.scores(odds, source), data.scores(chosen, source)
        for kind in searched:
            shares = (default[kind], fitted[kind], searched[kind], right)
            rows.append(_row(kind, source, frames, shares))
    rows.sort(key=lambda row: row["searched_pct"])
    show(result_table(rows, COLUMNS, caption=CAPTION, left=COLUMNS[1][:1]), json_wanted=json)
    write_csv(out / TABLE_FILE, rows)
    write_text(out / DOCUMENT_FILE, markdown_table(rows, COLUMNS))
    say(f"table: {out / TABLE_FILE}, {out / DOCUMENT_FILE}")
    if json:
        machine, folder = machine_line(), str(out)
        print_json(
            "evaluate_segmentation_left_out", options.seed, rows, machine=machine, out=folder
        )
    return 0


def _search(data: _Data) -> dict[Constant, list[tuple[float, dict[str, float]]]]:
    """Score each constant scaled by each factor: constant → (value, score of each kind)."""
    tried: dict[Constant, list[tuple[float, dict[str, float]]]] = {}
    constants = (*log_odds(), *OTHERS)
    for constant in tracked(constants, "searching", len(constants)):
        for factor in FACTORS:
            value = constant.scaled(factor)
            tried.setdefault(constant, []).append((value, data.scores({constant: value})))
    return tried


def _choose(
    data: _Data,
    default: Mapping[str, float],
    tried: Mapping[Constant, Sequence[tuple[float, dict[str, float]]]],
    source: str,
) -> Setting:
    """Return the changes that help the other sources, the largest gain first.

    Changes that help alone may not help together. A change stays if the mean rises further.
    """
    best = data.mean_without(default, source)
    gains = sorted(
        (
            (data.mean_without(shares, source) - best, constant, value)
            for constant, values in tried.items()
            for value, shares in values
        ),
        reverse=True,
    )
    chosen: Setting = {}
    for gain, constant, value in gains:
        if gain < MIN_GAIN or constant in chosen:
            continue
        together = best + gain
        if chosen:
            together = data.mean_without(data.scores({**chosen, constant: value}), source)
        if together >= best + MIN_GAIN:
            chosen[constant] = value
            best = together
    return chosen


def _named(setting: Mapping[Constant, float]) -> str:
    return ", ".join(f"{constant.name} {value:.3g}" for constant, value in setting.items())


def _row(
    kind: str, source: str, frames: Sequence[KindFrame], shares: tuple[float, ...]
) -> dict[str, Any]:
    default, fitted, searched, right = (round(100 * share, 2) for share in shares)
    return {
        "name": kind,
        "source": source,
        "frames": sum(frame.kind == kind for frame in frames),
        "default_pct": default,
        "fitted_pct": fitted,
        "edges_right_pct": right,
        "searched_pct": searched,
    }


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
