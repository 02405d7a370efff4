"""`eyehand evaluate motion`: reaching in clutter with this package's controller and a baseline."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from eyehand.data_synth.cell import INCLUDED_ARM
from eyehand.data_synth.scenes import MAX_BOXES, Place
from eyehand.errors import InputError

from ..bench import Provenance, machine_line, write_chart, write_csv
from ..bench.machine import core_count
from ..console import print_json, say, show, tracked
from ..frame_masks import Numbers
from ..process_end import end_with_parent
from ..run_folder import claim_folder
from .arm_choice import carry_hand, choose_arm, reaching_robot, report_visual_gap, robot_with_hand
from .cycle_comparison import PAIRS, cycle_rows
from .loop_times import loop_row
from .moving_obstacles import TRIALS as MOVING_TRIALS
from .moving_obstacles import moving_rows
from .reach_chart import reach_chart
from .reach_methods import BASELINE, BASELINE_PLANNED, BASELINES, METHODS, PLANNED
from .reach_outcome import Goal, ReachOptions
from .reach_run import ReachRecord, run_scene, summary_row
from .reach_tables import cycle_table, loop_table, moving_table, reach_table

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from eyehand.data_synth import ReachingArm

QUICK_SCENES = 4
"""Number of scenes with --quick."""
QUICK_MOVING = 2
"""Number of trials with moving solids per row with --quick."""
QUICK_POSTURES = 2
"""Number of postures at which a single cycle is timed with --quick."""
MAX_PROCESSES = 2
"""Number of scenes that run side by side. Each process takes about 300 MB."""
BATCH = 4
"""Number of scenes handed to a process at a time."""
TIMED_SCENES = 6
"""Number of scenes in which cycles are timed, while nothing else runs."""
REPEATS = 3
"""Number of runs of each timed scene. The motion is the same, and the fastest time counts."""


class _ReachCase(NamedTuple):
    method: str
    seed: int
    boxes: int
    options: ReachOptions


def evaluate_motion(
    *,
    scenes: int = 200,
    seed: int = 0,
    boxes: int = 5,
    arm: str = "",
    hand: str = "",
    mount: Numbers = None,
    frame: str = "",
    place: Place = "boxes",
    goal: Goal = "position",
    time_limit: float = ReachOptions.time_limit,
    only: list[str] | None = None,
    baseline: bool = True,
    quick: bool = False,
    loop: float = 0.0,
    out: Path = Path("out/evaluate_motion"),
    json: bool = False,
) -> int:
    """Run cluttered reaching scenes, and print success, contacts and cycle times per method.

    An arm reaches for points among boxes. A separate collision model evaluates every cycle.
    Writes bench.png, bench.csv with the numbers behind it, and scenes.csv with one row per scene
    and method. With a hand, robot.xml is the arm with the hand.

    Parameters
    ----------
    scenes
        Number of scenes.
    seed
        Seed of the first scene. Scene k depends on seed + k only.
    boxes
        Number of boxes in each scene, 0 to 12. The other places have none.
    arm
        Arm: lbr (the default, included), panda, ur5e, iiwa14, or an MJCF or URDF file.
        EYEHAND_ROBOTS names the folder of the files. The lengths of the scenes follow its reach.
    hand
        Hand on the arm, open and rigid: own, panda, 2f85, allegro, or a file of a gripper.
    mount
        Pose of the hand's file in the arm's flange, where no default is known: x y z in m, roll
        pitch yaw in rad.
    frame
        Site or body that reaches. Default: attachment_site, the flange; with a hand the point
        between its fingertips, or its palm.
    place
        Surroundings of the goal: boxes, shelf, bin, or neighbours 60 mm wider apart than the arm.
    goal
        What must be reached: position, axis (the position and the axis of the tool), or pose.
    time_limit
        Simulated time after which a reach is given up, s.
    only
        Run only this method. Can be given several times.
    baseline
        Also run the baselines mink and OMPL in the same scenes.
    quick
        Four scenes, for a first look.
    loop
        Also run planned motions in real time at 1 kHz for so many seconds, and print the longest
        time of a call of the controller.
    out
        Output folder.
    json
        Print one JSON object on stdout. Tables then go to stderr.
    """
    _check_numbers(scenes, seed, boxes, loop)
    methods = _selected_methods(only, baseline=baseline)
    joined = robot_with_hand(arm, hand, mount)
    alone = choose_arm() if joined else choose_arm(arm, frame)
    options = ReachOptions(time_limit=time_limit, goal=goal, place=place, arm=alone)
    _check_arm(options, methods, arm, hand)
    claim_folder(out)
    if joined:
        options = replace(options, arm=carry_hand(arm, joined, out / "robot.xml", frame))
    report_visual_gap(reaching_robot(options.arm))
    scenes = min(scenes, QUICK_SCENES) if quick else scenes
    seeds = range(seed, seed + scenes)
    cases = [_ReachCase(method, each, boxes, options) for method in methods for each in seeds]
    records = _run(cases, processes=1 if quick else MAX_PROCESSES)
    timed = [case for case in cases if case.seed in seeds[:TIMED_SCENES]]
    cycles_us = _cycle_times(timed, repeats=1 if quick else REPEATS)
    rows = [
        summary_row(
            method, [r for r in records if r.method == method], cycles_us[method], time_limit
        )
        for method in methods
    ]
    say(f"timing one cycle with {PAIRS} distance pairs")
    fewer = {"rounds": 1, "postures": QUICK_POSTURES} if quick else {}
    cycles = cycle_rows(seed, baseline=BASELINE in methods, arm=options.arm, **fewer)
    loops = _loop_rows(seed, loop, options.arm)
    say("moving solids at the arm")
    moving = moving_rows(seed, QUICK_MOVING if quick else MOVING_TRIALS, options.arm)
    write_csv(out / "scenes.csv", [record.row() for record in records])
    where = _described(options, boxes)
    named = " with ".join(Path(part).stem for part in (arm or "7-joint arm", hand) if part)
    made = Provenance(f"{named}, {where}, 5 ms cycles", seed, scenes, "scene")
    write_chart(reach_chart(rows, made), out / "bench.png", [*rows, *cycles, *loops, *moving])
    title = f"{named} reaching, {where}: {scenes} scenes from seed {seed}"
    tables = [reach_table(rows, title, time_limit), cycle_table(cycles), moving_table(moving)]
    for table in [*tables, *([loop_table(loops)] if loops else [])]:
        show(table, json_wanted=json)
    say(f"every scene: {out / 'scenes.csv'}; chart: {out / 'bench.png'}")
    if json:
        print_json(
            "evaluate_motion",
            seed,
            [*rows, *cycles, *loops, *moving],
            scenes=scenes,
            boxes=boxes,
            place=place,
            goal=goal,
            arm=arm or INCLUDED_ARM,
            hand=hand,
            longest_s=time_limit,
            machine=machine_line(),
            out=str(out),
        )
    return 0


def _check_numbers(scenes: int, seed: int, boxes: int, loop: float) -> None:
    if scenes < 1:
        raise InputError(f"--scenes must be >= 1, got {scenes}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if not 0 <= boxes <= MAX_BOXES:
        raise InputError(f"--boxes must be from 0 to {MAX_BOXES}, got {boxes}")
    if not 0.0 <= loop < float("inf"):
        raise InputError(f"--loop must be a finite time >= 0 s, got {loop:g}")


def _check_arm(options: ReachOptions, methods: Sequence[str], arm: str, hand: str) -> None:
    if options.place == "neighbours" and (arm not in ("", INCLUDED_ARM) or hand):
        raise InputError("--place neighbours fits the included arm without a hand only")
    robot = reaching_robot(options.arm)
    if robot.model.nq != robot.n and set(methods) & set(BASELINES):
        raise InputError(
            f"--arm {arm} has joints of a hand: mink needs an arm alone; give --no-baseline"
        )


def _described(options: ReachOptions, boxes: int) -> str:
    """Return surroundings and goal of the scenes, in words."""
    places = {
        "boxes": f"among {boxes} boxes",
        "shelf": "into a shelf",
        "bin": "into a bin",
        "neighbours": "between two neighbours",
    }
    goals = {"position": "positions", "axis": "positions with an axis", "pose": "full poses"}
    return f"{goals[options.goal]} {places[options.place]}"


def _selected_methods(only: list[str] | None, *, baseline: bool) -> list[str]:
    for name in only or []:
        if name not in METHODS:
            raise InputError(f"unknown method {name!r}; choose from: {', '.join(METHODS)}")
    selected = [name for name in METHODS if name in (only or METHODS)]
    if not baseline:
        selected = [name for name in selected if name not in BASELINES]
        if not selected:
            named = ", ".join(only or BASELINES)
            raise InputError(f"--no-baseline excludes {named}, the only selected methods")
    missing = sorted({BASELINES.get(name, "") for name in selected} - {""})
    for package in (one for one in missing if find_spec(one) is None):
        left = [name for name in selected if BASELINES.get(name) != package]
        rows = ", ".join(name for name in selected if name not in left)
        note = f"{package} is not installed: pip install 'eyehand[baselines]'"
        if not left:
            raise InputError(note)
        say(f"without the rows {rows}: {note}")
        selected = left
    return selected


def _run(cases: Sequence[_ReachCase], *, processes: int) -> list[ReachRecord]:
    """Run all cases, those with a planner last and alone, because their search time is reported."""
    searching = (PLANNED, BASELINE_PLANNED)
    parallel = [case for case in cases if case.method not in searching]
    alone = [case for case in cases if case.method in searching]
    records = list(tracked(_records(parallel, processes), "reaching", len(parallel)))
    return records + list(tracked(_records(alone, 1), "reaching with a planner", len(alone)))


def _records(cases: Sequence[_ReachCase], processes: int) -> Iterator[ReachRecord]:
    processes = min(processes, core_count())
    if processes < 2 or len(cases) < 2 * BATCH:
        yield from map(_record, cases)
        return
    # A forked process would inherit the locks of this process' threads.
    with ProcessPoolExecutor(
        processes, get_context("spawn"), initializer=end_with_parent, initargs=(os.getpid(),)
    ) as pool:
        yield from pool.map(_record, cases, chunksize=BATCH)


def _record(case: _ReachCase) -> ReachRecord:
    return run_scene(*case)


def _cycle_times(cases: Sequence[_ReachCase], *, repeats: int) -> dict[str, NDArray[np.float64]]:
    """Run a few scenes again, one at a time, and return the times of all cycles by method, µs."""
    times: dict[str, list[NDArray[np.float64]]] = {case.method: [] for case in cases}
    ordered = sorted(cases, key=lambda case: case.seed)
    for case in tracked(ordered, "timing cycles", len(ordered)):
        runs = [_record(case).cycle_times_us for _ in range(repeats)]
        shared = min(map(len, runs))
        times[case.method].append(np.min([run[:shared] for run in runs], axis=0))
    return {method: np.concatenate(taken) for method, taken in times.items()}


def _loop_rows(seed: int, seconds: float, arm: ReachingArm) -> list[dict[str, Any]]:
    """Return the row of calls in real time; none for 0 s."""
    if not seconds:
        return []
    say(f"calling the controller at 1 kHz for {seconds:g} s")
    return [loop_row(seed, seconds, arm)]
