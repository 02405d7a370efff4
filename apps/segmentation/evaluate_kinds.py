"""`evaluate segmentation --report kinds`: score all kinds of development data, worst first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.perception import SegmentationOptions

from ..bench import machine_line, write_csv
from ..bench.experiment import markdown_table, result_table
from ..output_files import write_text
from ..perceived_frame import load_kernels
from ..run_folder import claim_folder
from .kinds import KindFrame, KindOptions, Score, open_kinds, score_by_kind, worst_kinds_mean
from .scored_frames import timed_segment
from .self_agreement import disturbed_frame, self_agreement

KINDS_FILE, FRAMES_FILE, TABLE_FILE = "kinds.csv", "frames.csv", "kinds.md"
WORST, MEAN = "mean of the three worst", "mean of all kinds"
COLUMNS = (
    ("kind", "{name}"),
    ("source", "{source}"),
    ("frames", "{frames}"),
    ("score %", "{score_pct:.1f}"),
    ("self-agreement %", "{self_agreement_pct:.1f}"),
    ("ms", "{median_ms:.1f}"),
)
"""Heading and cell of each column of the table."""
CAPTION = (
    "score: mean overlap F of labelled frames, share of right objects of annotated frames; "
    "self-agreement: lowest of all frames"
)


def evaluate_kinds(
    data: KindOptions, options: SegmentationOptions, out: Path, *, json: bool
) -> int:
    """Segment all frames, and print one row per kind, worst kind first."""
    frames = open_kinds(data)
    claim_folder(out)
    load_kernels()
    scores: list[Score] = []
    rows: list[dict[str, Any]] = []
    for frame in tracked(frames, "segmenting", len(frames)):
        judged = frame.load()
        found, seconds, _ = timed_segment(judged.frame, options)
        disturbed, _, _ = timed_segment(disturbed_frame(judged.frame), options)
        scores.append(judged.judge(found.labels))
        rows.append(_frame_row(frame, scores[-1], seconds))
        rows[-1]["self_agreement_pct"] = _percent(self_agreement(found.labels, disturbed.labels))
    kinds = _kind_rows(frames, scores, rows)
    show(result_table(kinds, COLUMNS, caption=CAPTION, left=("source",)), json_wanted=json)
    write_csv(out / KINDS_FILE, kinds)
    write_csv(out / FRAMES_FILE, rows)
    write_text(out / TABLE_FILE, markdown_table(kinds, COLUMNS))
    say(f"every frame: {out / FRAMES_FILE}, every kind: {out / KINDS_FILE}, {out / TABLE_FILE}")
    if json:
        machine, folder = machine_line(), str(out)
        print_json(
            "evaluate_segmentation_kinds",
            data.seed,
            kinds,
            options=asdict(options),
            machine=machine,
            out=folder,
        )
    return 0


def _frame_row(frame: KindFrame, score: Score, seconds: float) -> dict[str, Any]:
    return {
        "kind": frame.kind,
        "name": frame.name,
        "right": round(score.right, 4),
        "total": score.total,
        "ms": round(1e3 * seconds, 2),
    }


def _kind_rows(
    frames: Sequence[KindFrame], scores: Sequence[Score], rows: Sequence[dict[str, Any]]
) -> list[dict[str, Any]]:
    """Return one row per kind, worst first, then the means over kinds."""
    shares = score_by_kind(frames, scores)
    sources = {frame.kind: frame.source for frame in frames}
    kinds = []
    for kind, share in shares.items():
        own = [row for row in rows if row["kind"] == kind]
        kinds.append(
            {
                "name": kind,
                "source": sources[kind],
                "frames": len(own),
                "score_pct": _percent(share),
                "self_agreement_pct": min(row["self_agreement_pct"] for row in own),
                "median_ms": round(float(np.median([row["ms"] for row in own])), 2),
            }
        )
    means = {WORST: worst_kinds_mean(shares), MEAN: float(np.mean(list(shares.values())))}
    for name, share in means.items():
        kinds.append(
            {"name": name, "source": "", "frames": len(rows), "score_pct": _percent(share)}
        )
    return kinds


def _percent(share: float) -> float:
    return round(100 * share, 2)
