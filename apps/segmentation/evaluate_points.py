"""Score the segmentation on frames annotated by points: `evaluate segmentation --points`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.perception import segment

from ..bench import machine_line, write_csv
from ..bench.experiment import result_table
from ..output_files import make_folder
from ..perceived_frame import load_kernels
from .point_frames import PointScore, Verdict, read_point_frames, score_points

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, SegmentationOptions

FRAMES_FILE = "frames.csv"
NOISE_M, NOISE_SHARE, NOISE_SEED = 0.001, 0.005, 0
"""The disturbance of the test of stability: this many metres on this share of the pixels."""
TOTAL = "total"
COLUMNS = (
    ("frame", "{name}"),
    ("objects", "{objects}"),
    ("right %", "{right_pct}"),
    *((verdict.replace("_", " "), f"{{{verdict}}}") for verdict in get_args(Verdict)),
    ("background", "{background}"),
    ("inside a segment", "{background_inside}"),
    ("surplus", "{surplus}"),
    ("self-agreement %", "{self_agreement_pct}"),
    ("ms", "{ms}"),
)
"""Heading and cell of each column of the table."""


def evaluate_points(folder: Path, options: SegmentationOptions, out: Path, *, json: bool) -> int:
    """Segment every annotated frame, print one row per frame, and write frames.csv.

    The self-agreement is the share of the pixels of either segmentation that keep their segment
    when ±1 mm is added to 0.5 % of the readings.
    """
    frames = read_point_frames(folder)
    make_folder(out)
    load_kernels()
    rows = []
    for frame in tracked(frames, "segmenting", len(frames)):
        found = segment(frame.frame, options)
        disturbed = segment(disturbed_frame(frame.frame), options).labels
        row = _row(frame.name, score_points(found.labels, frame))
        row["self_agreement_pct"] = round(100 * self_agreement(found.labels, disturbed), 1)
        row["ms"] = round(1e3 * sum(found.timings.values()), 1)
        rows.append(row)
    rows.append(_total(rows))
    show(result_table(rows, COLUMNS, title=f"{folder}, depth alone"), json_wanted=json)
    write_csv(out / FRAMES_FILE, rows)
    say(f"every frame: {out / FRAMES_FILE}")
    if json:
        print_json("evaluate_segmentation", NOISE_SEED, rows, machine=machine_line(), out=str(out))
    return 0


def disturbed_frame(frame: DepthFrame) -> DepthFrame:
    """Return a frame with ±1 mm on 0.5 % of its readings."""
    rng = np.random.default_rng(NOISE_SEED)
    depth = frame.depth.copy()
    hit = (depth > 0) & (rng.random(depth.shape) < NOISE_SHARE)
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


def _row(name: str, score: PointScore) -> dict[str, Any]:
    objects = len(score.verdicts)
    return {
        "name": name,
        "objects": objects,
        "right_pct": round(100 * score.count("right") / max(objects, 1), 1),
        **{verdict: score.count(verdict) for verdict in get_args(Verdict)},
        "background": score.background,
        "background_inside": score.background_inside,
        "surplus": score.surplus,
    }


def _total(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Sum the counts, and take the worst agreement and the median time."""
    total = {
        key: sum(row[key] for row in rows)
        for key in rows[0]
        if key not in ("name", "right_pct", "self_agreement_pct", "ms")
    }
    right = round(100 * total["right"] / max(total["objects"], 1), 1)
    first = {"name": TOTAL, "objects": total.pop("objects"), "right_pct": right}
    return {
        **first,
        **total,
        "self_agreement_pct": min(row["self_agreement_pct"] for row in rows),
        "ms": round(float(np.median([row["ms"] for row in rows])), 1),
    }
