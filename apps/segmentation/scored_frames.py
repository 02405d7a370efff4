"""Segment labelled frames, score and time each, and average the figures by group."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.scenes import BACKGROUND_LEGEND, BackgroundKind
from eyehand.perception import DepthFrame, Segmentation, SegmentationOptions, segment
from eyehand.perception.io import naming

from ..bench.peak_memory import peak_megabytes
from ..perceived_frame import check_usable
from .dataset import FrameSource
from .score import SegmentationScore, score_segmentation
from .self_agreement import disturbed_frame, self_agreement

MEMORY_FRAMES = 2
"""Number of frames per group whose peak memory is measured. It hardly differs between frames."""
TOTAL = "total"
"""Name of the row over all groups."""


@dataclass(frozen=True)
class FrameResult:
    """The score, times and memory of one segmented frame."""

    source: FrameSource
    """Source of the frame."""
    score: SegmentationScore
    """Score of its segmentation."""
    seconds: float
    """Wall time of `segment`."""
    cpu_seconds: float
    """Processor time of `segment`, all threads. It depends less on other load."""
    agreement: float
    """Self-agreement after a small disturbance, 0-1, see :func:`.self_agreement`."""
    stages: dict[str, float]
    """Time of each stage, s."""
    peak_mb: float | None
    """Peak memory of `segment` without its input, MB; None where it was not measured."""
    assumed: tuple[str, ...]
    """Assumptions made when reading the frame, in words."""
    false_kinds: dict[BackgroundKind, int] | None = None
    """Number of false segments on each kind of background; None if the kinds are unknown."""


def run_trials(
    sources: Iterable[FrameSource],
    options: SegmentationOptions,
    *,
    ignore_invalid: bool = True,
    memory_frames: int = MEMORY_FRAMES,
) -> Iterator[FrameResult]:
    """Segment and score every frame. Call `load_kernels` first, or the first times include it.

    Parameters
    ----------
    sources
        The frames.
    options
        Options of the segmentation.
    ignore_invalid
        Leave pixels without a reading out of truth and prediction.
    memory_frames
        Number of frames per group whose peak memory is measured, in an extra run.

    Raises
    ------
    InputError
        If a frame cannot be read or segmented. The message names the frame.
    """
    measured: dict[str, int] = {}
    first = True
    for source in sources:
        with naming(source.name):
            labelled = source.load()
            if first:
                # These options may use kernels that are not compiled yet.
                segment(labelled.frame, options)
                first = False
            found, seconds, cpu_seconds = timed_segment(labelled.frame, options)
            check_usable(found.warnings, source.name)
            ignore = labelled.unscored(ignore_invalid=ignore_invalid)
            score = score_segmentation(found.labels, labelled.truth, ignore)
            kinds = None
            if labelled.background is not None:
                kinds = false_kinds(found.labels, labelled.truth, labelled.background, ignore)
            disturbed = segment(disturbed_frame(labelled.frame), options).labels
            agreement = self_agreement(found.labels, disturbed)
            peak = None
            if measured.get(source.group, 0) < memory_frames:
                measured[source.group] = measured.get(source.group, 0) + 1
                peak = peak_megabytes(lambda frame=labelled.frame: segment(frame, options))
        yield FrameResult(
            source,
            score,
            seconds,
            cpu_seconds,
            agreement,
            found.timings,
            peak,
            labelled.assumed,
            kinds,
        )


def timed_segment(
    frame: DepthFrame, options: SegmentationOptions
) -> tuple[Segmentation, float, float]:
    """Return the segmentation of a frame, its wall time and its processor time, s."""
    cpu, wall = time.process_time(), time.perf_counter()
    found = segment(frame, options)
    return found, time.perf_counter() - wall, time.process_time() - cpu


def summary_rows(results: Sequence[FrameResult]) -> list[dict[str, Any]]:
    """Return one row of figures per group, then one row of all frames if there are several groups.

    Percentages are means over frames, as in the literature. Counts are sums. The self-agreement is
    the lowest. Times are the median and the 90th percentile. Memory is the maximum.
    """
    groups = list(dict.fromkeys(result.source.group for result in results))
    rows = [
        _row(group, [result for result in results if result.source.group == group])
        for group in groups
    ]
    return [*rows, _row(TOTAL, results)] if len(groups) > 1 else rows


def frame_row(result: FrameResult) -> dict[str, Any]:
    """Return all figures of one frame, for the table of frames."""
    row: dict[str, Any] = {"group": result.source.group, "name": result.source.name}
    row |= _row(result.source.name, [result])
    for key in ("frames", "median_ms", "p90_ms", "median_cpu_ms", "peak_mb"):
        del row[key]
    row["segments"] = result.score.predicted_count
    row["ms"] = round(1e3 * result.seconds, 2)
    row["cpu_ms"] = round(1e3 * result.cpu_seconds, 2)
    row["peak_mb"] = None if result.peak_mb is None else round(result.peak_mb, 1)
    return row | {f"{stage}_ms": round(1e3 * s, 2) for stage, s in result.stages.items()}


def _row(name: str, results: Sequence[FrameResult]) -> dict[str, Any]:
    scores = [result.score for result in results]
    milliseconds = [1e3 * result.seconds for result in results]
    peaks = [result.peak_mb for result in results if result.peak_mb is not None]
    return {
        "name": name,
        "frames": len(results),
        "objects": sum(score.truth_count for score in scores),
        "overlap_precision_pct": _percent(score.precision for score in scores),
        "overlap_recall_pct": _percent(score.recall for score in scores),
        "overlap_f_pct": _percent(score.f for score in scores),
        "boundary_precision_pct": _percent(score.boundary_precision for score in scores),
        "boundary_recall_pct": _percent(score.boundary_recall for score in scores),
        "boundary_f_pct": _percent(score.boundary_f for score in scores),
        "found_pct": _percent(score.found for score in scores),
        "over": sum(score.over for score in scores),
        "under": sum(score.under for score in scores),
        "missed": sum(score.missed for score in scores),
        "false": sum(score.false for score in scores),
        **_false_counts(results),
        "self_agreement_pct": round(100 * min(result.agreement for result in results), 2),
        "median_ms": round(float(np.median(milliseconds)), 2),
        "p90_ms": round(float(np.percentile(milliseconds, 90)), 2),
        "median_cpu_ms": round(float(np.median([1e3 * r.cpu_seconds for r in results])), 2),
        "peak_mb": round(max(peaks), 1) if peaks else None,
    }


def _false_counts(results: Sequence[FrameResult]) -> dict[str, int]:
    """Sum the false segments on each kind of background over the frames whose kinds are known."""
    counts = {f"false_on_{kind}": 0 for kind in BACKGROUND_LEGEND.values()}
    for result in results:
        for kind, count in (result.false_kinds or {}).items():
            counts[f"false_on_{kind}"] += count
    return counts


def _percent(shares: Iterable[float]) -> float:
    return round(100 * float(np.mean(list(shares))), 2)


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
