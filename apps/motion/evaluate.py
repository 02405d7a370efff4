"""`eyehand evaluate motion`: reaching in clutter by the control basis and by a baseline."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich import box
from rich.table import Table

from eyehand.data_synth.scenes import MAX_BOXES
from eyehand.errors import InputError

from ..bench import Provenance, core_count, machine_line, write_chart, write_csv
from ..console import print_json, say, show, tracked
from ..output_files import make_folder
from .cycle_comparison import PAIRS, cycle_rows
from .reach_chart import bench_chart
from .reach_methods import BASELINE, METHODS, PLANNED
from .reach_outcome import ReachOptions
from .reach_run import ReachRecord, run_scene
from .reach_summary import summary_row

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

QUICK_SCENES = 4
MAX_PROCESSES = 2
"""Scenes run side by side; each process takes about 300 MB."""
BATCH = 4
"""Scenes handed to a process at a time."""
TIMED_SCENES = 6
"""Scenes in which cycles are timed, with nothing running beside them."""
TAKES = 3
"""Times that each of them is run: the motion is the same, and a cycle's fastest counts."""
QUICK_POSTURES = 2
"""At which a single cycle is timed."""


class _Job(NamedTuple):
    method: str
    seed: int
    boxes: int
    reach: ReachOptions


def evaluate_motion(
    *,
    scenes: int = 200,
    seed: int = 0,
    boxes: int = 5,
    longest: float = ReachOptions.longest,
    only: list[str] | None = None,
    baseline: bool = True,
    quick: bool = False,
    out: Path = Path("out/evaluate_motion"),
    json: bool = False,
) -> int:
    """Run cluttered reaching scenes and print who reaches, who touches, who gets stuck.

    A 7-joint arm reaches for points among boxes, step by step, under a judge with a model of its
    own. Writes bench.png, bench.csv with the figures behind it, and scenes.csv with a row for
    every scene and method. Scene k follows from seed + k alone.

    Parameters
    ----------
    scenes
        How many scenes.
    seed
        First seed.
    boxes
        Boxes in each, 0 to 12.
    longest
        Simulated time after which a reach is given up, s.
    only
        Run this method alone; can be given several times.
    baseline
        Whether mink runs the same scenes.
    quick
        Four scenes: a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout; tables go to stderr.
    """
    if scenes < 1:
        raise InputError(f"--scenes must be >= 1, got {scenes}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if not 0 <= boxes <= MAX_BOXES:
        raise InputError(f"--boxes must be from 0 to {MAX_BOXES}, got {boxes}")
    reach = ReachOptions(longest=longest)
    methods = _chosen(only, baseline=baseline)
    scenes = min(scenes, QUICK_SCENES) if quick else scenes
    make_folder(out)
    seeds = range(seed, seed + scenes)
    jobs = [_Job(method, one, boxes, reach) for method in methods for one in seeds]
    records = _run(jobs, processes=1 if quick else MAX_PROCESSES)
    cycles_us = _timed(
        [job for job in jobs if job.seed in seeds[:TIMED_SCENES]], takes=1 if quick else TAKES
    )
    rows = [
        summary_row(
            method,
            [record for record in records if record.method == method],
            cycles_us[method],
        )
        for method in methods
    ]
    say(f"timing one cycle with {PAIRS} distance pairs")
    cycles = (
        cycle_rows(seed, baseline=BASELINE in methods, rounds=1, postures=QUICK_POSTURES)
        if quick
        else cycle_rows(seed, baseline=BASELINE in methods)
    )
    write_csv(out / "scenes.csv", [record.row() for record in records])
    made = Provenance(f"7-joint arm among {boxes} boxes, 5 ms cycles", seed, scenes, "scene")
    write_chart(bench_chart(rows, made), out / "bench.png", [*rows, *cycles])
    show(_table(rows, seeds, boxes, longest), json_wanted=json)
    show(_cycle_table(cycles), json_wanted=json)
    say(f"every scene: {out / 'scenes.csv'}; chart: {out / 'bench.png'}")
    if json:
        print_json(
            "evaluate_motion",
            seed,
            [*rows, *cycles],
            scenes=scenes,
            boxes=boxes,
            longest_s=longest,
            machine=machine_line(),
            out=str(out),
        )
    return 0


def _chosen(only: list[str] | None, *, baseline: bool) -> list[str]:
    for name in only or []:
        if name not in METHODS:
            raise InputError(f"unknown method {name!r}; choose from: {', '.join(METHODS)}")
    chosen = [
        name for name in METHODS if name in (only or METHODS) and (baseline or name != BASELINE)
    ]
    if not chosen:
        raise InputError(f"--no-baseline leaves nothing of {', '.join(only or [])}")
    return chosen


def _run(jobs: Sequence[_Job], *, processes: int) -> list[ReachRecord]:
    """Run all scenes: side by side, but for searches, whose limit is time: these run alone."""
    plain = [job for job in jobs if job.method != PLANNED]
    alone = [job for job in jobs if job.method == PLANNED]
    records = list(tracked(_records(plain, processes), "reaching", len(plain)))
    return records + list(tracked(_records(alone, 1), "reaching with searches", len(alone)))


def _records(jobs: Sequence[_Job], processes: int) -> Iterator[ReachRecord]:
    processes = min(processes, core_count())
    if processes < 2 or len(jobs) < 2 * BATCH:
        yield from map(_record, jobs)
        return
    # A forked process would inherit the locks of this one's threads.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from pool.map(_record, jobs, chunksize=BATCH)


def _record(job: _Job) -> ReachRecord:
    return run_scene(job.method, job.seed, job.boxes, job.reach)


def _timed(jobs: Sequence[_Job], *, takes: int) -> dict[str, NDArray[np.float64]]:
    """Run a few scenes again, one method after the other; times of all cycles by method, µs."""
    times: dict[str, list[NDArray[np.float64]]] = {job.method: [] for job in jobs}
    turns = sorted(jobs, key=lambda job: job.seed)
    for job in tracked(turns, "timing cycles", len(turns)):
        runs = [_record(job).cycle_times_us for _ in range(takes)]
        # A search that runs out of time may find another way, of another length.
        shared = min(map(len, runs))
        times[job.method].append(np.min([run[:shared] for run in runs], axis=0))
    return {method: np.concatenate(taken) for method, taken in times.items()}


_COLUMNS = {
    "success_pct": ("success", 1),
    "interval": ("95 %", 1),
    "contacts": ("contacts", 0),
    "stuck_pct": ("stuck", 1),
    "late_pct": ("late", 1),
    "min_clearance_mm": ("clear mm", 2),
    "cycle_p50_us": ("cycle µs", 0),
    "cycle_p99_us": ("p99", 0),
    "plan_p50_ms": ("plan ms", 0),
    "plan_p90_ms": ("p90", 0),
}
"""Heading and decimals of every figure."""


def _table(rows: list[dict[str, Any]], seeds: range, boxes: int, longest: float) -> Table:
    scenes = f"{len(seeds)} scene{'s' if len(seeds) > 1 else ''}"
    table = Table(
        title=f"reaching among {boxes} boxes: {scenes}, seed {seeds[0]}"
        + (f" to {seeds[-1]}" if len(seeds) > 1 else ""),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        caption="success: goal reached to 1 mm, nothing touched, %, with its 95 % interval; "
        "contacts: scenes in which something was touched; stuck: stood still or gave up, %; "
        f"late: {longest:g} s were up, %; clear: least distance of all cycles; cycle: wall time "
        "of a control cycle, median and 99th percentile; plan: wall time of a search, median and "
        "90th percentile",
        caption_justify="left",
    )
    table.add_column("method", no_wrap=True)
    for heading, _ in _COLUMNS.values():
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        shown = {**row, "interval": None}
        cells = [_cell(shown.get(key), decimals) for key, (_, decimals) in _COLUMNS.items()]
        cells[1] = f"{row['success_low_pct']:.0f}-{row['success_high_pct']:.0f}"
        table.add_row(row["name"], *cells)
    return table


def _cycle_table(rows: list[dict[str, Any]]) -> Table:
    table = Table(
        title=f"one cycle with {PAIRS} distance pairs",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        caption="the same postures and limits, in turns; ratio: to this package",
        caption_justify="left",
    )
    table.add_column("form", no_wrap=True)
    for heading in ("cycle µs", "p99", "ratio"):
        table.add_column(heading, justify="right")
    compiled = next(row["cycle_p50_us"] for row in rows if row["name"] == "cycle compiled")
    for row in rows:
        ratio = row["cycle_p50_us"] / compiled
        table.add_row(
            row["name"].removeprefix("cycle "),
            f"{row['cycle_p50_us']:.0f}",
            f"{row['cycle_p99_us']:.0f}",
            f"{ratio:.2f}",
        )
    return table


def _cell(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"
