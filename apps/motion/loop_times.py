"""Measure the time of every call of a planned motion at 1 kHz, with searches in the background."""

from __future__ import annotations

import gc
import time
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.control import ControlOptions, PlannedApproach
from eyehand.control.tasks import Position
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import make_reaching_scene

from .reach_methods import reaching_world

PERIOD_S = 1e-3
"""Period of the control loop, s."""
BOXES = 5
"""Number of boxes in each scene."""
SCENE_S = 20.0
"""Time after which the next scene begins, s."""


def loop_row(seed: int, seconds: float, arm: ReachingArm | None = None) -> dict[str, Any]:
    """Run motions in real time at 1 kHz, and return the times of the calls of `step`.

    Parameters
    ----------
    seed
        Seed of the first scene. Further scenes follow until the time is up.
    seconds
        Time to measure, s, without the preparation of the scenes.
    arm
        The arm; None for the included one.

    Returns
    -------
    dict
        Row `loop 1 kHz`: number of calls and searches; time of a call in µs: median, 99.9th
        percentile and maximum; the same 99.9th percentile and maximum of processor time.
    """
    walls, processor, searches, left = [], [], 0, seconds
    for number in count(seed):
        taken, used, paths = _run(number, min(left, SCENE_S), arm or ReachingArm())
        walls.append(taken)
        processor.append(used)
        searches += paths
        left -= PERIOD_S * len(taken)
        if left < PERIOD_S:
            break
    wall, used = np.concatenate(walls), np.concatenate(processor)
    return {
        "name": "loop 1 kHz",
        "calls": len(wall),
        "searches": searches,
        "step_p50_us": round(float(np.percentile(wall, 50)), 1),
        "step_p999_us": round(float(np.percentile(wall, 99.9)), 1),
        "step_max_us": round(float(wall.max()), 1),
        "processor_p999_us": round(float(np.percentile(used, 99.9)), 1),
        "processor_max_us": round(float(used.max()), 1),
    }


def _run(
    seed: int, seconds: float, arm: ReachingArm
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return wall and processor time of each call, µs, and the number of searches."""
    scene = make_reaching_scene(seed, boxes=BOXES, arm=arm)
    controller = PlannedApproach(
        reaching_world(scene.obstacles, arm),
        (Position(scene.goal),),
        ControlOptions(dt=PERIOD_S),
        background=True,
    )
    controller.warm_up()
    q = scene.start.copy()
    times = np.zeros((max(round(seconds / PERIOD_S), 1), 2))
    # The collector would stop the loop for the objects of the preparation.
    gc.collect()
    gc.freeze()
    used = 0
    due = time.perf_counter()
    for used in range(len(times)):
        start, began = time.perf_counter_ns(), time.thread_time_ns()
        step = controller.step(q)
        times[used] = time.perf_counter_ns() - start, time.thread_time_ns() - began
        if step.status in ("reached", "stuck"):
            break
        q = q + PERIOD_S * step.velocity
        due = max(due + PERIOD_S, time.perf_counter())
        time.sleep(max(due - time.perf_counter(), 0.0))
    gc.unfreeze()
    taken = 1e-3 * times[: used + 1]
    return taken[:, 0], taken[:, 1], len(controller.paths)
