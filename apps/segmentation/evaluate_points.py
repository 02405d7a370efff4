"""Score the segmentation on frames annotated by points: `evaluate segmentation --points`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.perception import Segmentation, SegmentationOptions, segment

from ..bench import machine_line, write_csv
from ..bench.experiment import markdown_table, result_table
from ..output_files import write_text
from ..perceived_frame import check_usable, load_kernels
from ..run_folder import claim_folder
from .moved_copies import moved_copies
from .point_frames import PointFrame, Verdict, frames_by_camera, read_point_frames, score_points
from .self_agreement import NOISE_SEED, disturbed_frame, self_agreement

FRAMES_FILE, TOTALS_FILE = "frames.csv", "totals.md"
TOTAL, DEPTH, COLOUR = "total", "depth", "colour"
COPIES = 5
"""Number of disturbed copies of a frame, besides the moved ones. On one copy all frames together
vary by up to 9 of 128 objects, which is more than most settings differ."""
COUNTS = (
    "objects",
    "right_copies",
    "unsaid",
    "false_alarms",
    *get_args(Verdict),
    "background",
    "background_inside",
    "surplus",
)
AGREEMENTS = ("self_agreement_pct", "moved_agreement_pct")
COLUMNS = (
    ("frame", "{name}"),
    ("input", "{input}"),
    ("objects", "{objects}"),
    ("right %", "{right_pct}"),
    ("right", "{right}"),
    ("right, copies", "{right_copies:.1f}"),
    ("unsaid", "{unsaid:.1f}"),
    ("false alarms", "{false_alarms:.1f}"),
    ("missed", "{missed}"),
    ("split", "{split}"),
    ("merged", "{merged}"),
    ("on backgr.", "{on_background}"),
    ("backgr. points inside", "{background_inside}/{background}"),
    ("surplus", "{surplus}"),
    ("agree %", "{self_agreement_pct}"),
    ("agree, moved %", "{moved_agreement_pct}"),
    ("ms", "{ms}"),
)
"""Heading and cell of each column of the table."""


def evaluate_points(folder: Path, options: SegmentationOptions, out: Path, *, json: bool) -> int:
    """Segment every annotated frame, print one row per frame, and write frames.csv.

    Frames with a colour image are segmented twice: from depth alone, and with colour. The last rows
    are the totals of each camera and of all frames. Each frame is also segmented in 5 copies with
    ±1 mm on 0.5 % of the readings, in 3 mirrored ones, and in 3 without the first row or columns.
    These 11 copies and the frame itself give the mean numbers of right objects, of wrong ones that
    no warning names, and of right ones that a warning names. The self-agreement is the share of
    the pixels of either segmentation that keep their segment, in the worst disturbed and in the
    worst moved copy.
    """
    frames = read_point_frames(folder)
    claim_folder(out)
    load_kernels()
    rows = [
        _row(frame, colour, options)
        for frame in tracked(frames, "segmenting", len(frames))
        for colour in ((False, True) if frame.colour is not None else (False,))
    ]
    rows.sort(key=lambda row: row["input"] == COLOUR)
    rows += _totals(rows, frames)
    show(result_table(rows, COLUMNS, title=str(folder), left=("input",)), json_wanted=json)
    write_csv(out / FRAMES_FILE, rows)
    totals = [row for row in rows if row["name"] not in {frame.name for frame in frames}]
    write_text(out / TOTALS_FILE, markdown_table(totals, COLUMNS))
    say(f"every frame: {out / FRAMES_FILE}, totals: {out / TOTALS_FILE}")
    if json:
        print_json("evaluate_segmentation", NOISE_SEED, rows, machine=machine_line(), out=str(out))
    return 0


def _row(annotated: PointFrame, colour: bool, options: SegmentationOptions) -> dict[str, Any]:
    frame = replace(annotated.frame, colour=annotated.colour if colour else None)
    found = segment(frame, options)
    check_usable(found.warnings, annotated.name)
    seeds = range(NOISE_SEED, NOISE_SEED + COPIES)
    disturbed = [segment(disturbed_frame(frame, seed=seed), options) for seed in seeds]
    moved = [
        (segmented := segment(one.frame, options), one.restore(segmented.labels))
        for one in moved_copies(frame)
    ]
    copies = [(one, one.labels) for one in (found, *disturbed)] + moved
    scores = [score_points(labels, annotated, _named(one)) for one, labels in copies]
    score = scores[0]
    objects = len(score.verdicts)
    return {
        "name": annotated.name,
        "input": COLOUR if colour else DEPTH,
        "objects": objects,
        "right_pct": round(100 * score.count("right") / max(objects, 1), 1),
        **{verdict: score.count(verdict) for verdict in get_args(Verdict)},
        "right_copies": float(np.mean([one.count("right") for one in scores])),
        "unsaid": float(np.mean([one.unsaid for one in scores])),
        "false_alarms": float(np.mean([one.false_alarms for one in scores])),
        "background": score.background,
        "background_inside": score.background_inside,
        "surplus": score.surplus,
        "self_agreement_pct": _worst_agreement(found.labels, [one.labels for one in disturbed]),
        "moved_agreement_pct": _worst_agreement(found.labels, [labels for _, labels in moved]),
        "ms": round(1e3 * sum(found.timings.values()), 1),
    }


def _named(found: Segmentation) -> set[int]:
    """Return the labels that warnings name."""
    return {warning.label for warning in found.warnings if warning.label is not None}


def _worst_agreement(labels: NDArray[np.int32], copies: Sequence[NDArray[np.int32]]) -> float:
    return round(100 * min(self_agreement(labels, copy) for copy in copies), 1)


def _totals(rows: list[dict[str, Any]], frames: Sequence[PointFrame]) -> list[dict[str, Any]]:
    """Return the totals of each camera and of all frames, for each input."""
    groups = {kind: {frame.name for frame in own} for kind, own in frames_by_camera(frames).items()}
    groups = {**groups, TOTAL: {frame.name for frame in frames}}
    totals = []
    for used in (DEPTH, COLOUR):
        for name, members in groups.items():
            own = [row for row in rows if row["input"] == used and row["name"] in members]
            if own:
                totals.append(_total(name, own))
    return totals


def _total(name: str, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Sum the counts, and take the lowest agreements and the median time."""
    total = {key: sum(row[key] for row in rows) for key in COUNTS}
    return {
        **rows[0],
        **total,
        "name": name,
        "right_pct": round(100 * total["right"] / max(total["objects"], 1), 1),
        **{key: min(row[key] for row in rows) for key in AGREEMENTS},
        "ms": round(float(np.median([row["ms"] for row in rows])), 1),
    }
