"""`eyehand evaluate segmentation`: score the segmentation on labelled or synthetic frames."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from rich.table import Table

from eyehand.apps.console import print_json, say, show, tracked, wide_table
from eyehand.errors import InputError
from eyehand.perception import SegmentationOptions, segment

from ..bench import machine_line, write_csv
from ..output_files import make_folder
from ..perceived_frame import load_kernels
from ..run_folder import claim_folder
from .dataset import Coding, DatasetOptions, FrameSource, open_dataset
from .evaluate_kinds import evaluate_kinds
from .evaluate_points import evaluate_points
from .kinds import KindOptions
from .left_out import evaluate_left_out
from .pictures import ScoredFrame, verdict, write_frame_picture, write_sheet
from .scored_frames import TOTAL, FrameResult, frame_row, run_trials, summary_rows
from .synthetic_frames import FurnishedContents, synthetic_sources

SYNTHETIC = "synthetic"
"""Value of --dataset for synthetic frames."""
SYNTHETIC_FRAMES = 10
"""Default number of scenes per family."""
FLAWED_F = 0.9
"""Frames with an overlap F below this are reported one by one."""
MAX_LINES = 30
"""Maximum number of frames reported on the terminal. The CSV file holds all."""
FRAMES_FILE, WORST_FILE, WORST_FOLDER = "frames.csv", "worst.png", "worst"
COLUMNS = {
    "name": "group",
    "frames": "frames",
    "objects": "objects",
    "overlap_precision_pct": "P",
    "overlap_recall_pct": "R",
    "overlap_f_pct": "F",
    "boundary_precision_pct": "bP",
    "boundary_recall_pct": "bR",
    "boundary_f_pct": "bF",
    "found_pct": "%75",
    "over": "over",
    "under": "under",
    "missed": "missed",
    "false": "false",
    "self_agreement_pct": "agree",
    "median_ms": "ms",
    "p90_ms": "p90",
    "peak_mb": "MB",
}
"""Key of a row → heading of its table column."""
CAPTION = (
    "P R F: precision, recall and F of the overlap, bP bR bF: of the boundaries, %75: objects with "
    "F > 75 %, all in % and means over frames; over, under: extra segments of split objects, "
    "extra objects in merged segments; missed, false: objects; agree: lowest share of pixels that "
    "keep their object after ±1 mm on 0.5 % of the readings; ms: wall time, median"
)


def evaluate_segmentation(
    *,
    report: Literal["groups", "kinds", "left-out"] = "groups",
    dataset: str = SYNTHETIC,
    points: Path | None = None,
    labels: Coding = "plain",
    camera: Path | None = None,
    depth_scale_mm: float | None = None,
    frames: int | None = None,
    seed: int = 0,
    groups: list[str] | None = None,
    noise: list[str] | None = None,
    ignore_invalid: bool = True,
    worst: int = 6,
    out: Path = Path("out/evaluate_segmentation"),
    json: bool = False,
    contents: Annotated[
        FurnishedContents | None, Parameter(name="*", group="Synthetic scenes with furniture")
    ] = None,
    options: Annotated[
        SegmentationOptions | None, Parameter(name="*", group="Segmentation options")
    ] = None,
) -> int:
    """Score the segmentation against known truth: overlap, boundaries, mistakes, time, memory.

    Prints a table by group. Writes frames.csv, a picture of each of the worst frames, and
    worst.png with all of them.

    Parameters
    ----------
    report
        groups: all figures of one data set by group. kinds: one score for each kind of data, worst
        kind first: the synthetic families, --dataset and --points together. left-out: for each
        source the score with settings chosen without it; takes about 10 minutes with 4 --frames.
    dataset
        Folder of .npz files with `depth` and `label`, or of folders from eyehand synth; or the
        word synthetic.
    points
        Folder of frames annotated by points, one folder per frame with depth.png, camera.json and
        points.json. It takes the place of --dataset for groups, and reports the share of objects
        whose points all carry one label of their own.
    labels
        Coding of the labels in .npz files: plain (object numbers) or osd (Object Segmentation
        Database: object number times ten).
    camera
        Camera file of the frames. Default: the camera in the files, or a camera file beside them.
    depth_scale_mm
        Millimetres per unit of integer depth in .npz files. Default: the unit in the files, or in
        a camera file beside them.
    frames
        Number of frames per group, spread evenly. Default: all of a folder, 10 synthetic ones.
    seed
        First seed of synthetic scenes.
    groups
        Groups to keep: their names in the table, or the part before the slash.
    noise
        Depth noises of synthetic frames: none, realistic, realistic*2 (twice as strong), 1.5mm
        (standard deviation at 1 m), or the camera models kinect-v1, stereo, structured-light, oak.
        Default: those named in --groups, else none realistic 1mm 2mm 3mm.
    ignore_invalid
        Leave pixels without a depth reading out of truth and prediction.
    worst
        Number of frames with the lowest overlap F to draw.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    contents
        What stands in synthetic scenes with furniture.
    options
        Options of the segmentation.
    """
    options = options or SegmentationOptions()
    if worst < 0:
        raise InputError(f"--worst must be >= 0, got {worst}")
    if report != "groups":
        folder = None if dataset == SYNTHETIC else Path(dataset)
        data = KindOptions(folder, labels, points, tuple(groups or ()), frames, seed)
        if report == "left-out":
            return evaluate_left_out(data, out, json=json)
        return evaluate_kinds(data, options, out, json=json)
    if points is not None:
        return evaluate_points(points, options, out, json=json)
    synthetic = dataset == SYNTHETIC
    if synthetic:
        sources = _synthetic(groups, noise, frames, seed, contents)
    else:
        reading = DatasetOptions(camera=camera, depth_scale_mm=depth_scale_mm, labels=labels)
        sources = _spread(_select_groups(open_dataset(Path(dataset), reading), groups), frames)
    claim_folder(out)
    load_kernels()
    results = _run(sources, options, ignore_invalid)
    rows = summary_rows(results)
    title = f"synthetic frames, seeds from {seed}" if synthetic else dataset
    show(_table(rows, title), json_wanted=json)
    _say_false(rows)
    _say_flawed(results)
    write_csv(out / FRAMES_FILE, [frame_row(result) for result in results])
    say(f"every frame: {out / FRAMES_FILE}")
    if worst:
        _write_worst(out, sorted(results, key=_badness)[:worst], options, ignore_invalid)
    if json:
        print_json(
            "evaluate_segmentation",
            seed if synthetic else None,
            rows,
            dataset=dataset,
            ignore_invalid=ignore_invalid,
            options=asdict(options),
            machine=machine_line(),
            out=str(out),
        )
    return 0


def _synthetic(
    groups: list[str] | None,
    noise: list[str] | None,
    frames: int | None,
    seed: int,
    contents: FurnishedContents | None,
) -> list[FrameSource]:
    families = None if groups is None else list(dict.fromkeys(g.split("/")[0] for g in groups))
    if groups is not None and noise is None and all("/" in group for group in groups):
        noise = list(dict.fromkeys(group.partition("/")[2] for group in groups))
    count = SYNTHETIC_FRAMES if frames is None else frames
    sources = synthetic_sources(families, noise, frames=count, seed=seed, contents=contents)
    return _select_groups(sources, groups)


def _select_groups(sources: list[FrameSource], groups: list[str] | None) -> list[FrameSource]:
    if groups is None:
        return sources
    names = dict.fromkeys(source.group for source in sources)
    for wanted in groups:
        if not any(_belongs(name, wanted) for name in names):
            raise InputError(f"--groups {wanted}: no such group, expected {', '.join(names)}")
    return [s for s in sources if any(_belongs(s.group, wanted) for wanted in groups)]


def _belongs(group: str, wanted: str) -> bool:
    return group == wanted or group.startswith(f"{wanted}/")


def _spread(sources: list[FrameSource], frames: int | None) -> list[FrameSource]:
    """Select `frames` of each group, evenly spread."""
    if frames is None:
        return sources
    if frames < 1:
        raise InputError(f"--frames must be >= 1, got {frames}")
    chosen = []
    for group in dict.fromkeys(source.group for source in sources):
        members = [source for source in sources if source.group == group]
        places = np.linspace(0, len(members) - 1, min(frames, len(members))).round().astype(int)
        chosen += [members[place] for place in places]
    return chosen


def _run(
    sources: list[FrameSource], options: SegmentationOptions, ignore_invalid: bool
) -> list[FrameResult]:
    results: list[FrameResult] = []
    reported: set[str] = set()
    trials = run_trials(sources, options, ignore_invalid=ignore_invalid)
    for result in tracked(trials, "segmenting", len(sources)):
        for note in result.assumed:
            if note not in reported:
                reported.add(note)
                say(note)
        results.append(result)
    return results


def _badness(result: FrameResult) -> tuple[float, float]:
    return result.score.f, result.score.boundary_f


def _say_flawed(results: Sequence[FrameResult]) -> None:
    flawed = sorted((r for r in results if r.score.f < FLAWED_F), key=_badness)
    for result in flawed[:MAX_LINES]:
        say(f"{result.source.name}: {verdict(result.score)}")
    if len(flawed) > MAX_LINES:
        say(f"... and {len(flawed) - MAX_LINES} more below F {100 * FLAWED_F:g} %")


def _say_false(rows: list[dict[str, Any]]) -> None:
    """Say on which kinds of background the false objects of each group lie."""
    for row in rows:
        kinds = {
            key.removeprefix("false_on_"): count
            for key, count in row.items()
            if key.startswith("false_on_") and count
        }
        if kinds and row["name"] != TOTAL:
            listed = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
            say(f"{row['name']}: false objects on {listed}")


def _write_worst(
    out: Path, results: Sequence[FrameResult], options: SegmentationOptions, ignore_invalid: bool
) -> None:
    """Write the sheet and a picture per frame. Pictures of an earlier run are removed."""
    folder = out / WORST_FOLDER
    make_folder(folder)
    for old in folder.glob("*.png"):
        old.unlink()
    shown = []
    for rank, result in enumerate(results, start=1):
        # To save memory, frames are not kept. Loading and segmenting again gives the same result.
        labelled = result.source.load()
        labels = segment(labelled.frame, options).labels
        counted = ~labelled.unscored(ignore_invalid=ignore_invalid)
        truth, labels = np.where(counted, labelled.truth, 0), np.where(counted, labels, 0)
        item = ScoredFrame(result.source.name, labelled.frame, truth, labels, result.score)
        shown.append(item)
        name = re.sub(r"[^\w.-]+", "_", result.source.name)
        write_frame_picture(folder / f"{rank:02d}_{name}.png", item)
    write_sheet(out / WORST_FILE, shown)
    say(f"the {len(shown)} worst: {out / WORST_FILE}, one by one in {folder}")


def _table(rows: list[dict[str, Any]], title: str) -> Table:
    table = wide_table(title, COLUMNS.values(), left=(COLUMNS["name"],), caption=CAPTION)
    for row in rows:
        if row is rows[-1] and len(rows) > 1:
            table.add_section()
        table.add_row(*(_cell(row[key], key) for key in COLUMNS))
    return table


def _cell(value: Any, key: str) -> str:
    if value is None:
        return "-"
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if key == "peak_mb" else f"{value:.1f}"
