"""Time one control cycle with 30 distance pairs: this package and mink take turns."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.control import ApproachController, CollisionOptions, ControlOptions
from eyehand.control.tasks import Position
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import ReachingScene, make_reaching_scene

from .baseline_mink import MinkMethod, MinkOptions
from .reach_methods import CONTROLLERS, DEFAULT, reaching_world
from .reach_outcome import ReachOptions

PAIRS = 30
"""Number of pairs of parts that are near enough to matter: typical of an arm with a hand."""
BOXES = 8
"""Number of boxes in a scene. With fewer boxes, few parts are near one."""
POSTURES = 8
"""Number of scenes, with one posture each."""
EARLY_CYCLES = 400
"""Number of cycles from the start in which the posture of smallest clearance is searched. The
safety level is active in this posture."""
WIDE_M = 1.5
"""Cut-off distance that includes all pairs of a scene, m."""
BURST = 25
"""Number of cycles of one method in a row. Caches are then warm, as in a control loop."""
ROUNDS = 13
"""Number of turns of each method at each posture."""
REPEATS = 3
"""Number of repetitions of each turn. The shortest time of each cycle counts, because other
programs disturb it least."""

_Step = Callable[[], object]


def cycle_rows(
    seed: int,
    *,
    baseline: bool,
    rounds: int = ROUNDS,
    postures: int = POSTURES,
    arm: ReachingArm | None = None,
) -> list[dict[str, Any]]:
    """Time one cycle of each method at the same postures, in turns.

    Both methods measure all pairs that can touch, and use the 30 nearest. Both have the same
    limits: joint ranges, joint speeds and distances.

    Parameters
    ----------
    seed
        Seed of the first scene.
    baseline
        Whether mink takes part.
    rounds
        Number of turns of each method at each posture.
    postures
        Number of postures, one per scene.
    arm
        The arm; None for the included one.

    Returns
    -------
    list of dict
        Rows `cycle compiled` and, with the baseline, `cycle mink`.
    """
    arm = arm or ReachingArm()
    scenes = (make_reaching_scene(seed + k, boxes=BOXES, arm=arm) for k in range(postures))
    turns = [_steps(scene, baseline) for scene in scenes]
    for steps in turns:
        for step in steps.values():
            _burst_us(step)
    times: dict[str, list[float]] = {name: [] for name in turns[0]}
    for _ in range(rounds):
        for steps in turns:
            bursts = [
                {name: _burst_us(step) for name, step in steps.items()} for _ in range(REPEATS)
            ]
            for name in steps:
                times[name] += np.min([burst[name] for burst in bursts], axis=0).tolist()
    return [
        {
            "name": f"cycle {name}",
            "pairs": PAIRS,
            "cycle_p50_us": round(float(np.percentile(taken, 50)), 1),
            "cycle_p99_us": round(float(np.percentile(taken, 99)), 1),
        }
        for name, taken in times.items()
    ]


def _steps(scene: ReachingScene, baseline: bool) -> dict[str, _Step]:
    """Return functions that run one cycle of each method, by name, at the posture of a scene."""
    posture, cut_off = _crowded_posture(scene)
    steps: dict[str, _Step] = {"compiled": _controller_step(scene, posture, cut_off)}
    if baseline:
        method = MinkMethod(scene, MinkOptions(detection=cut_off), ReachOptions().dt)
        steps["mink"] = lambda: method(posture)
    return steps


def _controller_step(scene: ReachingScene, posture: NDArray[np.float64], cut_off: float) -> _Step:
    world = reaching_world(scene.obstacles, scene.arm, CollisionOptions(cut_off=cut_off))
    controller = ApproachController(world, (Position(scene.goal),), CONTROLLERS[DEFAULT].options)

    def step() -> None:
        # Without a restart, the controller would soon search for the reason why it is stuck.
        controller.restart()
        controller.step(posture)

    return step


def _crowded_posture(scene: ReachingScene) -> tuple[NDArray[np.float64], float]:
    """Return the posture (n,) of smallest clearance, and a cut-off that includes PAIRS pairs, m."""
    world = reaching_world(scene.obstacles, scene.arm)
    options = ControlOptions()
    controller = ApproachController(world, (Position(scene.goal),), options)
    q = crowded = scene.start
    min_clearance = float("inf")
    for _ in range(EARLY_CYCLES):
        cycle = controller.step(q)
        if cycle.clearance < min_clearance:
            min_clearance, crowded = cycle.clearance, q
        q = q + options.dt * cycle.velocity
    world = reaching_world(scene.obstacles, scene.arm, CollisionOptions(cut_off=WIDE_M))
    distances = np.sort(world.proximity(crowded).distance)
    return crowded, float(distances[PAIRS - 1 : PAIRS + 1].mean())


def _burst_us(step: _Step) -> list[float]:
    """Return the times of a burst of cycles, µs."""
    times: list[float] = []
    for _ in range(BURST):
        start = time.perf_counter_ns()
        step()
        times.append(1e-3 * (time.perf_counter_ns() - start))
    return times
